"""The two lines of Marton and Lantos from a Tustin fit: tangents at rest and at the largest speed.

    F_d1 = a_1 + b_1 |v|    a_1 = F_stiction,            b_1 = B - D / v_s               (3.4)
    F_d2 = a_2 + b_2 |v|    a_2 = F_C + D e (1 + w),     b_2 = B - D e / v_s             (3.5)
    v_SW = (a_1 - a_2) / (b_2 - b_1) = v_s (1 - e (1 + w)) / (1 - e)                     (3.6)

with D = F_stiction - F_C, w = v_max / v_s, e = exp(-w). a_2 is the intercept at v = 0, not the
value at v_max. v_SW depends on v_s and v_max alone.
"""

import numpy as np

from hbench.analysis.fit import NAMES, tustin_jacobian
from hbench.analysis.intervals import covariance, fit_parameters
from hbench.records import Curve, Fit

UNITS = {
    "low_force_n": "N",
    "low_slope_n_s_m": "N s/m",
    "high_force_n": "N",
    "high_slope_n_s_m": "N s/m",
    "v_switch_m_s": "m/s",
}
_STEP = 1e-20  # of the complex-step derivative, which is exact for any small one


def marton_lantos(curve: Curve, tustin: Fit) -> Fit:
    """Return the lines of a curve's direction, from its Tustin fit, on magnitudes as that fit.

    Intervals follow from the Tustin parameters' covariance by the delta method. ``rmse_n`` is
    that of the lines at the curve's points.
    """
    v = np.abs([point.v_m_s for point in curve.points])
    p = np.array([tustin.parameters[name].value for name in NAMES])
    free = np.array([tustin.parameters[name].at_bound is None for name in NAMES])
    v_max = float(v.max())
    values = lines(p, v_max)
    slopes = np.column_stack(
        [np.imag(lines(p + 1j * _STEP * direction, v_max)) / _STEP for direction in np.eye(4)]
    )[:, free]
    jacobian = tustin_jacobian(v, p)[:, free]
    # Only the residuals' sum of squares counts, and the Tustin fit knows it.
    own = covariance(jacobian, np.full(len(v), tustin.rmse_n))
    spread = slopes @ own @ slopes.T
    sign = 1.0 if curve.direction == "extend" else -1.0
    measured = sign * np.array([point.friction_n for point in curve.points])
    residual = force(v, values) - measured
    return Fit(
        law="marton_lantos",
        parameters=fit_parameters(UNITS, values, spread, len(v) - int(free.sum()), [None] * 5),
        rmse_n=float(np.sqrt(np.mean(residual**2))),
        converged=tustin.converged,
        message=tustin.message,
        line=tuple(
            (sign * speed, sign * float(force(np.array(speed), values)))
            for speed in sorted({float(v.min()), *v.tolist(), float(values[4])})
            if v.min() <= speed <= v_max
        ),
    )


def lines(p: np.ndarray, v_max_m_s: float) -> np.ndarray:
    """Return a_1, b_1, a_2, b_2, v_SW, as in ``UNITS``, of Tustin's p = F_C, F_stiction, v_s, B."""
    f_c, f_s, v_s, b = p
    w = v_max_m_s / v_s
    e, drop = np.exp(-w), f_s - f_c
    return np.array(
        [
            f_s,
            b - drop / v_s,
            f_c + drop * e * (1 + w),
            b - drop * e / v_s,
            v_s * (1 - e * (1 + w)) / (1 - e),
        ]
    )


def force(speed_m_s: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return friction [N] at speeds >= 0 (3.3)."""
    a_1, b_1, a_2, b_2, v_switch = p
    return np.where(speed_m_s <= v_switch, a_1 + b_1 * speed_m_s, a_2 + b_2 * speed_m_s)
