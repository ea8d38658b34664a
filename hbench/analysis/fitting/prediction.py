"""Friction predicted by a fitted law, with its interval from the parameters' covariance.

    F = f(v, p),  u^2(F) = c' V c,  c_j = df/dp_j,  U_95 = t u(F)

V is the covariance of the parameters and t Student's factor with the degrees of freedom of c'Vc
(``parameter_spread.py``). Without the off-diagonal entries of V the interval would be several
times too wide, since the parameters of a Stribeck curve are strongly correlated. Source:
JCGM 102:2011, 6.2 (propagation with covariances) and JCGM 100:2008, 5.2.2 and G.3 (one output
quantity; t factor).
"""

import numpy as np

from hbench.analysis.fitting.fittable_law import FittableLaw
from hbench.analysis.fitting.parameter_spread import standard_uncertainty
from hbench.analysis.statistics.student import student_factor
from hbench.records import Fit


def predict_friction(
    law: FittableLaw, fit: Fit, inputs: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return friction [N] (n,) and the half-width of its 95 % interval [N] (n,).

    ``inputs`` (3, n) are speed [m/s] and both pressures [Pa], as of ``FittableLaw``. The interval
    is that of the law, not of a further measurement. A parameter at an active bound counts as
    known. The half-width is nan where friction depends on a parameter that the data does not
    determine.
    """
    values = np.array([fit.parameters[name].value for name in law.names])
    friction, slopes = law.model(inputs, values), law.jacobian(inputs, values)
    if fit.dof is None or fit.spread is None:
        return friction, np.full(len(friction), np.nan)
    known = np.array([fit.parameters[name].at_bound is None for name in law.names])
    lost = known & ~np.isfinite(np.diag(fit.spread.residual))
    u, dof = standard_uncertainty(fit.spread, fit.dof, np.where(known & ~lost, slopes, 0.0))
    half = np.array([student_factor(each) for each in dof.tolist()]) * u
    return friction, np.where((slopes[:, lost] != 0.0).any(axis=1), np.nan, half)
