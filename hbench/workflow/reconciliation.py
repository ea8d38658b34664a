"""Reconciliation of a campaign with a model: diagnosis, and a revised model."""

from collections.abc import Callable
from pathlib import Path

from hbench.errors import ConfigError
from hbench.records import KINDS, Diagnosis, PlannedEffects
from hbench.records.reconcile.diagnosis import MATERIAL
from hbench.report.diagnosis.diagnosis_document import diagnosis_json
from hbench.report.diagnosis.figures.all_figures import draw_diagnosis
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.revised_yaml import revised_yaml, schedule_yaml
from hbench.report.diagnosis.tables.run_gaps import run_gaps_csv
from hbench.report.render.figures import figure_files
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.stored_diagnosis import FILE_NAME
from hbench.store.files.atomic import figures_in, remove_files, write_files
from hbench.workflow.board import physics_of
from hbench.workflow.campaign import Experiment
from hbench.workflow.results import calibrated_runs

_OPTIONAL = ("next.yaml", "gaps_by_run.csv")  # files of some diagnoses only


def reconcile(
    folder: Path,
    model_file: Path,
    report: Callable[[int, int], None],
    series: str | None = None,
    material: float = MATERIAL,
    stage: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Find where a campaign and a model disagree, and which effect is missing in the model.

    The model is a bench file, or a plant file applied to the campaign's bench. ``report`` gets the
    numbers of finished and of all simulations, ``stage`` what begins. Logs with chamber pressures
    and commands are compared along their samples, whoever made them. Of other imported logs one
    ``series`` is compared, which must be specified if there are several: the motion of a mass whose
    drive force was measured, or else steady strokes. Deviations below a share ``material`` of a
    signal's range do not matter. Raises ``ConfigError``, ``DataError``.
    """
    # Slow imports: they compile.
    from hbench.workflow import campaign_diagnosis
    from hbench.workflow.motion_diagnosis import diagnosed_motion, has_drive
    from hbench.workflow.stroke_diagnosis import diagnosed_strokes

    campaign = load_campaign(folder)
    runs = tuple(r for r in calibrated_runs(campaign) if KINDS[r.plan.kind].is_reconciled)
    if campaign.imported and has_drive(runs):
        return diagnosed_motion(campaign, runs, model_file, series, material, stage)
    if campaign.imported and (absent := campaign_diagnosis.no_flows_without(runs, model_file)):
        return diagnosed_strokes(campaign, model_file, series, absent)
    if series is not None:
        raise ConfigError(
            f"--series: {folder} has pressures and valve commands: all its series are compared",
            "Remove --series.",
        )
    return campaign_diagnosis.diagnosed(campaign, runs, model_file, material, report, stage)


def planned_effects(experiment: Experiment, plant: Path | None) -> PlannedEffects:
    """Return the effects that ``reconcile`` would find in the runs of a schedule, by simulation.

    The bench's own physics are the model, or those of the file ``plant``. Raises ``ConfigError``,
    ``DataError``.
    """
    from hbench.reconcile.separation import planned_runs  # compiles

    bench = experiment.bench
    model = physics_of(experiment.files["bench"]["content"], plant) or bench
    return planned_runs.planned_effects(bench, model, experiment.plans)


def write_diagnosis(folder: Path, diagnosis: Diagnosis) -> None:
    """Write the page, its figures, the numbers as JSON, the revised model and the next schedule.

    Files of an earlier diagnosis in ``folder`` that this one does not have are removed.
    """
    drawings = draw_diagnosis(diagnosis)
    files = figure_files(drawings)
    files["model.yaml"] = revised_yaml(diagnosis).encode()
    if diagnosis.next_schedule:
        files["next.yaml"] = schedule_yaml(diagnosis).encode()
    if diagnosis.gap_runs:
        files["gaps_by_run.csv"] = run_gaps_csv(diagnosis).encode()
    files["diagnosis.json"] = diagnosis_json(diagnosis).encode()
    files["report.html"] = diagnosis_page(diagnosis, drawings).encode()
    if (folder / FILE_NAME).is_file():
        remove_files(folder, {*_OPTIONAL, *figures_in(folder)} - files.keys())
    write_files(folder, files)
