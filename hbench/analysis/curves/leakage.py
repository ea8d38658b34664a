"""Leakage of the test cylinder, from the decay of its chamber pressures with all valves closed.

    V_p/beta dp_p/dt + A_p v  =  -C_i (p_p - p_r) - C_p p_p
    V_r/beta dp_r/dt - A_r v  =   C_i (p_p - p_r) - C_r p_r

C_i is the leakage across the piston, C_p and C_r from either side to outside, at 0 bar gauge. They
are laminar unless the holds show another exponent n, that of an orifice being 0.5: then each
pressure p above becomes p |p/p_0|^(n-1), p_0 being the root mean square of all these pressures. The
exponent is the one with the least squares, the same for all leaks. The integral over time avoids
differentiating measured signals:

    V_p/beta (p_p - p_p(0)) + A_p (x - x(0))  =  -C_i I(p_p - p_r) - C_p I(p_p)  + constant

and likewise the other side: linear in C, solved by least squares over all holds, with a constant
for each hold and side. The term in x accounts for the oil that a creeping piston moves. Intervals
are over whole holds, not samples.

A pressure at rest stays on one or two of the values that the log can hold, so the agreement of
holds can be too good. Rounding, as a drift of one step q over the hold, causes a leak error of
q V / (beta I(p)). The half-width of an interval is at least this error, since all holds can round
alike. q is the smallest step of a logged channel, which is finer than a code of the converter where
conversions are averaged; for a constant channel nothing is added.

Two assumed errors are added as squares. Oil that warms or cools at ``TEMPERATURE_RATE_K_S``, or at
the largest rate that was measured in the holds if it is larger, acts as a drift of the pressures by
beta times its expansion. Pressures determine only C beta / V: a bulk modulus with a relative error
``BULK_MODULUS_ERROR`` gives C that error. The dead volumes of the bench file or map are taken as
exact.

A side that is open to the air has no balance. Holds with one open side alone do not distinguish
what leaks across the piston from what leaks out of the closed side.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hbench.analysis.curves.hold_temperature import measured_rate_k_s
from hbench.analysis.rounding import ROUNDING, distinct
from hbench.analysis.statistics.intervals import covariance_over_runs, has_effect, parts_in
from hbench.analysis.statistics.student import student_factor
from hbench.config.campaign_settings import Chambers
from hbench.records import Decay, Leak, Leakage, LeakCoefficient, Run, ScreenedRun
from hbench.records.motions import BULK_MODULUS_ERROR, OIL_EXPANSION_1_K, TEMPERATURE_RATE_K_S
from hbench.sentences import listed

LEAK_NAMES: tuple[Leak, ...] = ("across_piston", "piston_side_out", "rod_side_out")
_SETTLE_S = 0.3  # after the valves have closed
# Of the largest eigenvalue of the scaled problem: smaller ones count as zero. Pressures whose ratio
# changes by 3 % give about this value; with less, every error would be amplified thirtyfold.
_DETERMINED = 1e-3
_PART = 0.1  # of a leak in directions that are not determined
_EXPONENTS = (0.3, 1.5)  # searched; an orifice has 0.5, a laminar gap 1
_TRACE = 30  # parts of a hold, for its course over time


def chamber_leakage(screened: Iterable[ScreenedRun], chambers: Chambers) -> tuple[Leakage, ...]:
    """Return the leaks from the accepted holds of each label whose cylinder has a known stroke."""
    groups: dict[tuple[str, str], list[Run]] = defaultdict(list)
    for verdict in screened:
        if verdict.accepted and verdict.run.plan.specimen.stroke_m is not None:
            groups[verdict.run.plan.kind, verdict.run.plan.label].append(verdict.run)
    return tuple(_leakage(label, runs, chambers) for (_, label), runs in groups.items())


def _leakage(label: str, runs: Sequence[Run], chambers: Chambers) -> Leakage:
    holds = [_hold(run, chambers) for run in runs]
    moved = np.concatenate([hold.moved for hold in holds])
    number = np.repeat(np.arange(len(holds)), [len(hold.moved) for hold in holds])
    p_0 = float(np.sqrt(np.mean(np.concatenate([hold.pressures.ravel() for hold in holds]) ** 2)))
    laminar = _solved(_matrix(holds, 1.0, p_0), moved, number, runs, chambers)
    found, exponent, exponent_ci95 = laminar, 1.0, None
    if p_0 > 0 and not laminar.unknown.any() and (abs(laminar.value) > laminar.half).any():
        n, half = _exponent(holds, moved, number, p_0)
        if abs(n - 1.0) > half:
            found = _solved(_matrix(holds, n, p_0), moved, number, runs, chambers)
            exponent, exponent_ci95 = n, half
    messages = list(_of_leaks(found))
    if exponent_ci95 is not None:
        messages.append(
            f"the leaks grow with the pressure to the power {exponent:.3f} ± {exponent_ci95:.1g} "
            f"(1: laminar, 0.5: orifice); the coefficients are those at {p_0 / 1e5:.3g} bar"
        )
    if len(runs) < 2:
        messages.append("no interval: there is only one hold")
    messages.append(
        f"conditional on the stated effective bulk modulus ({chambers.bulk_modulus / 1e5:.0f} bar) "
        "and dead volumes: pressures determine only the leaks times beta / V. U contains an error "
        f"of {100 * BULK_MODULUS_ERROR:.0f} % of this modulus and a change of the oil temperature "
        f"at {_rate_words(measured_rate_k_s(runs))}"
    )
    return Leakage(
        label=label,
        coefficients=_coefficients(found),
        decays=tuple(hold.decay for hold in holds),
        bulk_modulus_pa=chambers.bulk_modulus,
        message="; ".join(messages),
        kind=runs[0].plan.kind,
        exponent=exponent,
        exponent_ci95=exponent_ci95,
        reference_pa=p_0,
        step_pa=max(_steps(runs, chambers)) or None,
    )


def _rate_words(measured_k_s: float) -> str:
    if measured_k_s <= TEMPERATURE_RATE_K_S:
        return f"{60 * TEMPERATURE_RATE_K_S:g} K/min, both assumed"
    return f"{60 * measured_k_s:.2g} K/min, the largest measured in a hold; the first is assumed"


class _Solution(NamedTuple):
    """Leaks (3,) of one exponent with their errors."""

    value: np.ndarray
    se: np.ndarray
    half: np.ndarray  # of the 95 % interval
    unknown: np.ndarray  # bool

    @property
    def known(self) -> np.ndarray:
        """Whether each leak (3,) has an interval."""
        return ~self.unknown & np.isfinite(self.half)


def _coefficients(found: _Solution) -> tuple[LeakCoefficient, ...]:
    coefficients = []
    for i, name in enumerate(LEAK_NAMES):
        value, se, half = float(found.value[i]), float(found.se[i]), float(found.half[i])
        coefficients.append(
            LeakCoefficient(
                name,
                None if found.unknown[i] else value,
                se if found.known[i] else None,
                (value - half, value + half) if found.known[i] else None,
            )
        )
    return tuple(coefficients)


def _of_leaks(found: _Solution) -> Iterator[str]:
    """Yield messages on leaks that are not significant, negative or unknown."""
    small = found.known & (found.value <= found.half)
    negative = small & (found.value < -found.half)
    if (none := small & ~negative).any():
        yield f"not significant at the 95 % level: {_listed(none)}"
    if negative.any():
        yield (
            "negative by more than U, although no oil leaks against its pressure: "
            f"{_listed(negative)}. Check the oil temperature, the drift of the pressure "
            "transducers and the leakage of the valves"
        )
    if found.unknown.any():
        yield (
            f"{listed(_names(found.unknown))} are not distinguishable at the pressures of these "
            "holds. Hold at other loads and rod-side pressures"
        )


def _listed(which: np.ndarray) -> str:
    return "all leaks" if which.all() else ", ".join(_names(which))


def _names(which: np.ndarray) -> list[str]:
    return [name for name, flag in zip(LEAK_NAMES, which, strict=True) if flag]


def _solved(
    matrix: np.ndarray,
    moved: np.ndarray,
    number: np.ndarray,
    runs: Sequence[Run],
    chambers: Chambers,
) -> _Solution:
    """Solve for the leaks by least squares; ``matrix`` (n, 3) are the derivatives of ``moved``."""
    scale = np.sqrt(np.sum(matrix**2, axis=0))
    effect = has_effect(matrix, np.ones(len(LEAK_NAMES)))  # a plunger does not have all leaks
    scale[~effect] = 1.0
    jacobian = np.where(effect, matrix / scale, 0.0)
    s2, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    used = s2 > _DETERMINED * s2[-1]
    unknown = parts_in(vectors[:, ~used]) > _PART
    inverse = (vectors[:, used] / s2[used]) @ vectors[:, used].T @ jacobian.T
    solution = inverse @ moved
    covariance, dof = covariance_over_runs(jacobian, moved - jacobian @ solution, number)
    t = np.array([student_factor(each) if each > 0 else np.nan for each in dof.tolist()])
    se = np.sqrt(np.diag(covariance)) / scale
    rounding = _drift_error(inverse, runs, chambers, _steps(runs, chambers), 0.0) / scale
    rate_k_s = max(TEMPERATURE_RATE_K_S, measured_rate_k_s(runs))
    rate_pa_s = chambers.bulk_modulus * OIL_EXPANSION_1_K * rate_k_s
    warming = _drift_error(inverse, runs, chambers, (0.0, 0.0), rate_pa_s) / scale
    value = solution / scale
    assumed = np.hypot(warming, BULK_MODULUS_ERROR * value)
    half = np.hypot(np.fmax(t * se, rounding), assumed)
    return _Solution(value, se, np.where(np.isfinite(t * se), half, np.nan), unknown)


def _exponent(
    holds: Sequence["_Hold"], moved: np.ndarray, number: np.ndarray, p_0: float
) -> tuple[float, float]:
    """Return the exponent with the least squares and its half-width; infinite: not determined."""
    from scipy.optimize import minimize_scalar  # slow import

    def leaks(n: float) -> np.ndarray:
        matrix = _matrix(holds, n, p_0)
        return np.linalg.lstsq(matrix, moved, rcond=None)[0]

    def residual(n: float) -> np.ndarray:
        return moved - _matrix(holds, n, p_0) @ leaks(n)

    n = float(minimize_scalar(lambda n: float(np.sum(residual(n) ** 2)), bounds=_EXPONENTS).x)
    step = 1e-3
    shift = (_matrix(holds, n + step, p_0) - _matrix(holds, n - step, p_0)) / (2 * step)
    jacobian = np.column_stack([_matrix(holds, n, p_0), shift @ leaks(n)])
    covariance, dof = covariance_over_runs(jacobian, residual(n), number)
    half = student_factor(float(dof[3])) * np.sqrt(covariance[3, 3])
    return n, float(half) if np.isfinite(half) else np.inf


def _steps(runs: Sequence[Run], chambers: Chambers) -> list[float]:
    """Return the smallest step [Pa] of each side's logged pressure; 0: it is constant."""
    smallest = [0.0, 0.0]
    for run in runs:
        _, sides = _chambers(run, chambers)
        for side, (p, _) in enumerate(sides):
            steps = np.diff(distinct(p))
            if len(steps):
                smallest[side] = min(smallest[side] or np.inf, float(steps.min()))
    return smallest


