"""Fit of the LuGre law to logged runs with reversals: bristles and steady curve jointly.

The law follows each run's measured velocity and pressures, and its friction is compared with the
measured one, sample by sample (3.8 to 3.12). Presliding after each reversal determines sigma_0 and
sigma_1, sliding the other parameters.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from hbench.analysis.identification.driven_law import driven_friction
from hbench.analysis.identification.sliding_start import sliding_start
from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.analysis.statistics.bounded import Problem, solve
from hbench.analysis.statistics.intervals import (
    covariance_over_runs,
    fit_parameters,
    has_effect,
    parameter_messages,
)
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from hbench.records import Fit
from hbench.records.friction_laws import PARAMETERS


class Unknown(NamedTuple):
    """Parameter to be fitted: its field of ``FrictionParameters``, unit, bounds, typical size."""

    field: str
    unit: str
    lower: float
    upper: float
    size: float


def unknown(name: str, lower: float, upper: float, size: float) -> Unknown:
    """Return a parameter of the table of laws with bounds and typical size, in SI."""
    return Unknown(PARAMETERS[name].key, PARAMETERS[name].unit, lower, upper, size)


_LIMITS = {  # bounds and typical size
    "sigma0_n_m": (1e4, 1e8, 1e6),
    "sigma1_n_s_m": (0.0, 1e5, 1e3),
    "f_coulomb_n": (0.0, 1e5, 300.0),
    "f_stiction_n": (0.0, 1e5, 300.0),
    "v_stribeck_m_s": (2e-3, 0.5, 0.05),
    "b_viscous_n_s_m": (0.0, 1e5, 2e3),
    "k_piston_n_pa": (0.0, 1e-2, 1e-5),
    "k_rod_n_pa": (0.0, 1e-2, 1e-5),
}
UNKNOWNS: Mapping[str, Unknown] = {name: unknown(name, *limits) for name, limits in _LIMITS.items()}
_STIFFNESSES = np.geomspace(3e4, 3e6, 7)  # candidates for a start
_STEP = 1e-5  # of a parameter's size, for its derivative
_TOLERANCE = 1e-8  # of the sum of squares: a hundredth of the share of one in a million samples


def fit_lugre(
    motions: Sequence[LoggedMotion],
    known: FrictionParameters,
    names: Sequence[str],
) -> Fit:
    """Fit the ``UNKNOWNS`` in ``names``; the other parameters are as in ``known``.

    The search starts at ``known``, or at the sliding friction of the motions where this is nearer
    (``sliding_start``), except for sigma_0. Intervals are over whole runs
    (``covariance_over_runs``), since the samples of a run are not independent. They do not include
    systematic errors, such as those of a sensor's gain.
    """
    law = known._replace(law=LAWS["lugre"].code)
    unknowns = {name: UNKNOWNS[name] for name in names}

    def put(x: np.ndarray) -> FrictionParameters:
        new = zip(unknowns.values(), x.tolist(), strict=True)
        values: dict[str, Any] = {u.field: value for u, value in new}
        return law._replace(**values)

    guesses = [law, sliding_start(motions, law)]
    starts = [
        np.array([getattr(guess, u.field) for u in unknowns.values()])
        for guess in guesses
        if guess is not None
    ]
    if "sigma0_n_m" in unknowns:
        chosen = np.array(list(unknowns)) == "sigma0_n_m"
        starts = [np.where(chosen, s, start) for start in starts for s in _STIFFNESSES]
    return fit_to_motions("lugre", motions, put, unknowns, [starts])


def fit_to_motions(
    law: str,
    motions: Sequence[LoggedMotion],
    put: Callable[[np.ndarray], FrictionParameters],
    unknowns: Mapping[str, Unknown],
    starts: Sequence[Sequence[np.ndarray]],
) -> Fit:
    """Fit any law to ``motions``; ``put`` returns its parameters from the unknowns.

    A search begins at the best of each group of ``starts``; the best of their solutions counts.
    """
    lower = np.array([u.lower for u in unknowns.values()])
    upper = np.array([u.upper for u in unknowns.values()])
    size = np.array([u.size for u in unknowns.values()])

    def residual(x: np.ndarray) -> np.ndarray:
        par = put(x)
        return np.concatenate(
            [(driven_friction(m, par) - m.friction_n)[m.compared] for m in motions]
        )

    def jacobian(x: np.ndarray) -> np.ndarray:
        steps = np.where(x + _STEP * size > upper, -_STEP, _STEP) * size
        here = residual(x)
        columns = [
            (residual(x + step * direction) - here) / step
            for step, direction in zip(steps, np.eye(len(x)), strict=True)
        ]
        return np.column_stack(columns)

    problem = Problem(residual, lower, upper, size, jacobian)

    def cost(x: np.ndarray) -> float:
        return float(np.sum(residual(x) ** 2))

    inside = [[np.clip(start, lower, upper) for start in group] for group in starts]
    solution = solve(problem, [min(group, key=cost) for group in inside], _TOLERANCE)
    left = residual(solution.x)
    run = np.repeat(np.arange(len(motions)), [int(m.compared.sum()) for m in motions])
    bounds = [solution.at_bound(problem, i) for i in range(len(size))]
    slopes, free = jacobian(solution.x), solution.free
    parameters = fit_parameters(
        {name: u.unit for name, u in unknowns.items()},
        solution.x,
        *covariance_over_runs(slopes[:, free], left, run, has_effect(slopes, size)[free]),
        bounds,
        size,
    )
    messages = [] if solution.converged else ["the search for the best fit did not converge"]
    return Fit(
        law=law,
        parameters=parameters,
        rmse_n=float(np.sqrt(np.mean(left**2))),
        converged=solution.converged,
        message="; ".join(messages + parameter_messages(parameters)),
    )
