"""Selection of the law with the best predictions at held-out speeds.

Each speed of a curve in turn is held out; the laws are fitted to the other points and predict its
friction. The lowest and the highest speed are never held out, since no law is to extrapolate. Two
laws differ by the mean of e_1^2 - e_2^2 over the held-out speeds, with the standard error of this
mean. They are distinguishable if Student's interval contains neither zero nor rounding. For joint
laws of all loads, a speed is held out of all curves together and counts once, since the errors of a
law's form recur at every load.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.fitting.fit import CURVE_LAWS, JOINT_LAWS, estimate_parameters
from hbench.analysis.fitting.fit_data import fit_points
from hbench.analysis.rounding import ROUNDING, ranked
from hbench.analysis.statistics.student import student_factor
from hbench.config.fitting import Fitting
from hbench.records import Curve, Fit, HeldOut, Selection
from hbench.records.fits import LEAST_HELD_OUT_SPEEDS

_TIE = 1e-6  # of a mean squared error: refits end within this of one another


def with_held_out(fit: Fit, curves: Sequence[Curve], how: Fitting) -> Fit:
    """Return a fit to ``curves`` with its law's errors at held-out points; nan at the ends.

    A fit without parameters, without pressures that its law needs, or to a curve with too few
    speeds is returned as it is.
    """
    if not fit.parameters or min(len(curve.points) for curve in curves) < LEAST_HELD_OUT_SPEEDS:
        return fit
    law = {**CURVE_LAWS, **JOINT_LAWS}[fit.law]
    data, speed_ranks = fit_points(curves, how.weights), _speed_ranks(curves)
    if law.pressures and not np.isfinite(data.inputs).all():
        return fit
    start = np.array([p.value for p in fit.parameters.values()])
    errors = np.full(len(speed_ranks), np.nan)
    for rank in range(1, speed_ranks.max() + 1):
        out = speed_ranks == rank
        solution = estimate_parameters(law, data.subset(~out), how, {}, start).solution
        errors[out] = law.model(data.inputs[:, out], solution.x) - data.friction_n[out]
    return replace(fit, held_out_n=tuple(errors.tolist()))


def select(curve: Curve) -> Selection | None:
    """Compare the laws fitted to a curve; None if there are not two, or too few speeds."""
    return _compare(_errors_of_curve_laws([curve]), [curve])


def select_joint(curves: Sequence[Curve], joint: Sequence[Fit]) -> Selection | None:
    """Compare joint laws of all loads with laws that have separate parameters for each curve."""
    if any(point.p_tr_pa is None for curve in curves for point in curve.points):
        return None
    errors = _errors_of_curve_laws(curves)
    errors |= {fit.law: np.array(fit.held_out_n) for fit in joint if fit.held_out_n}
    return _compare(errors, curves)


def _errors_of_curve_laws(curves: Sequence[Curve]) -> dict[str, np.ndarray]:
    """Return the errors of the laws that have held-out errors in all ``curves``."""
    by_law: dict[str, list[tuple[float, ...]]] = defaultdict(list)
    for fit in (fit for curve in curves for fit in curve.fits if fit.held_out_n):
        by_law[fit.law].append(fit.held_out_n)
    return {
        law: np.concatenate(errors) for law, errors in by_law.items() if len(errors) == len(curves)
    }


def _speed_ranks(curves: Sequence[Curve]) -> np.ndarray:
    """Return the rank of each point's speed in its curve; 0 for the ends, never held out."""
    ranks = [np.arange(len(curve.points)) for curve in curves]
    return np.concatenate([np.where(rank == rank[-1], 0, rank) for rank in ranks])


def _compare(errors: Mapping[str, np.ndarray], curves: Sequence[Curve]) -> Selection | None:
    if len(errors) < 2:
        return None
    speed_ranks = _speed_ranks(curves)
    means = {
        law: np.array([np.mean(e[speed_ranks == i] ** 2) for i in range(1, speed_ranks.max() + 1)])
        for law, e in errors.items()
    }
    largest = max(abs(point.friction_n) for curve in curves for point in curve.points)
    tie = (ROUNDING * largest) ** 2 + _TIE * min(float(mean.mean()) for mean in means.values())
    laws = ranked(list(means), lambda law: -float(means[law].mean()), tie)
    difference = means[laws[1]] - means[laws[0]]
    n = len(difference)
    se = float(difference.std(ddof=1) / np.sqrt(n))
    return Selection(
        laws=tuple(HeldOut(law, float(np.sqrt(means[law].mean()))) for law in laws),
        difference_n2=float(difference.mean()),
        difference_se_n2=se,
        distinguishable=bool(difference.mean() > student_factor(n - 1) * se + tie),
        speeds=n,
    )