def _drift_error(
    inverse: np.ndarray,
    runs: Sequence[Run],
    chambers: Chambers,
    steps_pa: Sequence[float],
    rate_pa_s: float,
) -> np.ndarray:
    """Return the largest error of the scaled leaks (3,) from a drift of the pressures in each hold.

    ``inverse`` (3, 2 n) maps moved volumes to leaks, in the order of ``_matrix``. Over a hold, each
    side's pressure drifts by its step and at the rate.
    """
    drifts = []
    for run in runs:
        settled, sides = _chambers(run, chambers)
        for side, (_, compliance) in enumerate(sides):
            t = run.t_s[settled]
            slope = steps_pa[side] / (t[-1] - t[0]) + rate_pa_s
            drifts.append(compliance * slope * (t - t.mean()))
    error, start = np.zeros(3), 0
    for drift in drifts:
        error += np.abs(inverse[:, start : start + len(drift)] @ drift)
        start += len(drift)
    return error


def _chambers(
    run: Run, chambers: Chambers
) -> tuple[np.ndarray, tuple[tuple[np.ndarray, float], tuple[np.ndarray, float]]]:
    """Return the settled samples (n,), and each side's pressures there and V / beta."""
    cylinder, beta = run.plan.specimen, chambers.bulk_modulus
    settled = run.t_s - run.t_s[0] >= _SETTLE_S - ROUNDING
    middle = run.x_m[settled].mean()
    v_p = chambers.dead_volume_piston + cylinder.area_piston_m2 * middle
    v_r = chambers.dead_volume_rod + cylinder.area_rod_m2 * ((cylinder.stroke_m or 0.0) - middle)
    p_p = run.channel("p_tp_pa")
    p_r = np.zeros(len(run.t_s)) if _is_plunger(run) else run.channel("p_tr_pa")
    return settled, ((p_p[settled], v_p / beta), (p_r[settled], v_r / beta))


