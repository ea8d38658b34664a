"""Two-line law of Marton and Lantos (3.3): fitted to a curve, or derived from a Tustin fit.

Fitted (``TWO_LINES``), they meet at the switch velocity, which is a parameter like the slopes
(``model/friction/formulas.py``). From a Tustin fit, as the source does it, they are tangents at
rest and at the largest speed:

    F_d1 = a_1 + b_1 |v|    a_1 = F_s,                   b_1 = B - D / v_s               (3.4)
    F_d2 = a_2 + b_2 |v|    a_2 = F_C + D e (1 + w),     b_2 = B - D e / v_s             (3.5)
    v_SW = (a_1 - a_2) / (b_2 - b_1) = v_s (1 - e (1 + w)) / (1 - e)                     (3.6)

with D = F_s - F_C, w = v_max / v_s, e = exp(-w). a_2 is the intercept at v = 0, not the
value at v_max. v_SW depends on v_s and v_max alone.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.fitting.fit_data import fit_points
from hbench.analysis.fitting.fittable_law import FittableLaw
from hbench.analysis.fitting.over_curves import tustin_covariance, without_impossible_intervals
from hbench.analysis.fitting.tustin import PARAMETER_NAMES
from hbench.analysis.rounding import ROUNDING, distinct
from hbench.analysis.statistics.bounded import complex_step
from hbench.analysis.statistics.intervals import fit_parameters, parameter_messages
from hbench.model.friction.formulas import joined_lines, two_lines
from hbench.records import Curve, Fit
from hbench.records.friction_laws import FRICTION_LAWS

PARAMETER_UNITS = FRICTION_LAWS["marton_lantos"].units
_SWITCH = "v_switch_m_s"


def _basis(inputs: np.ndarray, v_switch: float) -> np.ndarray:
    low = np.minimum(inputs[0], v_switch)
    return np.column_stack([np.ones(len(low)), low, inputs[0] - low])


def _jacobian(inputs: np.ndarray, p: np.ndarray) -> np.ndarray:
    _, b_1, b_2, v_switch = p
    beyond = inputs[0] > v_switch * (1 + ROUNDING)  # a point on the switch belongs to the low line
    return np.column_stack([_basis(inputs, v_switch), np.where(beyond, b_1 - b_2, 0)])


def _between(inputs: np.ndarray, force_n: float) -> dict[str, tuple[float, float]]:
    """Return bounds of v_SW with two or more speeds on each line."""
    speeds = distinct(inputs[0])
    return {"v_switch_m_s": (float(speeds[1]), float(speeds[-2]))}


def _switches(
    inputs: np.ndarray, friction: np.ndarray, sigma: np.ndarray, low: float, high: float
) -> np.ndarray:
    """Return the values of v_SW that can be a minimum: the speeds, and intersections between them.

    Between two speeds each line is fitted to its own points, so that the cost has a minimum there
    only where the two lines intersect (Hudson, 1966).
    """
    v, speeds = inputs[0], distinct(inputs[0])
    values = [low, high, *speeds]
    for below, above in zip(speeds[1:-2], speeds[2:-1], strict=True):
        right = v > below * (1 + ROUNDING)
        (b_1, a_1), (b_2, a_2) = (
            np.polyfit(v[side], friction[side], 1, w=1 / sigma[side]) for side in (~right, right)
        )
        if b_1 != b_2 and below < (crossing := (a_1 - a_2) / (b_2 - b_1)) < above:
            values.append(crossing)
    return np.unique(np.clip(values, low, high))


def _scale(inputs: np.ndarray, force: float) -> np.ndarray:
    v_max = inputs[0].max()
    return np.array([force, force / v_max, force / v_max, v_max])


TWO_LINES = FittableLaw(
    name="marton_lantos",
    units={name: unit for name, unit in PARAMETER_UNITS.items() if name != "high_force_n"},
    model=lambda inputs, p: joined_lines(inputs[0], *p),
    jacobian=_jacobian,
    basis=_basis,
    nonlinear="v_switch_m_s",
    bounds=_between,
    scale=_scale,
    candidates=_switches,
)


def lines_from_tustin(curves: Sequence[Curve], tustin: Fit) -> Fit:
    """Return the two lines of one direction's curves from their Tustin fit, for magnitudes.

    Intervals follow from the Tustin parameters' covariance (``tustin_covariance``) by the delta
    method, with the least of their degrees of freedom. Tangents at rest and at v_max intersect
    between them, so v_SW has no interval if it would extend beyond, or if v_s has no standard
    error. ``rmse_n`` is that of the lines at the points.
    """
    data = fit_points(curves)
    v, direction = data.inputs[0], curves[0].against_motion
    p = np.array([tustin.parameters[name].value for name in PARAMETER_NAMES])
    v_max = float(v.max())
    values = lines(p, v_max)
    slopes = complex_step(lambda p: lines(p, v_max), p)
    spread, dof = tustin_covariance(curves, tustin)
    force, slope, _, speed = _scale(data.inputs, float(np.abs(data.friction_n).max()))
    size = np.array([force, slope, force, slope, speed])
    least = np.full(len(values), np.min(dof[np.isfinite(dof)], initial=np.inf))
    parameters = fit_parameters(
        PARAMETER_UNITS, values, slopes @ spread @ slopes.T, least, [None] * 5, size
    )
    undetermined = parameter_messages(parameters)
    parameters, messages = without_impossible_intervals(parameters, {_SWITCH: (0.0, v_max)})
    messages = [*undetermined, *messages]
    if tustin.parameters["v_stribeck_m_s"].se is None and parameters[_SWITCH].ci95:
        parameters[_SWITCH] = replace(parameters[_SWITCH], se=None, ci95=None)
        messages.append(f"{_SWITCH} has no interval, since v_stribeck_m_s has no standard error")
    if tustin.message:
        messages.append(f"Tustin fit: {tustin.message}")
    return Fit(
        law="marton_lantos",
        parameters=parameters,
        rmse_n=float(np.sqrt(np.mean((two_lines(v, *values[:4]) - data.friction_n) ** 2))),
        converged=tustin.converged,
        message="; ".join(messages),
        line=tuple(
            (direction * speed, direction * float(two_lines(np.array(speed), *values[:4])))
            for speed in sorted({float(v.min()), *v.tolist(), float(values[4])})
            if v.min() <= speed <= v_max
        ),
    )


def lines(p: np.ndarray, v_max_m_s: float) -> np.ndarray:
    """Return a_1, b_1, a_2, b_2, v_SW (``PARAMETER_UNITS``) of Tustin's p = F_C, F_s, v_s, B."""
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
