"""``hbench compare``: comparison of two campaigns."""

from pathlib import Path

import typer


def compare(
    a: Path = typer.Argument(help="Campaign folder."),
    b: Path = typer.Argument(help="Campaign folder to compare with the first."),
    same_instruments: bool = typer.Option(
        None,
        "--same-instruments/--other-instruments",
        help="Whether both were measured with the same sensors, whose errors then cancel. By "
        "default they are taken as the same if the benches have equal names and "
        "instruments; campaigns imported with a map count as measured with other sensors.",
    ),
    speed_tolerance: str = typer.Option(
        None,
        help="Largest relative difference of speeds that count as the same, such as '30 %'; by "
        "default 2 %, or 20 % where no speed was set. Curves over speed are interpolated instead.",
    ),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for page, figures and JSON."),
    as_json: bool = typer.Option(False, "--json", help="Print comparison.json instead of tables."),
) -> None:
    """Compare friction, efficiency and breakaway of A and B: differences with their significance.

    Example: hbench compare before after -o comparison
    """
    from hbench import workflow
    from hbench.errors import ConfigError
    from hbench.report.comparison.text import differences_json, differences_text

    if a.exists() and a.resolve() == b.resolve():
        raise ConfigError(
            f"{a} and {b}: are the same campaign", "Give two campaigns, such as before and after."
        )
    tolerance = None if speed_tolerance is None else _ratio(speed_tolerance)
    comparison = workflow.compare(
        a, b, same_instruments=same_instruments, speed_tolerance=tolerance
    )
    if output is not None:
        workflow.write_comparison(output, comparison)
        typer.echo(f"{output / 'comparison.html'}", err=True)
    typer.echo(differences_json(comparison) if as_json else differences_text(comparison))


def _ratio(text: str) -> float:
    """Return the value of ``--speed-tolerance``. Raises ``ConfigError``."""
    from hbench.cli.quantities import si_of
    from hbench.errors import ConfigError

    ratio = si_of("--speed-tolerance:", text, "%")
    if not 0 <= ratio < 1:
        raise ConfigError(f"--speed-tolerance: is {text!r}; limits 0 % and below 100 %")
    return ratio
