"""The pressure-based law fitted to steady points of all loads and directions (3.7).

    sign(v) F = k1 exp(k2 |v|) + k3 |P_p - P_r| + k4 P_r + k5 |v|

It is linear but for k2. So for each k2 the other four follow by linear least squares, and the
search is one over k2 alone (variable projection). k4 needs both directions or rod-side pressures
that differ: at one of them P_r is as good as constant over speed.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from hbench.analysis.intervals import bound_messages, covariance, fit_parameters
from hbench.records import Curve, Fit

UNITS = {"k1_n": "N", "k2_s_m": "s/m", "k3_n_pa": "N/Pa", "k4_n_pa": "N/Pa", "k5_n_s_m": "N s/m"}
# From no fall at all to one over 2 mm/s, below the speeds that the bench holds.
K2_S_M = (-500.0, 0.0)
_GRID = 60
_NEAR = 1e-6  # of the range of k2: at its bound


def fit_pressure_based(curves: Sequence[Curve], k2_s_m: tuple[float, float] = K2_S_M) -> Fit:
    """Fit equation 3.7 to the points of all ``curves`` at once, all with the same weight.

    Points without a rod-side pressure are left out. Standard errors come from the Jacobian of
    all five parameters, k2 among them unless it is at a bound.
    """
    points = [point for curve in curves for point in curve.points if point.p_tr_pa is not None]
    if len({(point.v_m_s, point.p_tp_pa) for point in points}) < len(UNITS):
        message = (
            f"{len(points)} points with both pressures do not determine {len(UNITS)} constants"
        )
        return Fit("pressure_based", {}, float("nan"), False, message)
    v = np.array([point.v_m_s for point in points])
    p_p = np.array([point.p_tp_pa for point in points])
    p_r = np.array([point.p_tr_pa for point in points])
    friction = np.sign(v) * np.array([point.friction_n for point in points])
    k2, converged = _search(lambda k2: _project(k2, np.abs(v), p_p, p_r, friction)[1], k2_s_m)
    k1, k3, k4, k5 = _project(k2, np.abs(v), p_p, p_r, friction)[0]
    k = np.array([k1, k2, k3, k4, k5])
    jacobian = _jacobian(np.abs(v), p_p, p_r, k)
    residual = pressure_based(np.abs(v), p_p, p_r, k) - friction
    near = _NEAR * (k2_s_m[1] - k2_s_m[0])
    bound = "lower" if k2 - k2_s_m[0] < near else "upper" if k2_s_m[1] - k2 < near else None
    bounds = [None, bound, None, None, None]
    free = np.array([one is None for one in bounds])
    parameters = fit_parameters(
        UNITS, k, covariance(jacobian[:, free], residual), len(v) - int(free.sum()), bounds
    )
    messages = [] if converged else ["the search over k2 did not converge"]
    return Fit(
        law="pressure_based",
        parameters=parameters,
        rmse_n=float(np.sqrt(np.mean(residual**2))),
        converged=converged,
        message="; ".join(messages + bound_messages(parameters)),
    )


def pressure_based(
    speed_m_s: np.ndarray, p_p_pa: np.ndarray, p_r_pa: np.ndarray, k: np.ndarray
) -> np.ndarray:
    """Return the magnitude of friction [N] at speeds >= 0; k in the order of ``UNITS``."""
    k1, k2, k3, k4, k5 = k
    seals = k3 * np.abs(p_p_pa - p_r_pa) + k4 * p_r_pa
    return k1 * np.exp(k2 * speed_m_s) + seals + k5 * speed_m_s


def _jacobian(speed: np.ndarray, p_p: np.ndarray, p_r: np.ndarray, k: np.ndarray) -> np.ndarray:
    e = np.exp(k[1] * speed)
    return np.column_stack([e, k[0] * e * speed, np.abs(p_p - p_r), p_r, speed])


def _project(
    k2: float, speed: np.ndarray, p_p: np.ndarray, p_r: np.ndarray, friction: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return the best k1, k3, k4, k5 at this k2, and the sum of squares they leave."""
    matrix = np.column_stack([np.exp(k2 * speed), np.abs(p_p - p_r), p_r, speed])
    size = np.linalg.norm(matrix, axis=0)
    linear = np.linalg.lstsq(matrix / size, friction, rcond=None)[0] / size
    return linear, float(np.sum((matrix @ linear - friction) ** 2))


def _search(cost, bounds: tuple[float, float]) -> tuple[float, bool]:
    """Return the k2 of least cost within the bounds: the best of a grid, refined."""
    low, high = bounds
    grid = high - np.concatenate(([0.0], np.geomspace(1e-3, 1.0, _GRID))) * (high - low)
    costs = [cost(k2) for k2 in grid]
    best = int(np.argmin(costs))
    around = grid[min(best + 1, _GRID)], grid[max(best - 1, 0)]
    found = minimize_scalar(cost, bounds=around, method="bounded", options={"xatol": 1e-9})
    if found.fun <= costs[best]:
        return float(found.x), bool(found.success)
    return float(grid[best]), bool(found.success)
