"""From a schedule to a campaign: check, estimate, measurement."""

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hbench.analysis.screening.calibrate import calibrate
from hbench.analysis.screening.screen import screen
from hbench.config.bench import Bench, parse_bench
from hbench.config.files.loading import file_sha256, read_yaml
from hbench.config.schedule import Schedule, parse_schedule
from hbench.errors import ConfigError, DataError
from hbench.experiment.campaign_header import (
    campaign_header,
    refuse_another,
    session_seed,
)
from hbench.experiment.kind_support import check_kinds
from hbench.experiment.plan import Plan, plan_runs, run_seconds
from hbench.experiment.progress import Report, WholeCampaign
from hbench.experiment.runner import bring_to_rest, run_campaign
from hbench.experiment.staged_plan import plan_parts
from hbench.protocol.dictionary import RECORD
from hbench.records import RunPlan
from hbench.rig.board_settings import board_settings
from hbench.rig.client import BoardClient, Identity
from hbench.rig.ports import Port
from hbench.store.campaign.folder import JOURNAL, StoredCampaign, load_campaign
from hbench.store.campaign.lock_file import campaign_lock
from hbench.store.campaign.writer import CampaignWriter
from hbench.store.files.bounded_read import LARGEST_LOG
from hbench.workflow.board import Line, check_effects, check_sensors, open_port, physics_of
from hbench.workflow.watching.live import published

if TYPE_CHECKING:
    from hbench.experiment.steady_demand import SteadyDemand


RECORD_BYTES = 5 * len(RECORD)  # of a raw log: four digits and a line feed a word


@dataclass(frozen=True)
class Experiment:
    """A checked schedule with its bench, and the contents of their files."""

    schedule: Schedule
    bench: Bench
    plan: Plan  # before the first measurement
    files: dict[str, dict[str, Any]]  # bench, schedule: {file, content}

    @property
    def plans(self) -> tuple[RunPlan, ...]:
        """All runs; with adaptive velocities, the largest possible number."""
        return self.plan.runs + self.plan.undecided


@dataclass(frozen=True)
class ScheduleEstimate:
    """Runs, time and log size of a schedule."""

    runs: int
    seconds: float  # on the bench
    bytes: int  # of raw logs
    at_most: bool  # upper limits, since the measurement determines adaptive velocities


@dataclass(frozen=True)
class MeasurementSummary:
    """Number of runs made by ``measure``, and the time they took."""

    runs: int
    seconds: float  # on the bench's clock
    made_again: dict[str, str] = field(default_factory=dict)  # runs with damaged logs: the damage


def load_experiment(
    schedule_file: Path, bench_file: Path | None, serial: str | None = None
) -> Experiment:
    """Read and check a schedule and its bench; ``serial`` is that of the cylinder under test.

    Raises ``ConfigError``.
    """
    schedule_data = read_yaml(schedule_file)
    identity = schedule_data.get("specimen") or {}
    if serial is not None and isinstance(identity, dict):  # anything else is refused below
        schedule_data = {**schedule_data, "specimen": {**identity, "serial": serial}}
    schedule = parse_schedule(schedule_data, str(schedule_file))
    if schedule.order == "random":  # the campaign records the seed, also the default one
        schedule_data = {**schedule_data, "seed": schedule.seed}
    check_kinds(schedule, str(schedule_file))
    if bench_file is None:
        if schedule.bench is None:
            raise ConfigError(
                f"{schedule_file}: key 'bench' is missing", "Add 'bench: FILE', or give --bench."
            )
        bench_file = schedule_file.parent / schedule.bench
        if not bench_file.exists():
            raise ConfigError(
                f"{schedule_file}: bench = {schedule.bench!r}: {bench_file} does not exist",
                "Give the path from the schedule's folder, or give --bench FILE.",
            )
    bench_data = read_yaml(bench_file)
    bench = parse_bench(bench_data, str(bench_file))
    check_effects(bench, bench_file)
    check_sensors(bench, bench_file)
    board_settings(bench)  # refuses what the board would refuse
    plan = plan_runs(schedule, bench, str(schedule_file))
    _check_log_sizes(plan, bench, schedule_file)
    return Experiment(
        schedule=schedule,
        bench=bench,
        plan=plan,
        files={
            "bench": {"file": bench_file.name, "content": bench_data},
            "schedule": {"file": schedule_file.name, "content": schedule_data},
        },
    )


def _check_log_sizes(plan: Plan, bench: Bench, schedule_file: Path) -> None:
    """Raise ``ConfigError`` for a run whose log could be too large to be read again."""
    rate = bench.controllers.log_rate
    for run in (*plan.runs, *plan.undecided):
        seconds = run.planned_motion.duration_s
        size, limit = seconds * rate * RECORD_BYTES / 1e6, LARGEST_LOG / 1e6
        if size > limit:
            raise ConfigError(
                f"{schedule_file}: run {run.run} ({run.kind}) may last {seconds:.0f} s, which is "
                f"{size:.0f} MB of log at {rate:g} Hz; limit {limit:g} MB",
                "Shorten the run, or lower controllers.log_rate.",
            )


def estimate(experiment: Experiment) -> ScheduleEstimate:
    """Return the runs, the time on the bench and the size of the raw logs."""
    plans, rate = experiment.plans, experiment.bench.controllers.log_rate
    records = sum(plan.motion.duration_s for plan in plans if plan.motion) * rate
    seconds = sum(run_seconds(plans, experiment.bench).values())
    return ScheduleEstimate(
        len(plans), seconds, round(records * RECORD_BYTES), bool(experiment.plan.undecided)
    )


