"""Points whose friction or efficiency has an implausible sign, in words and as a table."""

from collections.abc import Sequence

from hbench.records import ImplausiblePoint
from hbench.report.campaign.series_words import load_words
from hbench.report.campaign.table_columns import WHO, table, who
from hbench.report.render.numbers import in_mm_s, number, with_interval
from hbench.report.render.word_tables import Table

_NAMED = 3  # points in a sentence


def contradictions(points: Sequence[ImplausiblePoint]) -> str:
    """Report the points whose sign contradicts the motion beyond its interval, by name."""
    beyond = [point for point in points if point.beyond]
    if not beyond:
        return ""
    named = [f"{_where(point)}: {_measured(point)}" for point in beyond[:_NAMED]]
    more = [f"{len(beyond) - _NAMED} more"] if len(beyond) > _NAMED else []
    return (
        "Friction opposes the motion, so a sign, the instruments, their zero or an area are in "
        "error, or a load was not measured: "
        f"{'; '.join([*named, *more])}."
    )


def implausible_table(points: Sequence[ImplausiblePoint]) -> Table:
    """Return the points whose friction or efficiency has an implausible sign."""
    rows = [
        (
            *who(point),
            number(1e3 * point.v_m_s, 2),
            _measured(point),
            "beyond its interval" if point.beyond else "within its interval",
        )
        for point in points
    ]
    return table((*WHO, "Velocity (mm/s)", "Measured", "Remark"), rows, words=("Measured",))


def _where(point: ImplausiblePoint) -> str:
    load = load_words(point.f_load_n, None)
    speed = f"{in_mm_s(abs(point.v_m_s))} mm/s"
    return ", ".join(filter(None, (point.label, point.direction, load, speed)))


def _measured(point: ImplausiblePoint) -> str:
    if point.quantity == "friction_n":
        return f"friction {with_interval(point.value, point.u95)} N"
    half = None if point.u95 is None else 100 * point.u95
    return f"efficiency {with_interval(100 * point.value, half)} %"
