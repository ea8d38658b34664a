"""Curves of the same load that differ in the load cylinder's rod-side pressure, told apart."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

from hbench.records import Band, Curve, EfficiencyCurve, RunPlan
from hbench.report.render.numbers import force, short
from hbench.units import from_si

Series = TypeVar("Series", Band, Curve, EfficiencyCurve, RunPlan)


def told_apart(series: Iterable[Series]) -> tuple[Series, ...]:
    """Return ``series`` with ``p_lr_ref_pa`` only if it tells two of them apart.

    It does if one kind, label, direction and load was measured at several. All keep it then,
    none otherwise.
    """
    series = tuple(series)
    pressures = defaultdict(set)
    for one in series:
        direction = None if isinstance(one, Band) else one.direction
        acceleration = getattr(one, "a_ref_m_s2", None)
        key = one.kind, one.label, direction, one.f_load_n, acceleration
        pressures[key].add(one.p_lr_ref_pa)
    if any(len(found) > 1 for found in pressures.values()):
        return series
    return tuple(replace(one, p_lr_ref_pa=None) for one in series)


def load_words(f_load_n: float | None, p_lr_ref_pa: float | None) -> str:
    """Write what the load cylinder did, such as ``500 N, 15 bar``; empty if nothing was set."""
    words = [] if f_load_n is None else [force(f_load_n)]
    if p_lr_ref_pa is not None:
        words.append(f"{short(from_si(p_lr_ref_pa, 'bar'))} bar")
    return ", ".join(words)


def kind_words(one: Curve | EfficiencyCurve | RunPlan) -> str:
    """Write what is not a steady run, such as ``ramp 0.1 m/s²``; empty for a steady one."""
    if one.kind == "ramp" and one.a_ref_m_s2 is not None:
        return f"ramp {short(one.a_ref_m_s2)} m/s²"
    return "" if one.kind == "steady" else one.kind
