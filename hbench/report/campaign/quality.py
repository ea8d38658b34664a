"""The verdict on a campaign's data in words: its checks as a table and as a sentence."""

from hbench.records import Quality, QualityCheck
from hbench.report.render.numbers import number
from hbench.report.render.word_tables import Cell, Table

RULE = (
    "Each check is good, to be used with care, or poor; the verdict is the worst of them. The "
    "limits are hbench's own; no standard sets them. Each fit has its own verdict."
)
_NAMES = {
    "runs_accepted": "Runs accepted",
    "trials_per_point": "Trials per point",
    "repeatability": "Repeatability",
    "instruments": "Instruments",
}
_LIMITS = {
    "runs_accepted": "good from {good:g} %, poor below {poor:g} %",
    "trials_per_point": "good from {good:g}, poor with {poor:g}",
    "repeatability": "good to {good:g} %, poor above {poor:g} %",
    "instruments": "good to {good:g} %; above, the level is uncertain, differences less so",
}
_HEAD = ("Check", "Verdict", "Found", "Limits")


def quality_table(quality: Quality) -> Table:
    """Return a row for each check."""
    rows = tuple(
        (Cell(_name(check)), _grade(check), Cell(_value(check)), Cell(_limits(check)))
        for check in quality.checks
    )
    return Table(_HEAD, rows, frozenset(_HEAD))


def quality_verdict(quality: Quality) -> str:
    """Return the verdict as a sentence or two."""
    if quality.grade == "good":
        return f"The data is good: all {len(quality.checks)} checks of its quality pass."
    worst = [check for check in quality.checks if check.grade == quality.grade]
    reasons = "; ".join(f"{_name(check).lower()}: {_value(check)}" for check in worst)
    if quality.grade == "poor":
        return f"The data is poor; do not rely on the numbers below. {_capital(reasons)}."
    return f"Use the data with care. {_capital(reasons)}."


def _name(check: QualityCheck) -> str:
    return _NAMES[check.name]


def _value(check: QualityCheck) -> str:
    if check.name == "runs_accepted":
        return f"{check.count} of {check.of}, {number(check.value)} %"
    if check.name == "trials_per_point":
        single = check.value == check.poor
        return "a point has one trial only, so no interval" if single else f"at least {check.value}"
    if check.name == "repeatability":
        return f"95 % interval of the trials is ±{number(check.value)} % of friction (median)"
    if check.value is None:
        return "tolerances are not known"
    return f"95 % interval of the instruments is ±{number(check.value)} % of friction (median)"


def _limits(check: QualityCheck) -> str:
    return _LIMITS[check.name].format(good=check.good, poor=check.poor)


def _grade(check: QualityCheck) -> Cell:
    return Cell("good") if check.grade == "good" else Cell("", check.grade)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
