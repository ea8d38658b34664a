"""Analysis of a campaign, and its report."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hbench.analysis.by_kind import analyse_runs
from hbench.analysis.curves.band_trends import band_trends
from hbench.analysis.curves.bands import friction_bands
from hbench.analysis.curves.motion_balance import motion_balances
from hbench.analysis.fitting.fit import unfitted_curves
from hbench.analysis.fitting.joint import joint_fits
from hbench.analysis.screening.calibrate import calibrate
from hbench.analysis.screening.limitations import not_computed, overdue
from hbench.analysis.screening.log_steps import with_common_steps
from hbench.analysis.screening.screen import screen
from hbench.analysis.screening.zero_check import (
    checked_zeros,
    corrected,
    with_zero_checks,
    zeros_over_time,
)
from hbench.analysis.summary.drift import friction_drift
from hbench.analysis.summary.drift_uncertainty import (
    efficiency_with_drift,
    with_drift,
    with_zero_drift,
)
from hbench.analysis.summary.force_checks import direction_notes
from hbench.analysis.summary.headline import at_working_speed, headline
from hbench.analysis.summary.quality import quality
from hbench.analysis.summary.run_clock import RunClock
from hbench.analysis.summary.unlike_trials import unlike_notes
from hbench.analysis.summary.zero_drift import zero_drift
from hbench.analysis.temperature.hersey import with_hersey
from hbench.analysis.temperature.oil_temperature import oil_temperature
from hbench.analysis.uncertainty.efficiency import efficiency_curve
from hbench.analysis.uncertainty.monte_carlo import checked_by_monte_carlo
from hbench.config.files.loading import read_yaml
from hbench.config.fitting import Fitting, parse_fitting
from hbench.errors import ConfigError, DataError
from hbench.experiment.staged_plan import planned_runs
from hbench.parallel.forked import map_forked
from hbench.records import KINDS, Provenance, Results, Run, ScreenedRun, ZeroCheck
from hbench.report.campaign.csv_motions import motion_tables
from hbench.report.campaign.csv_tables import TABLES
from hbench.report.campaign.results_document import results_json
from hbench.store.campaign.folder import StoredCampaign, load_campaign, write_report, write_results
from hbench.store.campaign.journal import Entry
from hbench.store.campaign.stored_acceptance import stored_checks, stored_decision, stored_rule
from hbench.store.campaign.stored_diagnosis import diagnoses
from hbench.untrusted_text import printable

if TYPE_CHECKING:
    from hbench.report.render.document import Document

_DEFAULT_FITTING = Fitting()
_AT_ONCE = 100  # runs that a process screens; a fork takes as long as some 60


def analyze(folder: Path, fit_file: Path | None = None, *, monte_carlo: bool = False) -> Results:
    """Screen, average and fit a campaign; write its tables to ``results/``.

    ``monte_carlo`` checks the expanded uncertainties by drawn errors of the instruments.
    """
    results = derive(load_campaign(folder), _fitting(fit_file), monte_carlo=monte_carlo)
    write_results(folder, _tables(results))
    return results


def report(
    folder: Path,
    fit_file: Path | None = None,
    *,
    form: str = "html",
    speed_m_s: float | None = None,
    monte_carlo: bool = False,
) -> Results:
    """Analyze a campaign and write tables, figures and ``report.`` ``form`` to ``results/``.

    ``form`` is html, md or pdf. ``speed_m_s`` is the working speed of the headline numbers, by
    default the median of the measured speeds. ``monte_carlo`` as in ``analyze``.
    """
    from hbench.report.campaign.figures.all_figures import draw_all  # slow import: matplotlib
    from hbench.report.campaign.page import report_document
    from hbench.report.campaign.reconciled import reconciled_section
    from hbench.report.conformity.decision_section import decision_drawings, decision_section
    from hbench.report.conformity.text import complete_u, next_steps
    from hbench.report.render.document import Document, page
    from hbench.report.render.figures import Drawing, figure_files
    from hbench.report.render.markdown import markdown

    results = derive(load_campaign(folder), _fitting(fit_file), monte_carlo=monte_carlo)
    if speed_m_s is not None:
        results = _at_measured_speed(results, speed_m_s)
    drawings = draw_all(results, png=form == "pdf")
    reconciled = tuple(reconciled_section(*diagnosis) for diagnosis in diagnoses(folder))
    name = printable(folder.resolve().name)
    decision = stored_decision(folder)
    checks = stored_checks(folder)
    decisions: tuple[Drawing, ...] = ()
    decided = None
    if decision:
        rule = stored_rule(folder)
        simulated = results.provenance.source == "simulated"
        decisions = decision_drawings(checks, rule[0], simulated, png=form == "pdf")
        decided = decision_section(decision, checks, *rule, decisions)
    step = next((step for _, step in next_steps(checks)), "")
    document = report_document(
        results, drawings, reconciled, name, decided, step, complete_u(checks)
    )
    forms: dict[str, Callable[[Document], str | bytes]] = {
        "html": page,
        "md": markdown,
        "pdf": _pdf,
    }
    content = forms[form](document)
    text = {f"report.{form}": content if isinstance(content, bytes) else content.encode()}
    write_report(folder, _tables(results) | figure_files((*drawings, *decisions)) | text)
    return results


def _pdf(document: "Document") -> bytes:
    from hbench.report.render.pdf import pdf  # slow import: it embeds fonts

    return pdf(document)


def _fitting(path: Path | None) -> Fitting:
    return _DEFAULT_FITTING if path is None else parse_fitting(read_yaml(path), str(path))


def _at_measured_speed(results: Results, speed_m_s: float) -> Results:
    """Return ``results`` at a working speed. Raises ``ConfigError`` if it was not measured."""
    steady = [curve for curve in results.curves if KINDS[curve.kind].has_constant_speed]
    measured = sorted(
        {f"{1e3 * abs(p.v_m_s):.3g}" for each in steady for p in each.points}, key=float
    )
    results = at_working_speed(results, speed_m_s)
    if measured and all(each.friction_n is None for each in results.headline.series):
        raise ConfigError(
            f"--speed: nothing was measured within {100 * results.headline.v_tolerance:g} % of "
            f"{1e3 * speed_m_s:g} mm/s",
            f"Give one of the measured speeds: {', '.join(measured)} mm/s.",
        )
    return results


def calibrated_runs(campaign: StoredCampaign) -> Iterator[Run]:
    """Yield the runs of a campaign in SI units, read one at a time.

    The zeros that the campaign's own checks found are subtracted from all but these checks.
    """
    return _corrected(campaign, zero_checks(campaign), campaign.start_times_s())


def _corrected(
    campaign: StoredCampaign, checks: Sequence[ZeroCheck], times_s: Mapping[str, float]
) -> Iterator[Run]:
    zeros = zeros_over_time(checks)
    for run in _uncorrected(campaign):
        is_check = KINDS[run.plan.kind].needs_supply_off
        yield run if is_check else corrected(run, zeros, times_s.get(run.plan.run))


def zero_checks(campaign: StoredCampaign) -> tuple[ZeroCheck, ...]:
    """Return the accepted zero checks of a campaign."""
    entries = [e for e in campaign.entries if KINDS[e.plan.kind].needs_supply_off]
    bench = campaign.bench()
    if not entries or bench is None:
        return ()
    rules = campaign.screening()
    runs = _uncorrected(replace(campaign, entries=tuple(entries)))
    accepted = (run for run in runs if screen(run, rules).accepted)
    return checked_zeros(accepted, campaign.start_times_s(), bench)


def _uncorrected(campaign: StoredCampaign) -> Iterator[Run]:
    bench = campaign.bench()
    if campaign.imported or bench is None:  # only imported campaigns can have no bench
        yield from campaign.runs()
    else:
        yield from (calibrate(raw, bench) for raw in campaign.raw_runs())


def screened_runs(campaign: StoredCampaign) -> Iterator[ScreenedRun]:
    """Yield the runs of a campaign with their verdicts, read one at a time."""
    return _screened(campaign, zero_checks(campaign), campaign.start_times_s())


def _screened(
    campaign: StoredCampaign, checks: Sequence[ZeroCheck], times_s: Mapping[str, float]
) -> Iterator[ScreenedRun]:
    rules = campaign.screening()
    return (screen(run, rules) for run in _corrected(campaign, checks, times_s))


def derive(
    campaign: StoredCampaign, how: Fitting = _DEFAULT_FITTING, *, monte_carlo: bool = False
) -> Results:
    """Screen, average and fit a campaign; nothing is written. Raises ``DataError``.

    Accepted steady runs, most of a large campaign, are kept without their samples.
    """
    checks_of_zero = zero_checks(campaign)
    setup = campaign.setup()
    setup = replace(setup, instruments=with_zero_checks(setup.instruments, checks_of_zero))
    times_s = campaign.start_times_s()

    def screened_part(entries: tuple[Entry, ...]) -> list[ScreenedRun]:
        part = replace(campaign, entries=entries)
        return list(map(_without_samples, _screened(part, checks_of_zero, times_s)))

    latest = campaign.latest
    parts = [latest[first : first + _AT_ONCE] for first in range(0, len(latest), _AT_ONCE)]
    screened = with_common_steps(chain.from_iterable(map_forked(screened_part, parts)))
    if not screened:
        raise DataError(
            f"{campaign.folder}: contains no runs", "Continue it with `hbench run --resume`."
        )
    instruments = setup.instruments
    analysed = analyse_runs(screened, setup, how)
    steady = with_hersey(analysed.steady, setup.oil)
    efficiencies = tuple(efficiency_curve(curve, instruments) for curve in steady)
    checks: tuple[str, ...] = ()
    if monte_carlo:
        steady, efficiencies, checks = checked_by_monte_carlo(steady, efficiencies, instruments)
    clock = RunClock.of(screened, times_s, campaign.source_files())
    temperature = oil_temperature(steady, screened, setup, how, clock)
    drift = friction_drift(steady, screened, clock)
    zero = zero_drift(steady, screened, clock, drift)
    steady = with_drift(steady, drift, clock, how.weights)
    steady = with_zero_drift(steady, zero, clock, how.weights)
    efficiencies = efficiency_with_drift(efficiencies, steady)
    curves = (*steady, *analysed.moving)
    provenance = campaign.provenance()
    limitations = (
        *overdue(instruments, _measured_on(provenance)),
        *checks,
        *not_computed(screened, efficiencies, instruments),
        *direction_notes(steady),
        *([zero.note] if zero else []),
        *unlike_notes(steady),
    )
    bands = friction_bands(steady)
    planned, unknown = planned_runs(campaign, screened)
    return Results(
        provenance=provenance,
        runs=screened,
        curves=curves,
        efficiency=efficiencies,
        bands=bands,
        notes=(
            *campaign.warnings,
            *unknown,
            *limitations,
            *unfitted_curves(steady),
            *analysed.notes,
        ),
        motions=replace(analysed.motions, zero_checks=checks_of_zero),
        joint_fits=joint_fits(steady, how, setup.reach),
        band_trends=band_trends(bands),
        motion_balances=motion_balances(steady),
        drift=drift,
        oil_temperature=temperature,
        headline=headline(curves, efficiencies, analysed.motions.breakaways),
        quality=quality(
            screened,
            curves,
            efficiencies,
            planned,
            drift,
            zero,
            checks_of_zero,
            analysed.motions.loops,
            analysed.motions.breakaways,
        ),
    )


def _measured_on(provenance: Provenance) -> str:
    """Return the date of the measurement, as far as it is known: not that of an import."""
    stated = str(provenance.settings.get("test", {}).get("date", ""))
    return stated or ("" if provenance.source == "imported" else provenance.started)


def _without_samples(screened: ScreenedRun) -> ScreenedRun:
    plan = screened.run.plan
    if not screened.accepted or not KINDS[plan.kind].has_constant_speed:
        return screened
    return replace(screened, run=Run(plan, t_s=np.zeros(0), x_m=np.zeros(0)))


def result_tables(results: Results) -> dict[str, str]:
    """Return the text of every table of the results, by its file's name."""
    tables = {name: table(results) for name, table in TABLES.items() if name.endswith(".csv")}
    return tables | motion_tables(results)


def _tables(results: Results) -> dict[str, bytes]:
    texts = {"results.json": results_json(results), **result_tables(results)}
    return {name: text.encode() for name, text in texts.items()}
