"""Parallel map on two forked processes, for arguments that can't be pickled."""

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any, TypeVar

_PROCESSES = 2
_CHECK_S = 0.5  # interval between checks for the parent process

Argument = TypeVar("Argument")
Result = TypeVar("Result")


def map_forked(work: Callable[[Argument], Result], arguments: Sequence[Argument]) -> list[Result]:
    """Return ``work(argument)`` for each argument, in their order.

    Two forked processes share the arguments without copying or importing; results must be
    picklable. They end with this process, however it ends. Where it can't be forked, this process
    does the work.
    """
    if not can_fork() or len(arguments) < _PROCESSES:
        return [work(argument) for argument in arguments]
    job = work, arguments, os.getpid()
    with (
        uncollected(),
        ProcessPoolExecutor(_PROCESSES, get_context("fork"), _start_worker, job) as pool,
    ):
        return list(pool.map(_result, range(len(arguments))))


def can_fork() -> bool:
    """Return whether a fork of this process is safe: it would copy the locks of other threads."""
    return sys.platform == "linux" and threading.active_count() == 1


@contextmanager
def uncollected() -> Iterator[None]:
    """Leave present objects out of garbage collections, which in a fork would copy their memory."""
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


_job: tuple[Callable[[Any], Any], Sequence[Any]]  # of a forked process


def _start_worker(work: Callable[[Any], Any], arguments: Sequence[Any], parent: int) -> None:
    global _job
    _job = work, arguments
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent process only
    threading.Thread(target=_end_with_parent, args=(parent,), daemon=True).start()


def _end_with_parent(parent: int) -> None:
    # Each fork has both ends of the pool's pipes, which therefore don't end with the parent.
    while os.getppid() == parent:
        time.sleep(_CHECK_S)
    os._exit(1)


def _result(index: int) -> Any:
    work, arguments = _job
    return work(arguments[index])
