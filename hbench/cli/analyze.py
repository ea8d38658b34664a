"""``hbench analyze`` and ``hbench report``: from a campaign's logs to results and page."""

from pathlib import Path

import typer

_FIT = typer.Option(None, help="Fit file: laws, bounds, weights, loss, bootstrap.")


def analyze(
    campaign: Path = typer.Argument(help="Campaign folder."),
    fit: Path | None = _FIT,
    as_json: bool = typer.Option(False, "--json", help="Print results.json instead of a table."),
) -> None:
    """Screen, average and fit CAMPAIGN; write its results folder.

    Example: hbench analyze demo
    """
    from hbench import workflow

    typer.echo(_result(workflow.analyze(campaign, fit), as_json))


def report(
    campaign: Path = typer.Argument(help="Campaign folder."),
    fit: Path | None = _FIT,
    as_json: bool = typer.Option(False, "--json", help="Print results.json instead of a table."),
) -> None:
    """Analyze CAMPAIGN and write results/report.html with figures and tables.

    Example: hbench report demo
    """
    from hbench import workflow

    results = workflow.report(campaign, fit)
    typer.echo(f"{campaign / 'results' / 'report.html'}", err=True)
    typer.echo(_result(results, as_json))


def _result(results, as_json: bool) -> str:
    from hbench.report.tables import results_json, summary_text

    return results_json(results) if as_json else summary_text(results)
