"""``hbench simulate``: the model alone, and what it shows of friction."""

from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON, as_object


def simulate(
    phenomenon: str = typer.Option(None, metavar="NAME", help="Which; without it, the list."),
    bench: Path = typer.Option(
        None, help="Bench of 'supply' and 'instability'; by default the one that 'init' writes."
    ),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for page, figures and data."),
    as_json: bool = AS_JSON,
) -> None:
    """Simulate a phenomenon of friction or of the bench; print its defining numbers.

    Without --phenomenon, list them.

    Example: hbench simulate --phenomenon stick-slip -o stick-slip
    """
    from importlib.resources import files

    from hbench import workflow
    from hbench.report.phenomenon_text import phenomenon_json, phenomenon_text

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
