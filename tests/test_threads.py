"""Threads: results in order, and no pool within a pool."""

import threading

import pytest

from hbench.parallel import threads
from hbench.parallel.threads import map_on_threads


@pytest.fixture(autouse=True)
def four_cores(monkeypatch):
    monkeypatch.setattr(threads, "usable_cores", lambda: 4)


def test_results_are_in_order_whichever_ends_first():
    last = threading.Event()

    def slow_first(i):
        if i == 0:
            assert last.wait(10)
        if i == 3:
            last.set()
        return 10 * i

    assert map_on_threads(slow_first, range(4)) == [0, 10, 20, 30]


def test_a_call_within_a_call_stays_in_its_thread():
    def within(i):
        own = map_on_threads(lambda _: threading.get_ident(), range(3))
        return set(own) == {threading.get_ident()}

    assert map_on_threads(within, range(6)) == [True] * 6


def test_one_argument_needs_no_thread():
    assert map_on_threads(lambda _: threading.get_ident(), [0]) == [threading.get_ident()]


def test_errors_of_the_work_are_raised():
    with pytest.raises(ZeroDivisionError):
        map_on_threads(lambda i: 1 // i, [1, 0])
