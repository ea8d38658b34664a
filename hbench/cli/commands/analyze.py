"""``hbench analyze`` and ``hbench report``: results and report of a campaign."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from hbench.records import Results

_MONTE_CARLO = typer.Option(
    False, "--monte-carlo", help="Check the expanded uncertainties by drawn errors (JCGM 101)."
)
_FIT = typer.Option(None, help="Fit file with laws, bounds, weights, loss and bootstrap.")


def analyze(
    campaign: Path = typer.Argument(help="Campaign folder."),
    fit: Path | None = _FIT,
    monte_carlo: bool = _MONTE_CARLO,
    as_json: bool = typer.Option(False, "--json", help="Print results.json instead of a table."),
) -> None:
    """Screen, average and fit CAMPAIGN's runs; write results.json and tables to its results folder.

    Example: hbench analyze demo
    """
    from hbench import workflow

    typer.echo(_result(workflow.analyze(campaign, fit, monte_carlo=monte_carlo), as_json))


class ReportFormat(StrEnum):
    """File format of ``hbench report``."""

    html = "html"
    md = "md"
    pdf = "pdf"


def report(
    campaign: Path = typer.Argument(help="Campaign folder."),
    fit: Path | None = _FIT,
    form: ReportFormat = typer.Option(
        ReportFormat.html,
        "--format",
        help="html: one self-contained page; md: Markdown with its figures as files; pdf: A4, with "
        "its figures as PNG files.",
    ),
    speed: str | None = typer.Option(
        None,
        help="Working speed of the headline numbers, such as '100 mm/s'; by default the median of "
        "the measured speeds.",
    ),
    monte_carlo: bool = _MONTE_CARLO,
    as_json: bool = typer.Option(False, "--json", help="Print results.json instead of a table."),
) -> None:
    """Analyze CAMPAIGN and write results/report.html with figures and tables.

    Example: hbench report demo
    """
    from hbench import workflow
    from hbench.cli.quantities import working_speed_m_s
    from hbench.store.campaign.stored_acceptance import stored_decision

    v = working_speed_m_s(speed)
    results = workflow.report(campaign, fit, form=form.value, speed_m_s=v, monte_carlo=monte_carlo)
    typer.echo(f"{campaign / 'results' / f'report.{form.value}'}", err=True)
    typer.echo(_result(results, as_json, stored_decision(campaign)))


def _result(results: "Results", as_json: bool, decision: str = "") -> str:
    from hbench.report.campaign.results_document import results_json
    from hbench.report.campaign.terminal import summary_text

    return results_json(results) if as_json else summary_text(results, decision)
