"""Friction laws fitted to curves: bounded least squares, with what the data does not determine.

The Tustin law (3.2) on magnitudes, so that both directions give positive parameters (a friction
along with the motion stays negative):

    F(v) = F_C + (F_stiction - F_C) exp(-|v| / v_stribeck) + B |v|
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from hbench.analysis.bounded import Problem, Solution, solve
from hbench.analysis.student import student_factor
from hbench.records import Curve, Fit, FitParameter

UNITS = {
    "f_coulomb_n": "N",
    "f_stiction_n": "N",
    "v_stribeck_m_s": "m/s",
    "b_viscous_n_s_m": "N s/m",
}
NAMES = tuple(UNITS)

# The source's bounds. It warns that they were set after seeing its data.
TABLE_6_1: Mapping[str, tuple[float, float]] = {
    "f_coulomb_n": (0.0, 1e5),
    "f_stiction_n": (0.0, 1e5),
    "v_stribeck_m_s": (0.05, 0.2),
    "b_viscous_n_s_m": (0.0, 1e5),
}

_GRID = 15  # Stribeck speeds tried for a start
_LINE_POINTS = 121
_ILL_CONDITIONED = 1e3
_SINGULAR = 1e-7
_LEAST_FORCE_N = 1e-6  # scale of a curve of zeros
_FULL_FILM = 2.0  # Stribeck speeds; below, the viscous part does not stand alone


def fits(curve: Curve) -> tuple[Fit, ...]:
    """Fit every law of ``LAWS`` to a curve; none to one with fewer speeds than parameters."""
    return tuple(law(curve) for law in LAWS.values()) if _speeds(curve) >= len(NAMES) else ()


def left_out(curves: Sequence[Curve]) -> tuple[str, ...]:
    """Return a note on the curves that ``fits`` leaves out, if there are any."""
    few = [_speeds(curve) for curve in curves if _speeds(curve) < len(NAMES)]
    if not few:
        return ()
    return (
        f"{len(few)} of {len(curves)} curves have {max(few)} or fewer speeds and are not fitted; "
        f"a fit needs {len(NAMES)}",
    )


def _speeds(curve: Curve) -> int:
    return len({point.v_m_s for point in curve.points})


def fit_tustin(curve: Curve, bounds: Mapping[str, tuple[float, float]] = TABLE_6_1) -> Fit:
    """Fit the Tustin law (3.2) to a curve's points, all with the same weight.

    Standard errors come from the Jacobian of the parameters off their bounds, with
    s^2 = RSS / (n - p); intervals from Student's t with n - p degrees of freedom, p being the
    number of these parameters. ``rmse_n`` is sqrt(RSS / n). What the data does not determine
    has neither, and the message says so.
    """
    v = np.abs([point.v_m_s for point in curve.points])
    friction = _sign(curve) * np.array([point.friction_n for point in curve.points])
    if len(v) < len(NAMES):
        message = f"{len(v)} points do not determine {len(NAMES)} parameters"
        return Fit("tustin", {}, float("nan"), False, message)
    lower, upper = np.array([bounds[name] for name in NAMES]).T
    force = max(float(np.abs(friction).max()), _LEAST_FORCE_N)
    problem = Problem(
        residual=lambda p: tustin(v, p) - friction,
        jacobian=lambda p: tustin_jacobian(v, p),
        lower=lower,
        upper=upper,
        scale=np.array([force, force, upper[2], force / v.max()]),
    )
    solution = solve(problem, _starts(v, friction, lower, upper))
    rss = float(np.sum(problem.residual(solution.x) ** 2))
    se, condition = _standard_errors(problem, solution, rss, len(v))
    parameters = _parameters(problem, solution, se, len(v))
    messages = [] if solution.converged else ["the search for the best fit did not converge"]
    messages += _bound_messages(parameters)
    messages += _identification_messages(parameters, v, condition)
    return Fit(
        law="tustin",
        parameters=parameters,
        rmse_n=float(np.sqrt(rss / len(v))),
        converged=solution.converged,
        message="; ".join(messages),
        line=_line(curve, v, solution.x),
    )


def tustin(v_m_s: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return F_C + (F_s - F_C) exp(-v / v_s) + B v [N] for speeds >= 0; p in ``NAMES`` order."""
    f_c, f_s, v_s, b = p
    return f_c + (f_s - f_c) * np.exp(-v_m_s / v_s) + b * v_m_s


