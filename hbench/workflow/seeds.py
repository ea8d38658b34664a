"""Campaigns of many seeds on virtual rigs, on all cores of the machine."""

from collections.abc import Callable, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path

from hbench.experiment.progress import Progress
from hbench.parallel.process_pool import on_all_cores
from hbench.store.campaign.folder import JOURNAL
from hbench.workflow.board import open_port, physics_of
from hbench.workflow.campaign import Experiment, Measured, measure


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
) -> Measured:
    """Make a campaign with each seed on a virtual rig of its own, in ``folder/SEED``.

    Each is what ``measure`` makes of its seed. With ``resume`` what is there stays, and what is
    missing is made. ``report`` is given how many campaigns are done; ``clock`` must be picklable.
    Raises as ``measure`` does, from the first campaign that fails, which interrupts the others;
    ``DeviceError`` where a process has died.
    """
    physics = physics_of(experiment.files["bench"]["content"], plant)
    rig = open_port("sim", experiment.bench, physics, seeds[0], baud)
    rig.read(0.0)  # compiles, before each process would
    rig.close()
    make = partial(_make, experiment, folder, plant, resume, clock, baud, retry)
    runs, seconds = 0, 0.0
    for done, made in enumerate(on_all_cores(make, seeds), start=1):
        runs, seconds = runs + made.runs, seconds + made.seconds
        report(done)
    return Measured(runs, seconds)


def _make(
    experiment: Experiment,
    folder: Path,
    plant: Path | None,
    resume: bool,
    clock: Callable[[], datetime],
    baud: int | None,
    retry: int,
    seed: int,
) -> Measured:
    own = folder / str(seed)
    return measure(
        experiment,
        own,
        port="sim",
        plant=plant,
        seed=seed,
        resume=resume and (own / JOURNAL).exists(),
        clock=clock,
        report=_tell_nobody,
        baud=baud,
        retry=retry,
    )


def _tell_nobody(progress: Progress) -> None:
    pass
