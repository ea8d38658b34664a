"""``hbench identify``: identification of friction laws from a campaign, with verification."""

import sys
from pathlib import Path

import typer


def identify(
    campaign: Path = typer.Argument(help="Campaign folder."),
    output: Path = typer.Option(
        ..., "-o", "--output", help="Folder for page, figures, JSON and a plant file per law."
    ),
    as_json: bool = typer.Option(
        False, "--json", help="Print identification.json instead of tables."
    ),
) -> None:
    """Identify five friction laws from CAMPAIGN, and verify each on its verification runs.

    The laws are Tustin, Marton and Lantos, pressure-based, LuGre and Leuven. A law that the runs do
    not determine is left out, with a reason.

    Example: hbench identify dynamics -o laws
    """
    from hbench import workflow
    from hbench.cli.progress import ProgressLine
    from hbench.report.identification.terminal import identification_text
    from hbench.report.identification.text import identification_json

    progress = ProgressLine(sys.stderr)
    try:
        result = workflow.identify(campaign, progress)
    finally:
        progress.close()
    workflow.write_identification(output, result)
    typer.echo(f"{output / 'identification.html'}", err=True)
    typer.echo(identification_json(result) if as_json else identification_text(result))
