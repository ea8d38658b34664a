"""Checks of a design in words: a row each, and the notes about them."""

import math
import re
from collections.abc import Sequence

from hbench.records import Check
from hbench.report.design.loops import TextRows, margin
from hbench.report.render.numbers import number, short, significant

LIMITS = (
    "Margins are the smallest over all operating points. The closed loop is simulated with the "
    "firmware on the bench as its file states it, and on two others. The softer one has 20 % less "
    "bulk modulus and viscous friction and 20 % more mass; the stiffer one has the opposite, and "
    "valves of 20 % more gain and 20 % less bandwidth. The limits of the mean speed error and of "
    "the speed ripple are those of the screening and depend on the speed; the table has the run "
    "that is nearest to its limit or farthest beyond it."
)
POINT_LIMITS = (
    "Margins of the present gains at the operating point below, with valve, filters and sampling "
    "of the board. The loops together are stable if their largest pole |z| is below 1. Its "
    "time constant is in the last section."
)
_DECIMALS = {"deg": 1, "dB": 1, "runs": 0}  # of a check's value; two digits in other units
_MOST_DECIMALS = 6
UNSTABLE = (
    "The three loops together are unstable: a margin that passes does not show that its loop is "
    "stable."
)
_STOPPED = re.compile(
    r"^(?:([^:]+): )?run \d+: the board stopped itself: (?:\w+: )?(.*)", re.DOTALL
)
_COMMAND = re.compile(r"\bu_([a-z]\d?)_v\b")
_CODE = re.compile(r"\b[a-z]+(?:_[a-z]+)+(?=: )")  # of a reason for rejection
_VARIANT = re.compile(r"^(softer|stiffer): ")
CHECK_HEAD = ("check", "value", "limit", "unit", "result", "worst at")


def check_rows(checks: Sequence[Check]) -> TextRows:
    """Return a row for each check, as ``CHECK_HEAD``."""
    return [
        (
            *shown(check),
            "PASS" if check.holds else "FAIL",
            _where(check),
        )
        for check in checks
    ]


def causes_of(checks: Sequence[Check]) -> tuple[str, ...]:
    """Return why the board stopped itself in the runs of the checks, each cause once."""
    return tuple(dict.fromkeys(filter(None, map(cause_of, checks))))


def cause_of(check: Check) -> str:
    """Return at which point and why the board stopped itself in a run; empty if it did not."""
    stopped = None if check.holds else _STOPPED.match(check.where)
    if not stopped:
        return ""
    point, words = stopped.groups()
    return f"at {point}, {words}" if point else words


def _where(check: Check) -> str:
    """Return where a check is worst, with symbols and words in place of keys."""
    stopped = None if check.holds else _STOPPED.match(check.where)
    if stopped:
        return ": ".join(filter(None, (stopped[1], "the board stopped itself")))
    text = _CODE.sub(lambda found: found[0].replace("_", " "), check.where)
    return _COMMAND.sub(lambda found: f"u_{found[1].upper()}", text)


def unstable(checks: Sequence[Check]) -> bool:
    """Return whether the checks contain a pole of all loops together that does not decay."""
    return any("modulus" in check.what and not check.holds for check in checks)


def shown(check: Check) -> tuple[str, str, str, str]:
    """Return what a check is of, its value, its limit and their unit."""
    if "modulus" in check.what:
        return "all loops together: largest pole |z|", f"{check.value:.6f}", "< 1", ""
    least = "≥ " if "margin" in check.what else "≤ " if check.limit else ""
    what = _VARIANT.sub(r"\1 bench: ", check.what)
    return what, check_value(check), f"{least}{short(check.limit)}", check.unit


def check_value(check: Check) -> str:
    """Write a check's value, with as many decimals as show on which side of the limit it is."""
    if not math.isfinite(check.value):
        return margin(check.value, 0)
    decimals = _DECIMALS.get(check.unit)
    if decimals is None:
        decimals = len(significant(check.value, 2).partition(".")[2])
    side = check.value >= check.limit, check.value <= check.limit
    while decimals < _MOST_DECIMALS:
        rounded = round(check.value, decimals)
        shown = rounded >= check.limit, rounded <= check.limit
        if shown == side or (check.holds and rounded == check.limit):
            break
        decimals += 1
    return number(check.value, decimals)
