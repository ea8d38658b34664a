"""The same work with many arguments, on all cores of the machine."""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from hbench.errors import DeviceError


def on_all_cores(work: Callable[[Any], Any], arguments: Sequence[Any]) -> Iterator[Any]:
    """Call ``work`` with each argument, a process a core, and give results as they come.

    ``work``, arguments and results must be picklable. Whatever ends this generator, or its
    process, ends the processes at once, as by ``kill -9``: so ``work`` must leave what can be gone
    on with. Raises what ``work`` raises, and ``DeviceError`` where a process has died.
    """
    spawn = get_context("spawn")  # a fork would take locks of threads with it
    watched, held = spawn.Pipe(duplex=False)  # nobody writes: it ends when ``held`` is closed
    processes = min(usable_cores(), len(arguments))
    pool = ProcessPoolExecutor(processes, spawn, _start_worker, (watched, work))
    with pool, held:  # left in reverse: workers end before the pool waits for them
        with _deaf_to_ctrl_c():
            futures = [pool.submit(_do, argument) for argument in arguments]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BrokenProcessPool:
            raise DeviceError(
                "one of the processes that share the work has died: killed, or out of memory",
                "What it had finished stays; go on with --resume.",
            ) from None


def usable_cores() -> int:
    """How many this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """Let processes that are started in here never hear Ctrl-C, this one only when it's over."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows: they end by it, and say so
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


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
