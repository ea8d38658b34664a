"""``hbench identify``: friction laws from a campaign, as models that were put to the test."""

import sys
from pathlib import Path

import typer


def identify(
    campaign: Path = typer.Argument(help="Campaign folder."),
    output: Path = typer.Option(
        ..., "-o", "--output", help="Folder for the page, figures, JSON and a plant file a law."
    ),
    as_json: bool = typer.Option(
        False, "--json", help="Print identification.json instead of tables."
    ),
) -> None:
    """Identify five friction laws from CAMPAIGN; verify each on its verification runs.

    Tustin, Marton and Lantos, pressure-based, LuGre and Leuven, as far as the runs tell them.

    Example: hbench identify dynamics -o laws
    """
    from hbench import workflow
    from hbench.cli.progress import ProgressLine
    from hbench.report.identification.text import identification_json, identification_text

    progress = ProgressLine(sys.stderr)
    try:
        found = workflow.identify(campaign, progress)
    finally:
        progress.close()
    workflow.write_identification(output, found)
    typer.echo(f"{output / 'identification.html'}", err=True)
    typer.echo(identification_json(found) if as_json else identification_text(found))