def doubts(experiment: Experiment, plant: Path | None) -> tuple[str, ...]:
    """Return what is implausible in the bench file, and in that of another plant for the rig.

    Raises ``ConfigError`` for a plant file that can't be used.
    """
    from hbench.control.plausibility import implausible  # slow import: numba

    bench = experiment.bench
    physics = physics_of(experiment.files["bench"]["content"], plant) or bench
    of_bench = implausible(bench)
    of_plant = [words for words in implausible(physics) if words not in of_bench]
    return (
        *(f"{experiment.files['bench']['file']}: {words}" for words in of_bench),
        *(f"{plant}: {words}" for words in of_plant),
    )


def demand(experiment: Experiment) -> "SteadyDemand | None":
    """Return the steady valve openings, pressures and flow that a schedule needs.

    Raises ``ConfigError`` for a steady state that supply or valves can't hold.
    """
    from hbench.experiment.steady_demand import steady_demand  # slow import: scipy.optimize

    schedule_file = experiment.files["schedule"]["file"]
    return steady_demand(experiment.plans, experiment.bench, schedule_file)


def measure(
    experiment: Experiment,
    folder: Path,
    line: Line,
    *,
    resume: bool,
    clock: Callable[[], datetime],
    report: Report,
    take_over: bool = False,
    retry: int = 0,
) -> MeasurementSummary:
    """Make the runs on ``line`` and journal them in the campaign ``folder``.

    A board that still runs, or has a latched fault, is taken over only with ``take_over`` or
    ``resume``. Of another plant's file the campaign stores only the checksum. ``resume`` also
    repeats completed runs whose log is missing or changed; a changed log is kept. ``clock`` gives
    the time of the session's start; the times in the journal are that plus the time of the line, so
    that setting the computer's clock does not change them. A run that is rejected as it ends is
    repeated at once, up to ``retry`` times. During the measurement, the folder's ``live.json``
    contains the state given to ``report``. Raises ``ConfigError``, ``DeviceError``, ``DataError``.
    """
    if line.plant is not None and line.port != "sim":
        raise ConfigError(
            f"--plant: applies to the virtual rig only; --port is {line.port!r}", "Remove --plant."
        )
    bench, simulated = experiment.bench, line.port == "sim"
    with campaign_lock(folder):
        campaign = _stored(folder) if resume else None
        damaged = campaign.damaged() if campaign else {}
        whole_logs = campaign.done - damaged.keys() if campaign else frozenset()
        done = {plan for plan in campaign.plans if plan.run in whole_logs} if campaign else set()
        physics = physics_of(experiment.files["bench"]["content"], line.plant)
        on_board = bench
        if simulated:
            from hbench.model.simulated_bench import as_run  # compiles

            on_board = as_run(bench, physics)
        port = open_port(line, bench, physics, session_seed(line.seed, campaign))
        try:
            client = BoardClient(port)
            now = _session_clock(port, clock(), campaign if simulated else None)
            identity = client.identify()
            bring_to_rest(client, resume or take_over)  # before the folder is created
            header = _header(experiment, line, identity, now())
            journal = _begun(folder, campaign, header)
            start, runs_made = port.now(), 0
            rules = experiment.schedule.screening
            about = {key: str(header[key]) for key in ("name", "source")}
            with published(folder, report, about) as publish:
                whole = WholeCampaign(publish, bench, (*experiment.plans, *done))
                for part in plan_parts(experiment.plan, experiment.schedule, bench, folder, done):
                    run_campaign(
                        part.runs,
                        on_board,
                        client,
                        journal,
                        now,
                        whole.part(part, len(done) + runs_made),
                        resume=resume and not runs_made,
                        judge=lambda raw: screen(calibrate(raw, bench), rules),
                        retry=retry,
                    )
                    runs_made += len(part.runs)
            return MeasurementSummary(runs_made, port.now() - start, damaged)
        finally:
            port.close()


def _stored(folder: Path) -> StoredCampaign:
    """Load the campaign to resume. Raises ``DataError`` if there is none."""
    if not (folder / JOURNAL).exists():
        raise DataError(
            f"{folder}: no campaign to resume: {JOURNAL} does not exist",
            "Check the folder. If no run was made yet, give the command without --resume.",
        )
    return load_campaign(folder)


def _begun(folder: Path, campaign: StoredCampaign | None, header: dict[str, Any]) -> CampaignWriter:
    """Create a campaign with the header, or continue a stored one. Raises ``ConfigError``."""
    if campaign is None:
        return CampaignWriter.create(folder, header)
    refuse_another(campaign, header)
    return CampaignWriter.resume(folder)


def _header(
    experiment: Experiment, line: Line, identity: Identity, now: datetime
) -> dict[str, Any]:
    """Return the header of a campaign on ``line``, whose board has the ``identity``."""
    schedule, bench = experiment.schedule, experiment.bench
    header = campaign_header(schedule.name, experiment.files, identity, bench, line.port, now)
    if line.port == "sim":  # the seed of a rig served by another process is not known
        header["seed"] = line.seed
    if line.plant is not None:
        header["plant"] = {"sha256": file_sha256(line.plant)}
    return header


def _session_clock(
    line: Port, now: datetime, simulated: StoredCampaign | None
) -> Callable[[], datetime]:
    """Return a clock that adds the line's time to that of the session's start.

    The virtual rig is faster than time passes, so an earlier session of a ``simulated`` campaign
    may end later than ``now``.
    """
    start = max(now, (simulated and simulated.ended_at()) or now)
    zero_s = line.now()
    return lambda: start + timedelta(seconds=line.now() - zero_s)
