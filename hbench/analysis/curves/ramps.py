"""Friction curves of velocity ramps (section 5.3): a curve for each load, direction, acceleration.

    F_fT = F_T - F_applied - m_T a        (2.12, with the inertia of the test side alone)

A point is the mean of the samples in a bin of velocity, trial by trial, and the interval is
Student's over the trials. The first bins hold friction before the seals have slid, which
``slid`` cuts off.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from hbench.analysis.curves.average import student_interval
from hbench.analysis.identification.verification import ramp_curve
from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.errors import DataError
from hbench.records import Curve, CurvePoint, RunPlan, ScreenedRun

_MEMORY_M = 0.02  # as the steady window: about ten lengths of presliding
_BINS = 20  # over the top speed; the first one begins with its second half


def ramp_curves(
    screened: Iterable[ScreenedRun], mass_kg: float
) -> tuple[tuple[Curve, ...], tuple[str, ...]]:
    """Return the curves of the accepted runs, which are ramps, and notes on what can't be used.

    Accelerations rise within a label, load and direction, in whatever order they were run.
    ``mass_kg`` is the test side's; 0 where it is not known, and then the inertia stays in.
    """
    groups: dict[tuple, list[tuple[int, LoggedMotion]]] = defaultdict(list)
    plans: dict[tuple, RunPlan] = {}
    notes = []
    for one in screened:
        plan = one.run.plan
        if not one.accepted:
            continue
        load = (plan.direction, plan.f_load_n, plan.p_lr_ref_pa, plan.specimen)
        key = (plan.kind, plan.label, *load, plan.a_ref_m_s2)
        try:
            groups[key].append((plan.trial, logged_motion(one.run, mass_kg)))
        except DataError as error:
            notes.append(f"left out of the ramps: {error.message}")
        plans.setdefault(key, plan)
    found = []
    of_load = list(dict.fromkeys(key[:-1] for key in groups))
    rising = sorted(groups, key=lambda key: (of_load.index(key[:-1]), abs(key[-1] or 0.0)))
    for key in rising:
        plan, trials = plans[key], groups[key]
        like = Curve(
            plan.kind,
            plan.direction,
            plan.f_load_n,
            plan.p_lr_ref_pa,
            plan.label,
            plan.specimen,
            (),
            a_ref_m_s2=plan.a_ref_m_s2,
        )
        found.append(_curve(like, trials, abs(plan.v_ref_m_s)))
    return tuple(curve for curve in found if curve.points), tuple(notes)


def slid(curve: Curve) -> Curve:
    """Return a ramp's curve from breakaway on, for a law or a test of sliding friction.

    Breakaway is the largest friction in the ramp's first 20 mm, v^2 / (2 a).
    """
    if not curve.a_ref_m_s2:
        return curve
    sign = 1.0 if curve.direction == "extend" else -1.0
    way = np.array([point.v_m_s**2 / (2 * curve.a_ref_m_s2) for point in curve.points])
    early = [sign * point.friction_n for point in curve.points][: int(np.sum(way < _MEMORY_M))]
    return replace(curve, points=curve.points[int(np.argmax(early)) :]) if early else curve


def _curve(like: Curve, runs: list[tuple[int, LoggedMotion]], top_m_s: float) -> Curve:
    edges = top_m_s / _BINS * (0.5 + np.arange(_BINS))
    trials: dict[int, list[LoggedMotion]] = defaultdict(list)
    for trial, motion in runs:
        trials[trial].append(motion)
    points = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        of_bin = {
            trial: curve.points[0]
            for trial, motions in trials.items()
            if (curve := ramp_curve(like, motions, np.array([low, high]))).points
        }
        if len(of_bin) == len(trials):  # else the bin is the end of a ramp that stopped early
            points.append(_mean(of_bin))
    return replace(like, points=tuple(points))


def _mean(trials: dict[int, CurvePoint]) -> CurvePoint:
    def mean(name: str) -> float:
        return float(np.mean([getattr(point, name) for point in trials.values()]))

    friction = [point.friction_n for point in trials.values()]
    has_no_rod_side = any(point.p_tr_pa is None for point in trials.values())
    return CurvePoint(
        v_m_s=mean("v_m_s"),
        friction_n=mean("friction_n"),
        ci95_n=student_interval(np.array(friction)),
        n=len(trials),
        f_test_n=mean("f_test_n"),
        f_applied_n=mean("f_applied_n"),
        p_tp_pa=mean("p_tp_pa"),
        p_tr_pa=None if has_no_rod_side else mean("p_tr_pa"),
        trials=tuple(trials),
        trials_n=tuple(friction),
        trials_f_test_n=tuple(point.f_test_n for point in trials.values()),
        runs=tuple(run for point in trials.values() for run in point.runs),
    )
