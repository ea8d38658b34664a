"""Display of a running measurement: a block of lines that is redrawn on a terminal.

Without a terminal it is a plain log with a line per run. Rejected runs stay above the block.
"""

import os
import time
from contextlib import suppress
from functools import partial
from typing import TextIO

from hbench.channels import CHANNELS
from hbench.cli.progress import bar, signed_speed, write_if_open
from hbench.experiment.progress import Ended, Progress
from hbench.records import KINDS, RunPlan

_EVERY_S = 0.1  # shortest interval between redraws
_HIGH = 0.9  # of the limit: a higher pressure is marked
_CHAMBERS = {  # keys of the status, and symbols
    key: CHANNELS[f"{key}_pa"].symbol for key in ("p_tp", "p_tr", "p_lp", "p_lr", "p_s")
}
_PHASES = {
    "return": "moving to its start",
    "hold": "at rest under load",
    "accelerate": "accelerating",
    "steady": "at constant speed",
    "closed": "at rest, valves closed",
    "push": "at rest, force rising",
    "vent": "venting the chambers",
    "brake": "braking",
}


class BenchDisplay:
    """Display of a running measurement. A closed terminal does not end a run."""

    def __init__(self, stream: TextIO):
        self._stream = stream
        self._write = partial(write_if_open, stream)
        self._redraws = stream.isatty() and os.environ.get("TERM") != "dumb"
        self._lines = 0  # of the displayed block
        self._drawn_s = -_EVERY_S
        self._asked = ""  # of the operator, in the plain log

    def __call__(self, progress: Progress) -> None:
        """Show the campaign's progress."""
        if not self._redraws:
            asked = progress.waiting.partition(":")[0]
            if asked and asked != self._asked:
                self._write(f"waiting: {progress.waiting}\n")
            self._asked = asked
            before = progress.runs_done - sum(not ended.again for ended in progress.ended)
            for ended in progress.ended:
                before += not ended.again
                self._write(f"{_count(before, progress)}: {_line(ended, progress)}\n")
            return
        lasting = [_line(ended, progress) for ended in progress.ended if ended.reasons]
        if lasting or time.monotonic() - self._drawn_s >= _EVERY_S:
            self._drawn_s = time.monotonic()
            self._draw(lasting, _block(progress))

    def close(self, last: str = "") -> None:
        """Remove the block, then print ``last``."""
        if self._redraws:
            self._draw([], [])
        if last:
            self._write(last + "\n")

    def _draw(self, lasting: list[str], block: list[str]) -> None:
        width = self._width()
        block = [line if len(line) < width else line[: width - 4] + "..." for line in block]
        up = f"\x1b[{self._lines}A" if self._lines else ""
        self._write(f"{up}\r\x1b[J" + "".join(line + "\n" for line in [*lasting, *block]))
        self._lines = len(block)

    def _width(self) -> int:
        with suppress(OSError, ValueError):
            return os.get_terminal_size(self._stream.fileno()).columns or 80
        return 80


def _block(now: Progress) -> list[str]:
    total = max(now.runs_total, 1)
    plan = now.plan
    again = f", attempt {now.attempt}" if now.attempt > 1 else ""
    count = _count(min(now.runs_done + 1, total), now)
    force = f"F_L {now.f_load_n:+.0f} of {plan.f_load_n or 0.0:+.0f} N"
    pressures = "  ".join(
        f"{symbol} {now.pressures_pa[key] / 1e5:.1f}{_mark(now.pressures_pa[key], now)}"
        for key, symbol in _CHAMBERS.items()
        if key in now.pressures_pa
    )
    return [
        f"{bar(now.runs_done, total)} {_left(now)}",
        *([f"WAITING   {now.waiting}"] if now.waiting else []),
        f"run       {count}, trial {plan.trial} of {now.trials}{again}: {_motion(plan)}; "
        f"{_PHASES.get(now.phase, 'at rest')}",
        f"speed     {signed_speed(now.v_m_s, plan)} of {signed_speed(now.v_ref_m_s, plan)} mm/s",
        f"force     {force}, load cell {now.f_applied_n:+.0f} N",
        f"pressure  {pressures} bar, limit {now.pressure_max_pa / 1e5:.0f}",
        f"rejected  {_rejected(now)}",
    ]


def _mark(pressure_pa: float, now: Progress) -> str:
    return "!" if pressure_pa > _HIGH * now.pressure_max_pa else ""


def _rejected(now: Progress) -> str:
    last = now.last_rejected
    return "none" if last is None else f"{now.rejected}; {last.plan.run}: {'; '.join(last.reasons)}"


def _count(number: int, now: Progress) -> str:
    return f"{number} of {'at most ' if now.at_most else ''}{now.runs_total}"


def _line(ended: Ended, now: Progress) -> str:
    """Return a finished run's verdict in a line."""
    plan = ended.plan
    start = f"{plan.run} {_motion(plan)}, trial {plan.trial}: "
    if not ended.reasons:
        friction = "" if ended.friction_n is None else f", friction {ended.friction_n:+.1f} N"
        return f"{start}accepted{friction}; {_left(now)}"
    again = "; will be repeated" if ended.again else ""
    return f"{start}rejected: {'; '.join(ended.reasons)}{again}"


def _motion(plan: RunPlan) -> str:
    load = "" if plan.f_load_n is None else f", {plan.f_load_n:+.0f} N"
    label = f"{plan.label}, " if plan.label else ""
    kind = KINDS[plan.kind]
    speed = "" if kind.is_at_rest else f" {signed_speed(plan.v_ref_m_s, plan)} mm/s"
    if kind.raises_force:
        speed = f" {plan.force_rate_n_s or 0.0:+.0f} N/s"
    elif kind.is_ramp and plan.a_ref_m_s2 is not None:
        speed += f" at {plan.a_ref_m_s2:.3g} m/s^2"
    return f"{label}{kind.display_name}{speed}{load}"


def _left(now: Progress) -> str:
    if now.seconds_left is None:
        return "time left not known yet"
    minutes, seconds = divmod(round(now.seconds_left), 60)
    hours, minutes = divmod(minutes, 60)
    clock = f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
    return f"{'at most ' if now.at_most else ''}{clock} left"
