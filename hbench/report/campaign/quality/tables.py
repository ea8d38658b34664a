"""Table of the checks of a campaign's data."""

from hbench.records import Quality, QualityCheck
from hbench.report.campaign.quality.finding import finding
from hbench.report.quality_words import LIMITS, NAMES
from hbench.report.render.word_tables import Cell, Table

_HEAD = ("Check", "Verdict", "Found", "Limits")


def quality_table(quality: Quality) -> Table:
    """Return a row for each check."""
    rows = tuple(
        (Cell(NAMES[check.name]), _grade(check), Cell(value), Cell(_limits(check)))
        for check, value in ((check, finding(check, quality)) for check in quality.checks)
    )
    return Table(_HEAD, rows, frozenset(_HEAD), title="Checks of the data")


def _limits(check: QualityCheck) -> str:
    return LIMITS[check.name].format(good=check.good, poor=check.poor)


def _grade(check: QualityCheck) -> Cell:
    return Cell("good") if check.grade == "good" else Cell("", check.grade)
