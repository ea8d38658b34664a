"""Many campaigns to one table and one page, on the cores of this machine or on a cluster."""

import os
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

from hbench import __version__
from hbench.analysis.summary.fleet_numbers import fleet_numbers
from hbench.analysis.summary.headline import at_working_speed, planned_speed_m_s
from hbench.errors import DataError, DeviceError, HbenchError
from hbench.parallel.process_pool import on_all_cores, whatever_dies
from hbench.records import Fleet, FleetRow
from hbench.report.fleet.row import fleet_row
from hbench.store.campaign.discovery import find_campaigns, fingerprint
from hbench.store.campaign.folder import load_campaign
from hbench.store.files.array_tables import require_pyarrow
from hbench.store.fleet.rows import FleetRows
from hbench.store.fleet.table import TABLE, cells_of, write_table
from hbench.untrusted_text import printable
from hbench.workflow.results import derive

_DIED = (
    "the process that analyzed it died, alone with it too: killed, or out of memory; tried again "
    "by the next call"
)


class Task(NamedTuple):
    """A campaign to be analyzed, by its absolute path."""

    path: str
    speed_m_s: float | None


class Analyzed(NamedTuple):
    """What a worker tells of a campaign. It is done again when its fingerprint is another."""

    path: str
    fingerprint: str
    hbench: str  # version
    row: FleetRow


def analyze_fleet(
    places: Iterable[str],
    folder: Path,
    *,
    scheduler: str | None,
    speed_m_s: float | None,
    report: Callable[[int, int, int], None],
    tell: Callable[[str], None],
) -> Fleet:
    """Analyze all campaigns in ``places`` to a table in ``folder``, and return what it shows.

    ``places`` are folders that hold campaigns to any depth, campaigns, and patterns. What an
    earlier call has done stays, unless the campaign has changed since. A campaign that can't be
    analyzed is a row with the reason. ``scheduler`` is the address of a Dask scheduler, by default
    the cores of this machine do the work. ``report`` is given how many campaigns are done by this
    call, of how many, and how many of them have failed. Raises ``ConfigError``,
    ``DataError``, ``DeviceError``.
    """
    from hbench.workflow.fleet_summary import summarize  # only once all is done

    require_pyarrow()
    with FleetRows(folder) as rows:
        rows.found(_found(rows, places, speed_m_s, tell))
        found, done, _ = rows.counts()
        if not found:
            raise DataError(
                "no campaign in any of the places", "A campaign's folder holds campaign.yaml."
            )
        if done:
            tell(f"{done} of {found} campaigns are done already and unchanged")
        if done < found:
            _do(rows, found - done, scheduler, speed_m_s, report, tell)
        write_table(folder / TABLE, rows.cells())
        rows.forget_others()
    return summarize(folder)


def write_fleet(folder: Path, found: Fleet) -> None:
    """Write a fleet's page, its figures and fleet.json."""
    from hbench.report.fleet.figures import draw_fleet
    from hbench.report.fleet.page import fleet_page
    from hbench.report.fleet.text import fleet_json
    from hbench.report.render.figures import figure_files
    from hbench.store.files.atomic import write_files

    drawings = draw_fleet(found)
    files = figure_files(drawings)
    files["fleet.json"] = fleet_json(found).encode()
    files["fleet.html"] = fleet_page(found, drawings).encode()
    write_files(folder, files)


def analyzed(task: Task) -> Analyzed:
    """Analyze a campaign; whatever goes wrong with it is its row's reason."""
    before = fingerprint(task.path, _made_by(task.speed_m_s))
    try:
        row = _row(task)
    except HbenchError as error:
        row = FleetRow(task.path, failed=_inside(task.path, error.message))
    except Exception as error:  # of a campaign that nobody thought of; the others go on
        row = FleetRow(task.path, failed=f"a bug in hbench: {type(error).__name__}: {error}")
    return Analyzed(task.path, before, __version__, row)


def _row(task: Task) -> FleetRow:
    """Return a campaign's row, at the planned working speed if none is asked for.

    The planned speed does not depend on which runs were rejected.
    """
    results = derive(load_campaign(Path(task.path)))
    planned = planned_speed_m_s(run.run.plan for run in results.runs)
    results = at_working_speed(results, task.speed_m_s or planned)
    return fleet_row(task.path, results, fleet_numbers(results))


def _inside(folder: str, words: str) -> str:
    """Leave out of a message where the campaign lies, which its row tells."""
    return printable(words.replace(folder + os.sep, "").removeprefix(f"{folder}: "))


def _lost(task: Task) -> Analyzed:
    return Analyzed(task.path, "", __version__, FleetRow(task.path, failed=_DIED))


def _found(
    rows: FleetRows, places: Iterable[str], speed_m_s: float | None, tell: Callable[[str], None]
) -> Iterator[tuple[str, bool]]:
    made_by = _made_by(speed_m_s)
    for path in find_campaigns(places, tell):
        known = rows.known(path)
        yield path, bool(known) and known == fingerprint(path, made_by)


def _made_by(speed_m_s: float | None) -> str:
    return f"{__version__} {speed_m_s}"


def _do(
    rows: FleetRows,
    to_do: int,
    scheduler: str | None,
    speed_m_s: float | None,
    report: Callable[[int, int, int], None],
    tell: Callable[[str], None],
) -> None:
    tasks = (Task(path, speed_m_s) for path in rows.missing())
    failed = 0
    for done, one in enumerate(_all(tasks, scheduler, tell), start=1):
        if one.hbench != __version__:
            raise DeviceError(
                f"{scheduler}: a worker runs hbench {one.hbench}; here it is {__version__}",
                "Install the same on each worker.",
            )
        rows.keep(one.path, one.fingerprint, bool(one.row.failed), cells_of(one.row))
        failed += bool(one.row.failed)
        report(done, to_do, failed)


def _all(
    tasks: Iterator[Task], scheduler: str | None, tell: Callable[[str], None]
) -> Iterator[Analyzed]:
    if scheduler is None:
        yield from whatever_dies(partial(on_all_cores, analyzed), tasks, _lost)
        return
    from hbench.parallel.dask_cluster import connected, on_cluster

    with connected(scheduler) as client:
        run = partial(on_cluster, client, analyzed, tell=tell)
        yield from whatever_dies(run, tasks, _lost)
