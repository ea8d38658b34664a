"""Diagnosis of imported campaigns of a mass with a drive, without hydraulics."""

from collections.abc import Callable, Sequence
from pathlib import Path

from hbench.config.bench import plant_sections
from hbench.config.files.loading import read_yaml
from hbench.config.stroke_model import motion_sections, parse_motion
from hbench.reconcile.motion.motion_diagnosis import MotionTask, diagnose_motion
from hbench.records import Diagnosis, Run
from hbench.store.campaign.folder import StoredCampaign
from hbench.workflow.stroke_diagnosis import chosen_series


def has_drive(runs: Sequence[Run]) -> bool:
    """Return whether some run has the force of a drive without hydraulics."""
    return any(run.f_drive_n is not None for run in runs)


def diagnosed_motion(
    campaign: StoredCampaign,
    runs: Sequence[Run],
    model_file: Path,
    series: str | None,
    material: float,
    stage: Callable[[str], None],
) -> Diagnosis:
    """Diagnose the motion in the runs of a ``series``, which is optional if there is only one.

    The model's file needs only moving_mass.test and friction.test. Raises ``ConfigError``,
    ``DataError``.
    """
    label = chosen_series(campaign, series, "The drive force is known")
    data = read_yaml(model_file)
    if campaign.bench_content:
        data = plant_sections(campaign.bench_content, data, str(model_file))
    sections = motion_sections(data)
    return diagnose_motion(
        MotionTask(
            provenance=campaign.provenance(),
            model=model_file.name,
            plant=parse_motion(sections, str(model_file)),
            plant_data=sections,
            runs=tuple(run for run in runs if run.plan.label == label),
            material=material,
            stage=stage,
        )
    )
