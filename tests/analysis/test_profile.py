"""Profile intervals against lmfit's, against closed forms, and where a bound is active."""

import numpy as np
import pytest
from scipy.optimize import brentq

from hbench.analysis.fitting.marton_lantos import TWO_LINES
from hbench.analysis.statistics import profile
from hbench.analysis.statistics.bounded import Problem, descend, solve, sum_of_squares
from hbench.analysis.statistics.profile import profile_interval
from hbench.analysis.statistics.student import student_factor
from tests.support.analysis import nist_strd

INFINITE = np.inf


def intervals(problem, solution, freedom):
    """95 % by each parameter; the linearised direction from the Jacobian, as the fits have it."""
    factor = student_factor(freedom)
    variance = sum_of_squares(problem, solution.x) / freedom
    jacobian = problem.derivatives(solution.x)
    spread = np.linalg.inv(jacobian.T @ jacobian) * variance
    ways = factor * spread / np.sqrt(np.diag(spread))
    level = factor**2 * variance
    return np.array(
        [profile_interval(problem, solution, i, level, ways[:, i]) for i in range(len(spread))]
    )


def linear(seed=0, **bounds):
    """A straight line through noise: the profile of a linear law is its Student interval."""
    x = np.linspace(0.0, 1.0, 12)
    y = 3.0 + 2.0 * x + np.random.default_rng(seed).standard_normal(12)
    matrix = np.column_stack([np.ones(12), x])
    given = {"lower": np.full(2, -INFINITE), "upper": np.full(2, INFINITE)} | bounds
    problem = Problem(
        lambda p: matrix @ p - y, scale=np.ones(2), jacobian=lambda p: matrix, **given
    )
    return problem, matrix, y


def test_of_a_linear_law_it_is_students_interval():
    problem, matrix, y = linear()
    solution = descend(problem, np.zeros(2))
    found = intervals(problem, solution, 10)
    best, rss, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    se = np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)) * rss[0] / 10)
    np.testing.assert_allclose(found[:, 0], best - 2.22814 * se, rtol=2e-3)
    np.testing.assert_allclose(found[:, 1], best + 2.22814 * se, rtol=2e-3)


@pytest.mark.parametrize("name", ["DanWood", "Chwirut2", "Rat42", "BoxBOD", "MGH09"])
def test_it_is_that_of_lmfit_on_certified_sets(name):
    lmfit = pytest.importorskip("lmfit")
    if not nist_strd.FOLDER.is_dir():
        pytest.skip(nist_strd.WHY_MISSING)
    data = nist_strd.load(name)
    p = len(data.certified)
    free = np.full(p, INFINITE)
    problem = Problem(data.residual, -free, free, np.abs(data.certified))
    solution = descend(problem, data.starts[1])
    found = intervals(problem, solution, len(data.y) - p)

    parameters = lmfit.Parameters()
    for i, value in enumerate(solution.x):
        parameters.add(f"b{i}", value=value)
    minimizer = lmfit.Minimizer(
        lambda q: data.residual(np.array(list(q.valuesdict().values()))), parameters
    )
    result = minimizer.minimize(method="leastsq", xtol=1e-12, ftol=1e-12)
    try:
        peer = lmfit.conf_interval(minimizer, result, sigmas=[0.95], maxiter=500)
    except (ValueError, lmfit.MinimizerException) as error:
        pytest.skip(f"lmfit finds no interval itself: {error}")
    ends = np.array([[rows[0][1], rows[-1][1]] for rows in peer.values()])
    known = np.isfinite(ends)
    assert known.sum() >= p
    widths = found[:, 1] - found[:, 0]
    away = np.abs(found - ends) / np.where(np.isfinite(widths), widths, 1.0)[:, None]
    assert np.all(away[known] < 5e-3)


def test_at_an_active_bound_it_has_one_side_and_begins_at_the_bound():
    problem, matrix, y = linear(lower=np.array([4.5, -INFINITE]))
    solution = descend(problem, np.array([5.0, 0.0]))
    assert solution.x[0] == 4.5 and not solution.free[0]
    level = 2.2**2 * sum_of_squares(problem, solution.x) / 11
    low, high = profile_interval(problem, solution, 0, level, np.zeros(2))
    assert low == 4.5
    # in closed form: the larger root of S(a) = S(4.5) + level, S by the slope that is best at a

    def least(a):
        slope = matrix[:, 1] @ (y - a) / (matrix[:, 1] @ matrix[:, 1])
        return float(np.sum((y - a - slope * matrix[:, 1]) ** 2))

    assert least(high) - least(4.5) == pytest.approx(level, rel=5e-3) and high > 4.5


def test_the_others_are_not_narrowed_by_a_bound_that_the_truth_does_not_touch():
    """With the first parameter on its bound, the second's linearised interval is conditional."""
    problem, matrix, y = linear(lower=np.array([4.5, -INFINITE]))
    solution = descend(problem, np.array([5.0, 0.0]))
    variance = sum_of_squares(problem, solution.x) / 11
    half = 2.2 * np.sqrt(variance / (matrix[:, 1] @ matrix[:, 1]))
    way = np.array([0.0, half])
    low, high = profile_interval(problem, solution, 1, 2.2**2 * variance, way)
    # in closed form: S(b) with the intercept that is best at b, not below its bound

    def beyond(slope):
        intercept = max(4.5, float(np.mean(y - slope * matrix[:, 1])))
        rest = y - intercept - slope * matrix[:, 1]
        return float(rest @ rest) - sum_of_squares(problem, solution.x) - 2.2**2 * variance

    expected = brentq(beyond, solution.x[1] - 9, solution.x[1]), brentq(beyond, solution.x[1], 9)
    assert (low, high) == pytest.approx(expected, rel=5e-3)
    assert low < solution.x[1] - 1.03 * half and high == pytest.approx(solution.x[1] + half)


