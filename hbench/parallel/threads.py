"""Threads: one function with many arguments, for work in compiled code."""

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from hbench.parallel.process_pool import usable_cores

_thread = threading.local()


def map_on_threads(work: Callable[[Any], Any], arguments: Iterable[Any]) -> list[Any]:
    """Call ``work`` with each argument, a thread per core, and return the results in order.

    Compiled functions and linear algebra run at the same time, Python code takes turns. A call
    within ``work`` stays in its thread, as the other cores have work.
    """
    every = list(arguments)
    if len(every) < 2 or getattr(_thread, "is_one_of_many", False):
        return [work(argument) for argument in every]
    with ThreadPoolExecutor(usable_cores(), initializer=_mark) as pool:
        return list(pool.map(work, every))


def _mark() -> None:
    _thread.is_one_of_many = True
