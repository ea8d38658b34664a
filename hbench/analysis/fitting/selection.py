"""Which law predicts best what it has not seen, and whether that can be told from chance.

Each speed of a curve in turn is left out, the laws are fitted to the rest and predict friction
there. The lowest and the highest speed stay in, for no law is asked beyond them. Two laws differ
by the mean of e_1^2 - e_2^2 over the speeds left out; its standard error is that of this mean, and
they can be told apart if Student's interval does not hold zero, nor what rounding may do. Laws of
all loads leave a speed out of all curves at once, and a speed counts once: errors of a law's form
come again at every load.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from hbench.analysis.fitting.fit import JOINT_LAWS, LAWS, estimate
from hbench.analysis.fitting.fit_data import sample
from hbench.analysis.rounding import ROUNDING, ranked
from hbench.analysis.statistics.student import student_factor
from hbench.config.fitting import Fitting
from hbench.records import Curve, Fit, HeldOut, Selection

_LEAST_SPEEDS = 7  # five left out, five parameters from the rest
_TIE = 1e-6  # of a mean squared error: refits end within this of one another


def select(curve: Curve, how: Fitting) -> Selection | None:
    """Compare the laws fitted to a curve; None if there are not two, or too few speeds."""
    if len(curve.points) < _LEAST_SPEEDS:
        return None
    return _compare(_errors_of_curve_laws([curve], how), [curve])


def select_joint(curves: Sequence[Curve], joint: Sequence[Fit], how: Fitting) -> Selection | None:
    """Compare laws of all loads with those that have parameters of their own for each curve."""
    if min(len(curve.points) for curve in curves) < _LEAST_SPEEDS:
        return None
    if any(point.p_tr_pa is None for curve in curves for point in curve.points):
        return None
    errors = _errors_of_curve_laws(curves, how)
    errors |= {fit.law: _held_out(fit, curves, how) for fit in joint if fit.parameters}
    return _compare(errors, curves)


def _errors_of_curve_laws(curves: Sequence[Curve], how: Fitting) -> dict[str, np.ndarray]:
    names = [fit.law for fit in curves[0].fits if all(f.parameters for f in curves[0].fits)]
    return {
        name: np.concatenate(
            [_held_out(fit, [c], how) for c in curves for fit in c.fits if fit.law == name]
        )
        for name in names
    }


def _places(curves: Sequence[Curve]) -> np.ndarray:
    """Return the rank of each point's speed in its curve; 0 for the ends, which stay in."""
    ranks = [np.arange(len(curve.points)) for curve in curves]
    return np.concatenate([np.where(rank == rank[-1], 0, rank) for rank in ranks])


def _held_out(fit: Fit, curves: Sequence[Curve], how: Fitting) -> np.ndarray:
    """Return the errors [N] of predictions at points left out; nan at the ends."""
    law = {**LAWS, **JOINT_LAWS}[fit.law]
    data, places = sample(curves, how.weights), _places(curves)
    start = np.array([p.value for p in fit.parameters.values()])
    errors = np.full(len(places), np.nan)
    for place in range(1, places.max() + 1):
        out = places == place
        solution = estimate(law, data.part(~out), how, {}, start).solution
        errors[out] = law.model(data.inputs[:, out], solution.x) - data.friction_n[out]
    return errors


def _compare(errors: Mapping[str, np.ndarray], curves: Sequence[Curve]) -> Selection | None:
    if len(errors) < 2:
        return None
    places = _places(curves)
    means = {
        law: np.array([np.mean(e[places == i] ** 2) for i in range(1, places.max() + 1)])
        for law, e in errors.items()
    }
    largest = max(abs(point.friction_n) for curve in curves for point in curve.points)
    tie = (ROUNDING * largest) ** 2 + _TIE * min(float(one.mean()) for one in means.values())
    laws = ranked(list(means), lambda law: -float(means[law].mean()), tie)
    difference = means[laws[1]] - means[laws[0]]
    n = len(difference)
    se = float(difference.std(ddof=1) / np.sqrt(n))
    return Selection(
        laws=tuple(HeldOut(law, float(np.sqrt(means[law].mean()))) for law in laws),
        difference_n2=float(difference.mean()),
        difference_se_n2=se,
        told_apart=bool(difference.mean() > student_factor(n - 1) * se + tie),
        speeds=n,
    )
