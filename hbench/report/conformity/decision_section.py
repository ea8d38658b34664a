"""Section of the campaign's report with the decisions of the last ``hbench accept``."""

import math
from collections.abc import Sequence
from dataclasses import replace

from hbench.records.conformity.acceptance import ConformityCheck, Rule
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
from hbench.report.render.numbers import NONE
from hbench.report.render.symbols import capital
from hbench.report.render.word_tables import Cell, Table

_HEAD = ("Quantity", "Series", "Measured ± U", "Limit", "Conforms", "Decision")
_NUMBERS = {"Measured ± U", "Conforms"}


def decision_section(
    decision: str,
    checks: Sequence[ConformityCheck],
    rule: Rule | None = None,
    largest_uncertainty: float | None = None,
    limits: str = "",
) -> Section:
    """Return the decision on the cylinder and a row for each of its checks.

    ``rule`` is the decision rule with its largest uncertainty, ``limits`` the name of the file of
    limits. The only paragraph states the decision, the lowest probability of conformity, and by how
    much the decisive value is inside or beyond its limit.
    """
    rows = tuple(
        (
            Cell(capital(requirement_words(check.requirement, check.measurement))),
            Cell(series_words(check.requirement, check.measurement) or NONE),
            Cell(measured_words(check)),
            Cell(limit_words(check.requirement)),
            Cell(probability_words(check.probability)),
            Cell("PASS") if check.decision == "PASS" else Cell(check.reason, check.decision),
        )
        for check in checks
    )
    table = Table(_HEAD, rows, frozenset(_HEAD) - _NUMBERS, title="Decisions")
    words = f"Decision: {decision} (by the last hbench accept).{_which(decision, checks)}"
    known = [check.probability for check in checks if check.probability is not None]
    if known:
        each = "" if len(known) == len(checks) else "known "
        words += f" The lowest {each}probability of conformity is {probability_words(min(known))}, "
        words += "with the uncertainty U taken into account."
    words = " ".join(filter(None, (words, _margin_words(decision, checks, rule))))
    items = [f"limits: {limits}"] if limits else []
    items += [f"rule: {rule_words(rule, largest_uncertainty)}"] if rule else []
    items += [CONFORMS] if known else []
    items = [capital(item) for item in (*items, *legend(checks))] if rows else []
    return Section("Decision", (words,), tables=(table,) if rows else (), items=tuple(items))


def _which(decision: str, checks: Sequence[ConformityCheck]) -> str:
    """Name the quantities that make the decision; empty for PASS."""
    if decision == "PASS":
        return ""
    decisive = [check for check in checks if check.decision == decision]
    names = dict.fromkeys(requirement_words(check.requirement, None) for check in decisive)
    verb = "has" if len(decisive) == 1 else "have"
    count = f"{len(decisive)} of {len(checks)} checks {verb} this decision"
    return f" {count}: {'; '.join(names)}." if names else ""


def _margin_words(decision: str, checks: Sequence[ConformityCheck], rule: Rule | None) -> str:
    """State how far the decisive value is from its limit, in multiples of U; empty if unknown.

    That is the one nearest to its limit, or of a failed cylinder the one farthest beyond.
    """
    known = [(margin, check) for check in checks if (margin := check.margin_in_u) is not None]
    if not known or decision not in ("PASS", "FAIL"):
        return ""
    margin, check = min(known, key=lambda each: each[0])
    measured = check.measurement and replace(check.measurement, p_lr_ref_pa=None)
    which = check_words(check.requirement, measured)
    times = f"{math.floor(10 * abs(margin)) / 10:.1f}"
    if decision == "FAIL":
        text = f"The value farthest beyond its limit is that of {which}, by {times} U."
        return text if margin < 0 else ""
    words = f"The value nearest to its limit is that of {which}: it is inside by {times} U"
    same = f", so a U up to {times} times as large would give the same decision"
    return f"{words}{same if rule == 'guard_band' else ''}."
