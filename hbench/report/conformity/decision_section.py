"""Section of the campaign's report with the decisions of the last ``hbench accept``."""

from collections.abc import Sequence

from hbench.records.conformity.acceptance import ConformityCheck, Rule
from hbench.report.conformity.text import (
    CONFORMS,
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
    limits. The only paragraph states the decision and the lowest probability of conformity.
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
    words = f"Decision: {decision} (by the last hbench accept)."
    known = [check.probability for check in checks if check.probability is not None]
    if known:
        each = "" if len(known) == len(checks) else " that is known"
        words += f" The lowest probability of conformity{each} is {probability_words(min(known))}, "
        words += "with the uncertainty U taken into account."
    items = [f"limits: {limits}"] if limits else []
    items += [f"rule: {rule_words(rule, largest_uncertainty)}"] if rule else []
    items += [CONFORMS] if known else []
    items = [capital(item) for item in (*items, *legend(checks))] if rows else []
    return Section("Decision", (words,), tables=(table,) if rows else (), items=tuple(items))
