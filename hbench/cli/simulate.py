"""``hbench simulate``: the model alone, and what it shows of friction."""

from pathlib import Path

import typer


def simulate(
    phenomenon: str = typer.Option(None, metavar="NAME", help="Which; without it, the list."),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for page, figures and data."),
) -> None:
    """Simulate a phenomenon of friction or of the bench; print its defining numbers.

    Without --phenomenon, list them.

    Example: hbench simulate --phenomenon stick-slip -o stick-slip
    """
    from hbench import workflow
    from hbench.report.phenomenon_text import phenomenon_text

    if phenomenon is None:
        typer.echo("\n".join(workflow.phenomena()))
        return
    found = workflow.simulate(phenomenon)
    if output is not None:
        workflow.write_phenomenon(output, found)
        typer.echo(f"{output / found.name}.html", err=True)
    typer.echo(phenomenon_text(found))
