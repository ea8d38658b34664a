"""Comparison of two campaigns."""

from collections.abc import Sequence
from pathlib import Path

from hbench.analysis.comparison import matching
from hbench.analysis.comparison.band_differences import band_differences, trend_differences
from hbench.analysis.comparison.breakaway_differences import breakaway_differences
from hbench.analysis.comparison.difference_tests import InstrumentPair
from hbench.analysis.comparison.differences import campaign_differences
from hbench.analysis.comparison.drift_effects import with_drift_effects
from hbench.analysis.screening.zero_check import with_zero_checks
from hbench.analysis.summary.run_clock import RunClock
from hbench.config.setup import Setup
from hbench.errors import DataError
from hbench.records import CampaignDifferences, Results
from hbench.records.fleet.campaign_names import distinct_names
from hbench.report.campaign.reasons import reason_counts
from hbench.report.comparison.figures import draw_differences
from hbench.report.comparison.text import differences_json, differences_page
from hbench.report.render.figures import figure_files
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.journal import measurements
from hbench.store.files.atomic import write_document
from hbench.workflow.results import derive

_SAME_LOGS = (
    "{count} of the {of} raw logs of A are also those of B: the same measurement under two names, "
    "whose differences are 0"
)
_LOOK_FOR = "`hbench report` states what to look for where runs were rejected. "
_ALIKE = (
    "Measure both at the same kind, direction, load and rod-side pressure, and breakaway after the "
    "same time at rest; imported series need the same label or factors."
)


def compare(
    a: Path,
    b: Path,
    *,
    same_instruments: bool | None = None,
    speed_tolerance: float | None = None,
) -> CampaignDifferences:
    """Compare two campaigns; differences are B minus A.

    ``same_instruments`` means equal instrument errors in both campaigns; by default it is True for
    benches of the same name and kind with equal instruments, and False for campaigns that were
    imported with a map. ``speed_tolerance`` is the largest relative difference of speeds that count
    as the same, by default 2 %, or 20 % where no speed was set; it does not concern curves over
    speed. Raises ``DataError``.
    """
    campaign_a, campaign_b = load_campaign(a), load_campaign(b)
    results_a, results_b = derive(campaign_a), derive(campaign_b)
    setups = campaign_a.setup(), campaign_b.setup()
    if same_instruments is None:
        same_source = results_a.provenance.source == results_b.provenance.source
        same_instruments = same_source and _of_one_bench(*setups)
    instruments = InstrumentPair(
        with_zero_checks(setups[0].instruments, results_a.motions.zero_checks),
        with_zero_checks(setups[1].instruments, results_b.motions.zero_checks),
        same_instruments,
    )
    both = results_a, results_b
    tolerance = matching.speed_tolerance(*both) if speed_tolerance is None else speed_tolerance
    curves, notes = campaign_differences(*both, instruments, tolerance)
    clocks = (
        RunClock.of(results_a.runs, campaign_a.start_times_s(), campaign_a.source_files()),
        RunClock.of(results_b.runs, campaign_b.start_times_s(), campaign_b.source_files()),
    )
    curves, mean_of_curves = with_drift_effects(curves, both, clocks, instruments, tolerance)
    bands = band_differences(*both, instruments, tolerance)
    breakaways, others = breakaway_differences(*both, instruments)
    notes = (*notes, *others)
    if not (curves or breakaways or notes):
        raise DataError(
            f"{a} and {b} have neither curves nor breakaway to compare",
            "hbench compare compares friction. For leakage use hbench accept.",
        )
    if not (curves or breakaways):
        rejected = "".join(map(_rejected, (a, b), both))
        raise DataError(
            f"{a} and {b} have nothing in common:{_apart(notes)}{rejected}",
            f"{_LOOK_FOR if rejected else ''}{_ALIKE}",
        )
    logs = [measurements(each.latest) for each in (campaign_a, campaign_b)]
    if same := len(logs[0] & logs[1]):
        notes = (_SAME_LOGS.format(count=same, of=len(logs[0])), *notes)
    paths = str(a.resolve()), str(b.resolve())
    names = distinct_names(list(dict.fromkeys(paths)))
    return CampaignDifferences(
        (names[paths[0]], names[paths[1]]),
        results_a.provenance,
        results_b.provenance,
        (results_a.quality, results_b.quality),
        same_instruments,
        curves,
        notes,
        bands,
        trend_differences(*both, bands, instruments),
        (results_a.oil_temperature, results_b.oil_temperature),
        mean_of_curves,
        (results_a.drift, results_b.drift),
        breakaways,
    )


def write_comparison(folder: Path, comparison: CampaignDifferences) -> None:
    """Write a comparison's page, its figures and comparison.json."""
    drawings = draw_differences(comparison)
    files = figure_files(drawings)
    files["comparison.json"] = differences_json(comparison).encode()
    files["comparison.html"] = differences_page(comparison, drawings).encode()
    write_document(folder, files, "comparison.json")


def _of_one_bench(a: Setup, b: Setup) -> bool:
    """Return whether both bench files are known and state the same name and instruments."""
    if a.bench is None or b.bench is None:
        return False
    return (a.bench.name, a.bench.instruments) == (b.bench.name, b.bench.instruments)


def _rejected(folder: Path, results: Results) -> str:
    """Count the rejected runs of a campaign with their reasons; empty without any."""
    count = sum(not run.accepted for run in results.runs)
    names = ", ".join(code.replace("_", " ") for code, _ in reason_counts(results).most_common())
    return (
        f"\n{folder}: {count} of {len(results.runs)} runs were rejected ({names})" if count else ""
    )


def _apart(notes: Sequence[str]) -> str:
    """Return why no curves are compared, with the curves of only A and of only B in one list each.

    A line of the message for each list.
    """
    lines = []
    for only in ("only in A", "only in B"):
        names = [note.removesuffix(f": {only}") for note in notes if note.endswith(f": {only}")]
        lines += [f"{only}: {', '.join(names)}"] if names else []
    others = [note for note in notes if not note.endswith((": only in A", ": only in B"))]
    return "\n".join(["", *lines, *others]) if lines or others else ""
