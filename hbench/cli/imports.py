"""``hbench import``: brings in the logs of another bench."""

from pathlib import Path

import typer


def import_(
    source: Path = typer.Argument(help="Folder with the logs."),
    output: Path = typer.Option(..., "-o", "--output", help="Campaign folder to write."),
    map_file: Path = typer.Option(None, "--map", help="Map of columns and units."),
) -> None:
    """Bring the logs in SOURCE in as a campaign.

    Example: hbench import logs -o campaign --map configs/tudelft.yaml
    """
    from datetime import datetime

    from hbench import workflow
    from hbench.config.words import printable

    summary = workflow.import_runs(source, output, map_file, datetime.now().astimezone)
    for note in summary.notes:
        typer.echo(f"note: {printable(note)}", err=True)
    typer.echo(f"{output}: {summary.runs} runs from {summary.files} files")
