"""``hbench import``: import of another bench's logs."""

import shlex
from collections import Counter
from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object, remark
from hbench.errors import ConfigError, ExitCode
from hbench.sentences import counted


def import_(
    source: Path = typer.Argument(help="Folder with the logs."),
    output: Path = typer.Option(None, "-o", "--output", help="Campaign folder to write."),
    map_file: Path = typer.Option(
        None, "--map", help="Import map: columns, units and series. Not needed for exported runs."
    ),
    preview: Path = typer.Option(
        None, "--preview", help="Only write a page to this folder: what --map makes of the logs."
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
        if output is not None or map_file is not None or preview is not None:
            raise ConfigError("--suggest takes no other option than --json")
        _suggest(source, as_json)
    elif preview is not None:
        if output is not None:
            raise ConfigError("--preview and -o: only one of them is possible")
        if map_file is None:
            raise ConfigError(
                "--preview needs --map", "`hbench import SRC --suggest` writes a map."
            )
        _preview(source, map_file, preview, as_json)
    elif output is None:
        raise ConfigError("-o is missing", "Give the campaign to write, or --preview or --suggest.")
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
        typer.echo(
            f"{output}: {counted(summary.runs, 'run')} from {counted(summary.files, 'file')}"
        )
        typer.echo(f"next: hbench report {shlex.quote(str(output))}", err=True)


def _preview(source: Path, map_file: Path, folder: Path, as_json: bool) -> None:
    from hbench import workflow
    from hbench.report.campaign.reasons import code_of

    preview = workflow.preview_import(source, map_file)
    page = workflow.write_import_preview(folder, preview)
    errors = {file.name: file.error for file in preview.files if file.error}
    errors |= {files: "matches no file" for files in preview.empty_series.values()}
    _print_notes(tuple(f"{name}: {error}" for name, error in errors.items()))
    runs = preview.runs
    accepted = sum(run.screened.accepted for run in runs)
    reasons = Counter(code_of(text) for run in runs for text in run.screened.reasons)
    if as_json:
        numbers = {"files": len(preview.files), "runs": len(runs), "accepted": accepted}
        unmatched = list(preview.unmatched)
        typer.echo(
            as_object("import-preview", page=page, **numbers, unmatched=unmatched, errors=errors)
        )
    else:
        typer.echo(
            f"{page}: {counted(len(preview.files), 'file')}, {counted(len(errors), 'error')}; "
            f"{counted(len(runs), 'run')}, "
            f"{accepted} accepted{''.join(f', {n} {code}' for code, n in reasons.most_common())}"
        )
    if errors and not runs:
        raise typer.Exit(ExitCode.DATA)


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
        remark(f"note: {printable(note)}")
