"""``hbench simulate``: phenomena of the model, and replay of measured valve commands."""

from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object


def simulate(
    campaign: Path = typer.Argument(
        None, help="Campaign folder whose measured valve commands drive the model."
    ),
    model: Path = typer.Option(
        None,
        help="Model for CAMPAIGN: a bench file, or a plant file such as reconcile's model.yaml.",
    ),
    phenomenon: str = typer.Option(
        None, metavar="NAME", help="Name of the phenomenon; without it, the names are listed."
    ),
    bench: Path = typer.Option(
        None,
        help="Bench file for 'supply' and 'instability'; by default that of 'hbench init'.",
    ),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for page, figures and data."),
    as_json: bool = AS_JSON,
) -> None:
    """Simulate a phenomenon of friction or of the bench; print its characteristic numbers.

    With CAMPAIGN and --model, simulate the campaign's runs in open loop instead: print the model's
    errors, and write the runs as CSV for 'hbench import', as in 'hbench simulate telling --model
    diagnosis/model.yaml -o replay'. For the closed loop use 'hbench run --plant MODEL'.

    Example: hbench simulate --phenomenon stick-slip -o stick-slip
    """
    if campaign is not None or model is not None:
        _replay(campaign, model, phenomenon, bench, output, as_json)
        return
    from hbench import workflow
    from hbench.config.files.examples import example_path
    from hbench.report.simulation.text import phenomenon_json, phenomenon_text

    if phenomenon is None:
        names = workflow.phenomena()
        typer.echo(as_object("phenomena", names=names) if as_json else "\n".join(names))
        return
    result = workflow.simulate_phenomenon(phenomenon, bench or example_path("bench-aau.yaml"))
    if output is not None:
        workflow.write_phenomenon(output, result)
        typer.echo(f"{output / result.name}.html", err=True)
    typer.echo(phenomenon_json(result) if as_json else phenomenon_text(result))


def _replay(
    campaign: Path | None,
    model: Path | None,
    phenomenon: str | None,
    bench: Path | None,
    output: Path | None,
    as_json: bool,
) -> None:
    from hbench import workflow
    from hbench.report.simulation.replay_text import replay_json, replay_text

    if campaign is None:
        raise typer.BadParameter("missing: --model needs it", param_hint="CAMPAIGN")
    if model is None:
        raise typer.BadParameter("missing: CAMPAIGN needs it", param_hint="'--model'")
    for name, given in (("--phenomenon", phenomenon), ("--bench", bench)):
        if given is not None:
            raise typer.BadParameter("can't be used with CAMPAIGN", param_hint=f"'{name}'")
    replay = workflow.replay(campaign, model)
    if output is not None:
        workflow.write_replay(output, replay)
        typer.echo(f"{output / 'runs.csv'}", err=True)
    typer.echo(replay_json(replay) if as_json else replay_text(replay))