def _is_vented(pressure_pa: np.ndarray) -> bool:
    """Return whether a side is open to the air: it is at 0 bar in all samples, as by a constant."""
    return not np.any(pressure_pa)


def _is_plunger(run: Run) -> bool:
    """Return whether the cylinder has only one chamber, which leaks to outside only."""
    return run.plan.specimen.area_rod_m2 == 0


@dataclass(frozen=True)
class _Hold:
    """Settled part of a hold: pressures that drive the leaks, and what the chambers lost."""

    t_s: np.ndarray  # (m,)
    pressures: np.ndarray  # (m, 3), in the order of LEAK_NAMES; 0 without a rod side
    closed: tuple[bool, bool]  # piston and rod side
    moved: np.ndarray  # (2 m,) [m^3], without each side's mean
    decay: Decay


def _matrix(holds: Sequence[_Hold], exponent: float, p_0: float) -> np.ndarray:
    """Return the derivatives (n, 3) of the moved volumes by leak, without means."""
    from scipy.integrate import cumulative_trapezoid  # slow import

    parts = []
    for hold in holds:
        p = hold.pressures
        if exponent != 1.0:
            p = np.sign(p) * p_0 * np.abs(p / p_0) ** exponent
        across, out_p, out_r = cumulative_trapezoid(p, hold.t_s, axis=0, initial=0).T
        none = np.zeros(len(hold.t_s))
        sides = [[-across, -out_p, none], [across, none, -out_r]]
        parts += [
            kept * (c - c.mean(axis=0))
            for c, kept in zip(map(np.column_stack, sides), hold.closed, strict=True)
        ]
    return np.concatenate(parts)


