"""Section of the campaign's report with the decisions of the last ``hbench accept``."""

import math
from collections.abc import Sequence
from dataclasses import replace

from hbench.records.conformity.acceptance import (
    WORST_FIRST,
    ConformityCheck,
    Requirement,
    Rule,
)
from hbench.records.rod_pressure import differs_in_rod_pressure
from hbench.report.conformity.text import (
    CONFORMS,
    check_words,
    legend,
    limit_words,
    measured_words,
    probability_words,
    requirement_words,
    rule_words,
    series_words,
)
from hbench.report.render.document import Section
from hbench.report.render.numbers import NONE, as_written
from hbench.report.render.symbols import capital, listed
from hbench.report.render.word_tables import Cell, Table
from hbench.units import from_si

_HEAD = ("Quantity", "Decision", "Series", "Measured ± U", "Limit", "Conforms")
_NUMBERS = {"Measured ± U", "Conforms"}
_EXACT = 1e-9  # of a tenth: 0.3 / 0.1 counts as 3


def decision_section(
    decision: str,
    checks: Sequence[ConformityCheck],
    rule: Rule | None = None,
    largest_uncertainty: float | None = None,
    limits: str = "",
) -> Section:
    """Return the decision on the cylinder and a row for each of its checks, the worst first.

    ``rule`` is the decision rule with its largest uncertainty, ``limits`` the name of the file of
    limits. The only paragraph states the decision, and the value that decides it with its limit,
    its margin and its probability of conformity.
    """
    checks = sorted(_without_common_rod_pressure(checks), key=_worst_first)
    reasons = any(check.reason for check in checks)
    rows = tuple(
        (
            Cell(capital(requirement_words(check.requirement, check.measurement))),
            Cell("PASS") if check.decision == "PASS" else Cell("", check.decision),
            Cell(series_words(check.requirement, check.measurement) or NONE),
            Cell(measured_words(check)),
            Cell(limit_words(check.requirement)),
            Cell(probability_words(check.probability)),
            *([Cell(check.reason)] if reasons else []),
        )
        for check in checks
    )
    head = (*_HEAD, "Reason") if reasons else _HEAD
    table = Table(head, rows, frozenset(head) - _NUMBERS, title="Decisions")
    parts = (f"Decision: {decision}.", _which(decision, checks), nearest_words(decision, checks))
    known = [check.probability for check in checks if check.probability is not None]
    words = [f"limits: the file {limits}, applied by the last hbench accept"] if limits else []
    words += [f"rule: {rule_words(rule, largest_uncertainty)}"] if rule else []
    words += [CONFORMS] if known else []
    facts = [_fact(each) for each in (*words, *legend(checks))] if rows else []
    paragraph = " ".join(filter(None, parts))
    return Section("Decision", (paragraph,), tables=(table,) if rows else (), facts=tuple(facts))


def _without_common_rod_pressure(checks: Sequence[ConformityCheck]) -> list[ConformityCheck]:
    """Return the checks without P_Lr, unless series differ in nothing else."""
    measured = [check.measurement for check in checks if check.measurement]
    if differs_in_rod_pressure(measured):
        return list(checks)
    return [
        replace(
            check, measurement=check.measurement and replace(check.measurement, p_lr_ref_pa=None)
        )
        for check in checks
    ]


def _worst_first(check: ConformityCheck) -> int:
    return WORST_FIRST.index(check.decision) if check.decision in WORST_FIRST else len(WORST_FIRST)


def _fact(line: str) -> tuple[str, str]:
    """Split ``name: words`` and write each with a capital."""
    name, _, words = line.partition(": ")
    return capital(name), f"{capital(words)}."


def _which(decision: str, checks: Sequence[ConformityCheck]) -> str:
    """Name the quantities that make the decision; empty for PASS."""
    if decision == "PASS":
        return ""
    decisive = [check for check in checks if check.decision == decision]
    names = dict.fromkeys(_name(check.requirement) for check in decisive)
    verb = "has" if len(decisive) == 1 else "have"
    count = f"{len(decisive)} of {len(checks)} checks {verb} this decision"
    reasons = " ([[decision]] has the reasons)" if decision == "NOT TESTED" else ""
    return f"{count}: {listed(list(names))}{reasons}." if names else ""


def _name(requirement: Requirement) -> str:
    """Return the name that the file of limits gives a quantity, or else the quantity."""
    return requirement.name or requirement_words(requirement, None)


def nearest_words(decision: str, checks: Sequence[ConformityCheck]) -> str:
    """State the value nearest to its limit, or of a failed cylinder the one farthest beyond.

    The margin is that of the numbers as they are written. Empty where none is known, and where a
    limit was not tested.
    """
    known = [(margin, check) for check in checks if (margin := check.margin_in_u) is not None]
    if not known or decision == "NOT TESTED":
        return ""
    margin, check = min(known, key=lambda each: each[0])
    measured = check.measurement
    if measured is None or (margin < 0) != (decision == "FAIL"):
        return ""
    what = "Farthest beyond its limit" if margin < 0 else "Nearest to its limit"
    which = check_words(check.requirement, replace(measured, p_lr_ref_pa=None))
    limit = f"limit {limit_words(check.requirement)}"
    side = "beyond" if margin < 0 else "inside"
    conforms = f"probability of conformity {probability_words(check.probability)}"
    return (
        f"{what} is {which}: {measured_words(check)}, {limit}; it is {side} by "
        f"{_in_u(check)}, {conforms}."
    )


def _in_u(check: ConformityCheck) -> str:
    """Write the distance from the limit in multiples of U, down to a tenth, as written beside."""
    measured, unit = check.measurement, check.requirement.unit
    assert measured is not None and measured.u95 is not None
    value, half = as_written(from_si(measured.value, unit), from_si(measured.u95, unit))
    low, high = check.requirement.low, check.requirement.high
    ends = [from_si(end, unit) for end in (low, high) if end is not None]
    nearest = min(abs(value - end) for end in ends)
    times = math.floor(10 * nearest / half + _EXACT) / 10
    return f"{times:.1f} U" if times else "less than 0.1 U"
