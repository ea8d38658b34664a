"""Whether runs have two loads, and one load at two pressures.

Loads are those of the plans. Where no plan states one they are measured: by the load cell, or else
by the pressures of the load cylinder, or else by those of the test cylinder.
"""

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np

from hbench.reconcile.separation.logged_motion import moving_direction, velocity_m_s
from hbench.records import KINDS, Run

Areas = tuple[float, float]  # piston side and rod side [m^2]
_OTHER_LOAD = 0.2  # of the largest mean force: a smaller difference may be that of friction
_SAME_LOAD = 0.02  # of the largest load: friction and the pressures' control change it by as much
_SAME_SPEED = 0.1  # speeds that differ by this share have nearly the same friction


def has_second_load(runs: Sequence[Run], load_areas: Areas | None = None) -> bool:
    """Return whether runs have two loads: nominal ones, or measured ones at nearly one speed.

    ``load_areas`` are those of the load cylinder.
    """
    nominal = {run.plan.f_load_n for run in runs if run.plan.f_load_n is not None}
    if nominal:
        return len(nominal) > 1
    load_of, forces = _measured_by(runs, load_areas), dict[tuple[str, float, str], list[float]]()
    for run in runs:
        if np.isfinite(load := load_of(run)):
            which = run.plan.kind, run.plan.v_ref_m_s, run.plan.label
            forces.setdefault(which, []).append(load)
    means = {which: float(np.mean(each)) for which, each in forces.items()}
    other = _OTHER_LOAD * max(map(abs, means.values()), default=0.0)
    return any(
        kind == kind_2
        and abs(v - v_2) <= _SAME_SPEED * min(abs(v), abs(v_2))
        and abs(means[kind, v, label] - means[kind_2, v_2, label_2]) > other
        for (kind, v, label), (kind_2, v_2, label_2) in combinations(means, 2)
    )


def has_second_pressure(runs: Sequence[Run], load_areas: Areas | None) -> bool:
    """Return whether steady runs have one load at two rod-side pressures of the load cylinder.

    Both are the nominal ones, or the measured ones at nearly one speed where none are stated.
    """
    steady = [run for run in runs if KINDS[run.plan.kind].has_constant_speed]
    load_of = _measured_by(steady, load_areas)
    loads = [load_of(run) if run.plan.f_load_n is None else run.plan.f_load_n for run in steady]
    levels = [
        _median(run.p_lr_pa) if run.plan.p_lr_ref_pa is None else run.plan.p_lr_ref_pa
        for run in steady
    ]
    speeds = [run.plan.v_ref_m_s for run in steady]
    same = _SAME_LOAD * np.nanmax(np.abs([*loads, 0.0]))
    other = _OTHER_LOAD * np.nanmax(np.abs([*levels, 0.0]))
    return any(
        abs(v - v_2) <= _SAME_SPEED * min(abs(v), abs(v_2))
        and abs(load - load_2) <= same
        and abs(level - level_2) > other
        for (v, load, level), (v_2, load_2, level_2) in combinations(
            zip(speeds, loads, levels, strict=True), 2
        )
    )


def _measured_by(runs: Sequence[Run], load_areas: Areas | None) -> Callable[[Run], float]:
    """Return how the load of a run is measured: the best way that some run has, or NaN."""
    every: tuple[Callable[[Run], float], ...] = (
        lambda run: _median(run.f_applied_n),
        lambda run: _pressure_force(run, run.p_lp_pa, run.p_lr_pa, load_areas),
        lambda run: _pressure_force(
            run, run.p_tp_pa, run.p_tr_pa, _known(run.plan.specimen.area_piston_m2,
                                                  run.plan.specimen.area_rod_m2)
        ),
    )  # fmt: skip
    known = (way for way in every if any(np.isfinite(way(run)) for run in runs))
    return next(known, lambda run: float("nan"))


def _known(piston_m2: float, rod_m2: float) -> Areas | None:
    return (piston_m2, rod_m2) if piston_m2 > 0 else None


def _pressure_force(
    run: Run, p_p: np.ndarray | None, p_r: np.ndarray | None, areas: Areas | None
) -> float:
    """Return the median force [N] of a cylinder's pressures; NaN without them.

    Where the piston moves both ways it is the mean of both medians, without friction.
    """
    if p_p is None or p_r is None or areas is None:
        return float("nan")
    force, way = p_p * areas[0] - p_r * areas[1], moving_direction(velocity_m_s(run))
    medians = [_median(force[way == sign]) for sign in (-1, 1) if np.any(way == sign)]
    return float(np.mean(medians)) if medians else _median(force)


def _median(measured: np.ndarray | None) -> float:
    """Return a median; NaN without values."""
    return float("nan") if measured is None or not len(measured) else float(np.median(measured))