def _hold(run: Run, chambers: Chambers) -> _Hold:
    plan, cylinder = run.plan, run.plan.specimen
    settled, ((p_p, compliance_p), (p_r, compliance_r)) = _chambers(run, chambers)
    t, x = run.t_s[settled], run.x_m[settled]
    moved_p = compliance_p * p_p + cylinder.area_piston_m2 * x
    moved_r = compliance_r * p_r - cylinder.area_rod_m2 * x
    across, none = p_p - p_r, np.zeros(len(t))
    if _is_plunger(run):
        across = moved_r = none
    closed = not _is_vented(p_p), not _is_vented(p_r)  # an open side keeps no oil: no balance
    moved_p, moved_r = (
        m if kept else none for m, kept in zip((moved_p, moved_r), closed, strict=True)
    )

    def slope(y: np.ndarray) -> float:
        return float(np.polynomial.polynomial.polyfit(t - t[0], y, 1)[1])

    at = np.linspace(0, len(t), min(_TRACE, len(t)) + 1).astype(int)
    means = (np.add.reduceat(y, at[:-1]) / np.diff(at) for y in (t, moved_p, moved_r))
    t_mean, lost_p, lost_r = (y - y[0] for y in means)
    decay = Decay(
        run=plan.run,
        series=plan.series,
        p_p_pa=float(p_p.mean()),
        p_r_pa=float(p_r.mean()),
        rate_p_pa_s=slope(p_p),
        rate_r_pa_s=slope(p_r),
        out_p_m3_s=-slope(moved_p),
        out_r_m3_s=-slope(moved_r),
        trace=tuple(zip(t_mean.tolist(), (-lost_p).tolist(), (-lost_r).tolist(), strict=True)),
    )
    moved = np.concatenate([moved_p - moved_p.mean(), moved_r - moved_r.mean()])
    return _Hold(t, np.column_stack([across, p_p, p_r]), closed, moved, decay)
