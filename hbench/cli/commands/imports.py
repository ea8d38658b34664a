"""``hbench import``: import of another bench's logs."""

import shlex
from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object


def import_(
    source: Path = typer.Argument(help="Folder with the logs."),
    output: Path = typer.Option(..., "-o", "--output", help="Campaign folder to write."),
    map_file: Path = typer.Option(
        None, "--map", help="Import map: columns, units and series. Not needed for exported runs."
    ),
    as_json: bool = AS_JSON,
) -> None:
    """Import the logs in SOURCE as a campaign.

    Example: hbench import logs -o campaign --map configs/import-csv.yaml
    """
    from datetime import datetime

    from hbench import workflow
    from hbench.untrusted_text import printable

    summary = workflow.import_runs(source, output, map_file, datetime.now().astimezone)
    for note in summary.notes:
        typer.echo(f"note: {printable(note)}", err=True)
    if as_json:
        typer.echo(as_object("import", campaign=output, **vars(summary)))
    else:
        typer.echo(f"{output}: {summary.runs} runs from {summary.files} files")
        typer.echo(f"next: hbench report {shlex.quote(str(output))}", err=True)
