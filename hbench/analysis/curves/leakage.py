"""Leakage of the test cylinder from the decay of its chambers' pressures, all valves closed.

    V_p/beta dp_p/dt + A_p v  =  -C_i (p_p - p_r) - C_p p_p
    V_r/beta dp_r/dt - A_r v  =   C_i (p_p - p_r) - C_r p_r

C_i leaks across the piston, C_p and C_r from either side to outside, at 0 bar gauge; all laminar.
Integrated over time, so that nothing measured is differentiated:

    V_p/beta (p_p - p_p(0)) + A_p (x - x(0))  =  -C_i I(p_p - p_r) - C_p I(p_p)  + constant

and so the other side: linear in C, solved by least squares over all holds, a constant for each hold
and side. A piston that friction holds leaves the volumes as they are; one that creeps moves oil,
which the term in x accounts for. Intervals are over whole holds, not samples.

A pressure at rest stays on one or two codes of its converter, so that holds may agree better than
they know. As a drift of one code q over the hold, rounding makes  q V / (beta I(p))  of a leak.
An interval is no narrower than this to either side: all holds may round alike. q is the smallest
step that a channel takes; without a step to see, nothing is added.

Pressures alone tell C beta / V. So C is conditional on the bench file's bulk modulus and dead
volumes: with beta 10 % higher, C comes out 10 % lower.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np
from scipy.integrate import cumulative_trapezoid

from hbench.analysis.rounding import ROUNDING, distinct
from hbench.analysis.statistics.intervals import covariance_over_runs, has_effect, parts_in
from hbench.analysis.statistics.student import student_factor
from hbench.config.bench import Bench
from hbench.records import Decay, Leak, Leakage, LeakCoefficient, Run, ScreenedRun, Series

NAMES: tuple[Leak, ...] = ("across_piston", "piston_side_out", "rod_side_out")
_SETTLE_S = 0.3  # after the valves have closed
# Of the best seen direction: smaller eigenvalues of the scaled problem count as none. Pressures
# whose ratio changes by 3 % give about as much; less would amplify every error thirtyfold.
_SEEN = 1e-3
_PART = 0.1  # of a leak in directions that are not seen


def leakage(screened: Iterable[ScreenedRun], bench: Bench) -> tuple[Leakage, ...]:
    """Return the leaks from the accepted holds of each label."""
    groups: dict[tuple[str, str], list[Run]] = defaultdict(list)
    for one in screened:
        if one.accepted:
            groups[one.run.plan.kind, one.run.plan.label].append(one.run)
    return tuple(_leakage(label, runs, bench) for (_, label), runs in groups.items())


def _leakage(label: str, runs: Sequence[Run], bench: Bench) -> Leakage:
    beta = bench.oil.bulk_modulus
    parts = [_equations(run, bench) for run in runs]
    matrix = np.concatenate([matrix for matrix, _, _ in parts])
    moved = np.concatenate([moved for _, moved, _ in parts])
    number = np.repeat(np.arange(len(parts)), [len(moved) for _, moved, _ in parts])
    scale = np.sqrt(np.sum(matrix**2, axis=0))
    effect = has_effect(matrix, np.ones(len(NAMES)))  # none: a leak that a plunger does not have
    scale[~effect] = 1.0
    jacobian = np.where(effect, matrix / scale, 0.0)
    s2, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    seen = s2 > _SEEN * s2[-1]
    unknown = parts_in(vectors[:, ~seen]) > _PART
    solution = (vectors[:, seen] / s2[seen]) @ vectors[:, seen].T @ (jacobian.T @ moved)
    covariance = covariance_over_runs(jacobian, moved - jacobian @ solution, number)
    t = student_factor(len(runs) - 1) if len(runs) > 1 else np.nan
    rounding = _rounding(
        (vectors[:, seen] / s2[seen]) @ vectors[:, seen].T @ jacobian.T, runs, bench
    )
    coefficients, messages = [], []
    for i, name in enumerate(NAMES):
        value, se = float(solution[i] / scale[i]), float(np.sqrt(covariance[i, i]) / scale[i])
        known = not unknown[i] and np.isfinite(t * se)
        half = max(t * se, float(rounding[i] / scale[i]))
        interval = (value - half, value + half) if known else None
        if known and value < 0:
            messages.append(f"{name} is negative: no leak is seen")
        if known and half > t * se:
            messages.append(f"the interval of {name} is that of one converter code over a hold")
        coefficients.append(
            LeakCoefficient(name, None if unknown[i] else value, se if known else None, interval)
        )
    if unknown.any():
        names = " and ".join(n for n, one in zip(NAMES, unknown, strict=True) if one)
        messages.append(
            f"these holds do not tell {names} apart: each changes two pressures alone. Hold at "
            "other loads and rod-side pressures"
        )
    if len(runs) < 2:
        messages.append("one hold: no interval")
    messages.append(
        f"conditional on the bench file's bulk modulus ({beta / 1e5:.4g} bar) and dead volumes: "
        "pressures alone tell the leaks times beta / V"
    )
    return Leakage(
        label=label,
        coefficients=tuple(coefficients),
        decays=tuple(decay for _, _, decay in parts),
        bulk_modulus_pa=beta,
        message="; ".join(messages),
        kind=runs[0].plan.kind,
    )


def _rounding(inverse: np.ndarray, runs: Sequence[Run], bench: Bench) -> np.ndarray:
    """Return what a drift of one code over each hold makes of the scaled leaks, at most (3,).

    ``inverse`` (3, 2 n) makes leaks of what moved, in the order of ``_equations``.
    """
    codes, drifts = [0.0, 0.0], []
    for run in runs:
        settled, chambers = _chambers(run, bench)
        for side, (p, compliance) in enumerate(chambers):
            steps = np.diff(distinct(p))
            if len(steps):
                codes[side] = min(codes[side] or np.inf, float(steps.min()))
            t = run.t_s[settled]
            drifts.append((side, compliance * (t - t.mean()) / (t[-1] - t[0])))
    made, start = np.zeros(3), 0
    for side, drift in drifts:
        made += codes[side] * np.abs(inverse[:, start : start + len(drift)] @ drift)
        start += len(drift)
    return made


def _chambers(
    run: Run, bench: Bench
) -> tuple[np.ndarray, tuple[tuple[np.ndarray, float], tuple[np.ndarray, float]]]:
    """Return the settled samples (n,), and either side's pressures there and V / beta."""
    cylinder, beta = bench.test_cylinder, bench.oil.bulk_modulus
    settled = run.t_s - run.t_s[0] >= _SETTLE_S - ROUNDING
    middle = run.x_m[settled].mean()
    v_p = cylinder.dead_volume_piston + cylinder.area_piston_m2 * middle
    v_r = cylinder.dead_volume_rod + cylinder.area_rod_m2 * (cylinder.stroke - middle)
    p_r = np.zeros(len(run.t_s)) if _is_plunger(run) else run.p_tr_pa
    return settled, ((run.p_tp_pa[settled], v_p / beta), (p_r[settled], v_r / beta))


