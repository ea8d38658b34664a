"""The firmware in closed loop with a simulated bench, without a campaign on disk."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from hbench.analysis.screening.calibrate import calibrate
from hbench.config.bench import Bench, Plant
from hbench.config.schedule import parse_schedule
from hbench.errors import DeviceError
from hbench.experiment.plan import plan_runs
from hbench.experiment.progress import Progress
from hbench.experiment.recorder import CHANNELS
from hbench.experiment.runner import run_campaign
from hbench.protocol.dictionary import FLAGS
from hbench.records import Outcome, RawRun, Run, RunPlan
from hbench.rig.client import BoardClient


@dataclass(frozen=True)
class Recorded:
    """The runs that were made, and what stopped the board before the last; empty if nothing."""

    runs: tuple[Run, ...]
    planned: int
    stopped: str = ""


@dataclass
class _Kept:
    """Keeps runs where a campaign's journal writes them."""

    bench: Bench
    runs: list[Run] = field(default_factory=list)

    def start_run(self, plan: RunPlan, at: datetime, after: str) -> None:
        pass

    def finish_run(
        self, plan: RunPlan, words: np.ndarray, outcome: Outcome, why: str, at: datetime
    ) -> None:
        raw = RawRun(plan, words, CHANNELS, FLAGS, self.bench.controllers.log_rate, outcome, why)
        self.runs.append(calibrate(raw, self.bench))


def record(
    bench: Bench,
    schedule: Mapping[str, Any],
    plant: Plant | None = None,
    report: Callable[[Progress], None] = lambda progress: None,
    seed: int = 1,
) -> Recorded:
    """Make the runs of a schedule (as in its file) on the virtual rig, in simulated time.

    ``plant`` stands in for the bench's own physics. Raises ``ConfigError`` where the bench can't
    make them; a board that stops itself is told in the result.
    """
    plans = plan_runs(parse_schedule(dict(schedule), "design"), bench, "design").runs
    return record_plans(bench, plans, plant, report, seed)


def record_plans(
    bench: Bench,
    plans: Sequence[RunPlan],
    plant: Plant | None = None,
    report: Callable[[Progress], None] = lambda progress: None,
    seed: int = 1,
) -> Recorded:
    """Make runs that are planned already, as ``record`` does."""
    from hbench.model.simulated_bench import as_run  # compiles
    from hbench.rig.virtual import VirtualRig

    on_board = as_run(bench, plant)
    rig, kept = VirtualRig(bench, plant, seed), _Kept(bench)
    try:
        clock = datetime.fromtimestamp(0, UTC)
        run_campaign(plans, on_board, BoardClient(rig), kept, lambda: clock, report)
    except DeviceError as error:
        return Recorded(tuple(kept.runs), len(plans), error.message)
    finally:
        rig.close()
    return Recorded(tuple(kept.runs), len(plans))
