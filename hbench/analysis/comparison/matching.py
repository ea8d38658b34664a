"""Matching of the series of two campaigns: labels, factors, loads, pressures, speeds."""

from collections.abc import Hashable, Mapping
from typing import NamedTuple, TypeVar

from hbench.motion.reversals import SAME_STROKE_SPEED
from hbench.records import Band, Curve, EfficiencyCurve, Results
from hbench.records.rod_pressure import differs_in_rod_pressure

SPEED_TOLERANCE = 0.02  # largest relative difference of two speeds with the same reference
# Largest difference of two pressures with the same set-point, as regulators hold them.
_PRESSURE_TOLERANCE, _PRESSURE_TOLERANCE_PA = 0.05, 5e3

Key = TypeVar("Key", bound=Hashable)


class SetPoint(NamedTuple):
    """Load and pressure at which a series was measured."""

    f_load_n: float | None
    p_tp_pa: float | None


class Distinction(NamedTuple):
    """What distinguishes the series of either campaign, and must agree in both."""

    labels: bool  # a single label names the cylinder or the seal, which may differ
    factors: frozenset[str]  # those with several values
    rod_pressures: bool  # a campaign of a bench without a load cylinder states none


def distinction(a: Results, b: Results) -> Distinction:
    """Return which of labels, without their factors, factors and rod-side pressures must agree."""
    labels, factors = False, set()
    for curves in (a.curves, b.curves):
        labels |= len({_label(curve) for curve in curves}) > 1
        values = [dict(curve.factors) for curve in curves]
        names = {name for each in values for name in each}
        factors |= {name for name in names if len({each.get(name) for each in values}) > 1}
    stated = all(any(each.p_lr_ref_pa is not None for each in x.curves) for x in (a, b))
    several = any(differs_in_rod_pressure(each.curves) for each in (a, b))
    return Distinction(labels, frozenset(factors), stated or several)


def _label(series: Band | Curve | EfficiencyCurve) -> str:
    """Return a label without the factors at its end."""
    factors = "".join(f", {name} {value}" for name, value in series.factors)
    return series.label.removesuffix(factors)


def speed_tolerance(a: Results, b: Results) -> float:
    """Return the largest relative difference of two speeds that count as the same.

    It is larger where no speed is known as set, as in strokes that a weight or a supply drives.
    """
    runs = (*a.runs, *b.runs)
    measured = any(run.run.plan.speed_is_measured for run in runs)
    return SAME_STROKE_SPEED if measured else SPEED_TOLERANCE


def matching_key(series: Band | Curve | EfficiencyCurve, distinct: Distinction) -> tuple:
    """Return what series must have in common besides direction, load and speed."""
    factors = frozenset(factor for factor in series.factors if factor[0] in distinct.factors)
    label = _label(series) if distinct.labels else None
    rod_pressure = series.p_lr_ref_pa if distinct.rod_pressures else None
    return series.kind, rod_pressure, label, factors


def same_set_point(a: SetPoint, b: SetPoint) -> bool:
    """Return whether the loads are equal, or the pressures within 5 % or 0.05 bar."""
    if a.f_load_n is not None and a.f_load_n == b.f_load_n:
        return True
    if a.p_tp_pa is None or b.p_tp_pa is None:
        return a.f_load_n is None and b.f_load_n is None
    limit = max(_PRESSURE_TOLERANCE * abs(a.p_tp_pa), _PRESSURE_TOLERANCE_PA)
    return abs(b.p_tp_pa - a.p_tp_pa) <= limit


def nearest_set_point(point: SetPoint, others: Mapping[Key, SetPoint]) -> Key | None:
    """Return the key of the same set-point; equal loads come before equal pressures."""
    same = [key for key, other in others.items() if same_set_point(point, other)]
    return min(same, key=lambda key: _distance(point, others[key]), default=None)


def _distance(a: SetPoint, b: SetPoint) -> tuple[bool, float]:
    return a.f_load_n != b.f_load_n, abs((a.p_tp_pa or 0.0) - (b.p_tp_pa or 0.0))
