"""Diagnosis of a campaign along its logs, measured with hbench or imported."""

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

from hbench.config.bench import Plant, merge, plant_sections
from hbench.config.files.loading import read_yaml, validate
from hbench.control.plausibility import implausible
from hbench.errors import ConfigError
from hbench.reconcile.contradicted_values import (
    GAIN,
    MODULUS,
    contradicted_values,
    given_value,
)
from hbench.reconcile.diagnose import ReconcileTask, diagnose
from hbench.reconcile.gaps.simulated_runs import simulator
from hbench.reconcile.measured.balances import CHANNELS_OF, FLOWS, channels_missing
from hbench.reconcile.nuisance import zero_values
from hbench.reconcile.separation.next_experiment import ExperimentLibrary
from hbench.records import Diagnosis, Run
from hbench.sentences import listed
from hbench.store.campaign.folder import StoredCampaign
from hbench.units import from_si
from hbench.workflow.board import check_effects

_NO_BENCH = (
    "The campaign has no bench file, from which missing sections could come: the model needs all "
    "sections of configs/model-aau.yaml. A bench whose logs have no pressures of a load cylinder "
    "needs none of its sections."
)
_ORDER_ASSUMED = (
    "The runs have no start times: they are taken in the order in which they were imported. If "
    "they were measured in another order, warming oil and drifting sensors are not found as such. "
    "Logs whose times are dates (t_s with 'unit: date-time' in the import map) give start times."
)
_DOUBT = "Implausible in the model file: {}."
_ZERO = (
    "The model file has 0, or no value, for {}. A refit multiplies values, so it started from {}."
)
_CONTRADICTED = (
    "The measured flows show {} = {}; the model file has {}. The refit started from the measured "
    "value. Correct the file."
)
_ALIKE = {
    MODULUS: " Wrong dead volumes look the same: check these too.",
    GAIN: " A wrong scale of the commands in the import map looks the same: check it too.",
}
_UNITS = {  # of values, by the last key of their path
    "bulk_modulus": "bar",
    "gain": "m^2/V",
    "tank": "bar",
    "dead_volume_piston": "cm^3",
    "dead_volume_rod": "cm^3",
    "coulomb": "N",
    "stiction": "N",
    "viscous": "N s/m",
    "gain_load_1": "%",
    "gain_load_2": "%",
    "ports": "%",
}


def no_flows_without(runs: Sequence[Run], model_file: Path) -> tuple[str, ...]:
    """Return what is missing to determine a flow: channels, or the model's valve; empty if nothing.

    The channels of the test cylinder suffice if the model's file describes the valve. Where a run
    has them and the file does not, the valve is what is missing. Raises ``ConfigError``.
    """
    has_valve = "valve" in read_yaml(model_file)
    known = FLOWS if has_valve else FLOWS[-1:]
    missing = [channels_missing(run, balance) for run in runs for balance in known]
    channels = min(missing, key=len, default=CHANNELS_OF[known[0]])
    if channels and not has_valve and not all(channels_missing(run, FLOWS[0]) for run in runs):
        return (f"a section 'valve' in {model_file.name}",)
    return channels


def diagnosed(
    campaign: StoredCampaign,
    runs: Sequence[Run],
    model_file: Path,
    material: float,
    report: Callable[[int, int], None],
    stage: Callable[[str], None],
) -> Diagnosis:
    """Diagnose the runs of a campaign, in the order of their starts where these are known.

    Raises ``ConfigError``, ``DataError``.
    """
    times_s = campaign.start_times_s()
    dated = all(run.plan.run in times_s for run in runs)
    if dated:
        runs = sorted(runs, key=lambda run: times_s[run.plan.run])
    bench = campaign.bench()
    content = campaign.bench_content
    source = str(model_file)
    sections = plant_sections(content, read_yaml(model_file), source)
    opposed = any(run.p_lp_pa is not None or run.p_lr_pa is not None for run in runs)
    try:
        plant = _validated(sections, opposed, source)
        check_effects(plant, model_file)
        doubts = [words for words in implausible(plant) if opposed or ".load" not in words]
        sections, zeros = _without_zeros(sections, plant)
        plant = _validated(sections, opposed, source)
        found = contradicted_values(bench, plant, runs)
        shown = {path: _quantity(path, value) for path, value in found.items()}
        given = {path: _quantity(path, given_value(plant, path)) for path in found}
        for path, value in shown.items():
            *parents, key = path.split(".")
            changed: dict[str, Any] = {key: value}
            for name in reversed(parents):
                changed = {name: changed}
            sections = merge(sections, changed)
        plant = _validated(sections, opposed, source)
    except ConfigError as error:
        raise ConfigError(error.message, error.hint or ("" if content else _NO_BENCH)) from None
    simulate = simulator(bench, plant, report) if bench and not campaign.imported else None
    instruments = campaign.setup().instruments
    schedule = (campaign.header.get("schedule") or {}).get("content") or {}
    bench_file = (campaign.header.get("bench") or {}).get("file") or "BENCH"
    experiments = None
    if bench:
        experiments = ExperimentLibrary(bench, plant, instruments, schedule, bench_file)
    diagnosis = diagnose(
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
    notes = list(diagnosis.notes)
    notes += [_DOUBT.format(words) for words in doubts]
    if zeros:
        notes.append(_ZERO.format(listed(list(zeros)), listed(list(zeros.values()))))
    notes += [
        _CONTRADICTED.format(path, value, given[path]) + _ALIKE.get(path, "")
        for path, value in shown.items()
    ]
    if campaign.imported and not dated:
        notes.append(_ORDER_ASSUMED)
    return replace(diagnosis, notes=tuple(notes))


def _validated(sections: dict[str, Any], opposed: bool, source: str) -> Plant:
    return validate(Plant, sections if opposed else _with_unused_load(sections), source)


def _quantity(path: str, value: float) -> str:
    """Return a value [SI] of a model file in the unit of its key."""
    unit = _UNITS[path.rpartition(".")[2]]
    return f"{float(f'{from_si(value, unit):.4g}'):.10g} {unit}"


def _without_zeros(sections: dict[str, Any], plant: Plant) -> tuple[dict[str, Any], dict[str, str]]:
    """Return a model's sections with small values where they have 0, and these by dotted path."""
    changed, values = deepcopy(sections), {}
    for path, value in zero_values(plant).items():
        *parents, key = path.split(".")
        section: Any = changed
        for name in parents:
            section = section.get(name, {})
        if section:  # it has no load cylinder that is not used
            section[key] = values[path] = _quantity(path, value)
    return changed, values


def _with_unused_load(sections: dict[str, Any]) -> dict[str, Any]:
    """Return a model's sections with those of a load cylinder, which no balance uses.

    What is missing is that of the test cylinder.
    """
    filled = dict(sections)
    if isinstance(cylinder := sections.get("test_cylinder"), dict):
        filled.setdefault("load_cylinder", cylinder | {"offset": "0 mm"})
    for name in ("moving_mass", "friction"):
        own = sections.get(name)
        if isinstance(own, dict) and "test" in own:
            filled[name] = own | {"load": own.get("load", own["test"])}
    return filled
