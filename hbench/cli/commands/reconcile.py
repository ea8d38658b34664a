"""``hbench reconcile``: where model and measurement disagree, and which effect the model lacks."""

import sys
from pathlib import Path

import typer

from hbench.errors import ExitCode


def reconcile(
    campaign: Path = typer.Argument(help="Campaign folder."),
    model: Path = typer.Option(
        ..., help="Today's model: a bench file, or a plant file over the campaign's bench."
    ),
    output: Path = typer.Option(
        ..., "-o", "--output", help="Folder for report.html, diagnosis.json and model.yaml."
    ),
    fail: bool = typer.Option(
        False, "--fail", help="Exit with 6 unless the model is as good as the bench repeats itself."
    ),
    series: str | None = typer.Option(
        None, help="Which of an imported campaign's series, such as a seal."
    ),
    as_json: bool = typer.Option(False, "--json", help="Print diagnosis.json instead of tables."),
) -> None:
    """Find where CAMPAIGN and a model disagree, name the effect that is missing, and add it.

    Verdicts: named; ambiguous (with the experiment that would tell, as next.yaml); unknown (the
    disagreement's shape is shown); none.

    Example: hbench reconcile telling --model my-bench/bench-aau.yaml -o diagnosis
    """
    from hbench import workflow
    from hbench.cli.progress import ProgressLine
    from hbench.report.diagnosis.diagnosis_document import diagnosis_json
    from hbench.report.diagnosis.text import diagnosis_text

    progress = ProgressLine(sys.stderr)
    try:
        found = workflow.reconcile(campaign, model, progress.counted, series)
    finally:
        progress.close()
    workflow.write_diagnosis(output, found)
    typer.echo(f"{output / 'report.html'}", err=True)
    typer.echo(diagnosis_json(found) if as_json else diagnosis_text(found))
    if fail and found.verdict != "none":
        raise typer.Exit(ExitCode.NEGATIVE)
