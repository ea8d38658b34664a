"""Diagnosis of a campaign against a closed-loop simulation of the same runs."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from hbench.analysis.screening.calibrate import calibrate
from hbench.config.bench import Bench, plant_sections
from hbench.config.files.loading import read_yaml
from hbench.reconcile.diagnose import ReconcileTask, diagnose
from hbench.reconcile.next_experiment import next_experiment
from hbench.reconcile.simulated_runs import simulator
from hbench.records import Diagnosis
from hbench.store.campaign.folder import StoredCampaign
from hbench.workflow.board import physics_of


def diagnosed(
    campaign: StoredCampaign, bench: Bench, model_file: Path, report: Callable[[int, int], None]
) -> Diagnosis:
    """Diagnose a campaign measured with hbench. Raises ``ConfigError``, ``DataError``."""
    content = campaign.header["bench"]["content"]
    plant = physics_of(content, model_file) or bench
    runs = tuple(calibrate(raw, bench) for raw in campaign.raw_runs())
    return diagnose(
        ReconcileTask(
            provenance=campaign.provenance(),
            bench=bench,
            model=model_file.name,
            plant=plant,
            plant_data=plant_sections(content, read_yaml(model_file), str(model_file)),
            runs=runs,
            simulate=simulator(bench, plant, campaign.plans, report),
            propose=partial(next_experiment, bench, plant),
        )
    )
