"""Analysis of many campaigns to one table and one page, on this machine's cores or a cluster."""

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote

from hbench import __version__
from hbench.analysis.summary.fleet_numbers import fleet_numbers
from hbench.analysis.summary.headline import at_working_speed, planned_speed_m_s
from hbench.config.conformity.limits import parse_limits
from hbench.config.files.loading import read_yaml
from hbench.errors import DataError, DeviceError, HbenchError
from hbench.parallel.process_pool import map_on_cores, retry_alone
from hbench.records import Fleet, FleetRow
from hbench.report.fleet.row import fleet_row
from hbench.store.campaign.checksums import sha256
from hbench.store.campaign.discovery import find_campaigns, fingerprint
from hbench.store.campaign.folder import StoredCampaign, load_campaign, refuse_existing
from hbench.store.campaign.journal import measurements
from hbench.store.campaign.stored_acceptance import stored_checks, stored_decision
from hbench.store.fleet.rows import FleetRows
from hbench.store.fleet.table import TABLE, FleetTable, cells_of, write_table
from hbench.store.formats.parquet import require_pyarrow
from hbench.untrusted_text import printable
from hbench.workflow.results import derive

if TYPE_CHECKING:
    from hbench.analysis.fleet.precision import Tolerance

_DIED = "its analysis killed the process twice (out of memory?); the next call analyzes it again"


class FleetTask(NamedTuple):
    """A campaign to analyze, by its absolute path."""

    path: str
    speed_m_s: float | None


class AnalyzedCampaign(NamedTuple):
    """A worker's result for a campaign, valid as long as the fingerprint is the same."""

    path: str
    fingerprint: str
    hbench: str  # version
    row: FleetRow


def analyze_fleet(
    patterns: Iterable[str],
    folder: Path,
    *,
    scheduler: str | None,
    speed_m_s: float | None,
    tolerance: "Tolerance | None" = None,
    limits: Path | None = None,
    report: Callable[[int, int, int], None],
    note: Callable[[str], None],
) -> Fleet:
    """Analyze all campaigns of ``patterns`` to a table in ``folder``, and return its summary.

    ``patterns`` are campaigns, folders that contain campaigns to any depth, and glob patterns. Rows
    of an earlier call are kept unless the campaign has changed since. A campaign that can't be
    analyzed is a row with the reason. ``scheduler`` is the address of a Dask scheduler; by default
    this machine's cores do the work. ``tolerance`` is that of friction or efficiency, to compare
    the measurement's precision with; ``limits`` is a file of limits, for the capability. ``report``
    gets the numbers of campaigns analyzed by this call, to analyze, and failed. Raises
    ``ConfigError``, ``DataError``, ``DeviceError``.
    """
    from hbench.analysis.fleet.summary import summarize  # needed at the end only

    require_pyarrow()
    refuse_existing(folder, "Choose another folder with -o for the table and the page.")
    product = None if limits is None else parse_limits(read_yaml(limits), str(limits))
    with FleetRows(folder) as rows:
        rows.register(_campaigns(rows, patterns, speed_m_s, note))
        total, done, _ = rows.counts()
        if not total:
            raise DataError(
                "no campaign found", "Give folders that contain campaigns (campaign.yaml)."
            )
        if done:
            note(f"{done} of {total} campaigns are unchanged since their analysis")
        if done < total:
            _analyze_missing(rows, total - done, scheduler, speed_m_s, report, note)
        write_table(folder / TABLE, rows.cells())
        rows.remove_others()
    return summarize(
        FleetTable(folder / TABLE),
        partial(report_link, folder.resolve()),
        tolerance,
        () if product is None else [limit.requirement for limit in product.limits],
        lambda path: stored_decision(Path(path)),
        lambda path: stored_checks(Path(path)),
    )


def report_link(folder: Path, campaign: str) -> str:
    """Return the link from a page in ``folder`` to a campaign's report; empty if there is none."""
    report = Path(campaign) / "results" / "report.html"
    if not os.path.isfile(report):
        return ""
    try:
        return quote(Path(os.path.relpath(report, folder)).as_posix())
    except ValueError:  # another drive
        return ""


