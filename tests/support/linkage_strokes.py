"""Strokes of a cylinder that a linkage of unknown force loads, without a force sensor.

The friction is ``friction(p_tp_pa, p_tr_pa)`` [N] times a share of each direction. The pressures
carry the load and the friction exactly, and the valve's back pressure differs between directions.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hbench.records import Run, RunPlan, ScreenedRun, Specimen, SteadyMeans

BORE_M, ROD_M = 0.065, 0.035
AREAS = Specimen(np.pi / 4 * BORE_M**2, np.pi / 4 * (BORE_M**2 - ROD_M**2))
LOADS_N = (9e3, 13e3, 17e3, 21e3, 25e3)
_BACK_PA = {1: (13e5, 9e5, 15e5, 8e5, 12e5), -1: (22e5, 17e5, 24e5, 15e5, 20e5)}  # rod side
_SPEED_M_S, _STROKE_M = 0.03, 0.2


def linkage_strokes(
    friction: Callable[[float, float], float],
    gain: float = 1.0,
    shares: tuple[float, float] = (1.0, 1.0),
    scatter: float = 0.01,
    trials: int = 3,
    seed: int = 0,
    loads_n: Sequence[float] = LOADS_N,
    slope_n_m: float = 0.0,
    apart_m: float = 0.0,
) -> tuple[ScreenedRun, ...]:
    """Return strokes at each load; ``gain`` is that of the piston side's pressure transducer.

    ``shares`` of the friction act while extending and while retracting. The load grows by
    ``slope_n_m`` times its number along the stroke; the strokes of the two directions are
    ``apart_m`` from each other.
    """
    rng, out = np.random.default_rng(seed), []
    t_s = np.linspace(0.0, _STROKE_M / _SPEED_M_S, 101)
    for trial in range(1, trials + 1):
        for number, load in enumerate(loads_n):
            for way, share in zip((1, -1), shares, strict=True):
                p_tr, level = _BACK_PA[way][number], 1 + scatter * rng.standard_normal()
                x = way * (_SPEED_M_S * t_s - _STROKE_M / 2) + way * apart_m / 2
                along = load + number * slope_n_m * x
                p_tp = (along + p_tr * AREAS.area_rod_m2) / AREAS.area_piston_m2
                for _ in range(50):  # the friction depends on the pressure that overcomes it
                    lost = way * share * level * friction(p_tp, p_tr)
                    p_tp = (along + lost + p_tr * AREAS.area_rod_m2) / AREAS.area_piston_m2
                plan = RunPlan(
                    str(len(out)), "steady", trial, way * _SPEED_M_S, AREAS, f_load_n=100.0 * number
                )
                out.append(_screened(plan, t_s, x, gain * p_tp, np.full(len(x), p_tr)))
    return tuple(out)


def sections(run: Run, edges_m: Sequence[float], v_m_s: float) -> tuple[ScreenedRun, ...]:
    """Return each passage of a log between two successive positions, as a stroke of its own load.

    ``v_m_s`` is the nominal speed of all.
    """
    out: list[ScreenedRun] = []
    for number, (low, high) in enumerate(zip(edges_m, edges_m[1:], strict=False)):
        inside = np.flatnonzero((run.x_m > low) & (run.x_m < high))
        trials = {1: 0, -1: 0}
        for passage in np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1):
            x, t = run.x_m[passage], run.t_s[passage]
            if abs(x[-1] - x[0]) < 0.8 * (high - low):
                continue  # it turns round within the section
            way = int(np.sign(x[-1] - x[0]))
            trials[way] += 1
            plan = replace(
                run.plan,
                run=str(len(out)),
                kind="steady",
                trial=trials[way],
                v_ref_m_s=way * v_m_s,
                f_load_n=100.0 * number,
            )
            out.append(_screened(plan, t, x, run.p_tp_pa[passage], run.p_tr_pa[passage]))
    return tuple(out)


def half_bands(screened: Sequence[ScreenedRun]) -> np.ndarray:
    """Return half the difference of the pressure forces of both directions, by load."""
    bands = []
    for load in sorted({run.run.plan.f_load_n for run in screened}):
        extend, retract = (
            np.mean(
                [
                    run.means.f_test_n
                    for run in screened
                    if run.run.plan.f_load_n == load and run.run.plan.direction == direction
                ]
            )
            for direction in ("extend", "retract")
        )
        bands.append((extend - retract) / 2)
    return np.array(bands)


def _screened(
    plan: RunPlan, t_s: np.ndarray, x_m: np.ndarray, p_tp_pa: np.ndarray, p_tr_pa: np.ndarray
) -> ScreenedRun:
    p_tp, p_tr = float(p_tp_pa.mean()), float(p_tr_pa.mean())
    force = p_tp * plan.specimen.area_piston_m2 - p_tr * plan.specimen.area_rod_m2
    v = float((x_m[-1] - x_m[0]) / (t_s[-1] - t_s[0]))
    means = SteadyMeans(t_s[0], t_s[-1], len(t_s), v, force, force, 0.0, p_tp, p_tr)
    run = Run(plan, t_s, x_m, p_tp_pa=p_tp_pa, p_tr_pa=p_tr_pa, f_applied_n=np.zeros(len(t_s)))
    return ScreenedRun(run, (), means)
