"""Friction curves of velocity ramps (section 5.3): a curve per load, direction and acceleration.

    F_fT = F_T - F_applied - m_T a        (2.12, with the inertia of the test side alone)

A point is the mean of the samples in a bin of velocity, by trials, with Student's interval over the
trials. The first bins contain presliding friction, which ``sliding`` cuts off.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.curves.average import student_interval
from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.errors import DataError
from hbench.records import Curve, CurvePoint, RunPlan, ScreenedRun

_MEMORY_M = 0.02  # as for the steady window: about ten presliding lengths
_BINS = 20  # over the top speed; the first half bin is left out


def ramp_curves(
    screened: Iterable[ScreenedRun], mass_kg: float
) -> tuple[tuple[Curve, ...], tuple[str, ...]]:
    """Return the curves of the accepted runs, all of them ramps, and notes on those left out.

    Within a label, load and direction, curves are in order of acceleration. ``mass_kg`` is the test
    side's; with 0, for an unknown mass, friction includes the inertia.
    """
    groups: dict[tuple, list[tuple[int, LoggedMotion]]] = defaultdict(list)
    plans: dict[tuple, RunPlan] = {}
    notes = []
    for verdict in screened:
        plan = verdict.run.plan
        if not verdict.accepted:
            continue
        load = (plan.direction, plan.f_load_n, plan.p_lr_ref_pa, plan.specimen)
        key = (plan.kind, plan.label, *load, plan.a_ref_m_s2)
        try:
            groups[key].append((plan.trial, logged_motion(verdict.run, mass_kg)))
        except DataError as error:
            notes.append(f"left out of the ramps: {error.message}")
        plans.setdefault(key, plan)
    curves = []
    loads = list(dict.fromkeys(key[:-1] for key in groups))
    rising = sorted(groups, key=lambda key: (loads.index(key[:-1]), abs(key[-1] or 0.0)))
    for key in rising:
        plan, trials = plans[key], groups[key]
        template = Curve(
            plan.kind,
            plan.direction,
            plan.f_load_n,
            plan.p_lr_ref_pa,
            plan.label,
            plan.specimen,
            (),
            a_ref_m_s2=plan.a_ref_m_s2,
            factors=plan.factors,
        )
        curves.append(_curve(template, trials, abs(plan.v_ref_m_s)))
    return tuple(curve for curve in curves if curve.points), tuple(notes)


def sliding(curve: Curve) -> Curve:
    """Return a ramp's curve from breakaway on, for fits and tests of sliding friction.

    Breakaway is the largest friction in the ramp's first 20 mm, v^2 / (2 a).
    """
    if not curve.a_ref_m_s2:
        return curve
    travel = np.array([point.v_m_s**2 / (2 * curve.a_ref_m_s2) for point in curve.points])
    friction = [curve.against_motion * point.friction_n for point in curve.points]
    early = friction[: int(np.sum(travel < _MEMORY_M))]
    return replace(curve, points=curve.points[int(np.argmax(early)) :]) if early else curve


def ramp_curve(like: Curve, motions: Sequence[LoggedMotion], speeds_m_s: np.ndarray) -> Curve:
    """Return friction over velocity of ramps: means of the samples between ``speeds_m_s`` (k,).

    Samples below the lowest of these speeds, thus breakaway itself, and empty bins are left out.
    Kind, load, direction and cylinder are those of ``like``.
    """
    v = np.concatenate([m.v_m_s for m in motions])
    friction = np.concatenate([m.friction_n for m in motions])
    p_p = np.concatenate([m.p_p_pa for m in motions])
    p_r = np.concatenate([m.p_r_pa for m in motions])
    applied = np.concatenate([m.f_applied_n for m in motions])
    bins = np.digitize(np.abs(v), speeds_m_s)
    points = []
    for i in range(1, len(speeds_m_s)):
        chosen = (bins == i) & (like.against_motion * v > 0)
        if chosen.any():
            means = [float(values[chosen].mean()) for values in (v, friction, p_p, p_r, applied)]
            points.append(_point(like, tuple(m.run for m in motions), *means))
    return replace(like, points=tuple(points), fits=())


def _curve(template: Curve, runs: list[tuple[int, LoggedMotion]], top_m_s: float) -> Curve:
    edges = top_m_s / _BINS * (0.5 + np.arange(_BINS))
    trials: dict[int, list[LoggedMotion]] = defaultdict(list)
    for trial, motion in runs:
        trials[trial].append(motion)
    points = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        by_trial = {
            trial: curve.points[0]
            for trial, motions in trials.items()
            if (curve := ramp_curve(template, motions, np.array([low, high]))).points
        }
        if len(by_trial) == len(trials):  # else a ramp has stopped before this bin
            points.append(_mean(by_trial))
    return replace(template, points=tuple(points))


def _point(
    like: Curve,
    runs: tuple[str, ...],
    v: float,
    friction: float,
    p_p: float,
    p_r: float,
    applied: float,
) -> CurvePoint:
    f_test = p_p * like.specimen.area_piston_m2 - p_r * like.specimen.area_rod_m2
    return CurvePoint(
        v_m_s=v,
        friction_n=friction,
        ci95_n=None,
        n=len(runs),
        f_test_n=f_test,
        f_applied_n=applied,
        p_tp_pa=p_p,
        p_tr_pa=p_r if like.specimen.area_rod_m2 > 0 else None,
        trials=(),
        trials_n=(),
        trials_f_test_n=(),
        runs=runs,
    )


def _mean(trials: dict[int, CurvePoint]) -> CurvePoint:
    def mean(name: str) -> float:
        return float(np.mean([getattr(point, name) for point in trials.values()]))

    friction = [point.friction_n for point in trials.values()]
    no_rod_side = any(point.p_tr_pa is None for point in trials.values())
    return CurvePoint(
        v_m_s=mean("v_m_s"),
        friction_n=mean("friction_n"),
        ci95_n=student_interval(np.array(friction)),
        n=len(trials),
        f_test_n=mean("f_test_n"),
        f_applied_n=mean("f_applied_n"),
        p_tp_pa=mean("p_tp_pa"),
        p_tr_pa=None if no_rod_side else mean("p_tr_pa"),
        trials=tuple(trials),
        trials_n=tuple(friction),
        trials_f_test_n=tuple(point.f_test_n for point in trials.values()),
        runs=tuple(run for point in trials.values() for run in point.runs),
    )
