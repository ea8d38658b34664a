"""Progress of simulated runs: a bar on a terminal, else a line for each tenth."""

import time
from contextlib import suppress
from functools import partial
from typing import TextIO

from hbench.experiment.progress import Progress
from hbench.records import RunPlan

_BAR = 24


def write_if_open(stream: TextIO, text: str) -> None:
    """Write to a terminal at once; a closed one is no error."""
    with suppress(OSError):
        stream.write(text)
        stream.flush()


def bar(done: int, total: int) -> str:
    """Return a bar of signs for the share that is done."""
    return f"[{'#' * (_BAR * done // total):.<{_BAR}}]"


def signed_speed(v_m_s: float, plan: RunPlan) -> str:
    """Write a speed in mm/s with its sign and one decimal, two in a slow run: +0.38, -5.0."""
    decimals = 2 if 0 < abs(plan.v_ref_m_s) < 1e-3 else 1
    return f"{1e3 * v_m_s:+.{decimals}f}"


class ProgressLine:
    """Display of finished runs, current reference and remaining wall time.

    A closed terminal does not end a run.
    """

    def __init__(self, stream: TextIO):
        self._write = partial(write_if_open, stream)
        self._redraws = stream.isatty()
        self._start = time.monotonic()
        self._shown = -1  # tenths, without a terminal
        self._width = 0

    def __call__(self, progress: Progress) -> None:
        """Show the campaign's progress."""
        done, total, plan = progress.runs_done, progress.runs_total, progress.plan
        reference = (
            f"{signed_speed(plan.v_ref_m_s, plan)} mm/s, {plan.f_load_n:+.0f} N, trial {plan.trial}"
        )
        of = " of at most " if progress.at_most else "/"
        parts = (
            f"{done}{of}{total} runs",
            reference if self._redraws else "",  # of one run in many it says nothing
            "" if progress.at_most else self._left(done, total),
        )
        self._show(done, total, ", ".join(filter(None, parts)))

    def campaigns(self, done: int, total: int, failed: int) -> None:
        """Show the number of analyzed campaigns of a fleet."""
        failures = f", {failed} failed" if failed else ""
        self._show(done, total, f"{done}/{total} campaigns{failures}, {self._left(done, total)}")

    def note(self, text: str) -> None:
        """Print a note, which stays above the line."""
        self.close(f"note: {text}")

    def stage(self, text: str) -> None:
        """Print what begins, with the time since the start."""
        self.close(f"{time.monotonic() - self._start:4.0f} s: {text}")

    def counted(self, done: int, total: int) -> None:
        """Show the number of finished simulations of a round, on a terminal only."""
        if self._redraws:
            self._redraw(f"{bar(done, total)} {done}/{total} simulations")

    def close(self, last: str = "") -> None:
        """Clear the line, then print ``last``."""
        if self._redraws:
            self._redraw("")
            self._write("\r")
        if last:
            self._write(last + "\n")

    def _show(self, done: int, total: int, text: str) -> None:
        if self._redraws:
            self._redraw(f"{bar(done, total)} {text}")
        elif 10 * done // total > self._shown:
            self._shown = 10 * done // total
            self._write(text + "\n")

    def _redraw(self, text: str) -> None:
        self._write("\r" + text.ljust(self._width))
        self._width = len(text)

    def _left(self, done: int, total: int) -> str:
        if not done:
            return "time left not known yet"
        seconds = round((time.monotonic() - self._start) * (total - done) / done)
        return f"{seconds // 60}:{seconds % 60:02d} left"