def _is_plunger(run: Run) -> bool:
    """Tell whether there is one chamber alone, whose oil all leaks outside."""
    return run.plan.specimen.area_rod_m2 == 0


def _equations(run: Run, bench: Bench) -> tuple[np.ndarray, np.ndarray, Decay]:
    """Return the derivatives (2 n, 3) by ``NAMES`` and what moved (2 n,) [m^3], means taken off."""
    cylinder = bench.test_cylinder
    settled, ((p_p, compliance_p), (p_r, compliance_r)) = _chambers(run, bench)
    t, x = run.t_s[settled], run.x_m[settled]
    moved_p = compliance_p * p_p + cylinder.area_piston_m2 * x
    moved_r = compliance_r * p_r - cylinder.area_rod_m2 * x
    across, out_p, out_r = (cumulative_trapezoid(p, t, initial=0) for p in (p_p - p_r, p_p, p_r))
    none = np.zeros(len(t))
    if _is_plunger(run):
        across, moved_r = none, none
    sides = (
        (np.column_stack([-across, -out_p, none]), moved_p),
        (np.column_stack([across, none, -out_r]), moved_r),
    )
    plan = run.plan

    def slope(y: np.ndarray) -> float:
        return float(np.polynomial.polynomial.polyfit(t - t[0], y, 1)[1])

    decay = Decay(
        run=plan.run,
        series=Series(plan.label, plan.f_load_n, plan.p_lr_ref_pa),
        p_p_pa=float(p_p.mean()),
        p_r_pa=float(p_r.mean()),
        rate_p_pa_s=slope(p_p),
        rate_r_pa_s=slope(p_r),
        out_p_m3_s=-slope(moved_p),
        out_r_m3_s=-slope(moved_r),
    )
    matrix = np.concatenate([columns - columns.mean(axis=0) for columns, _ in sides])
    moved = np.concatenate([values - values.mean() for _, values in sides])
    return matrix, moved, decay
