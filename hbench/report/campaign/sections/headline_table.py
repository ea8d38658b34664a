"""Table of the headline numbers: friction, breakaway and efficiency of each direction and load."""

from collections.abc import Collection, Iterable, Sequence

from hbench.records import Curve, HeadlineNumber, HeadlineSeries, Results
from hbench.report.campaign.table_columns import LOAD_CELL, WHO, table, who
from hbench.report.headline import FLAGS
from hbench.report.render.numbers import NONE, half_width, in_mm_s, number, short, with_interval
from hbench.report.render.word_tables import Cell, Table
from hbench.units import from_si


def load_cell_means(results: Results) -> list[float | None]:
    """Return the mean force of the load cell [N] at each series' point of the headline."""
    forces = {
        (*_who(curve), abs(point.v_m_s)): point.f_applied_n
        for curve in results.curves
        for point in curve.points
    }
    return [forces.get((*_who(each), each.v_m_s)) for each in results.headline.series]


def differs_from_load(
    series: Collection[HeadlineSeries], load_cell_n: Iterable[float | None]
) -> bool:
    """Return whether the load cell's force differs from a set load, as the table writes them."""
    return any(
        None not in (force_n, each.f_load_n) and number(force_n, 0) != number(each.f_load_n, 0)
        for each, force_n in zip(series, load_cell_n, strict=True)
    )


def _who(series: Curve | HeadlineSeries) -> tuple:
    load = series.f_load_n, series.p_lr_ref_pa
    return series.kind, series.label, series.direction, *load, series.a_ref_m_s2


def headline_table(series: Sequence[HeadlineSeries], load_cell_n: Sequence[float | None]) -> Table:
    """Return a row a direction and load, with the force of the load cell [N] of each."""
    per_bar = from_si(1.0, "bar")
    common = _common_remark(series)
    rows: list[tuple[str | Cell, ...]] = [
        (
            *who(each)[:1],
            *who(each)[2:],
            in_mm_s(each.v_m_s),
            number(applied, 0),
            _without_one_trial(_cell(each.friction_n)),
            _as_pressure(each.friction_pa, per_bar),
            _trials(each.friction_n),
            _cell(each.breakaway_n).text if common else _breakaway(each),
            _as_pressure(each.breakaway_pa, per_bar),
            _without_one_trial(_cell(each.efficiency, 100.0)),
        )
        for each, applied in zip(series, load_cell_n, strict=True)
    ]
    head = (
        *("At (mm/s)", LOAD_CELL, "Friction ± U (N)", "Friction ± U (bar)", "Trials alone (N)"),
        *(
            f"Breakaway ± U (N){common and f', {common}'}",
            "Breakaway ± U (bar)",
            "Efficiency ± U (%)",
        ),
    )
    return table((WHO[0], *WHO[2:], *head), rows)


def _cell(estimate: HeadlineNumber | None, scale: float = 1.0) -> Cell:
    if estimate is None:
        return Cell(NONE)
    half = None if estimate.u95 is None else scale * estimate.u95
    return Cell(with_interval(scale * estimate.value, half), FLAGS[estimate.basis])


def _as_pressure(estimate: HeadlineNumber | None, scale: float) -> Cell:
    """Return a force as a pressure; its flag is beside the force."""
    return Cell(_cell(estimate, scale).text)


def _without_one_trial(cell: Cell) -> Cell:
    """Return a cell without the flag that the column of the trials has."""
    return Cell(cell.text) if cell.flag == FLAGS["one_trial"] else cell


def _breakaway(series: HeadlineSeries) -> Cell:
    """Return breakaway with the rest that it was measured after, or what else it is."""
    cell = _cell(series.breakaway_n)
    if series.breakaway_dwell_s is None:
        return cell
    return Cell(f"{cell.text} {_breakaway_remark(series)}")


def _breakaway_remark(series: HeadlineSeries) -> str:
    """Return after which rest breakaway was measured, or how else it was determined."""
    if series.breakaway_dwell_s is not None:
        return f"after {short(series.breakaway_dwell_s)} s at rest"
    return "" if series.breakaway_n is None else FLAGS[series.breakaway_n.basis]


def _common_remark(series: Sequence[HeadlineSeries]) -> str:
    """Return the remark that breakaway has in all of several series; else empty."""
    remarks = [_breakaway_remark(each) for each in series if each.breakaway_n is not None]
    return remarks[0] if len(remarks) > 1 and len(set(remarks)) == 1 else ""


def _trials(estimate: HeadlineNumber | None) -> str:
    if estimate is not None and estimate.basis == "one_trial":
        return FLAGS["one_trial"]
    return "" if estimate is None or estimate.ci95 is None else f"±{half_width(estimate.ci95)}"
