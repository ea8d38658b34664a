"""Diagnosis of a driven mass in its own names: of its balance, its constant force and its parts."""

from collections.abc import Collection, Mapping
from dataclasses import replace
from math import nan

from hbench.reconcile.motion.measured_motion import BALANCE
from hbench.records import (
    AddedEffect,
    BeforeAfter,
    Diagnosis,
    EffectInPractice,
    Gap,
    GapTable,
    Region,
    ResidualMap,
    WorkingPoint,
)
from hbench.records.reconcile.diagnosis import MOTION_BALANCE

_CONSTANT = "load_cell_offset"
_CONSTANT_FORCE = "a constant force acts, such as a weight or an offset of the drive's force"
_ADVICE = {  # what to inspect, and what to do then
    "direction_asymmetry": (
        "the seals and wipers of the guide, and the drive's force in both directions at one speed",
        "Replace the seal or the wiper that rubs unequally.",
    ),
    "position_friction": (
        "the guide's straightness and preload along its length, and the drive's screw or belt",
        "Realign or clean the guide, or avoid its tight part.",
    ),
    "end_cushion": (
        "the bumpers or shock absorbers at the ends of the travel",
        "Adjust them, or keep the motion away from the ends.",
    ),
    "added_mass": (
        "the driven mass by weighing, and the inertia of the drive",
        "Enter the mass in the model file.",
    ),
    _CONSTANT: (
        "the inclination of the guide, weights on the mass, and the zero of the drive's force",
        "Balance the weight, correct the zero, or keep this force in the model.",
    ),
}


def of_driven_mass(diagnosis: Diagnosis, observable: Collection[str], has_load: bool) -> Diagnosis:
    """Return a diagnosis without the names of a hydraulic bench.

    ``observable`` are the effects that the balance can show, ``has_load`` is whether a load was
    measured.
    """
    return replace(
        diagnosis,
        why=diagnosis.why.replace(BALANCE, MOTION_BALANCE),
        where=tuple(map(_gap, diagnosis.where)),
        rest=tuple(map(_gap, diagnosis.rest)),
        regions=tuple(map(_region, diagnosis.regions)),
        regions_after=tuple(map(_region, diagnosis.regions_after)),
        gap_heldout=_table(diagnosis.gap_heldout),
        gap_train=_table(diagnosis.gap_train),
        gap_runs=tuple(replace(each, gap=_table(each.gap)) for each in diagnosis.gap_runs),
        residuals_before=_map(diagnosis.residuals_before),
        residuals_after=_map(diagnosis.residuals_after),
        effects=tuple(map(_effect, diagnosis.effects)),
        practice=tuple(_practice(each, observable, has_load) for each in diagnosis.practice),
        working_point=_point(diagnosis.working_point, has_load),
    )


def _name(name: str) -> str:
    return MOTION_BALANCE if name == BALANCE else name


def _gap(gap: Gap) -> Gap:
    return replace(gap, name=_name(gap.name))


def _region(region: Region) -> Region:
    return replace(region, gaps={_name(name): gap for name, gap in region.gaps.items()})


def _table(table: GapTable) -> GapTable:
    balances: Mapping[str, BeforeAfter] = table.balances
    return replace(table, balances={_name(name): gap for name, gap in balances.items()})


def _map(residuals: ResidualMap) -> ResidualMap:
    return replace(residuals, names=tuple(map(_name, residuals.names)))


def _effect(effect: AddedEffect) -> AddedEffect:
    if effect.name != _CONSTANT:
        return effect
    return replace(effect, description=_CONSTANT_FORCE, of_sensor=False)


def _practice(
    effect: EffectInPractice, observable: Collection[str], has_load: bool
) -> EffectInPractice:
    of_reading = has_load and effect.name != _CONSTANT
    changes = tuple(
        replace(change, quantity=_name(change.quantity))
        for change in effect.changes
        if change.quantity != "f_applied" or of_reading
    )
    inspect, repair = _ADVICE.get(effect.name, (effect.inspect, effect.repair))
    others = tuple(other for other in effect.lookalikes if other.name in observable)
    return replace(effect, changes=changes, inspect=inspect, repair=repair, lookalikes=others)


def _point(point: WorkingPoint | None, has_load: bool) -> WorkingPoint | None:
    if point is None:
        return None
    residuals = {_name(name): value for name, value in point.residuals.items()}
    return replace(point, f_applied_n=point.f_applied_n if has_load else nan, residuals=residuals)
