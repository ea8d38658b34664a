"""Tables of the page: records as rows of text, in display units."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from math import hypot, sqrt
from statistics import fmean, stdev

from hbench.records import (
    EfficiencyCurve,
    PressureLine,
    Results,
    RunPlan,
    ScreenedRun,
)
from hbench.records.numbers import NORMAL_95
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.reasons import cause_of, code_of, reason_counts
from hbench.report.campaign.table_columns import (
    HERSEY,
    OF_DIRECTIONS,
    OF_LOAD,
    OIL,
    ROD_SIDE,
    SIGMAS,
    WHO,
    in_bar,
    rod_side,
    table,
    who,
)
from hbench.report.render.numbers import (
    NONE,
    in_mm_s,
    number,
    short,
    significant,
    span,
    with_interval,
    with_minus,
)
from hbench.report.render.word_tables import Cell, Table
from hbench.sentences import capital, counted
from hbench.units import from_si

_RUN = ("Run", *WHO, "Reference (mm/s)", "Trial")


def point_table(results: Results) -> Table:
    """Return the points of all friction curves."""
    head = (
        *WHO,
        "Velocity (mm/s)",
        "Friction ± trials (N)",
        "Trials",
        "U (N)",
        "F_T (N)",
        "F_applied (N)",
        "p_Tp (bar)",
        "p_Tr (bar)",
        OIL,
        HERSEY,
    )
    rows: list[tuple[str | Cell, ...]] = [
        (
            *who(curve),
            number(1e3 * point.v_m_s, 2),
            with_interval(point.friction_n, point.ci95_n),  # the next column has the trials
            str(point.n),
            "" if point.u95_n is None else significant(point.u95_n, 2),
            number(point.f_test_n),
            number(point.f_applied_n),
            in_bar(point.p_tp_pa),
            in_bar(point.p_tr_pa),
            "" if point.temp_k is None else number(from_si(point.temp_k, "degC"), 1),
            "" if point.hersey_m is None else significant(1e9 * point.hersey_m, 3),
        )
        for curve in without_common_rod_pressure(results.curves)
        for point in curve.points
    ]
    return table(head, rows)


def efficiency_table(results: Results) -> Table:
    """Return the points of the efficiency curves with a load; a remark on all is its message."""
    curves = without_common_rod_pressure(loaded(results.efficiency))
    remarks = {point.reason for curve in curves for point in curve.points}
    common = remarks.pop() if len(remarks) == 1 else ""
    rows = [
        (
            *who(curve),
            number(1e3 * point.v_m_s, 2),
            _percent(point.efficiency),
            _percent(point.sigma),
            _percent(point.sigma_as_printed),
            _share(point.sigma_trials),
            _percent(point.u95),
            "" if common else point.reason,
        )
        for curve in curves
        for point in curve.points
    ]
    head = (
        "Velocity (mm/s)",
        "Efficiency (%)",
        *SIGMAS[:2],
        "s.e. of trials (% points)",
        SIGMAS[2],
    )
    return table((*WHO, *head, "Remark"), rows, [f"{capital(common)}."] if common else ())


def loaded(curves: Iterable[EfficiencyCurve]) -> list[EfficiencyCurve]:
    """Return the curves with a load: without one, only friction of the load side is driven."""
    return [curve for curve in curves if curve.f_load_n != 0]


_LEAST_PART = 0.01  # of the combined uncertainty; smaller parts are not listed


def friction_budget_table(results: Results) -> Table:
    """Return friction at the working speed and the parts of its uncertainty, a column each."""
    rows, parts = [], []
    for curve in without_common_rod_pressure(results.curves):
        speeds = {series.v_m_s for series in results.headline.series if series.kind == curve.kind}
        for point in curve.points:
            if point.u95_n is None or point.ci95_n is None or abs(point.v_m_s) not in speeds:
                continue
            trials = stdev(point.trials_n) / sqrt(point.n)
            sigmas = {name: abs(part) for name, part in point.parts_n.items()} | {"trials": trials}
            if point.sigma_drift_n is not None:
                sigmas["drift"] = abs(point.sigma_drift_n)
            combined = hypot(*sigmas.values())
            if combined == 0:
                continue
            large = {n: each for n, each in sigmas.items() if each >= _LEAST_PART * combined}
            parts.append({name: significant(each, 2) for name, each in _ranked(large)})
            rows.append(
                (
                    *who(curve),
                    with_interval(curve.against_motion * point.friction_n, point.u95_n),
                    significant(combined, 2),
                    _degrees_of_freedom(point.u95_dof) if point.sigma_drift_n is None else NONE,
                    significant(point.u95_n / combined, 3),
                )
            )
    head = (*WHO, "Friction ± U (N)", "u (N)", "ν", "k")
    return _with_parts(head, rows, parts, "N")


def _ranked(sigmas: dict[str, float]) -> list[tuple[str, float]]:
    """Return the parts of an uncertainty, largest first."""
    return sorted(sigmas.items(), key=lambda part: -part[1])


def _with_parts(
    head: Sequence[str],
    rows: Sequence[tuple[str | Cell, ...]],
    parts: Sequence[dict[str, str]],
    unit: str,
) -> Table:
    """Return a table with a column for each part, in the order of the first row that has it."""
    names = list(dict.fromkeys(name for each in parts for name in each))
    cells = [
        (*row, *(each.get(name, "") for name in names))
        for row, each in zip(rows, parts, strict=True)
    ]
    return table((*head, *(f"{capital(name)} ({unit})" for name in names)), cells)


def _degrees_of_freedom(dof: float | None) -> str:
    return "∞" if dof is None else "> 100" if dof > 100 else number(dof)


def budget_table(results: Results) -> Table:
    """Return each curve's mean efficiency and the parts of its uncertainty, a column each."""
    rows: list[tuple[str | Cell, ...]] = []
    parts = []
    for curve in without_common_rod_pressure(loaded(results.efficiency)):
        if curve.mean is None or curve.mean.sigma is None:
            continue
        sigmas = {name: abs(sigma) for name, sigma in curve.mean.parts.items()}
        if curve.mean.sigma_trials is not None:
            sigmas["trials"] = curve.mean.sigma_trials
        parts.append({name: _share(each) for name, each in _ranked(sigmas)})
        rows.append(
            (
                *who(curve),
                str(curve.mean.points),
                _percent(curve.mean.efficiency),
                Cell(_share(u)) if (u := curve.mean.sigma_combined) else Cell(NONE, "one trial"),
                Cell(_share(NORMAL_95 * u) if u else NONE),
            )
        )
    head = (*WHO, "Speeds", "Mean efficiency (%)", "u (% points)", "U = 1.96 u (% points)")
    return _with_parts(head, rows, parts, "% points")


