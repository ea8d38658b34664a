"""How badly the identified laws fit: the error of a law that repeats from trial to trial.

At steady speeds (N. R. Draper and H. Smith, Applied Regression Analysis, 1998, section 2.1), with
the means of n_i trials at n points, a law with p parameters fitted to them, and the variance s^2
pooled within the points:

    F = sum n_i (mean_i - law_i)^2 / (n - p) / s^2
    misfit^2 = sum ((mean_i - law_i)^2 - s^2 / n_i) / n

Errors of the instruments within their tolerances, and a drift, are first taken off as far as they
explain the differences: they are common to all points, with the sensitivities of the budget. Where
the tolerances are not known, this is one offset of the force.

Along motions with reversals, the differences less their mean over the run are averaged within cells
of velocity and sign of the acceleration. ``d_r`` being that of run r, noise and a level of each run
have no part in the mean product of two runs:

    misfit^2 = sum over cells of w_cell mean over pairs r < q of d_r d_q

Its standard error is that of a jackknife over the runs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear
from scipy.special import fdtrc

from hbench.analysis.identification.driven_law import driven_friction
from hbench.analysis.identification.identify import reverses
from hbench.analysis.rounding import ROUNDING
from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.analysis.statistics.student import student_factor
from hbench.config.friction import parse_friction
from hbench.model.build import friction_parameters
from hbench.model.friction.laws import steady_friction
from hbench.model.parameters import FrictionParameters
from hbench.records import Curve, CurvePoint, IdentifiedLaw, LackOfFit
from hbench.records.friction_laws import FRICTION_LAWS
from hbench.records.numbers import NORMAL_95

_LEVEL = 1e-3  # of the F test
_CELLS = 12  # of velocity between the highest in both directions
_FEWEST_RUNS = 3


def with_lack_of_fit(
    laws: Sequence[IdentifiedLaw], curves: Sequence[Curve], motions: Sequence[LoggedMotion]
) -> tuple[IdentifiedLaw, ...]:
    """Return each law with its misfit at the points of ``curves`` and along ``motions``.

    Only dynamic laws are compared along motions: static laws contain no presliding.
    """
    return tuple(
        law if law.fit is None else _compared(law, law.fit.parameters, curves, motions)
        for law in laws
    )


def _compared(
    law: IdentifiedLaw,
    parameters: Mapping[str, object],
    curves: Sequence[Curve],
    motions: Sequence[LoggedMotion],
) -> IdentifiedLaw:
    par = friction_parameters(parse_friction(law.section, law.law))
    if FRICTION_LAWS[law.law].dynamic:
        return replace(
            law, misfit=_at_points(par, 0, curves), misfit_in_motion=_along(par, motions)
        )
    return replace(law, misfit=_at_points(par, len(parameters), curves))


def _at_points(par: FrictionParameters, p: int, curves: Sequence[Curve]) -> LackOfFit | None:
    points = [point for curve in curves for point in curve.points]
    n = len(points)
    counts = np.array([len(point.trials_n) for point in points])
    dof = int(counts.sum()) - n
    if n <= p or dof < 1:
        return None
    friction = np.array([point.friction_n for point in points])
    difference = friction - np.array(
        [steady_friction(q.v_m_s, q.p_tp_pa or 0.0, q.p_tr_pa or 0.0, par) for q in points]
    )
    variance = sum(float(np.var(q.trials_n)) * len(q.trials_n) for q in points) / dof
    size = _rms(friction)
    if not np.sqrt(variance) > ROUNDING * size:
        return None  # simulated without noise: nothing to compare with
    rest = _without_common_errors(points, difference)
    ratio = float(np.sum(counts * rest**2)) / (n - p) / variance
    misfit = float(np.mean(rest**2 - variance / counts))
    return LackOfFit(
        friction_n=size,
        error_n=_rms(difference),
        scatter_n=float(np.sqrt(np.mean(variance / counts))),
        misfit_n=float(np.sqrt(max(misfit, 0.0))),
        significant=bool(fdtrc(n - p, dof, ratio) < _LEVEL),
        compared=n,
    )


def _without_common_errors(points: Sequence[CurvePoint], difference: np.ndarray) -> np.ndarray:
    """Return the differences (n,) that no error within the tolerances, and no drift, explains."""
    names = sorted({name for point in points for name in point.parts_n})
    columns = [[point.parts_n.get(name, 0.0) for point in points] for name in names]
    limits = [NORMAL_95] * len(names)
    if not names:
        columns, limits = [[1.0] * len(points)], [np.inf]
    columns.append([point.sigma_drift_n or 0.0 for point in points])
    matrix, limit = np.array(columns).T, np.array([*limits, NORMAL_95])
    known = np.abs(matrix).max(axis=0) > 0
    if not known.any():
        return difference
    matrix, limit = matrix[:, known], limit[known]
    return difference - matrix @ lsq_linear(matrix, difference, (-limit, limit), "bvls").x


def _along(par: FrictionParameters, motions: Sequence[LoggedMotion]) -> LackOfFit | None:
    used = [motion for motion in motions if reverses(motion)]
    if len(used) < _FEWEST_RUNS:
        return None
    fastest = max(float(np.abs(motion.v_m_s[motion.compared]).max()) for motion in used)
    size, squares, cells, counts = [], [], [], []
    for motion in used:
        chosen = motion.compared
        friction = motion.friction_n[chosen]
        difference = friction - driven_friction(motion, par)[chosen]
        difference -= difference.mean()
        cell = _cells(motion, fastest)[chosen]
        count = np.bincount(cell, minlength=2 * _CELLS)
        cells.append(np.bincount(cell, difference, 2 * _CELLS) / np.maximum(count, 1))
        counts.append(count)
        size.append(friction - friction.mean())
        squares.append(difference)
    mean, number = np.array(cells), np.array(counts)
    misfit = _of_pairs(mean, number)
    if misfit is None:
        return None
    runs = len(used)
    without = [
        _of_pairs(np.delete(mean, i, axis=0), np.delete(number, i, axis=0)) for i in range(runs)
    ]
    known = np.array([value for value in without if value is not None])
    error = np.sqrt((len(known) - 1) * np.mean((known - known.mean()) ** 2))
    significant = misfit > student_factor(runs - 1) * error
    whole = _rms(np.concatenate(squares))
    return LackOfFit(
        friction_n=_rms(np.concatenate(size)),
        error_n=whole,
        scatter_n=float(np.sqrt(max(whole**2 - max(misfit, 0.0), 0.0))),
        misfit_n=float(np.sqrt(max(misfit, 0.0))),
        significant=bool(significant),
        compared=runs,
    )


def _cells(motion: LoggedMotion, fastest: float) -> np.ndarray:
    """Return the cell (n,) of each sample, by velocity and sign of the acceleration."""
    share = (motion.v_m_s / fastest + 1) / 2
    speed = np.clip((_CELLS * share).astype(int), 0, _CELLS - 1)
    return np.where(np.gradient(motion.v_m_s) > 0, speed, speed + _CELLS)


def _of_pairs(mean: np.ndarray, number: np.ndarray) -> float | None:
    """Return the mean product of two runs' means (runs, cells), weighted by the samples."""
    has = number > 0
    runs = has.sum(axis=0)
    cells = runs >= 2
    if not cells.any():
        return None
    mean = np.where(has, mean, 0.0)[:, cells]
    pairs = (runs * (runs - 1))[cells]
    product = (mean.sum(axis=0) ** 2 - np.sum(mean**2, axis=0)) / pairs
    weight = number[:, cells].sum(axis=0)
    return float(np.sum(weight * product) / weight.sum())


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
