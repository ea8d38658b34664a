"""Parallel map on two forked processes, for arguments that can't be pickled."""

import signal
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, TypeVar

_PROCESSES = 2

Argument = TypeVar("Argument")
Result = TypeVar("Result")


def map_forked(work: Callable[[Argument], Result], arguments: Sequence[Argument]) -> list[Result]:
    """Return ``work(argument)`` for each argument, in their order.

    Two forked processes share the arguments without copying or importing; results must be
    picklable. A fork copies the locks of other threads, so with several threads, or on systems
    other than Linux, this process does all the work.
    """
    no_fork = threading.active_count() > 1 or sys.platform != "linux"
    if no_fork or len(arguments) < _PROCESSES:
        return [work(argument) for argument in arguments]
    job = work, arguments
    with ProcessPoolExecutor(_PROCESSES, get_context("fork"), _start_worker, job) as pool:
        return list(pool.map(_result, range(len(arguments))))


_job: tuple[Callable[[Any], Any], Sequence[Any]]  # of a forked process


def _start_worker(work: Callable[[Any], Any], arguments: Sequence[Any]) -> None:
    global _job
    _job = work, arguments
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent process only


def _result(index: int) -> Any:
    work, arguments = _job
    return work(arguments[index])
