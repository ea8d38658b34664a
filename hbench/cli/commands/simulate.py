"""``hbench simulate``: the model alone: what it shows of friction, measured commands replayed."""

from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object


def simulate(
    campaign: Path = typer.Argument(None, help="Campaign whose valve commands --model gets."),
    model: Path = typer.Option(
        None, help="A bench file, or a plant file such as reconcile's model.yaml, for CAMPAIGN."
    ),
    phenomenon: str = typer.Option(None, metavar="NAME", help="Which; without it, the list."),
    bench: Path = typer.Option(
        None, help="Bench of 'supply' and 'instability'; by default the one that 'init' writes."
    ),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for page, figures and data."),
    as_json: bool = AS_JSON,
) -> None:
    """Simulate a phenomenon of friction or of the bench; print its defining numbers.

    Without --phenomenon, list them. With CAMPAIGN and --model, simulate its runs in open loop
    instead: print how far the model is off, write the runs as CSV that 'import' reads, as in
    'hbench simulate telling --model diagnosis/model.yaml -o replay'. The closed loop is
    'hbench run --plant MODEL'.

    Example: hbench simulate --phenomenon stick-slip -o stick-slip
    """
    if campaign is not None or model is not None:
        _replay(campaign, model, phenomenon, bench, output, as_json)
        return
    from importlib.resources import files

    from hbench import workflow
    from hbench.report.simulation.text import phenomenon_json, phenomenon_text

    if phenomenon is None:
        names = workflow.phenomena()
        typer.echo(as_object("phenomena", names=names) if as_json else "\n".join(names))
        return
    default = files("hbench.config") / "examples" / "bench-aau.yaml"
    found = workflow.simulate(phenomenon, bench or default)
    if output is not None:
        workflow.write_phenomenon(output, found)
        typer.echo(f"{output / found.name}.html", err=True)
    typer.echo(phenomenon_json(found) if as_json else phenomenon_text(found))


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
        raise typer.BadParameter("a campaign is needed", param_hint="CAMPAIGN")
    if model is None:
        raise typer.BadParameter("a model is needed", param_hint="'--model'")
    for name, given in (("--phenomenon", phenomenon), ("--bench", bench)):
        if given is not None:
            raise typer.BadParameter("is not for a campaign's runs", param_hint=f"'{name}'")
    found = workflow.replay(campaign, model)
    if output is not None:
        workflow.write_replay(output, found)
        typer.echo(f"{output / 'runs.csv'}", err=True)
    typer.echo(replay_json(found) if as_json else replay_text(found))
