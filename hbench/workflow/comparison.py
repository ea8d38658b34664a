"""Two campaigns side by side."""

from pathlib import Path

from hbench.analysis.differences import differences
from hbench.errors import DataError
from hbench.records import CampaignDifferences
from hbench.report.differences_text import differences_json, differences_page
from hbench.report.draw_differences import draw_differences
from hbench.report.figures import figure_files
from hbench.store.atomic import write_files
from hbench.store.campaign import load_campaign
from hbench.workflow.results import derive


def compare(a: Path, b: Path, *, same_instruments: bool | None = None) -> CampaignDifferences:
    """Compare two campaigns, B less A.

    ``same_instruments``: their errors are the same in both; by default where both were measured on
    benches of the same name and kind with the same instruments. Raises ``DataError``.
    """
    campaigns = load_campaign(a), load_campaign(b)
    results = tuple(derive(campaign) for campaign in campaigns)
    benches = [campaign.bench() for campaign in campaigns]
    instruments = tuple(None if bench is None else bench.instruments for bench in benches)
    if same_instruments is None:
        same_instruments = (
            None not in benches
            and benches[0].name == benches[1].name
            and instruments[0] == instruments[1]
            and results[0].provenance.source == results[1].provenance.source
        )
    curves, notes = differences(*results, instruments, same_instruments)
    if not curves:
        raise DataError(
            f"{a} and {b} have no curves in common: {'; '.join(notes) or 'neither has any'}",
            "Curves belong together by kind, direction, load and rod-side pressure.",
        )
    return CampaignDifferences(
        (a.resolve().name, b.resolve().name),
        results[0].provenance,
        results[1].provenance,
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
