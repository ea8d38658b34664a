"""Parallel map on two forked processes, for arguments that can't be pickled."""

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, TypeVar

_PROCESSES = 2
_CHECK_S = 0.5  # interval between checks for the parent process

Argument = TypeVar("Argument")
Result = TypeVar("Result")


def map_forked(work: Callable[[Argument], Result], arguments: Sequence[Argument]) -> list[Result]:
    """Return ``work(argument)`` for each argument, in their order.

    Two forked processes share the arguments without copying or importing; results must be
    picklable. They end with this process, however it ends. A fork copies the locks of other
    threads, so with several threads, or on systems other than Linux, this process does the work.
    """
    no_fork = threading.active_count() > 1 or sys.platform != "linux"
    if no_fork or len(arguments) < _PROCESSES:
        return [work(argument) for argument in arguments]
    job = work, arguments, os.getpid()
    gc.freeze()  # a collection in a fork would copy this process's memory
    try:
        with ProcessPoolExecutor(_PROCESSES, get_context("fork"), _start_worker, job) as pool:
            return list(pool.map(_result, range(len(arguments))))
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
