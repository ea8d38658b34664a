"""Closed-loop runs of the firmware on a simulated bench, kept in memory."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from hbench.analysis.screening.calibrate import calibrate
from hbench.config.bench import Bench, Plant
from hbench.config.schedule import parse_schedule
from hbench.errors import DeviceError
from hbench.experiment.plan import plan_runs, run_seconds
from hbench.experiment.progress import Progress, Report, no_report
from hbench.experiment.recorder import LOG_CHANNELS
from hbench.experiment.runner import run_campaign
from hbench.protocol.dictionary import RECORD_FLAGS
from hbench.records import Outcome, RawRun, Run, RunPlan
from hbench.rig.client import BoardClient

LONGEST = 2.0  # simulated time of plans, in times of that estimated (a sound bench: about 0.9) ...
LONGEST_S = 10.0  # ... plus this


@dataclass(frozen=True)
class ClosedLoopRuns:
    """Closed-loop runs, with the reason where the board stopped before the last one."""

    runs: tuple[Run, ...]
    planned: int
    stopped: str = ""  # empty: all runs were made


@dataclass
class _MemoryJournal:
    """Journal that keeps the calibrated runs in memory."""

    bench: Bench
    runs: list[Run] = field(default_factory=list)

    def start_run(self, plan: RunPlan, at: datetime, after: str) -> None:
        pass

    def finish_run(
        self, plan: RunPlan, words: np.ndarray, outcome: Outcome, why: str, at: datetime
    ) -> None:
        raw = RawRun(
            plan, words, LOG_CHANNELS, RECORD_FLAGS, self.bench.controllers.log_rate, outcome, why
        )
        self.runs.append(calibrate(raw, self.bench))


def record(
    bench: Bench,
    schedule: Mapping[str, Any],
    plant: Plant | None = None,
    report: Report = no_report,
    seed: int = 1,
) -> ClosedLoopRuns:
    """Make the runs of a schedule (as in its file) on the virtual rig, in simulated time.

    ``plant`` replaces the bench's own physics. Raises ``ConfigError`` where the bench can't make
    the runs. Where the board stops itself, ``stopped`` of the result has the reason.
    """
    plans = plan_runs(parse_schedule(dict(schedule), "design"), bench, "design").runs
    return record_plans(bench, plans, plant, report, seed)


def record_plans(
    bench: Bench,
    plans: Sequence[RunPlan],
    plant: Plant | None = None,
    report: Report = no_report,
    seed: int = 1,
) -> ClosedLoopRuns:
    """Make planned runs on the virtual rig; otherwise as ``record``.

    A plant on which they take more than ``LONGEST`` times the estimated time is not simulated to
    the end; ``stopped`` says so. Computing time is proportional to simulated time.
    """
    from hbench.model.simulated_bench import as_run  # compiles
    from hbench.rig.virtual import VirtualRig

    on_board = as_run(bench, plant)
    rig, journal = VirtualRig(bench, plant, seed), _MemoryJournal(bench)
    expected_s = sum(run_seconds(plans, bench).values())
    limit_s = LONGEST * expected_s + LONGEST_S

    def in_time(progress: Progress) -> None:
        report(progress)
        if rig.now() > limit_s:
            raise DeviceError(
                f"run {progress.plan.run}: the simulation was ended after {rig.now():.0f} s of the "
                f"bench's time; {expected_s:.0f} s were expected for {len(plans)} runs"
            )

    try:
        clock = datetime.fromtimestamp(0, UTC)
        run_campaign(plans, on_board, BoardClient(rig), journal, lambda: clock, in_time)
    except DeviceError as error:
        return ClosedLoopRuns(tuple(journal.runs), len(plans), error.message)
    finally:
        rig.close()
    return ClosedLoopRuns(tuple(journal.runs), len(plans))
