"""The core of all fits on NIST's certified nonlinear regressions, from both certified starts.

``pytest -s`` prints the digits: the log relative error of the worst parameter and of the worst
standard error (11 are certified).
"""

import os

import numpy as np
import pytest

from hbench.analysis.statistics.bounded import Problem, descend, solve
from hbench.analysis.statistics.intervals import covariance
from tests.support.analysis import nist_strd

if not nist_strd.FOLDER.is_dir() and not os.environ.get("HBENCH_CI"):
    pytest.skip(nist_strd.WHY_MISSING, allow_module_level=True)

# Digits at least; elsewhere 6 of the parameters and 6 of the standard errors.
FEWER = {"Lanczos1": (6.0, 2.5)}  # its residuals are rounding alone: their sum is 1e-25


def digits(found, certified):
    """Log relative error, at most 11: that many digits are certified."""
    error = np.abs(found - certified) / np.abs(certified)
    return float(min(11.0, -np.log10(max(error.max(), 1e-16))))


def problem(data):
    infinite = np.full(len(data.certified), np.inf)
    return Problem(data.residual, -infinite, infinite, np.abs(data.starts[0]))


def worth(data, solution):
    one = problem(data)
    spread = covariance(one.derivatives(solution.x), data.residual(solution.x))
    return digits(solution.x, data.certified), digits(np.sqrt(np.diag(spread)), data.errors)


@pytest.mark.parametrize("start", [1, 2])
@pytest.mark.parametrize("name", nist_strd.NAMES)
def test_certified_parameters_and_standard_errors_are_found(name, start):
    data = nist_strd.load(name)
    solution = descend(problem(data), data.starts[start - 1])
    values, errors = worth(data, solution)
    print(f"{name:9} {data.level:8} start {start}  digits {values:4.1f}  of s.e. {errors:4.1f}")
    assert solution.converged and solution.free.all()
    least_values, least_errors = FEWER.get(name, (6.0, 6.0))
    assert values >= least_values and errors >= least_errors
    if name in FEWER:  # no more digits than the data has
        assert errors < 6.0


@pytest.mark.parametrize("name", nist_strd.NAMES)
def test_from_both_starts_together_every_set_is_solved(name):
    data = nist_strd.load(name)
    solution = solve(problem(data), list(data.starts))
    assert solution.converged and worth(data, solution)[0] >= 6.0
    left = data.residual(solution.x)
    assert name == "Lanczos1" or left @ left == pytest.approx(data.rss, rel=1e-9)


@pytest.mark.parametrize("name", ["Misra1a", "Thurber", "MGH09"])
def test_a_bound_beyond_the_minimum_is_found_active_and_the_rest_is_minimal(name):
    """The second parameter is kept 10 % away; scipy's bounded search finds no lower cost."""
    from scipy.optimize import least_squares

    data = nist_strd.load(name)
    lower = np.full(len(data.certified), -np.inf)
    lower[1] = data.certified[1] + 0.1 * abs(data.certified[1])
    one = problem(data)._replace(lower=lower)
    solution = descend(one, np.maximum(data.certified, lower))
    assert solution.at_bound(one, 1) == "lower" and solution.x[1] == lower[1]
    start = np.maximum(data.certified, lower + 1e-3 * abs(lower[1]))
    start[1] = lower[1] * (1 + 1e-3)
    peer = least_squares(
        data.residual, start, bounds=(lower, np.inf), x_scale="jac", xtol=1e-15, ftol=1e-15
    )
    left = data.residual(solution.x)
    assert left @ left <= 2 * peer.cost * (1 + 1e-9)
    np.testing.assert_allclose(solution.x, peer.x, rtol=1e-3)


@pytest.mark.parametrize("name", ["Misra1a", "Chwirut2", "ENSO", "Hahn1", "Rat43"])
def test_lmfit_finds_the_same_values_and_errors_within_three_digits(name):
    lmfit = pytest.importorskip("lmfit")
    data = nist_strd.load(name)
    parameters = lmfit.Parameters()
    for i, value in enumerate(data.starts[1]):
        parameters.add(f"b{i}", value=value)

    def residual(p):
        return data.residual(np.array(list(p.valuesdict().values())))

    found = lmfit.minimize(residual, parameters, xtol=1e-15, ftol=1e-15, gtol=0)
    solution = descend(problem(data), data.starts[1])
    peer = np.array([p.value for p in found.params.values()])
    assert digits(solution.x, peer) > 3  # lmfit takes differences
    spread = covariance(problem(data).derivatives(solution.x), data.residual(solution.x))
    errors = np.array([p.stderr for p in found.params.values()])
    np.testing.assert_allclose(np.sqrt(np.diag(spread)), errors, rtol=1e-2)
