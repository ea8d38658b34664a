"""Findings of the checks of a campaign's data, in words."""

from hbench.records import Quality, QualityCheck
from hbench.report.drift import drift_finding, drift_words
from hbench.report.quality_words import FINDINGS, NAMES, WRONG_BALANCE
from hbench.report.render.numbers import number, significant
from hbench.sentences import counted, plural

_WRONG_SIGN = "friction has the direction of the motion, or the efficiency is above 100 %"
_UNKNOWN_DRIFT = (
    "F_T - F_applied changes over the campaign in both directions alike; by how much is not known"
)


def reason(check: QualityCheck, stated: bool = False) -> str:
    """Write what a check found, for a sentence; shorter where U is ``stated`` before."""
    if check.name == "instruments" and check.value is not None:
        if stated:
            percent = number(check.value, 0)
            return f"the tolerances of the instruments alone give ±{percent} % (median)"
        return f"the tolerances of the instruments{_value(check).removeprefix('their tolerances')}"
    if check.name == "complete" and check.value is not None and check.count != check.of:
        limit = f" (poor below {check.poor:g} %)" if check.grade == "poor" else ""
        return f"{number(check.value, 0)} % of the planned runs were completed{limit}"
    if is_without_trial(check):
        return _without_trial(check.count or 0)
    if check.name == "runs_accepted":
        were = plural(check.count or 0, "was", "were")
        return f"{check.count} of {check.of} runs {were} accepted"
    if check.drift is not None:
        return drift_finding(check.drift)
    return f"{NAMES[check.name].lower()}: {_value(check)}"


def finding(check: QualityCheck, quality: Quality) -> str:
    """Write what a check found, for the table; the points without a trial are counted."""
    points = quality.completeness.short_points
    none, single = (sum(point.accepted == count for point in points) for count in (0, 1))
    if is_without_trial(check) and single:
        return f"{_value(check)}, one at {counted(single, 'point')}"
    if check.name != "complete" or not none:
        return _value(check)
    return f"{_value(check)}; {_without_trial(none)}"


def _value(check: QualityCheck) -> str:
    """Write the numbers of a check; most checks need no more than ``FINDINGS``."""
    value = "" if check.value is None else number(check.value)
    if check.drift is not None:
        return drift_words(check.drift)
    if check.name == "complete":
        made = f"{check.count} of {check.of} planned runs were"
        return f"{made} made" if check.count == check.of else f"{made} completed, {value} %"
    if check.name == "trials_per_point":
        return _trials(check)
    if check.name == "plausible_signs":
        return _signs(check)
    if check.name in ("zeros", "zero_drift") and check.value is None:
        return "a sensor shows its lowest value: the whole error of its zero is not known"
    if check.name == "force_drift" and check.value is None:
        return _UNKNOWN_DRIFT
    if check.name == "instruments":
        return _instruments(check)
    words = FINDINGS[check.name].format(
        value=value, count=check.count, of=check.of, good=check.good
    )
    wrong = check.name in ("load_balance", "load_share") and check.grade != "good"
    return f"{words}{WRONG_BALANCE}" if wrong else words


def _trials(check: QualityCheck) -> str:
    if is_without_trial(check):
        return f"none at {counted(check.count or 0, 'point')}"
    if check.value == check.poor:
        return "at least one point has a single trial, so no interval"
    return f"at least {check.value}"


def _instruments(check: QualityCheck) -> str:
    if check.value is None:
        return "tolerances are not known"
    median = "" if check.of == 1 else ", median over all operating points"
    percent = significant(check.value, 2)
    return f"their tolerances make friction uncertain by ±{percent} % (95 %{median})"


def _signs(check: QualityCheck) -> str:
    if not check.value:
        return "friction opposes the motion at all points"
    if not check.count:
        return f"at {check.value} of {check.of} points {_WRONG_SIGN}, within the interval"
    return f"at {check.count} of {check.of} points {_WRONG_SIGN}, beyond the interval"


def _without_trial(count: int) -> str:
    return f"{counted(count, 'point')} {plural(count, 'has', 'have')} no accepted trial"


def is_without_trial(check: QualityCheck) -> bool:
    """Return whether a point has no accepted trial."""
    return check.name == "trials_per_point" and check.value == 0
