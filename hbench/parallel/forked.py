"""The same work on each of many things, two at a time."""

import signal
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, TypeVar

_PROCESSES = 2

Thing = TypeVar("Thing")
Made = TypeVar("Made")


def side_by_side(work: Callable[[Thing], Made], things: Sequence[Thing]) -> list[Made]:
    """Return what ``work`` makes of each of ``things``, in their order.

    Two processes share them. These are forked, so they have what they work on without a copy or an
    import; what they make must be picklable. A fork would take locks of threads with it: where
    there is a thread, or a system other than Linux, this process does it all.
    """
    alone = threading.active_count() > 1 or sys.platform != "linux"
    if alone or len(things) < _PROCESSES:
        return [work(thing) for thing in things]
    hold = work, things
    with ProcessPoolExecutor(_PROCESSES, get_context("fork"), _start, hold) as pool:
        return list(pool.map(_make, range(len(things))))


_held: tuple[Callable[[Any], Any], Sequence[Any]]  # of a forked process


def _start(work: Callable[[Any], Any], things: Sequence[Any]) -> None:
    global _held
    _held = work, things
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits


def _make(place: int) -> Any:
    work, things = _held
    return work(things[place])
