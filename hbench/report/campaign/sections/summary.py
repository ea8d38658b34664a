"""The first section of the page: friction at the working speed, breakaway, efficiency."""

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import replace

from hbench.records import KINDS, HeadlineNumber, HeadlineSeries, Results
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
from hbench.report.campaign.sections.drift import drift_sections
from hbench.report.campaign.sections.headline_table import (
    differs_from_load,
    headline_table,
    load_cell_means,
)
from hbench.report.drift import drift_fact
from hbench.report.headline import extrapolated_words, headline_tiles
from hbench.report.next_step import next_step_of
from hbench.report.oil_words import temperature_words
from hbench.report.render.document import Section
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import span
from hbench.report.zero_words import zero_reserve
from hbench.sentences import counted, listed, plural

_ONE_TRIAL = (
    "A number of one trial has no U: a single trial does not show the scatter of repetitions."
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
    numbers = _numbers(series)
    title = "Results of each direction and load"
    if _any_u(numbers):
        title += f", with {'expanded uncertainty ' * _instruments_known(results)}U"
    load_cell_n = load_cell_means(results)
    table_of_series = headline_table(series, load_cell_n)
    tables = (replace(table_of_series, title=title),) if series else ()
    heading = f"Each direction and load ({len(series)})"
    folded = (Section(heading, tables=tables, folded=True),) if len(series) > _LONG else ()
    load = _NOMINAL_LOAD if results.provenance.source == "imported" else _LOAD
    facts = (
        ("Measured", _measured(results)),
        ("Data", _data(results) if decided else ""),
        ("Drift", drift_fact(results.drift)),
        ("Oil", temperature_words(results)),
        ("Friction laws", _laws(results)),
    )
    terms = (
        ("Uncertainty", _uncertainty(results, numbers)),
        ("Breakaway", extrapolated_words(results)),
        ("Efficiency", _EFFICIENCY if any(each.efficiency for each in series) else ""),
        ("Load", load if differs_from_load(series, load_cell_n) else ""),
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


def _numbers(series: Iterable[HeadlineSeries]) -> list[HeadlineNumber]:
    """Return all numbers of the summary that are known."""
    return [
        known
        for each in series
        for known in (each.friction_n, each.breakaway_n, each.efficiency)
        if known is not None
    ]


def _any_u(numbers: Iterable[HeadlineNumber]) -> bool:
    return any(each.u95 is not None for each in numbers)


def _uncertainty(results: Results, numbers: Collection[HeadlineNumber]) -> str:
    """State what U is, which table has its parts, and what the instruments contribute.

    Empty if no number of the summary has a U or is of one trial.
    """
    of_one_trial: tuple[str, ...] = ()
    if any(each.basis == "one_trial" for each in numbers):
        share = instruments_percent(results.quality)
        alone = f"The tolerances of the instruments alone give ±{share} %." if share else ""
        of_one_trial = _ONE_TRIAL, alone
    if not _any_u(numbers):
        return " ".join(filter(None, of_one_trial))
    known = _instruments_known(results)
    drift = any(p.sigma_drift_n is not None for curve in results.curves for p in curve.points)
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
    has_budget = (known or drift) and friction_budget_table(results).rows
    budget = "[[uncertainty]] contains its factor k and its parts." if has_budget else ""
    zeros = zero_reserve(results) if known else ""
    return " ".join(filter(None, (what, budget, *of_one_trial, zeros)))


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


def _measured(results: Results) -> str:
    """Return runs, speeds, loads and directions in a sentence."""
    kinds = Counter(KINDS[run.run.plan.kind] for run in results.runs)
    counts = ", ".join(kind.counted(count) for kind, count in kinds.items()) or "none"
    of_all = counted(len(results.runs), "run")
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
