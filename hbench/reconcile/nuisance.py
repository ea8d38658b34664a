"""Known parameters that are only badly tuned, fitted to the balances before effects are sought.

Each is a factor on a value of the plant file, with a prior (standard deviation of its logarithm)
and bounds at three of them. Least squares over the differences d between the balances of measured
and simulated runs, in units of their noise, and over the priors:

    minimise  sum (d(theta) / sigma_d)^2 + sum (ln theta_i / prior_i)^2

Flows, test side and load side share no nuisance, so each is a fit of its own: what friction lacks
can't bend the valve's gain. d takes the simulation as it is made with the factors so far; simulate
with the new ones and fit again, until they stay. Simulated friction should not scatter from stroke
to stroke here: a mean is wanted, and its noise would go into the factors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from hbench.analysis.bounded import Problem, descend
from hbench.analysis.intervals import Bound, covariance_over_runs, fit_parameters
from hbench.config.bench import Bench, Plant
from hbench.config.scaling import scaled
from hbench.reconcile.balances import FLOWS, Prepared, model, prepared, residuals
from hbench.reconcile.gap import differences
from hbench.records import FitParameter, Run

_FRICTION = {
    "coulomb": 0.3,
    "stiction": 0.3,
    "stribeck_velocity": 0.2,
    "viscous": 0.3,
    "bristle_stiffness": 0.3,
    "stribeck_force": 0.3,
}
# Balances, and the priors of their nuisances. Judged: how well a bench file's values are known.
GROUPS: Mapping[tuple[str, ...], Mapping[str, float]] = {
    FLOWS: {
        "valve.gain": 0.1,
        "valve.bandwidth": 0.1,
        "oil.bulk_modulus": 0.3,
        "test_cylinder.dead_volume_piston": 0.3,
        "test_cylinder.dead_volume_rod": 0.3,
        "load_cylinder.dead_volume_piston": 0.3,
        "load_cylinder.dead_volume_rod": 0.3,
    },
    **{
        (f"force_{side}",): {
            f"moving_mass.{side}": 0.2,
            **{f"friction.{side}.{name}": prior for name, prior in _FRICTION.items()},
        }
        for side in ("test", "load")
    },
}
_BOUND = 3.0  # priors
_STEP = 1e-4  # of a logarithm, for its derivative
_ENOUGH = 1e-5  # relative change of the cost or of a step


@dataclass(frozen=True)
class Refit:
    """A plant with nuisances refitted, and their factors on the values of the plant file."""

    plant: Plant
    factors: dict[str, FitParameter]  # intervals of the data alone, over operating points
    converged: bool


def refit(
    measured: Sequence[Run],
    modelled: Sequence[Run],
    bench: Bench,
    plant: Plant,
    factors: Mapping[str, float] = MappingProxyType({}),
) -> Refit:
    """Fit the nuisances of ``plant``; ``modelled`` are the runs simulated with ``factors`` on it.

    Raises ``DataError`` where no operating point has two trials and a simulation.
    """
    found: dict[str, FitParameter] = {}
    converged = True
    logs = [prepared(run) for run in measured], [prepared(run) for run in modelled]
    for names, priors in GROUPS.items():
        here = {path: sd for path, sd in priors.items() if _value(plant, path)}
        if here:
            fit = _Group(names, here, *logs, bench, plant, factors)
            new, well = fit.solve()
            found |= new
            converged &= well
    values = {path: one.value for path, one in found.items()}
    return Refit(scaled(plant, values), found, converged)


class _Group:
    """The fit of the nuisances that some balances share; theta are logarithms of the factors."""

    def __init__(
        self,
        names: tuple[str, ...],
        priors: Mapping[str, float],
        measured: Sequence[Prepared],
        modelled: Sequence[Prepared],
        bench: Bench,
        plant: Plant,
        factors: Mapping[str, float],
    ):
        self._names, self._paths, self._measured = names, tuple(priors), measured
        self._prior = np.array(list(priors.values()))
        self._bench, self._plant = bench, plant
        self._start = np.log([factors.get(path, 1.0) for path in priors])
        now = model(bench, scaled(plant, factors))
        self._expected = [residuals(run, now, names) for run in modelled]
        before = differences([residuals(run, now, names) for run in measured], self._expected)
        self._compared = np.isfinite(before.difference) & (before.noise > 0)
        self._sigma = np.sqrt(before.noise[self._compared])
        self._point = np.broadcast_to(before.point[:, None], self._compared.shape)[self._compared]

    def solve(self) -> tuple[dict[str, FitParameter], bool]:
        """Return the factors, and whether the search converged."""
        prior, zero = self._prior, np.zeros(len(self._prior))
        if not self._compared.any():
            return self._parameters(zero, np.zeros((0, 0)), [None] * len(zero)), True
        problem = Problem(
            residual=lambda theta: np.concatenate([self._seen(theta), theta / prior]),
            lower=-_BOUND * prior,
            upper=_BOUND * prior,
            scale=prior,
            jacobian=lambda theta: np.vstack([self._derivatives(theta), np.diag(1 / prior)]),
        )
        solution = descend(problem, self._start, tolerance=_ENOUGH)
        spread = covariance_over_runs(
            self._derivatives(solution.x)[:, solution.free], self._seen(solution.x), self._point
        )
        bounds = [solution.at_bound(problem, i) for i in range(len(prior))]
        return self._parameters(solution.x, spread, bounds), solution.converged

    def _seen(self, theta: np.ndarray) -> np.ndarray:
        factors = dict(zip(self._paths, np.exp(theta).tolist(), strict=True))
        tried = model(self._bench, scaled(self._plant, factors))
        measured = [residuals(run, tried, self._names) for run in self._measured]
        return differences(measured, self._expected).difference[self._compared] / self._sigma

    def _derivatives(self, theta: np.ndarray) -> np.ndarray:
        here = self._seen(theta)
        steps = np.where(theta > 0, -_STEP, _STEP)  # inwards
        columns = [
            (self._seen(theta + step * one) - here) / step
            for step, one in zip(steps, np.eye(len(theta)), strict=True)
        ]
        return np.column_stack(columns)

    def _parameters(
        self, theta: np.ndarray, spread: np.ndarray, bounds: Sequence[Bound]
    ) -> dict[str, FitParameter]:
        units = dict.fromkeys(self._paths, "1")
        dof = len(np.unique(self._point)) - 1
        logs = fit_parameters(units, theta, spread, dof, bounds)
        return {path: _factor(one) for path, one in logs.items()}


def _factor(log: FitParameter) -> FitParameter:
    """Turn a logarithm with its interval into a factor."""
    value = float(np.exp(log.value))
    ci95 = None if log.ci95 is None else (float(np.exp(log.ci95[0])), float(np.exp(log.ci95[1])))
    return FitParameter(value, None if log.se is None else value * log.se, ci95, log.at_bound, "1")


def _value(plant: Plant, path: str) -> float:
    value = plant
    for name in path.split("."):
        value = getattr(value, name, 0.0)
    return value
