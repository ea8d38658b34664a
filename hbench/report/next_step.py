"""What to do next with a campaign, in words."""

from collections import Counter

from hbench.records import Results
from hbench.report.campaign.page_tables import friction_budget_table
from hbench.report.campaign.quality.verdict import next_step
from hbench.report.campaign.reasons import aborted_words, stopped_by_fault
from hbench.sentences import uncapital

_CAUSE = "Find and correct the cause of the stop."


def next_step_words(results: Results) -> str:
    """Return what to do next; empty if nothing is."""
    return _step_words(next_step_of(results))


def decided_step_words(results: Results, step: str) -> str:
    """Return what to do next after an acceptance, with its own ``step``; without one, nothing.

    What U does not contain is improved nevertheless, and an aborted campaign is continued first.
    """
    if aborted_words(results):
        return next_step_words(results)
    beyond = "" if step else next_step_of(results, beyond_u=True)
    return _step_words(f"{step}." if step else beyond)


def next_step_of(results: Results, beyond_u: bool = False) -> str:
    """Return what improves the data, with the table of the parts of the uncertainty.

    The cause of a stop comes first: a campaign that continues with it stops again.
    """
    parts = "[[uncertainty]]" if friction_budget_table(results).rows else ""
    step = next_step(
        results.quality,
        _largest(results, parts),
        bool(aborted_words(results)),
        results.provenance.source == "imported",
        beyond_u,
    )
    return f"{_CAUSE} {step}" if stopped_by_fault(results) else step


def _step_words(step: str) -> str:
    return f"Next step: {uncapital(step)}" if step else ""


def _largest(results: Results, table: str) -> str:
    """Name the largest parts of the instruments' uncertainty of friction, and their table."""
    parts = [point.parts_n for curve in results.curves for point in curve.points if point.parts_n]
    names = Counter(max(each, key=lambda name: abs(each[name])) for each in parts)
    return "; ".join(filter(None, (" and ".join(name for name, _ in names.most_common(2)), table)))
