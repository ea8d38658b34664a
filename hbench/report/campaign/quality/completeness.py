"""Runs and trials that a campaign does not have, in words and as a table."""

from collections.abc import Sequence

from hbench.records import Completeness, PointTrials
from hbench.report.campaign.table_columns import WHO, table, who
from hbench.report.render.numbers import in_mm_s, short
from hbench.report.render.word_tables import Table
from hbench.sentences import plural


def incomplete_words(complete: Completeness) -> str:
    """Report planned runs that were not completed and points without a trial; empty without any."""
    missing = missing_words(complete)
    resume = " Continue it with --resume." if complete.not_completed else ""
    what = "The campaign is incomplete" if complete.not_completed else "Accepted trials are missing"
    return f"{what}: {missing}.{resume}" if missing else ""


def missing_words(complete: Completeness) -> str:
    """Count the runs not completed and the points without enough trials; empty if complete."""
    missing, points = len(complete.not_completed), complete.short_points
    none = sum(point.accepted == 0 for point in points)
    parts = []
    if missing:
        most, were = "at most " if complete.at_most else "", plural(missing, "was", "were")
        parts.append(f"{most}{missing} of {complete.planned} planned runs {were} not completed")
    if none:
        have = plural(none, "has", "have")
        parts.append(f"{none} of {complete.points} points {have} no accepted trial")
    few = len(points) - none
    if parts and few:
        parts.append(f"{few} {plural(few, 'has', 'have')} fewer accepted trials than planned")
    return "; ".join(parts)


def short_point_table(points: Sequence[PointTrials]) -> Table:
    """Return the operating points with fewer accepted trials than planned.

    The unit of the speeds is in the rows where others have a time at rest.
    """
    rests = any(point.dwell_s is not None for point in points)
    head, unit = ("Reference", " mm/s") if rests else ("Reference (mm/s)", "")
    rows = [
        (*who(point), _reference(point, unit), f"{point.accepted} of {point.planned}")
        for point in sorted(points, key=_in_order)
    ]
    return table((*WHO, head, "Accepted trials"), rows)


def _in_order(point: PointTrials) -> tuple:
    """Return the place of a point in a table: by series, then by speed."""
    load, pressure, speed = (
        abs(v or 0.0) for v in (point.f_load_n, point.p_lr_ref_pa, point.v_ref_m_s)
    )
    return point.kind, point.label, point.direction, load, pressure, speed, point.dwell_s or 0.0


def _reference(point: PointTrials, unit: str) -> str:
    if point.dwell_s is not None:
        return f"after {short(point.dwell_s)} s at rest"
    return f"{in_mm_s(point.v_ref_m_s)}{unit}"
