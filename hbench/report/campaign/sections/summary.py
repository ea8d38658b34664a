"""The first section of the page: friction at the working speed, breakaway, efficiency."""

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

from hbench.records import KINDS, Curve, HeadlineNumber, HeadlineSeries, Results
from hbench.records.fits import LEAST_HELD_OUT_SPEEDS
from hbench.records.rod_pressure import differs_in_rod_pressure, without_rod_pressure
from hbench.report.campaign.fit_tables import fits_verdict
from hbench.report.campaign.page_tables import friction_budget_table
from hbench.report.campaign.quality.completeness import short_point_table
from hbench.report.campaign.quality.plausibility import implausible_table
from hbench.report.campaign.quality.tables import quality_table
from hbench.report.campaign.quality.verdict import (
    RULE,
    instruments_percent,
    quality_count,
    quality_verdict,
)
from hbench.report.campaign.reasons import aborted_words, is_aborted
from hbench.report.campaign.table_columns import LOAD_CELL, WHO, table, who
from hbench.report.drift import drift_fact
from hbench.report.drift_section import drift_sections
from hbench.report.headline import FLAGS, extrapolated_words, headline_tiles
from hbench.report.next_step import next_step_of
from hbench.report.oil_words import temperature_words
from hbench.report.render.document import Section
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import (
    NONE,
    half_width,
    number,
    short,
    span,
    with_interval,
)
from hbench.report.render.word_tables import Cell, Table
from hbench.report.zero_words import zero_reserve
from hbench.sentences import counted, listed, plural
from hbench.units import from_si

_ONE_TRIAL = (
    " A number of one trial has no U: a single trial does not show the scatter of repetitions."
)
_EFFICIENCY = (
    "F_applied / F_T where the oil drives the load, F_T / F_applied where the load drives the oil. "
    "F_T = F_applied + friction is the pressure force of the test cylinder; friction counts "
    "as negative when it retracts."
)
_LOAD = (
    "The set load F_L is the pressure force of the load cylinder. The load cell measures "
    "F_applied, which differs from F_L by the friction of the load cylinder, also at a set load "
    "of 0 N."
)
_NOMINAL_LOAD = (
    "F_L is the nominal load from the map of the import. F_applied is the force that the load "
    "cell measured."
)
_LONG = 12  # rows; a longer table starts folded


def summary_section(
    results: Results, decided: bool = False, curves: tuple[Drawing, ...] = ()
) -> Section:
    """Return tiles, ``curves``, a row for each direction and load, and the checks of the data.

    Of a cylinder that was ``decided`` on, it has the verdict on the data too.
    """
    series = results.headline.series
    if not differs_in_rod_pressure(results.curves):
        series = without_rod_pressure(series)
    known = _instruments_known(results)
    with_u = any(
        number is not None and number.u95
        for each in series
        for number in (each.friction_n, each.breakaway_n, each.efficiency)
    )
    title = "Results of each direction and load"
    title += f", with {'expanded uncertainty ' * known}U" if with_u else ""
    load_cell_n = _load_cell(results)
    table_of_series = _table(series, load_cell_n)
    tables = (replace(table_of_series, title=title),) if series else ()
    budget = friction_budget_table(results)
    heading = f"Each direction and load ({len(series)})"
    folded = (Section(heading, tables=tables, folded=True),) if len(series) > _LONG else ()
    parts = "[[uncertainty]]" if budget.rows else ""
    load = _NOMINAL_LOAD if results.provenance.source == "imported" else _LOAD
    zeros = zero_reserve(results) if known and with_u else ""
    drift = any(p.sigma_drift_n is not None for curve in results.curves for p in curve.points)
    uncertainty = _uncertainty(series, parts, known, drift)
    share = instruments_percent(results.quality) if _ONE_TRIAL.strip() in uncertainty else ""
    alone = f"The tolerances of the instruments alone give ±{share} %." if share else ""
    facts = (
        ("Measured", _measured(results)),
        ("Data", _data(results) if decided else ""),
        ("Drift", drift_fact(results.drift)),
        ("Oil", temperature_words(results)),
        ("Friction laws", _laws(results)),
    )
    terms = (
        ("Uncertainty", " ".join(filter(None, (uncertainty, alone, zeros)))),
        ("Breakaway", extrapolated_words(results)),
        ("Efficiency", _EFFICIENCY if any(each.efficiency for each in series) else ""),
        ("Load", load if _differs_from_load(series, load_cell_n) else ""),
    )
    return Section(
        "Summary",
        drawings=curves,
        tables=() if folded else tables,
        facts=_stated(facts),
        tiles=tuple(headline_tiles(results)),
        parts=(
            *folded,
            *_terms(_stated(terms)),
            Section(
                f"Quality of the data: {quality_count(results.quality)}",
                (RULE,),
                tables=(quality_table(results.quality),),
                parts=tuple(_quality_details(results)),
                anchor="quality",
                folded=results.quality.grade != "poor",
            ),
            *drift_sections(results),
        ),
    )


