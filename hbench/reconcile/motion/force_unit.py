"""Unit of force of a bench without hydraulics, and results converted from it to newtons.

The catalogue states the typical sizes of effects for a cylinder with some hundred newtons of
friction. They decide how large a step a coefficient takes, how wide its prior is, and below which
size an effect has no name. A driven mass may have a thousandth of this friction. Its forces,
masses and stiffnesses are therefore expressed in a unit of force in which its friction is as large
as that of such a cylinder; lengths and times stay the same.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from hbench.config.scaling import replaced, value_paths
from hbench.config.stroke_model import MotionPlant
from hbench.model.effects.catalogue import EFFECTS, read_effects
from hbench.reconcile.estimates import times
from hbench.reconcile.hypothesis import Hypothesis
from hbench.records import Candidate, Change, Diagnosis, FitParameter, Gap, WorkingPoint

FRICTION_N = 250.0  # of the catalogue's cylinder
_OF_FORCE = frozenset({"N", "kg", "N s/m", "N/m"})
_FORCES = frozenset(
    ("test", "coulomb", "stiction", "viscous", "stribeck_force", "elements")
    + ("bristle_stiffness", "bristle_damping", "low_force", "low_slope", "high_force", "high_slope")
)  # keys of a model's values in proportion to force
_UNKNOWN = {"pressure", "force_load"}  # quantities that a bench without hydraulics does not have
_NAN = float("nan")


def in_unit(plant: MotionPlant, unit_n: float) -> MotionPlant:
    """Return a model with forces and masses in units of ``unit_n`` [N]."""
    given = read_effects(plant.effects)
    for path in value_paths(MotionPlant):
        *parents, key = path.split(".")
        if key in _FORCES and _has(plant, path):
            plant = replaced(plant, [*parents, key], partial(_times, factor=1 / unit_n))
    scaled = Hypothesis(effects=_scaled_effects(given, 1 / unit_n)).section()
    return plant.model_copy(update={"effects": scaled})


def in_newtons(diagnosis: Diagnosis, unit_n: float, fitted: frozenset[str]) -> Diagnosis:
    """Return a diagnosis with all forces and masses in SI; ``fitted`` are effects of ``revised``.

    The pressure, which stands for the drive's force in the balances, is removed.
    """
    effects = tuple(
        replace(
            effect,
            parameters={k: _parameter(p, unit_n) for k, p in effect.parameters.items()},
        )
        for effect in diagnosis.effects
    )
    practice = tuple(
        replace(
            effect,
            changes=tuple(
                _change(each, unit_n) for each in effect.changes if each.quantity not in _UNKNOWN
            ),
        )
        for effect in diagnosis.practice
    )
    return replace(
        diagnosis,
        where=tuple(_gap(gap, unit_n) for gap in diagnosis.where),
        rest=tuple(_gap(gap, unit_n) for gap in diagnosis.rest),
        effects=effects,
        alternatives=tuple(_candidate(each, unit_n) for each in diagnosis.alternatives),
        ranking=tuple(_candidate(each, unit_n) for each in diagnosis.ranking),
        practice=practice,
        working_point=_point(diagnosis.working_point, unit_n),
        revised=_revised(diagnosis.revised, unit_n, fitted),
    )


def _has(plant: Any, path: str) -> bool:
    for name in path.split("."):
        if not hasattr(plant, name):
            return False
        plant = getattr(plant, name)
    return True


def _times(value: Any, factor: float) -> Any:
    return tuple(factor * each for each in value) if isinstance(value, tuple) else factor * value


def _scaled_effects(
    effects: Mapping[str, Mapping[str, float]], factor: float
) -> dict[str, dict[str, float]]:
    """Return coefficients [SI] of which those in proportion to force are multiplied."""
    return {
        name: {
            key: value * (factor if EFFECTS[name].coefficients[key].unit in _OF_FORCE else 1.0)
            for key, value in coefficients.items()
        }
        for name, coefficients in effects.items()
    }


def _gap(gap: Gap, unit_n: float) -> Gap:
    names = ("scatter", "deviation", "material", "allowed")
    return replace(gap, **{name: unit_n * getattr(gap, name) for name in names})


def _parameter(parameter: FitParameter, unit_n: float) -> FitParameter:
    return times(parameter, unit_n) if parameter.unit in _OF_FORCE else parameter


def _candidate(candidate: Candidate, unit_n: float) -> Candidate:
    values = _scaled_effects({candidate.name: candidate.parameters}, unit_n)[candidate.name]
    return replace(candidate, parameters=values)


def _change(change: Change, unit_n: float) -> Change:
    if change.unit != "N":
        return change
    ends = change.ci95
    return replace(
        change,
        at_point=unit_n * change.at_point,
        ci95=None if ends is None else (unit_n * ends[0], unit_n * ends[1]),
        along=unit_n * change.along,
        largest=unit_n * change.largest,
    )


def _point(point: WorkingPoint | None, unit_n: float) -> WorkingPoint | None:
    if point is None:
        return None
    residuals = {
        name: unit_n * value for name, value in point.residuals.items() if name not in _UNKNOWN
    }
    return replace(
        point,
        f_applied_n=unit_n * point.f_applied_n,
        p_tp_pa=_NAN,
        p_tr_pa=_NAN,
        residuals=residuals,
    )


def _revised(sections: Mapping[str, Any], unit_n: float, fitted: frozenset[str]) -> dict[str, Any]:
    """Return the revised model; of its effects only the ``fitted`` ones are in the unit."""
    effects = dict(sections.get("effects", {}))
    values = read_effects({name: effects[name] for name in effects if name in fitted})
    section = Hypothesis(effects=_scaled_effects(values, unit_n)).section()
    return {**sections, "effects": {**effects, **section}} if effects else dict(sections)


def unit_of(friction_n: float) -> float:
    """Return the unit of force [N] in which a friction is that of the catalogue's cylinder."""
    return friction_n / FRICTION_N
