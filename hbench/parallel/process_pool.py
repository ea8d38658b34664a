"""The same work with many arguments, on all cores of the machine."""

import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from hbench.errors import DeviceError

_AHEAD = 2  # arguments a process: it never waits for the next one
_INTERRUPTS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class ProcessDied(DeviceError):
    """A process that shared the work has died; ``unfinished`` are arguments that it may have had.

    Those that were not taken from the arguments yet are still there.
    """

    def __init__(self, unfinished: Sequence[Any], words: str, hint: str):
        super().__init__(words, hint)
        self.unfinished = tuple(unfinished)


def on_all_cores(work: Callable[[Any], Any], arguments: Iterable[Any]) -> Iterator[Any]:
    """Call ``work`` with each argument, a process a core, and give results as they come.

    ``work``, arguments and results must be picklable. Arguments are taken as they are needed, and
    a process has one thread for linear algebra. Whatever ends this generator, or its process, ends
    the processes at once, as by ``kill -9``: so ``work`` must leave what can be gone on with.
    Raises what ``work`` raises, and ``ProcessDied`` where a process has died.
    """
    spawn = get_context("spawn")  # a fork would take locks of threads with it
    watched, held = spawn.Pipe(duplex=False)  # nobody writes: it ends when ``held`` is closed
    processes = usable_cores()
    pool = ProcessPoolExecutor(processes, spawn, _start_worker, (watched, work))
    taken = iter(arguments)
    running: dict[Future, Any] = {}
    last: list[Any] = []  # taken, and not running yet
    with pool, held:  # left in reverse: workers end before the pool waits for them
        try:
            while True:
                for argument in islice(taken, _AHEAD * processes - len(running)):
                    last = [argument]
                    with _deaf_to_ctrl_c(), _one_thread_each():  # a process may be started here
                        running[pool.submit(_do, argument)] = argument
                    last = []
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    result = future.result()
                    del running[future]
                    yield result
        except BrokenProcessPool:
            raise ProcessDied(
                [*running.values(), *last],
                "one of the processes that share the work has died: killed, or out of memory",
                "Give the same command again; `hbench run` goes on with --resume.",
            ) from None


def whatever_dies(
    run: Callable[[Iterable[Any]], Iterator[Any]],
    arguments: Iterable[Any],
    lost: Callable[[Any], Any],
) -> Iterator[Any]:
    """Give the results of ``run`` for all arguments, ``lost(argument)`` for what kills a process.

    What may have killed one is run again by itself; if a process dies then too, it is lost.
    """
    taken = iter(arguments)
    while True:
        try:
            yield from run(taken)
            return
        except ProcessDied as died:
            for argument in died.unfinished:
                try:
                    yield from run([argument])
                except ProcessDied:
                    yield lost(argument)


def usable_cores() -> int:
    """How many this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """Let processes that are started in here never hear Ctrl-C.

    What would interrupt this process in between does it when they have all that they wait for.
    """
    masks = hasattr(signal, "pthread_sigmask")  # not on Windows: they end by it, and say so
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if masks else set()
    try:
        with _interrupted_afterwards():  # the mask is this thread's; others still hear it
            yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _interrupted_afterwards() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():  # only that one is interrupted
        yield
        return
    heard: list[int] = []
    handlers = {
        number: handler for number in _INTERRUPTS if callable(handler := signal.getsignal(number))
    }
    try:
        for number in handlers:
            signal.signal(number, lambda number, _: heard.append(number))
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number in heard[:1]:
            signal.raise_signal(number)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let processes that are started in here have one thread for linear algebra."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


_work: Callable[[Any], Any]  # of a worker


def _start_worker(watched: Connection, work: Callable[[Any], Any]) -> None:
    global _work
    _work = work
    threading.Thread(target=_end_with_parent, args=(watched,), daemon=True).start()


def _end_with_parent(watched: Connection) -> None:
    watched.poll(None)
    os._exit(1)


def _do(argument: Any) -> Any:
    return _work(argument)
