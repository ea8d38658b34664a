"""Campaigns with many seeds on virtual rigs, on all cores of the machine."""

from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path

from hbench.experiment.progress import no_report
from hbench.parallel.process_pool import map_on_cores
from hbench.store.campaign.folder import JOURNAL
from hbench.workflow.board import Line, open_port, physics_of
from hbench.workflow.campaign import Experiment, MeasurementSummary, measure


def measure_seeds(
    experiment: Experiment,
    folder: Path,
    line: Line,
    campaigns: int,
    *,
    resume: bool,
    clock: Callable[[], datetime],
    report: Callable[[int], None],
    retry: int = 0,
) -> MeasurementSummary:
    """Measure campaigns on a virtual rig each, with seeds from the line's on, in ``folder/SEED``.

    Each campaign equals that of ``measure`` with its seed. ``resume`` keeps existing runs and makes
    missing ones. ``report`` gets the number of finished campaigns; ``clock`` must be picklable.
    Raises as ``measure`` does, from the first campaign that fails, which interrupts the others;
    ``DeviceError`` if a process has died.
    """
    physics = physics_of(experiment.files["bench"]["content"], line.plant)
    rig = open_port(line, experiment.bench, physics, line.seed)
    rig.read(0.0)  # compiles once, instead of in each process
    rig.close()
    lines = [replace(line, seed=seed) for seed in range(line.seed, line.seed + campaigns)]
    job = partial(_measure_seed, experiment, folder, resume, clock, retry)
    runs, seconds = 0, 0.0
    made_again: dict[str, str] = {}
    for done, (seed, summary) in enumerate(map_on_cores(job, lines), start=1):
        runs, seconds = runs + summary.runs, seconds + summary.seconds
        made_again |= {f"{seed}/{run}": found for run, found in summary.made_again.items()}
        report(done)
    return MeasurementSummary(runs, seconds, made_again)


def _measure_seed(
    experiment: Experiment,
    folder: Path,
    resume: bool,
    clock: Callable[[], datetime],
    retry: int,
    line: Line,
) -> tuple[int, MeasurementSummary]:
    destination = folder / str(line.seed)
    return line.seed, measure(
        experiment,
        destination,
        line,
        resume=resume and (destination / JOURNAL).exists(),
        clock=clock,
        report=no_report,
        retry=retry,
    )
