"""``hbench fleet``: many campaigns to one table and one page."""

import sys
from pathlib import Path

import typer

from hbench.cli.printed import AS_JSON
from hbench.errors import ExitCode


def fleet(
    places: list[str] = typer.Argument(
        metavar="DIR_OR_GLOB...",
        help="Folders that hold campaigns, to any depth; or a pattern of their names.",
    ),
    output: Path = typer.Option(..., "-o", "--output", help="Folder for table and page."),
    scheduler: str | None = typer.Option(
        None,
        help="Address of a Dask scheduler, whose workers do it and see the same folders; by "
        "default this machine's cores do.",
    ),
    speed: str | None = typer.Option(
        None, help="Working speed, such as '100 mm/s'; by default each campaign's middle one."
    ),
    fail: bool = typer.Option(False, "--fail", help="Exit with 6 if a campaign has failed."),
    as_json: bool = AS_JSON,
) -> None:
    """Analyze many campaigns to one table and one page: distributions, drifts, outliers.

    Called again it does what is missing or has changed.

    Example: hbench fleet 'line-1/*' -o fleet
    """
    from hbench import workflow
    from hbench.cli.commands.analyze import speed_m_s
    from hbench.cli.progress import ProgressLine

    v = None if speed is None else speed_m_s(speed)
    line = ProgressLine(sys.stderr)
    try:
        found = workflow.analyze_fleet(
            places, output, scheduler=scheduler, speed_m_s=v, report=line.campaigns, tell=line.note
        )
    except KeyboardInterrupt:
        line.close("interrupted; the same command goes on")
        raise
    finally:
        line.close()
    workflow.write_fleet(output, found)

    from hbench.report.fleet.text import fleet_json, fleet_text

    typer.echo(f"{output / 'fleet.html'}", err=True)
    typer.echo(fleet_json(found) if as_json else fleet_text(found))
    if fail and found.failed:
        raise typer.Exit(ExitCode.NEGATIVE)
