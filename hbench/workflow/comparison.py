"""Two campaigns side by side."""

from pathlib import Path

from hbench.analysis.comparison.differences import differences
from hbench.errors import DataError
from hbench.records import CampaignDifferences
from hbench.report.comparison.figures import draw_differences
from hbench.report.comparison.text import differences_json, differences_page
from hbench.report.render.figures import figure_files
from hbench.store.campaign.folder import load_campaign
from hbench.store.files.atomic import write_files
from hbench.workflow.results import derive


def compare(a: Path, b: Path, *, same_instruments: bool | None = None) -> CampaignDifferences:
    """Compare two campaigns, B less A.

    ``same_instruments``: their errors are the same in both; by default where both were measured on
    benches of the same name and kind with the same instruments. Raises ``DataError``.
    """
    ours, theirs = load_campaign(a), load_campaign(b)
    of_a, of_b = derive(ours), derive(theirs)
    bench_a, bench_b = ours.bench(), theirs.bench()
    instruments = (
        None if bench_a is None else bench_a.instruments,
        None if bench_b is None else bench_b.instruments,
    )
    if same_instruments is None:
        same_instruments = (
            bench_a is not None
            and bench_b is not None
            and bench_a.name == bench_b.name
            and bench_a.instruments == bench_b.instruments
            and of_a.provenance.source == of_b.provenance.source
        )
    curves, notes = differences(of_a, of_b, instruments, same_instruments)
    if not curves:
        raise DataError(
            f"{a} and {b} have no curves in common: {'; '.join(notes) or 'neither has any'}",
            "Curves belong together by kind, direction, load and rod-side pressure.",
        )
    return CampaignDifferences(
        (a.resolve().name, b.resolve().name),
        of_a.provenance,
        of_b.provenance,
        same_instruments,
        curves,
        notes,
    )


def write_comparison(folder: Path, found: CampaignDifferences) -> None:
    """Write a comparison's page, its figures and comparison.json."""
    drawings = draw_differences(found)
    files = figure_files(drawings)
    files["comparison.json"] = differences_json(found).encode()
    files["comparison.html"] = differences_page(found, drawings).encode()
    write_files(folder, files)
