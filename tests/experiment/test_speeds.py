"""Speeds that are known beforehand: the source's polynomial, and its first two suggestions."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from hbench.config.velocities import Velocities
from hbench.experiment.fixed_speeds import speeds

ENDS = {"first": "5 mm/s", "last": "200 mm/s"}


def speeds_of(velocities):
    return speeds(TypeAdapter(Velocities).validate_python(velocities))


@pytest.mark.parametrize("strategy", [{}, {"strategy": "polynomial"}])
def test_without_a_strategy_speeds_are_a_second_order_polynomial_between_the_ends(strategy):
    found = speeds_of({**strategy, **ENDS, "count": 15})
    assert found[[0, -1]] == pytest.approx([0.005, 0.2])
    np.testing.assert_allclose(np.diff(found, 3), 0, atol=1e-12)
    assert np.all(np.diff(found, 2) > 0)


def test_linear_steps_are_equal():
    found = speeds_of({"strategy": "linear", **ENDS, "count": 14})
    assert found[[0, -1]] == pytest.approx([0.005, 0.2])
    np.testing.assert_allclose(np.diff(found), 0.015, rtol=1e-9)


@pytest.mark.parametrize(("count", "below", "above"), [(3, 1, 1), (14, 7, 6), (15, 7, 7)])
def test_slope_adjusted_steps_change_once_at_the_transition(count, below, above):
    given = {"strategy": "slope_adjusted", **ENDS, "transition": "80 mm/s", "count": count}
    found = speeds_of(given)
    assert len(found) == count
    np.testing.assert_allclose(np.diff(found[: below + 1]), 0.075 / below, rtol=1e-9)
    np.testing.assert_allclose(np.diff(found[below:]), 0.12 / above, rtol=1e-9)


def test_a_list_is_taken_as_it_is():
    assert speeds_of(["60 mm/s", "5 mm/s"]).tolist() == [0.06, 0.005]
