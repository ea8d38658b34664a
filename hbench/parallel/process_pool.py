"""Process pool: one function with many arguments, on all cores of the machine."""

import os
import pickle
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
from hbench.parallel.forked import can_fork, uncollected
from hbench.parallel.one_thread import ONE_THREAD

_QUEUED = 2  # arguments per process, so that no process waits for the next one
_INTERRUPTS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]


class ProcessDied(DeviceError):
    """Death of a worker process; ``unfinished`` are the arguments that it may have been given.

    Arguments not yet taken from the iterable remain there.
    """

    def __init__(self, unfinished: Sequence[Any], message: str, hint: str):
        super().__init__(message, hint)
        self.unfinished = tuple(unfinished)


def map_on_cores(work: Callable[[Any], Any], arguments: Iterable[Any]) -> Iterator[Any]:
    """Call ``work`` with each argument, one process per core, and yield results as they come.

    ``work``, arguments and results must be picklable. The processes are forks where that is safe,
    which need not import anything. Arguments are taken on demand, and a process has one thread for
    linear algebra. The end of this generator or of its process kills the workers at once, as by
    ``kill -9``, so ``work`` must leave data from which it can continue. Raises the errors of
    ``work``, and ``ProcessDied`` if a process has died.
    """
    forks = can_fork()
    context = get_context("fork" if forks else "spawn")
    watched, held = context.Pipe(duplex=False)  # no data: the pipe ends when ``held`` is closed
    processes = usable_cores()
    job = watched, held if forks else None, pickle.dumps(work)
    pool = ProcessPoolExecutor(processes, context, _start_worker, job)
    taken = iter(arguments)
    running: dict[Future, Any] = {}
    last: list[Any] = []  # taken, not submitted yet
    # Exit in reverse order: workers end before the pool waits for them.
    with uncollected(), pool, held:
        try:
            while True:
                for argument in islice(taken, _QUEUED * processes - len(running)):
                    last = [argument]
                    with _ctrl_c_blocked(), _single_threaded():  # may start a process
                        running[pool.submit(_run, argument)] = argument
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
                "a worker process has died: killed, or out of memory",
                "Give the same command again; add --resume for `hbench run`.",
            ) from None


def retry_alone(
    run: Callable[[Iterable[Any]], Iterator[Any]],
    arguments: Iterable[Any],
    lost: Callable[[Any], Any],
) -> Iterator[Any]:
    """Yield the results of ``run``, and ``lost(argument)`` for an argument that kills a process.

    After the death of a process, each argument that it may have had is run alone; if a process dies
    again, the argument is lost.
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
    """Return the number of cores available to this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _ctrl_c_blocked() -> Iterator[None]:
    """Block Ctrl-C for the processes started within.

    An interrupt of this process in between is delivered once they have started.
    """
    masks = hasattr(signal, "pthread_sigmask")  # not on Windows, where Ctrl-C ends the workers
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if masks else set()
    try:
        with _interrupts_deferred():  # the mask applies to this thread only
            yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _interrupts_deferred() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():  # which alone gets signals
        yield
        return
    received: list[int] = []
    handlers = {
        number: handler for number in _INTERRUPTS if callable(handler := signal.getsignal(number))
    }
    try:
        for number in handlers:
            signal.signal(number, lambda number, _: received.append(number))
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number in received[:1]:
            signal.raise_signal(number)


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Give the processes started within one thread for linear algebra."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


_work: Callable[[Any], Any]  # of a worker


def _start_worker(watched: Connection, held: Connection | None, pickled_work: bytes) -> None:
    """Begin a worker; ``held`` is the parent's end of the pipe, of which a fork has a copy."""
    global _work
    if held is not None:
        held.close()
        for number in _INTERRUPTS[1:]:  # Ctrl-C is blocked
            signal.signal(number, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, args=(watched,), daemon=True).start()
    _work = pickle.loads(pickled_work)  # imports for a second, in which the parent may end


def _end_with_parent(watched: Connection) -> None:
    watched.poll(None)
    os._exit(1)


def _run(argument: Any) -> Any:
    return _work(argument)