def band_table(results: Results) -> Table:
    """Return friction against pressure: both directions, half band, middle, energy of a cycle."""
    rows = [
        (
            band.label,
            rod_side(band.p_lr_ref_pa),
            in_bar(band.p_tp_pa),
            in_mm_s(band.v_m_s),
            with_interval(band.extend.friction_n, band.extend.ci95_n),
            with_interval(band.retract.friction_n, band.retract.ci95_n),
            with_interval(band.half_n, band.half_ci95_n),
            with_interval(band.middle_n, band.middle_ci95_n),
            "" if band.energy_j is None else with_interval(band.energy_j, band.energy_ci95_j),
            str(band.n),
        )
        for band in without_common_rod_pressure(results.bands)
    ]
    head = (
        *("Label", ROD_SIDE, "Pressure (bar)", "Speed (mm/s)", *OF_DIRECTIONS),
        *("Half band (N)", "Middle of band (N)", "Energy of a cycle (J)", "Trials of both"),
    )
    return table(head, rows)


def trend_table(results: Results) -> Table:
    """Return slope and intercept of half band and middle over pressure."""
    lines = Counter((t.label, t.specimen, t.p_lr_ref_pa) for t in results.band_trends)
    two_speeds = max(lines.values(), default=0) > 1
    rows = [
        (
            trend.label,
            rod_side(trend.p_lr_ref_pa),
            span([from_si(p, "bar") for p in trend.pressures_pa]),
            in_mm_s(fmean(band.v_m_s for band in trend.bands)) if two_speeds else "",
            *_line(trend.half),
            *_line(trend.middle),
        )
        for trend in without_common_rod_pressure(results.band_trends)
    ]
    head = (
        *("Label", ROD_SIDE, "Pressures (bar)", "Speed (mm/s)"),
        *("Half band, slope (N/bar)", "at 0 bar (N)"),
        *("Middle, slope (N/bar)", "at 0 bar (N)"),
    )
    return table(head, rows)


