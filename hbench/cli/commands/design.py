"""``hbench design``: analysis of a bench's three control loops, and proposal of gains."""

import sys
from pathlib import Path

import typer

from hbench.errors import ConfigError, ExitCode

# Quantities of an operating point: name, a unit, and the workflow's name.
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
        help="Operating point of the linearisation: any of v, load, x, p_lr, such as "
        "'v=50 mm/s, load=5 kN'; by default the one with the least margin.",
    ),
    propose: bool = typer.Option(
        False, "--propose", help="Propose gains, and check them with the firmware."
    ),
    ratio: float = typer.Option(
        1.7,
        min=1.0,
        max=10.0,
        help="Ratio of neighbouring loops' bandwidths in the proposal. If it fails a check, others "
        "are tried, and the verdict states one that passes.",
    ),
    write: bool = typer.Option(
        False, "--write", help="Write the proposed gains into BENCH if they pass all checks."
    ),
    fail: bool = typer.Option(False, "--fail", help="Exit with 6 if the proposal fails a check."),
    output: Path = typer.Option(None, "-o", "--output", help="Folder for figures, page and JSON."),
    as_json: bool = typer.Option(False, "--json", help="Print design.json instead of tables."),
) -> None:
    """Analyze the control loops of BENCH: margins, bandwidth, overshoot, digital poles.

    Without BENCH, analyze those of the source, and compare with its numbers.

    Example: hbench design my-bench/bench-aau.yaml --operating-point 'v=50 mm/s, load=5 kN'
    """
    given = _operating_point(point)
    for option, wanted in (("--fail", fail), ("--write", write)):
        if wanted and not propose:
            raise typer.BadParameter("needs --propose", param_hint=f"'{option}'")
    if write and bench is None:
        raise typer.BadParameter("needs BENCH, the file to write to", param_hint="'--write'")

    from hbench import workflow
    from hbench.cli.printed import remark
    from hbench.cli.progress import ProgressLine
    from hbench.config.files.examples import example_path
    from hbench.report.design.text import design_json, design_text

    file = bench or example_path("bench-aau.yaml")
    for words in workflow.bench_doubts(file):
        remark(f"note: {words}")
    progress = ProgressLine(sys.stderr)
    try:
        result = workflow.design(
            file,
            point=given,
            source=bench is None,
            ratio=ratio if propose else None,
            report=progress,
        )
    finally:
        progress.close()
    if output is not None:
        workflow.write_design(output, result)
        typer.echo(f"{output / 'design.html'}", err=True)
    typer.echo(design_json(result) if as_json else design_text(result))
    if write:
        workflow.write_gains(bench, result)
        typer.echo(f"{bench}: has the proposed gains", err=True)
    if fail and not result.proposal.holds:
        raise typer.Exit(ExitCode.NEGATIVE)


def _operating_point(text: str) -> dict[str, float]:
    """Convert ``v=50 mm/s, load=5 kN`` to SI, with the workflow's names. Raises ``ConfigError``."""
    from hbench.cli.quantities import si_of

    point = {}
    for item in filter(None, (item.strip() for item in text.split(","))):
        name, _, value = (side.strip() for side in item.partition("="))
        if name not in _POINT:
            raise ConfigError(
                f"--operating-point: unknown {name!r} in {item!r}; known are {', '.join(_POINT)}",
                "Write for example 'v=50 mm/s, load=5 kN, x=170 mm, p_lr=15 bar'.",
            )
        unit, key = _POINT[name]
        point[key] = si_of(f"--operating-point: {name} =", value, unit)
    return point
