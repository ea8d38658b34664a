"""The bootstrap of trials against what a mean's resampling is known to give."""

import numpy as np
import pytest
from scipy.special import ndtr

from hbench.analysis.statistics.bootstrap import (
    drawn_means,
    drawn_residuals,
    leveraged,
    parameter_dof,
    percentile_intervals,
)
from hbench.analysis.statistics.student import student_factor


def test_means_of_three_drawn_trials_scatter_by_their_standard_error():
    """Without the stretch it would be two thirds of the variance s^2 / 3."""
    trials = np.array([1.0, 4.0, 10.0])
    drawn = drawn_means([trials], 40_000, np.random.default_rng(0))[:, 0]
    assert drawn.mean() == pytest.approx(5.0, abs=0.05)
    assert drawn.var() == pytest.approx(trials.var(ddof=1) / 3, rel=0.03)


def test_a_point_with_one_trial_has_none_to_draw():
    assert drawn_means([np.ones(3), np.ones(1)], 10, np.random.default_rng(0)) is None


def test_leveraged_residuals_have_the_variance_of_the_errors():
    """Plain residuals have lost p / n of it; a sixth here. Over 2000 draws it is known to 2 %."""
    rng = np.random.default_rng(1)
    x = np.linspace(0, 1, 12)
    matrix = np.column_stack([np.ones(12), x])
    hat = matrix @ np.linalg.inv(matrix.T @ matrix) @ matrix.T
    raised = []
    for _ in range(2000):
        y = rng.standard_normal(12)
        raised.append(leveraged(y - hat @ y, matrix).var())
    assert np.mean(raised) == pytest.approx(1.0, rel=0.03)
    drawn = drawn_residuals(np.zeros(2), np.array([1.0, -1.0]), np.array([1.0, 5.0]), 4000, rng)
    np.testing.assert_allclose(drawn.std(axis=0), [1.0, 5.0], rtol=0.05)


def test_percentiles_of_normal_draws_are_where_student_puts_them():
    """The identity as the fit: quantiles at Phi(-t), Phi(t) of a normal are -t and t."""
    drawn = np.random.default_rng(2).standard_normal((200_000, 1))
    (low,), (high,) = percentile_intervals(lambda row: row, drawn, np.array([30.0]))
    assert (low, high) == pytest.approx((-2.0423, 2.0423), abs=0.03)
    assert ndtr(student_factor(30)) == pytest.approx(0.97944, abs=1e-4)


def test_a_parameter_has_the_freedom_of_the_points_that_it_rests_on():
    """A mean of k equal points with two trials has k degrees of freedom, of one point one."""
    first_alone = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]])
    np.testing.assert_allclose(parameter_dof(first_alone, np.full(4, 2)), [1.0, 3.0])
    np.testing.assert_allclose(parameter_dof(first_alone, np.full(4, 3)), [2.0, 6.0])
