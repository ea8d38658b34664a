"""Leakage of the test cylinder, from the decay of its chamber pressures with all valves closed.

    V_p/beta dp_p/dt + A_p v  =  -C_i (p_p - p_r) - C_p p_p
    V_r/beta dp_r/dt - A_r v  =   C_i (p_p - p_r) - C_r p_r

C_i is the leakage across the piston, C_p and C_r from either side to outside, at 0 bar gauge; all
laminar. The integral over time avoids differentiating measured signals:

    V_p/beta (p_p - p_p(0)) + A_p (x - x(0))  =  -C_i I(p_p - p_r) - C_p I(p_p)  + constant

and likewise the other side: linear in C, solved by least squares over all holds, with a constant
for each hold and side. The term in x accounts for the oil that a creeping piston moves. Intervals
are over whole holds, not samples.

A pressure at rest stays on one or two codes of its converter, so the agreement of holds can be too
good. Rounding, as a drift of one code q over the hold, causes a leak error of q V / (beta I(p)).
The half-width of an interval is at least this error, since all holds can round alike. q is the
smallest step of a channel; for a constant channel nothing is added.

Pressures determine only C beta / V. So C is conditional on the bench file's bulk modulus and dead
volumes: with beta 10 % higher, C is 10 % lower.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np

from hbench.analysis.rounding import ROUNDING, distinct
from hbench.analysis.screening.friction_channels import required
from hbench.analysis.statistics.intervals import covariance_over_runs, has_effect, parts_in
from hbench.analysis.statistics.student import student_factor
from hbench.config.bench import Bench
from hbench.records import Decay, Leak, Leakage, LeakCoefficient, Run, ScreenedRun, Series

LEAK_NAMES: tuple[Leak, ...] = ("across_piston", "piston_side_out", "rod_side_out")
_SETTLE_S = 0.3  # after the valves have closed
# Of the largest eigenvalue of the scaled problem: smaller ones count as zero. Pressures whose ratio
# changes by 3 % give about this value; with less, every error would be amplified thirtyfold.
_DETERMINED = 1e-3
_PART = 0.1  # of a leak in directions that are not determined


def chamber_leakage(screened: Iterable[ScreenedRun], bench: Bench) -> tuple[Leakage, ...]:
    """Return the leaks from the accepted holds of each label."""
    groups: dict[tuple[str, str], list[Run]] = defaultdict(list)
    for verdict in screened:
        if verdict.accepted:
            groups[verdict.run.plan.kind, verdict.run.plan.label].append(verdict.run)
    return tuple(_leakage(label, runs, bench) for (_, label), runs in groups.items())


def _leakage(label: str, runs: Sequence[Run], bench: Bench) -> Leakage:
    beta = bench.oil.bulk_modulus
    equations = [_equations(run, bench) for run in runs]
    matrix = np.concatenate([matrix for matrix, _, _ in equations])
    moved = np.concatenate([moved for _, moved, _ in equations])
    number = np.repeat(np.arange(len(equations)), [len(moved) for _, moved, _ in equations])
    scale = np.sqrt(np.sum(matrix**2, axis=0))
    effect = has_effect(matrix, np.ones(len(LEAK_NAMES)))  # a plunger does not have all leaks
    scale[~effect] = 1.0
    jacobian = np.where(effect, matrix / scale, 0.0)
    s2, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    used = s2 > _DETERMINED * s2[-1]
    unknown = parts_in(vectors[:, ~used]) > _PART
    solution = (vectors[:, used] / s2[used]) @ vectors[:, used].T @ (jacobian.T @ moved)
    covariance = covariance_over_runs(jacobian, moved - jacobian @ solution, number)
    t = student_factor(len(runs) - 1) if len(runs) > 1 else np.nan
    rounding = _rounding(
        (vectors[:, used] / s2[used]) @ vectors[:, used].T @ jacobian.T, runs, bench
    )
    coefficients, messages = [], []
    for i, name in enumerate(LEAK_NAMES):
        value, se = float(solution[i] / scale[i]), float(np.sqrt(covariance[i, i]) / scale[i])
        known = not unknown[i] and np.isfinite(t * se)
        half = max(t * se, float(rounding[i] / scale[i]))
        interval = (value - half, value + half) if known else None
        if known and value < 0:
            messages.append(f"{name} is negative: no leak detected")
        if known and half > t * se:
            messages.append(f"the interval of {name} is that of a drift by one converter code")
        coefficients.append(
            LeakCoefficient(name, None if unknown[i] else value, se if known else None, interval)
        )
    if unknown.any():
        names = " and ".join(name for name, flag in zip(LEAK_NAMES, unknown, strict=True) if flag)
        messages.append(
            f"{names} are not distinguishable at the pressures of these holds. Hold at other "
            "loads and rod-side pressures"
        )
    if len(runs) < 2:
        messages.append("no interval: there is only one hold")
    messages.append(
        f"conditional on the bench file's bulk modulus ({beta / 1e5:.4g} bar) and dead volumes: "
        "pressures determine only the leaks times beta / V"
    )
    return Leakage(
        label=label,
        coefficients=tuple(coefficients),
        decays=tuple(decay for _, _, decay in equations),
        bulk_modulus_pa=beta,
        message="; ".join(messages),
        kind=runs[0].plan.kind,
    )


def _rounding(inverse: np.ndarray, runs: Sequence[Run], bench: Bench) -> np.ndarray:
    """Return the largest error of the scaled leaks (3,) from a drift of one code over each hold.

    ``inverse`` (3, 2 n) maps moved volumes to leaks, in the order of ``_equations``.
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
    error, start = np.zeros(3), 0
    for side, drift in drifts:
        error += codes[side] * np.abs(inverse[:, start : start + len(drift)] @ drift)
        start += len(drift)
    return error


def _chambers(
    run: Run, bench: Bench
) -> tuple[np.ndarray, tuple[tuple[np.ndarray, float], tuple[np.ndarray, float]]]:
    """Return the settled samples (n,), and each side's pressures there and V / beta."""
    cylinder, beta = bench.test_cylinder, bench.oil.bulk_modulus
    settled = run.t_s - run.t_s[0] >= _SETTLE_S - ROUNDING
    middle = run.x_m[settled].mean()
    v_p = cylinder.dead_volume_piston + cylinder.area_piston_m2 * middle
    v_r = cylinder.dead_volume_rod + cylinder.area_rod_m2 * (cylinder.stroke - middle)
    p_p = required(run, "p_tp_pa")
    p_r = np.zeros(len(run.t_s)) if _is_plunger(run) else required(run, "p_tr_pa")
    return settled, ((p_p[settled], v_p / beta), (p_r[settled], v_r / beta))


def _is_plunger(run: Run) -> bool:
    """Return whether the cylinder has only one chamber, which leaks to outside only."""
    return run.plan.specimen.area_rod_m2 == 0


def _equations(run: Run, bench: Bench) -> tuple[np.ndarray, np.ndarray, Decay]:
    """Return derivatives (2 n, 3) by leak and moved volumes (2 n,) [m^3], without means."""
    from scipy.integrate import cumulative_trapezoid  # slow import

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
