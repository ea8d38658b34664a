"""Campaigns with many seeds on virtual rigs, on all cores of the machine."""

from collections.abc import Callable, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path

from hbench.experiment.progress import Progress
from hbench.parallel.process_pool import map_on_cores
from hbench.store.campaign.folder import JOURNAL
from hbench.workflow.board import open_port, physics_of
from hbench.workflow.campaign import Experiment, MeasurementSummary, measure


def measure_seeds(
    experiment: Experiment,
    folder: Path,
    *,
    seeds: Sequence[int],
    plant: Path | None,
    resume: bool,
    clock: Callable[[], datetime],
    report: Callable[[int], None],
    baud: int | None = None,
    retry: int = 0,
) -> MeasurementSummary:
    """Measure a campaign with each seed on a virtual rig of its own, in ``folder/SEED``.

    Each campaign equals that of ``measure`` with its seed. ``resume`` keeps existing runs and makes
    missing ones. ``report`` gets the number of finished campaigns; ``clock`` must be picklable.
    Raises as ``measure`` does, from the first campaign that fails, which interrupts the others;
    ``DeviceError`` if a process has died.
    """
    physics = physics_of(experiment.files["bench"]["content"], plant)
    rig = open_port("sim", experiment.bench, physics, seeds[0], baud)
    rig.read(0.0)  # compiles once, instead of in each process
    rig.close()
    job = partial(_measure_seed, experiment, folder, plant, resume, clock, baud, retry)
    runs, seconds = 0, 0.0
    made_again: dict[str, str] = {}
    for done, (seed, summary) in enumerate(map_on_cores(job, seeds), start=1):
        runs, seconds = runs + summary.runs, seconds + summary.seconds
        made_again |= {f"{seed}/{run}": found for run, found in summary.made_again.items()}
        report(done)
    return MeasurementSummary(runs, seconds, made_again)


def _measure_seed(
    experiment: Experiment,
    folder: Path,
    plant: Path | None,
    resume: bool,
    clock: Callable[[], datetime],
    baud: int | None,
    retry: int,
    seed: int,
) -> tuple[int, MeasurementSummary]:
    destination = folder / str(seed)
    return seed, measure(
        experiment,
        destination,
        port="sim",
        plant=plant,
        seed=seed,
        resume=resume and (destination / JOURNAL).exists(),
        clock=clock,
        report=_ignore,
        baud=baud,
        retry=retry,
    )


def _ignore(progress: Progress) -> None:
    pass
