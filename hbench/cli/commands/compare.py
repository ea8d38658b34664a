"""``hbench compare``: two campaigns side by side."""

from pathlib import Path

import typer


def compare(
    a: Path = typer.Argument(help="Campaign folder."),
    b: Path = typer.Argument(help="Another, which is compared with the first."),
    same_instruments: bool = typer.Option(
        None,
        "--same-instruments/--other-instruments",
        help="Whether both were measured with the same sensors, whose errors are then in both. By "
        "default if the benches have the same name and instruments.",
    ),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for page, figures and JSON."),
    as_json: bool = typer.Option(False, "--json", help="Print comparison.json instead of tables."),
) -> None:
    """Tell which differences of friction and efficiency between A and B are real, with intervals.

    Example: hbench compare before after -o comparison
    """
    from hbench import workflow
    from hbench.report.comparison.text import differences_json, differences_text

    found = workflow.compare(a, b, same_instruments=same_instruments)
    if output is not None:
        workflow.write_comparison(output, found)
        typer.echo(f"{output / 'comparison.html'}", err=True)
    typer.echo(differences_json(found) if as_json else differences_text(found))
