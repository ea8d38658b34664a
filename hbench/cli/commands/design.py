"""``hbench design``: the three control loops of a bench, and gains for it."""

import sys
from pathlib import Path

import typer

from hbench.errors import ConfigError, ExitCode

# What an operating point may give: name, unit of its kind, and the workflow's own name.
_POINT = {
    "v": ("mm/s", "v_m_s"),
    "load": ("N", "f_load_n"),
    "x": ("mm", "x_m"),
    "p_lr": ("bar", "p_lr_pa"),
}


def design(
    bench: Path = typer.Argument(None, help="Bench file; by default the source's bench."),
    point: str = typer.Option(
        "",
        "--operating-point",
        metavar="POINT",
        help="Where to linearise: any of v, load, x, p_lr, e.g. 'v=50 mm/s, load=5 kN'.",
    ),
    propose: bool = typer.Option(
        False, "--propose", help="Propose gains and check them with the firmware."
    ),
    ratio: float = typer.Option(
        1.7, min=1.0, max=10.0, help="Of neighbouring bandwidths in the proposal."
    ),
    fail: bool = typer.Option(False, "--fail", help="Exit with 6 if the proposal fails a check."),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for figures, page and JSON."),
    as_json: bool = typer.Option(False, "--json", help="Print design.json instead of tables."),
) -> None:
    """Judge the control loops of BENCH: margins, bandwidth, overshoot, digital poles.

    Without BENCH, those of the source, with each of its numbers beside the one obtained.

    Example: hbench design my-bench/bench-aau.yaml --operating-point 'v=50 mm/s, load=5 kN'
    """
    from importlib.resources import files

    given = _operating_point(point)
    if fail and not propose:
        raise typer.BadParameter("judges a proposal: add --propose", param_hint="'--fail'")

    from hbench import workflow
    from hbench.cli.progress import ProgressLine
    from hbench.report.design.text import design_json, design_text

    progress = ProgressLine(sys.stderr)
    try:
        found = workflow.design(
            bench or files("hbench.config") / "examples" / "bench-aau.yaml",
            point=given,
            source=bench is None,
            ratio=ratio if propose else None,
            report=progress,
        )
    finally:
        progress.close()
    if output is not None:
        workflow.write_design(output, found)
        typer.echo(f"{output / 'design.html'}", err=True)
    typer.echo(design_json(found) if as_json else design_text(found))
    if fail and not found.proposal.holds:
        raise typer.Exit(ExitCode.NEGATIVE)


def _operating_point(text: str) -> dict[str, float]:
    """Read ``v=50 mm/s, load=5 kN`` into SI by the workflow's names. Raises ``ConfigError``."""
    from hbench.units import to_si

    found = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, _, value = (word.strip() for word in part.partition("="))
        if name not in _POINT:
            raise ConfigError(
                f"--operating-point: unknown {name!r} in {part!r}; known are {', '.join(_POINT)}",
                "Write for example 'v=50 mm/s, load=5 kN, x=170 mm, p_lr=15 bar'.",
            )
        unit, key = _POINT[name]
        try:
            found[key] = to_si(value, unit)
        except ValueError as error:
            raise ConfigError(f"--operating-point: {name} = {value!r} {error}") from None
    return found