def write_fleet(folder: Path, fleet: Fleet) -> None:
    """Write a fleet's page, its figures and fleet.json."""
    from hbench.report.fleet.figures import draw_fleet
    from hbench.report.fleet.page import fleet_page
    from hbench.report.fleet.text import fleet_json
    from hbench.report.render.figures import figure_files
    from hbench.store.files.atomic import write_document

    drawings = draw_fleet(fleet)
    files = figure_files(drawings)
    files["fleet.json"] = fleet_json(fleet).encode()
    files["fleet.html"] = fleet_page(fleet, drawings).encode()
    write_document(folder, files, "fleet.json")


def analyzed(task: FleetTask) -> AnalyzedCampaign:
    """Analyze a campaign; an error becomes the reason in its row."""
    before = fingerprint(task.path, _settings(task.speed_m_s))
    try:
        row = _row(task)
    except HbenchError as error:
        row = FleetRow(task.path, failed=_without_path(task.path, error.message))
    except Exception as error:  # one campaign's bug must not end the others' analysis
        row = FleetRow(task.path, failed=f"a bug in hbench: {type(error).__name__}: {error}")
    return AnalyzedCampaign(task.path, before, __version__, row)


def _row(task: FleetTask) -> FleetRow:
    """Return a campaign's row, at the planned working speed if none is asked for.

    The planned speed does not depend on which runs were rejected.
    """
    campaign = load_campaign(Path(task.path))
    results = derive(campaign)
    planned = planned_speed_m_s(run.run.plan for run in results.runs)
    results = at_working_speed(results, task.speed_m_s or planned)
    row = fleet_row(task.path, results, fleet_numbers(results))
    return replace(row, logs_sha256=_logs_sha256(campaign))


def _logs_sha256(campaign: StoredCampaign) -> str:
    """Return a checksum of all logs, in any order; empty for a campaign without logs."""
    logs = sorted(measurements(campaign.latest))
    return sha256("\n".join(logs).encode()) if logs else ""


def _without_path(folder: str, message: str) -> str:
    """Remove the campaign's path, which has its own column, from a message."""
    return printable(message.replace(folder + os.sep, "").removeprefix(f"{folder}: "))


def _lost(task: FleetTask) -> AnalyzedCampaign:
    return AnalyzedCampaign(task.path, "", __version__, FleetRow(task.path, failed=_DIED))


def _campaigns(
    rows: FleetRows, patterns: Iterable[str], speed_m_s: float | None, note: Callable[[str], None]
) -> Iterator[tuple[str, bool]]:
    settings = _settings(speed_m_s)
    for path in find_campaigns(patterns, note):
        stored = rows.fingerprint(path)
        yield path, bool(stored) and stored == fingerprint(path, settings)


def _settings(speed_m_s: float | None) -> str:
    return f"{__version__} {speed_m_s}"


def _analyze_missing(
    rows: FleetRows,
    to_do: int,
    scheduler: str | None,
    speed_m_s: float | None,
    report: Callable[[int, int, int], None],
    note: Callable[[str], None],
) -> None:
    tasks = (FleetTask(path, speed_m_s) for path in rows.missing())
    failed = 0
    for done, result in enumerate(_analyzed_campaigns(tasks, scheduler, note), start=1):
        if result.hbench != __version__:
            raise DeviceError(
                f"{scheduler}: a worker runs hbench {result.hbench}; this machine {__version__}",
                "Install the same version on each worker.",
            )
        row_failed = bool(result.row.failed)
        rows.keep(result.path, result.fingerprint, row_failed, cells_of(result.row))
        failed += row_failed
        report(done, to_do, failed)


def _analyzed_campaigns(
    tasks: Iterator[FleetTask], scheduler: str | None, note: Callable[[str], None]
) -> Iterator[AnalyzedCampaign]:
    if scheduler is None:
        yield from retry_alone(partial(map_on_cores, analyzed), tasks, _lost)
        return
    from hbench.parallel.dask_cluster import connected, map_on_cluster

    with connected(scheduler) as client:
        run = partial(map_on_cluster, client, analyzed, note=note)
        yield from retry_alone(run, tasks, _lost)
