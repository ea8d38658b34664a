"""Covariance of a Tustin fit to several curves, with curves as the independent unit.

A curve's load and direction affect all of its points alike, so points of several curves are not
independent; curves are. For a single curve the points are the unit.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from hbench.analysis.fitting.fit_data import fit_points
from hbench.analysis.fitting.parameter_spread import standard_uncertainty
from hbench.analysis.fitting.tustin import (
    PARAMETER_NAMES,
    TUSTIN_LAW,
    tustin_friction,
    tustin_jacobian,
)
from hbench.analysis.statistics.intervals import (
    OverRuns,
    covariance_over_runs,
    has_effect,
)
from hbench.config.fitting import Fitting
from hbench.records import Curve, Fit, FitParameter

Range = tuple[float, float]


def tustin_covariance(curves: Sequence[Curve], fit: Fit) -> OverRuns:
    """Return the covariance (4, 4) of a Tustin fit to ``curves``, and its degrees of freedom (4,).

    Points have the weights of the fit. For several curves it is ``covariance_over_runs``, for one
    curve that of the fit (``parameter_spread.py``). Rows of parameters at a bound are zero,
    their degrees nan.
    """
    p = np.array([fit.parameters[name].value for name in PARAMETER_NAMES])
    free = np.array([fit.parameters[name].at_bound is None for name in PARAMETER_NAMES])
    spread, dof = np.zeros((len(p), len(p))), np.full(len(p), np.nan)
    if len(curves) == 1 and fit.spread is not None:
        if fit.dof is not None:
            dof = np.where(free, standard_uncertainty(fit.spread, fit.dof, np.eye(len(p)))[1], dof)
        return OverRuns(np.where(np.outer(free, free), fit.spread.covariance, spread), dof)
    data = fit_points(curves, Fitting().weights)
    jacobian = tustin_jacobian(data.inputs[0], p) / data.sigma[:, None]
    size = TUSTIN_LAW.scale(data.inputs, float(np.abs(data.friction_n).max()))
    jacobian, effect = jacobian[:, free], has_effect(jacobian, size)[free]
    residual = (tustin_friction(data.inputs[0], p) - data.friction_n) / data.sigma
    curve = np.repeat(np.arange(len(curves)), [len(c.points) for c in curves])
    over_curves = covariance_over_runs(jacobian, residual, curve, effect)
    spread[np.ix_(free, free)], dof[free] = over_curves
    return OverRuns(spread, dof)


def without_impossible_intervals(
    parameters: Mapping[str, FitParameter], possible: Mapping[str, Range]
) -> tuple[dict[str, FitParameter], list[str]]:
    """Remove linearised intervals beyond the ``possible`` range, and return messages on them."""
    kept, messages = dict(parameters), []
    for name, (least, most) in possible.items():
        p = parameters[name]
        if p.ci95 and not (least <= p.ci95[0] and p.ci95[1] <= most):
            kept[name] = FitParameter(p.value, None, None, p.at_bound, p.unit)
            messages.append(
                f"{name} has no interval: the linearised one, {_range(*p.ci95)} {p.unit}, exceeds "
                f"the range {_range(least, most)} {p.unit}"
            )
    return kept, messages


def _range(low: float, high: float) -> str:
    return " to ".join(f"{float(f'{end:.3g}'):g}" for end in (low, high)).replace("-", "−")