def test_an_end_that_the_data_does_not_set_is_infinite():
    x = np.linspace(0.0, 1.0, 20)
    y = np.random.default_rng(1).standard_normal(20)
    free = np.full(2, INFINITE)
    problem = Problem(lambda p: p[0] * np.exp(-p[1] * x) - y, -free, free, np.ones(2))
    solution = descend(problem, np.array([0.5, 1.0]))
    level = 2.1**2 * sum_of_squares(problem, solution.x) / 18
    ends = profile_interval(problem, solution, 1, level, np.full(2, np.nan))
    assert INFINITE in ends or -INFINITE in ends


def test_steps_on_ellipsoids_find_the_limits_of_the_search_along_the_parameter(monkeypatch):
    """Decays through noise, some of which end at a bound: 20 curves of three parameters."""
    x = np.linspace(0.02, 1.0, 15)
    by_ellipsoids, quick = profile._by_ellipsoids, []

    def counted(*arguments):
        quick.append(by_ellipsoids(*arguments))
        return quick[-1]

    for seed in range(20):
        y = 1.0 + 2.0 * np.exp(-x / 0.3) + 0.1 * np.random.default_rng(seed).standard_normal(15)
        problem = Problem(
            lambda p, y=y: p[0] + p[1] * np.exp(-x / p[2]) - y,
            np.array([0.8, 0.0, 0.02]),
            np.array([INFINITE, INFINITE, 1.0]),
            np.array([1.0, 1.0, 0.3]),
        )
        solution = descend(problem, np.array([1.0, 2.0, 0.3]))
        monkeypatch.setattr(profile, "_by_ellipsoids", counted)
        found = intervals(problem, solution, 12)
        monkeypatch.setattr(profile, "_by_ellipsoids", lambda *arguments: None)
        expected = intervals(problem, solution, 12)
        half = np.abs(expected - solution.x[:, None])
        np.testing.assert_array_less(np.abs(found - expected), 3e-3 * half + 1e-12)
    assert np.mean([limit is not None for limit in quick]) > 0.6


def two_lines(seed):
    """Two lines that meet at a speed, nearly parallel: S over that speed has several minima."""
    v = np.linspace(0.01, 0.2, 12)
    law = TWO_LINES
    y = 300 - 500 * np.minimum(v, 0.1) + 3 * np.random.default_rng(seed).standard_normal(12)
    inputs = np.vstack([v, v, v])
    lower, upper = law.limits(inputs, 300.0, {})
    problem = Problem(
        lambda p: law.model(inputs, p) - y,
        lower,
        upper,
        law.scale(inputs, 300.0),
        lambda p: law.jacobian(inputs, p),
        uneven=law.uneven(inputs, y, np.ones(12), lower, upper),
    )
    return problem, solve(problem, law.starts(inputs, y, np.ones(12), lower, upper)), inputs, y


@pytest.mark.parametrize("number", [0, 1, 2])
def test_limits_of_a_law_with_a_kink_are_the_outermost_over_all_its_places(number):
    """Against S at 2,000 places of the kink, each a linear problem with a limit in closed form."""
    away = []
    for seed in range(12):
        problem, solution, inputs, y = two_lines(seed)
        least = sum_of_squares(problem, solution.x)
        level = 2.3**2 * least / 8
        limits = []
        for place in np.linspace(problem.lower[3], problem.upper[3], 2000):
            matrix = TWO_LINES.basis(inputs, place)
            best, rest, *_ = np.linalg.lstsq(matrix, y, rcond=None)
            room = least + level - float(rest[0])
            if room > 0:
                half = np.sqrt(room * np.linalg.inv(matrix.T @ matrix)[number, number])
                limits += [best[number] - half, best[number] + half]
        found = profile_interval(problem, solution, number, level, np.full(4, np.nan))
        half = np.ptp(limits) / 2
        away += [abs(found[0] - min(limits)) / half, abs(found[1] - max(limits)) / half]
    assert max(away) < 5e-3


@pytest.mark.parametrize("slope", [0.0, 1e-12])
def test_a_parameter_whose_effect_is_rounding_keeps_its_value_at_the_start(slope):
    """A start at its bound is no reason to move it across its range."""
    problem = Problem(
        residual=lambda p: np.array([p[0] - 1.0, p[0] - 2.0, slope * p[1]]),
        lower=np.array([-10.0, 0.01]),
        upper=np.array([10.0, 0.2]),
        scale=np.array([1.0, 0.1]),
        jacobian=lambda p: np.array([[1.0, 0.0], [1.0, 0.0], [0.0, slope]]),
    )
    for start in (0.2, 0.05):
        found = descend(problem, np.array([5.0, start]))
        assert found.x == pytest.approx([1.5, start])
