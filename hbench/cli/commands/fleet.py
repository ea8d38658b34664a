"""``hbench fleet``: analysis of many campaigns to one table and one page."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from hbench.cli.printed import AS_JSON
from hbench.errors import ConfigError, ExitCode

if TYPE_CHECKING:
    from hbench.analysis.fleet.precision import Tolerance


def fleet(
    patterns: list[str] = typer.Argument(
        metavar="DIR_OR_GLOB...",
        help="Campaigns, folders that contain campaigns to any depth, or glob patterns.",
    ),
    output: Path = typer.Option(..., "-o", "--output", help="Folder for table and page."),
    scheduler: str | None = typer.Option(
        None,
        help="Address of a Dask scheduler, whose workers must see the same folders; by default "
        "this machine's cores do the work.",
    ),
    speed: str | None = typer.Option(
        None, help="Working speed, such as '100 mm/s'; by default each campaign's median."
    ),
    tolerance: str | None = typer.Option(
        None,
        help="Width between the limits of friction, such as '60 N', or of efficiency, such as "
        "'3 %'; the page states the share that the measurement uses (%GRR).",
    ),
    limits: Path | None = typer.Option(
        None,
        help="File of limits, as for hbench accept: the page states Ppk and Cpk with intervals.",
    ),
    fail: bool = typer.Option(False, "--fail", help="Exit with 6 if a campaign has failed."),
    as_json: bool = AS_JSON,
) -> None:
    """Analyze many campaigns to one table and one page with distributions, drifts and outliers.

    Where cylinders were measured more than once, the page states repeatability and reproducibility:
    set specimen.serial, test.operator and test.mounting in the bench file, schedule or map.

    Decisions of hbench accept are counted.

    A repeated call analyzes only new and changed campaigns.

    Example: hbench fleet 'line-1/*' -o fleet
    """
    from hbench import workflow
    from hbench.cli.progress import ProgressLine
    from hbench.cli.quantities import working_speed_m_s

    v = working_speed_m_s(speed)
    line = ProgressLine(sys.stderr)
    try:
        summary = workflow.analyze_fleet(
            patterns,
            output,
            scheduler=scheduler,
            speed_m_s=v,
            tolerance=None if tolerance is None else _tolerance(tolerance),
            limits=limits,
            report=line.campaigns,
            note=line.note,
        )
    except KeyboardInterrupt:
        line.close("interrupted; give the same command again to continue")
        raise
    finally:
        line.close()
    workflow.write_fleet(output, summary)

    from hbench.report.fleet.terminal import fleet_text
    from hbench.report.fleet.text import fleet_json

    typer.echo(f"{output / 'fleet.html'}", err=True)
    typer.echo(fleet_json(summary) if as_json else fleet_text(summary))
    if fail and summary.failed:
        raise typer.Exit(ExitCode.NEGATIVE)


def _tolerance(text: str) -> "Tolerance":
    """Return the value of ``--tolerance``. Raises ``ConfigError``."""
    from hbench.analysis.fleet.precision import Tolerance
    from hbench.units import to_si

    for unit in ("N", "%"):
        try:
            width = to_si(text, unit)
        except ValueError:
            continue
        if width > 0:
            return Tolerance(width, unit)
    raise ConfigError(
        f"--tolerance: is {text!r}; limit 0", "Give a width with its unit: '60 N' or '3 %'."
    )
