"""``hbench simulate``: the model alone, and what it shows of friction."""

from pathlib import Path

import typer


def simulate(
    phenomenon: str = typer.Option(None, metavar="NAME", help="Which; without it, the list."),
    bench: Path = typer.Option(
        None, help="Bench of 'supply' and 'instability'; by default the one that 'init' writes."
    ),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for page, figures and data."),
) -> None:
    """Simulate a phenomenon of friction or of the bench; print its defining numbers.

    Without --phenomenon, list them.

    Example: hbench simulate --phenomenon stick-slip -o stick-slip
    """
    from importlib.resources import files

    from hbench import workflow
    from hbench.report.phenomenon_text import phenomenon_text

    if phenomenon is None:
        typer.echo("\n".join(workflow.phenomena()))
        return
    default = files("hbench.config") / "examples" / "bench-aau.yaml"
    found = workflow.simulate(phenomenon, bench or default)
    if output is not None:
        workflow.write_phenomenon(output, found)
        typer.echo(f"{output / found.name}.html", err=True)
    typer.echo(phenomenon_text(found))
