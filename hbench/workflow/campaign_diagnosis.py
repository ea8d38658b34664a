"""Diagnosis of a campaign along its logs, measured with hbench or imported."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from hbench.config.bench import plant_sections
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.reconcile.diagnose import ReconcileTask, diagnose
from hbench.reconcile.measured.balances import FLOWS, channels_missing
from hbench.reconcile.separation.next_experiment import ExperimentLibrary
from hbench.reconcile.simulated_runs import simulator
from hbench.records import Diagnosis, Run
from hbench.store.campaign.folder import StoredCampaign
from hbench.workflow.board import physics_of

_NO_BENCH = (
    "The campaign has no bench file, from which missing sections could come: the model needs all "
    "sections of configs/model-aau.yaml. For a bench without a load cylinder, copy test_cylinder "
    "to load_cylinder, with 'offset: 0 mm', and friction.test to friction.load: they are not used."
)


def determines_flows(runs: Sequence[Run], model_file: Path) -> bool:
    """Return whether commands and chamber pressures of some run determine flows.

    Those into the test cylinder suffice if the model's file describes the valve. Raises
    ``ConfigError``.
    """
    known = FLOWS if "valve" in read_yaml(model_file) else FLOWS[-1:]
    return any(not channels_missing(run, balance) for run in runs for balance in known)


def diagnosed(
    campaign: StoredCampaign,
    runs: Sequence[Run],
    model_file: Path,
    material: float,
    report: Callable[[int, int], None],
    stage: Callable[[str], None],
) -> Diagnosis:
    """Diagnose the runs of a campaign. Raises ``ConfigError``, ``DataError``."""
    bench = campaign.bench()
    content: dict[str, Any] = (campaign.header.get("bench") or {}).get("content") or {}
    sections = plant_sections(content, read_yaml(model_file), str(model_file))
    try:
        plant = physics_of(content, model_file)
    except ConfigError as error:
        raise ConfigError(error.message, error.hint or ("" if content else _NO_BENCH)) from None
    assert plant is not None  # there is a file
    simulate = simulator(bench, plant, report) if bench and not campaign.imported else None
    instruments = campaign.setup().instruments
    schedule = (campaign.header.get("schedule") or {}).get("content") or {}
    bench_file = (campaign.header.get("bench") or {}).get("file") or "BENCH"
    experiments = None
    if bench:
        experiments = ExperimentLibrary(bench, plant, instruments, schedule, bench_file)
    return diagnose(
        ReconcileTask(
            provenance=campaign.provenance(),
            bench=bench,
            model=model_file.name,
            plant=plant,
            plant_data=sections,
            runs=tuple(runs),
            instruments=instruments,
            material=material,
            simulate=simulate,
            experiments=experiments,
            stage=stage,
        )
    )
