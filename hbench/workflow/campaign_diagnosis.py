"""Diagnosis of a campaign along its logs, measured with hbench or imported."""

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from hbench.config.bench import Bench, Plant, merge, plant_sections
from hbench.config.files.loading import read_yaml, validate
from hbench.config.sensors import Instruments
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


class _Model(NamedTuple):
    """A campaign's model, with a value where its file has 0 or what the flows contradict."""

    plant: Plant
    sections: dict[str, Any]  # of the plant, as in a file
    notes: tuple[str, ...]  # values that are implausible, and those that are not the file's


def diagnosed(
    campaign: StoredCampaign,
    runs: Sequence[Run],
    model_file: Path,
    material: float,
    report: Callable[[int, int], None],
    stage: Callable[[str], None],
) -> Diagnosis:
    """Diagnose the runs of a campaign, in the order of their starts where these are known.

    Deviations below ``material``, a share of a signal's range, do not matter. ``report`` receives
    the number of completed simulations and the total, ``stage`` a description of each stage. Raises
    ``ConfigError``, ``DataError``.
    """
    times_s = campaign.start_times_s()
    dated = all(run.plan.run in times_s for run in runs)
    if dated:
        runs = sorted(runs, key=lambda run: times_s[run.plan.run])
    bench = campaign.bench()
    sections = plant_sections(campaign.bench_content, read_yaml(model_file), str(model_file))
    try:
        model = _model(sections, bench, runs, model_file)
    except ConfigError as error:
        hint = error.hint or ("" if campaign.bench_content else _NO_BENCH)
        raise ConfigError(error.message, hint) from None
    instruments = campaign.setup().instruments
    experiments = _experiments(campaign, bench, model.plant, instruments) if bench else None
    simulate = simulator(bench, model.plant, report) if bench and not campaign.imported else None
    diagnosis = diagnose(
        ReconcileTask(
            provenance=campaign.provenance(),
            bench=bench,
            model=model_file.name,
            plant=model.plant,
            plant_data=model.sections,
            runs=tuple(runs),
            instruments=instruments,
            material=material,
            simulate=simulate,
            experiments=experiments,
            stage=stage,
        )
    )
    assumed = (_ORDER_ASSUMED,) if campaign.imported and not dated else ()
    return replace(diagnosis, notes=(*diagnosis.notes, *model.notes, *assumed))


def _model(
    sections: dict[str, Any], bench: Bench | None, runs: Sequence[Run], model_file: Path
) -> _Model:
    """Return the model of a plant's ``sections`` from which the refit of the runs starts.

    Raises ``ConfigError``.
    """
    source = str(model_file)
    opposed = any(run.p_lp_pa is not None or run.p_lr_pa is not None for run in runs)
    plant = _validated(sections, opposed, source)
    check_effects(plant, model_file)
    doubts = [words for words in implausible(plant) if opposed or ".load" not in words]
    sections, zeros = _without_zeros(sections, plant)
    plant = _validated(sections, opposed, source)
    contradicted = contradicted_values(bench, plant, runs)
    shown = {path: _quantity(path, value) for path, value in contradicted.items()}
    given = {path: _quantity(path, given_value(plant, path)) for path in contradicted}
    for path, value in shown.items():
        *parents, key = path.split(".")
        changed: dict[str, Any] = {key: value}
        for name in reversed(parents):
            changed = {name: changed}
        sections = merge(sections, changed)
    notes = [_DOUBT.format(words) for words in doubts]
    if zeros:
        notes.append(_ZERO.format(listed(list(zeros)), listed(list(zeros.values()))))
    notes += [
        _CONTRADICTED.format(path, value, given[path]) + _ALIKE.get(path, "")
        for path, value in shown.items()
    ]
    return _Model(_validated(sections, opposed, source), sections, tuple(notes))


def _experiments(
    campaign: StoredCampaign, bench: Bench, plant: Plant, instruments: Instruments | None
) -> ExperimentLibrary:
    """Return the experiments on a campaign's bench that could follow it."""
    schedule = (campaign.header.get("schedule") or {}).get("content") or {}
    bench_file = (campaign.header.get("bench") or {}).get("file") or "BENCH"
    return ExperimentLibrary(bench, plant, instruments, schedule, bench_file)


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
