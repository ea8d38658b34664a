"""Section of the campaign's report with the decisions of the last ``hbench accept``."""

from collections.abc import Sequence

from hbench.records.conformity.acceptance import ConformityCheck
from hbench.report.conformity.text import (
    limit_words,
    measured_words,
    requirement_words,
    series_words,
)
from hbench.report.render.document import Section
from hbench.report.render.symbols import capital
from hbench.report.render.word_tables import Cell, Table

_HEAD = ("Quantity", "Series", "Measured ± U", "Limit", "Decision")


def decision_section(decision: str, checks: Sequence[ConformityCheck]) -> Section:
    """Return the decision on the cylinder and a row for each of its checks.

    The first paragraph states the decision in a sentence.
    """
    rows = tuple(
        (
            Cell(capital(requirement_words(check.requirement, check.measurement))),
            Cell(series_words(check.requirement, check.measurement)),
            Cell(measured_words(check)),
            Cell(limit_words(check.requirement)),
            Cell("PASS") if check.decision == "PASS" else Cell(check.reason, check.decision),
        )
        for check in checks
    )
    table = Table(_HEAD, rows, frozenset(_HEAD) - {"Measured ± U"}, title="Decisions")
    words = f"Decision: {decision} (by the last hbench accept)."
    return Section("Decision", (words,), tables=(table,) if rows else ())