def _stated(facts: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    return tuple((name, words) for name, words in facts if words)


def _terms(facts: tuple[tuple[str, str], ...]) -> tuple[Section, ...]:
    """Return a folded part that explains the columns of the table; its title names them."""
    names = listed([name.lower() for name, _ in facts])
    verb = plural(len(facts), "means", "mean")
    return (Section(f"What {names} {verb} here", facts=facts, folded=True),) if facts else ()


def _data(results: Results) -> str:
    """Return the verdict on the data, and what improves it."""
    aborted = bool(aborted_words(results))
    verdict = quality_verdict(results.quality, not aborted)
    step = "" if aborted else next_step_of(results)
    return " ".join(filter(None, (verdict, step)))


def _laws(results: Results) -> str:
    """State how many fits determine all parameters, and which table compares the laws."""
    selections = [curve.selection for curve in results.curves]
    selections += [joint.selection for joint in results.joint_fits]
    speeds = [len(c.points) for c in results.curves if KINDS[c.kind].has_constant_speed and c.fits]
    few = bool(speeds) and max(speeds) < LEAST_HELD_OUT_SPEEDS
    not_compared = f"The laws are not compared: that takes {LEAST_HELD_OUT_SPEEDS} speeds." * few
    compared = "[[laws]] compares the laws." if any(selections) else not_compared
    return " ".join(filter(None, (fits_verdict(results), compared)))


def _instruments_known(results: Results) -> bool:
    """Return whether the uncertainty of friction contains the instruments, where there is any."""
    points = [point for curve in results.curves for point in curve.points]
    return not points or any(point.sigma_instruments_n is not None for point in points)


def _uncertainty(series: Collection[HeadlineSeries], budget: str, known: bool, drift: bool) -> str:
    """State what U is, and which table has its parts; empty if no number of the summary has one."""
    numbers = [n for each in series for n in (each.friction_n, each.breakaway_n, each.efficiency)]
    single = any(each is not None and each.basis == "one_trial" for each in numbers)
    if all(each is None or each.u95 is None for each in numbers):
        return _ONE_TRIAL.lstrip() if single else ""
    parts = f" {budget} contains its factor k and its parts." if budget else ""
    without = "It does not contain the errors of the instruments, whose tolerances are not known."
    if known:
        of = "trials, instruments and drift" if drift else "trials and instruments"
        what = (
            f"U is the expanded uncertainty of {of} together, for a coverage probability of 95 %."
        )
    elif drift:
        what = f"U is the expanded uncertainty of trials and drift, for 95 %. {without}"
    else:
        what = f"U is the half-width of the 95 % interval of the trials. {without}"
    what += parts if known or drift else ""
    return f"{what}{_ONE_TRIAL if single else ''}"


def _quality_details(results: Results) -> Iterable[Section]:
    short = results.quality.completeness.short_points
    implausible = results.quality.implausible
    if not differs_in_rod_pressure(results.curves):
        short, implausible = without_rod_pressure(short), without_rod_pressure(implausible)
    details = (
        ("Points without enough trials", short_point_table(short)),
        ("Implausible signs", implausible_table(implausible)),
    )
    for title, each in details:
        count = len(each.rows)
        if count:
            if count <= _LONG:
                yield Section(tables=(replace(each, title=title),))
            else:
                printed = not aborted_words(results)  # nearly all points are short then
                name = f"{title} ({count})"
                yield Section(name, tables=(each,), folded=True, printed=printed)


def _load_cell(results: Results) -> list[float | None]:
    """Return the mean force of the load cell [N] at each series' point of the headline."""
    forces = {
        (*_who(curve), abs(point.v_m_s)): point.f_applied_n
        for curve in results.curves
        for point in curve.points
    }
    return [forces.get((*_who(each), each.v_m_s)) for each in results.headline.series]


def _differs_from_load(
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


def _table(series: Sequence[HeadlineSeries], load_cell_n: Sequence[float | None]) -> Table:
    per_bar = from_si(1.0, "bar")
    common = _common_remark(series)
    rows: list[tuple[str | Cell, ...]] = [
        (
            *who(each)[:1],
            *who(each)[2:],
            number(None if each.v_m_s is None else 1e3 * each.v_m_s),
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


def _measured(results: Results) -> str:
    """Return runs, speeds, loads and directions in a sentence."""
    kinds = Counter(KINDS[run.run.plan.kind] for run in results.runs)
    counts = ", ".join(kind.counted(count) for kind, count in kinds.items()) or "none"
    of_all = f"{counted(len(results.runs), 'run')}"
    runs = f"{of_all} ({counts})"
    if len(kinds) == 1:
        (kind,) = kinds
        runs = of_all.replace(" ", f" {kind.display_name} ")
    made, phrases = _not_accepted(results), []
    curves = [curve for curve in results.curves if KINDS[curve.kind].has_constant_speed]
    points = [point for curve in curves for point in curve.points]
    if points:
        speeds = f"at {span([1e3 * abs(p.v_m_s) for p in points])} mm/s"
        if len(kinds) == 1 and not made:
            runs += f" {speeds}"
        else:
            phrases.append(f"steady {speeds}")
        loads = {abs(c.f_load_n) for c in curves if c.f_load_n is not None}
        if loads:
            phrases.append(f"{counted(len(loads), 'load')} of {span(loads)} N")
        both = len({curve.direction for curve in curves}) == 2
        phrases.append("both directions" if both else "one direction")
        if not any(curve.over_velocity for curve in curves):
            pressures = [p.p_tp_pa / 1e5 for p in points if p.p_tp_pa is not None]
            phrases += [f"piston-side pressure {span(pressures)} bar"] if pressures else []
    if made:
        of_accepted = f" Accepted: {', '.join(phrases)}." if phrases else ""
        return f"{runs}, of which {made}.{of_accepted}"
    return f"{', '.join([runs, *phrases])}."


def _not_accepted(results: Results) -> str:
    """Count the runs that were interrupted and those rejected; empty if all are accepted."""
    aborted = sum(is_aborted(run) for run in results.runs)
    rejected = sum(not run.accepted for run in results.runs) - aborted
    counts = ((aborted, "interrupted"), (rejected, "rejected"))
    parts = [f"{count} {plural(count, 'was', 'were')} {how}" for count, how in counts if count]
    return " and ".join(parts)
