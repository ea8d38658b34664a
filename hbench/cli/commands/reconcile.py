"""``hbench reconcile``: differences between model and measurement, and the missing effect."""

import sys
from pathlib import Path

import typer

from hbench.errors import ExitCode


def reconcile(
    campaign: Path = typer.Argument(help="Campaign folder."),
    model: Path = typer.Option(
        ..., help="Present model: a bench file, or a plant file applied to the campaign's bench."
    ),
    output: Path = typer.Option(
        ..., "-o", "--output", help="Folder for report.html, diagnosis.json and model.yaml."
    ),
    fail: bool = typer.Option(
        False, "--fail", help="Exit with 6 unless the model agrees within the repeatability."
    ),
    series: str | None = typer.Option(
        None, help="Label of the series to use, for an imported campaign with several."
    ),
    material: float = typer.Option(
        0.2, min=0.0, max=100.0, help="Smaller deviations do not matter: % of a signal's range."
    ),
    as_json: bool = typer.Option(False, "--json", help="Print diagnosis.json instead of tables."),
) -> None:
    """Find where CAMPAIGN and a model disagree, identify the missing effect, and add it.

    Verdicts: named (the missing effect is identified); ambiguous (several effects fit; next.yaml is
    an experiment that distinguishes them); unknown (no known effect fits); none (no difference).
    The stages are logged to reconcile.log in the output folder, with a line at least every 30 s.

    Example: hbench reconcile telling --model my-bench/bench-aau.yaml -o diagnosis
    """
    from hbench import workflow
    from hbench.cli.progress import ProgressLine
    from hbench.cli.stage_log import stage_log
    from hbench.report.diagnosis.diagnosis_document import diagnosis_json
    from hbench.report.diagnosis.terminal import diagnosis_text

    progress = ProgressLine(sys.stderr)
    with stage_log(output / "reconcile.log") as log:

        def counted(done: int, total: int) -> None:
            progress.counted(done, total)
            log.counted(done, total)

        def stage(text: str) -> None:
            progress.stage(text)
            log.stage(text)

        log.stage(f"reading {campaign}")
        try:
            with log.repeated():
                diagnosis = workflow.reconcile(
                    campaign, model, counted, series, material / 100, stage
                )
        finally:
            progress.close()
        log.stage("drawing the figures and writing the page")
        workflow.write_diagnosis(output, diagnosis)
    typer.echo(f"{output / 'report.html'}", err=True)
    typer.echo(diagnosis_json(diagnosis) if as_json else diagnosis_text(diagnosis))
    if fail and diagnosis.verdict != "none":
        raise typer.Exit(ExitCode.NEGATIVE)
