"""``hbench import``: import of another bench's logs."""

import shlex
from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object
from hbench.errors import ConfigError


def import_(
    source: Path = typer.Argument(help="Folder with the logs."),
    output: Path = typer.Option(None, "-o", "--output", help="Campaign folder to write."),
    map_file: Path = typer.Option(
        None, "--map", help="Import map: columns, units and series. Not needed for exported runs."
    ),
    suggest: bool = typer.Option(
        False, "--suggest", help="Only print a map for the logs, to be completed."
    ),
    as_json: bool = AS_JSON,
) -> None:
    """Import the logs in SOURCE as a campaign.

    Example: hbench import logs -o campaign --map configs/import-csv.yaml
    """
    if suggest:
        if output is not None or map_file is not None:
            raise ConfigError("--suggest: takes neither -o nor --map")
        _suggest(source, as_json)
    elif output is None:
        raise ConfigError("-o is missing", "Give the campaign folder to write, or --suggest.")
    else:
        _import(source, output, map_file, as_json)


def _import(source: Path, output: Path, map_file: Path | None, as_json: bool) -> None:
    from datetime import datetime

    from hbench import workflow

    summary = workflow.import_runs(source, output, map_file, datetime.now().astimezone)
    _print_notes(summary.notes)
    if as_json:
        typer.echo(as_object("import", campaign=output, **vars(summary)))
    else:
        typer.echo(f"{output}: {summary.runs} runs from {summary.files} files")
        typer.echo(f"next: hbench report {shlex.quote(str(output))}", err=True)


def _suggest(source: Path, as_json: bool) -> None:
    from hbench import workflow

    suggestion = workflow.suggest_import_map(source)
    _print_notes(suggestion.notes)
    if as_json:
        typer.echo(as_object("import-map", map=suggestion.text, notes=suggestion.notes))
    else:
        typer.echo(suggestion.text, nl=False)


def _print_notes(notes: tuple[str, ...]) -> None:
    from hbench.untrusted_text import printable

    for note in notes:
        typer.echo(f"note: {printable(note)}", err=True)
