"""Threads: one function with many arguments, for work in compiled code."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from hbench.parallel.process_pool import usable_cores


def map_on_threads(work: Callable[[Any], Any], arguments: Iterable[Any]) -> list[Any]:
    """Call ``work`` with each argument, a thread per core, and return the results in order.

    Compiled functions and linear algebra run at the same time, Python code takes turns.
    """
    with ThreadPoolExecutor(usable_cores()) as pool:
        return list(pool.map(work, arguments))