def tustin_jacobian(v_m_s: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the derivatives (n, 4) of ``tustin`` by its parameters."""
    f_c, f_s, v_s, _ = p
    e = np.exp(-v_m_s / v_s)
    return np.column_stack([1 - e, e, (f_s - f_c) * e * v_m_s / v_s**2, v_m_s])


def _starts(
    v: np.ndarray, friction: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> list[np.ndarray]:
    """Return a start for each minimum over v_s of the best fit of the three linear parameters."""
    grid = np.geomspace(lower[2], upper[2], _GRID)
    found, costs = [], []
    for v_s in grid:
        e = np.exp(-v / v_s)
        linear, *_ = np.linalg.lstsq(np.column_stack([1 - e, e, v]), friction, rcond=None)
        p = np.clip([linear[0], linear[1], v_s, linear[2]], lower, upper)
        found.append(p)
        costs.append(np.sum((tustin(v, p) - friction) ** 2))
    padded = np.array([np.inf, *costs, np.inf])
    minima = (padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:])
    return [found[i] for i in np.flatnonzero(minima)]


def _standard_errors(
    problem: Problem, solution: Solution, rss: float, n: int
) -> tuple[np.ndarray, float]:
    """Return standard errors, nan where not determined, and the condition of the free part.

    Columns are scaled by the parameters' sizes first. A direction with no singular value to
    speak of is not determined, and neither is a parameter with a part in it.
    """
    free, scale = solution.free, problem.scale
    se = np.full(len(scale), np.nan)
    dof = n - int(free.sum())
    if not free.any():
        return se, 1.0
    jacobian = problem.jacobian(solution.x)[:, free] * scale[free]
    _, s, vt = np.linalg.svd(jacobian, full_matrices=False)
    known = s > _SINGULAR * s[0]
    condition = float(s[0] / s[-1]) if known.all() else np.inf
    if dof > 0:
        variance = np.sum((vt[known].T / s[known]) ** 2, axis=1) * rss / dof
        undetermined = np.any(np.abs(vt[~known]) > 1e-3, axis=0)
        se[free] = np.where(undetermined, np.nan, np.sqrt(variance) * scale[free])
    return se, condition


def _parameters(
    problem: Problem, solution: Solution, se: np.ndarray, n: int
) -> dict[str, FitParameter]:
    dof = n - int(solution.free.sum())
    t = student_factor(dof) if dof > 0 else np.nan
    found = {}
    for i, name in enumerate(NAMES):
        value, error = float(solution.x[i]), float(se[i])
        known = np.isfinite(error)
        found[name] = FitParameter(
            value=value,
            se=error if known else None,
            ci95=(value - t * error, value + t * error) if known else None,
            at_bound=solution.at_bound(problem, i),
            unit=UNITS[name],
        )
    return found


def _bound_messages(parameters: dict[str, FitParameter]) -> list[str]:
    return [
        f"{name} is at its {p.at_bound} bound {p.value:g} {p.unit}: the data would have it "
        f"{'lower' if p.at_bound == 'lower' else 'higher'}; its value is the bound's, and the "
        "other parameters depend on it"
        for name, p in parameters.items()
        if p.at_bound
    ]


def _identification_messages(
    parameters: dict[str, FitParameter], v: np.ndarray, condition: float
) -> list[str]:
    free = {name: p for name, p in parameters.items() if not p.at_bound}
    unknown = [name for name, p in free.items() if p.se is None]
    viscous, v_s = parameters["b_viscous_n_s_m"], parameters["v_stribeck_m_s"].value
    messages = []
    if len(free) == len(v):
        messages.append("as many parameters as points: no standard errors")
    elif unknown:
        messages.append(f"the data does not determine {' and '.join(unknown)}")
    elif condition > _ILL_CONDITIONED:
        messages.append(
            f"ill-conditioned (condition number {condition:.1g}): the parameters can't be told "
            "apart well, only the curve as a whole is known"
        )
    if viscous.ci95 is not None and viscous.ci95[0] <= 0:
        messages.append("the velocities do not determine b_viscous_n_s_m: its interval holds 0")
    elif viscous.at_bound is None and v.max() < _FULL_FILM * v_s:
        messages.append(
            f"b_viscous_n_s_m rests on speeds up to {v.max():.3g} m/s, where the Stribeck part "
            f"(v_stribeck_m_s = {v_s:.3g} m/s) still falls; do not extrapolate"
        )
    return messages


def _sign(curve: Curve) -> float:
    return 1.0 if curve.direction == "extend" else -1.0


def _line(curve: Curve, v: np.ndarray, p: np.ndarray) -> tuple[tuple[float, float], ...]:
    sign = _sign(curve)
    speeds = np.union1d(v, np.linspace(v.min(), v.max(), _LINE_POINTS))
    return tuple(zip((sign * speeds).tolist(), (sign * tustin(speeds, p)).tolist(), strict=True))


LAWS: dict[str, Callable[[Curve], Fit]] = {
    "tustin": fit_tustin,
}