def balance_table(results: Results) -> Table:
    """Return Coulomb and viscous friction, offset and asymmetry of benches without hydraulics."""
    rows = [
        (
            balance.label,
            "" if balance.f_load_n is None else short(balance.f_load_n),
            span([1e3 * v for v in balance.speeds_m_s]),
            with_interval(balance.coulomb_n, balance.coulomb_ci95_n),
            with_interval(balance.viscous_n_s_m, balance.viscous_ci95_n_s_m),
            with_interval(balance.offset_n, balance.offset_ci95_n),
            with_interval(balance.asymmetry_n_s_m, balance.asymmetry_ci95_n_s_m),
        )
        for balance in results.motion_balances
    ]
    head = (
        *("Label", OF_LOAD, "Speeds (mm/s)", "Coulomb (N)", "Viscous (N s/m)", "Offset (N)"),
        "Asymmetry (N s/m)",
    )
    return table(head, rows)


def rejected_table(results: Results) -> Table:
    """Return the rejected runs, each with its main reason and the names of any further ones."""
    rows = []
    for run, plan in _planned(results):
        if not run.accepted:
            main, *others = dict.fromkeys(map(code_of, run.reasons))
            first = f"{capital(_reason_words(run.reasons[0]))}."
            rows.append((*_run(plan), first, ", ".join(others).replace("_", " ")))
    if not any(others for *_, others in rows):
        return table((*_RUN, "Reason"), [row[:-1] for row in rows])
    further = "Further reasons"
    return table((*_RUN, "Main reason", further), rows, words=("Main reason", further))


def cause_table(results: Results) -> Table:
    """Return the reasons for rejection with their runs, and the cause to look for."""
    rows = [
        (code.replace("_", " ").capitalize(), str(count), cause_of(results, code))
        for code, count in reason_counts(results).most_common()
    ]
    head = ("Reason", "Runs", "Look for")
    return table(head, rows, words=("Look for",))


def remark_table(results: Results) -> Table:
    """Return the remarks on accepted runs; runs with the same one have one row."""
    remarks = defaultdict[str, list[tuple[str, ...]]](list)
    for run, plan in _planned(results):
        if run.accepted and run.notes:
            remarks["; ".join(run.notes)].append(_run(plan))
    return table((*_RUN, "Remark"), [(*_common(rows), text) for text, rows in remarks.items()])


def _common(rows: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Return several runs as one row, with the values that all have; a single run as it is."""
    names, *columns = zip(*rows, strict=True)
    if len(names) == 1:
        return rows[0]
    values = (column[0] if len(set(column)) == 1 else "several" for column in columns)
    return f"{names[0]} and {counted(len(names) - 1, 'other')}", *values


def _planned(results: Results) -> list[tuple[ScreenedRun, RunPlan]]:
    plans = without_common_rod_pressure(run.run.plan for run in results.runs)
    return list(zip(results.runs, plans, strict=True))


def _run(plan: RunPlan) -> tuple[str, ...]:
    return plan.run, *who(plan), in_mm_s(plan.v_ref_m_s), str(plan.trial)


def _reason_words(reason: str) -> str:
    code = code_of(reason)
    return with_minus(reason.replace(code, code.replace("_", " "), 1))


def _line(line: PressureLine) -> tuple[str, str]:
    per_bar = 1 / from_si(1.0, "bar")
    return (
        with_interval(per_bar * line.slope_n_pa, per_bar * line.slope_ci95_n_pa),
        with_interval(line.intercept_n, line.intercept_ci95_n),
    )


def _share(ratio: float | None) -> str:
    return significant(None if ratio is None else 100 * ratio, 2)


def _percent(ratio: float | None) -> str:
    return number(None if ratio is None else 100 * ratio, 1)
