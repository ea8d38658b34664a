"""EWMA, rules for patterns, and change points: textbook numbers and rates of false signals."""

import numpy as np
import pytest
from scipy.stats import ttest_ind

from hbench.analysis.fleet.change_point import change_point
from hbench.analysis.fleet.ewma import ewma
from hbench.analysis.fleet.run_rules import RULES, SHEWHART, run_rules

# Montgomery, Introduction to Statistical Quality Control, table 9.1 and example 9.2 (mean 10, sigma
# 1, lambda 0.1, L 2.7; a shift to 11 after point 20). The numbers were typed from memory, without
# the book at hand: that the averages follow from the values confirms both columns.
VALUES = [
    9.45, 7.99, 9.29, 11.66, 12.16, 10.18, 8.04, 11.46, 9.20, 10.34, 9.03, 11.47, 10.51, 9.40,
    10.08, 9.37, 10.62, 10.31, 8.52, 10.84, 10.90, 9.33, 12.29, 11.50, 10.60, 11.08, 10.38, 11.62,
    11.31, 10.52,
]  # fmt: skip
AVERAGES = [
    9.945, 9.7495, 9.70355, 9.8992, 10.1253, 10.1307, 9.92167, 10.0755, 9.98796, 10.0232, 9.92384,
    10.0785, 10.1216, 10.0495, 10.0525, 9.98426, 10.0478, 10.074, 9.91864, 10.0108, 10.0997,
    10.0227, 10.2495, 10.3745, 10.3971, 10.4654, 10.4568, 10.5731, 10.6468, 10.6341,
]  # fmt: skip
WESTERN_ELECTRIC = [name for name in RULES if name.startswith("Western Electric")]


def test_montgomerys_ewma():
    found = ewma(VALUES, 10.0, 1.0)
    np.testing.assert_allclose(found.values, AVERAGES, atol=6e-5)
    assert found.high[:2] == pytest.approx([10.27, 10.36], abs=0.005)
    assert (found.low[-1], found.high[-1]) == pytest.approx((9.38, 10.62), abs=0.005)
    assert np.flatnonzero(found.signals).tolist() == [28, 29]


def test_the_limits_of_an_ewma_have_its_variance_at_each_point():
    rng = np.random.default_rng(1)
    x = rng.normal(5.0, 2.0, (20_000, 8))
    averages = np.array([ewma(row, 5.0, 2.0).values for row in x])
    found = ewma(x[0], 5.0, 2.0)
    np.testing.assert_allclose(2.7 * averages.std(axis=0), found.high - 5.0, rtol=0.03)


@pytest.mark.parametrize(
    ("number", "z", "at"),
    [
        (0, [0, 3.1, -2.9, -3.1], [1, 3]),
        (1, [2.1, 0.5, 2.2, -2.1, 0, -2.5], [2, 5]),
        (1, [2.1, 0.0, 0.0, 2.2, -2.1, 2.1], [5]),  # opposite sides do not count together
        (2, [1.1, 1.2, 0.5, 1.1, 1.3, 0.0], [4]),
        (2, [-1.1, 1.2, -1.1, -1.1, -1.3, -1.1], [4, 5]),
        (3, [0.1] * 9 + [-0.1], [7, 8]),
        (3, [0.1] * 7 + [0.0] + [0.1] * 7, []),
        (4, [0, 1, 2, 3, 4, 5, 4], [5]),
        (4, [5, 4, 3, 2, 1, 1, 0], []),
    ],
)
def test_each_rule_signals_at_the_last_point_of_its_pattern(number, z, at):
    signals = list(run_rules(np.array(z, dtype=float)).values())[number]
    assert np.flatnonzero(signals).tolist() == at


def test_rates_of_false_signals_are_those_of_the_literature():
    """Shewhart's 0.0027 a point; 91.75 points to the first of Western Electric's four rules.

    Champ and Woodall (1987). The EWMA's 356 points are those of 20 000 sequences, computed once
    without this code.
    """
    rng = np.random.default_rng(2)
    z = rng.standard_normal(400_000)
    signals = run_rules(z)[SHEWHART]
    assert signals.mean() == pytest.approx(0.0026998, abs=3 * np.sqrt(0.0027 / len(z)))
    first = [_first(_any(run_rules(part))) for part in z.reshape(-1, 1000)]
    assert np.mean(first) == pytest.approx(91.75, abs=3 * np.std(first) / np.sqrt(len(first)))
    averages = [_first(ewma(rng.standard_normal(4000), 0, 1).signals) for _ in range(400)]
    assert np.mean(averages) == pytest.approx(356, abs=3 * np.std(averages) / 20)


def _any(rules):
    return np.any([rules[name] for name in WESTERN_ELECTRIC], axis=0)


def _first(signals):
    found = np.flatnonzero(signals)
    return found[0] + 1 if len(found) else len(signals)


def test_a_step_is_found_where_it_is_and_the_same_values_have_the_same_p():
    rng = np.random.default_rng(3)
    x = rng.standard_t(6, 40)
    x[25:] += 3.0
    found = change_point(x)
    assert found.first == 25 and found.p == pytest.approx(1 / 2000)
    assert found.after - found.before == pytest.approx(3.0, abs=1.0)
    assert change_point(x) == found


def test_without_a_step_five_per_cent_of_p_values_are_below_five_per_cent():
    rng = np.random.default_rng(4)
    p = np.array([change_point(rng.exponential(size=20)).p for _ in range(150)])
    assert (p < 0.05).mean() == pytest.approx(0.05, abs=3 * np.sqrt(0.05 * 0.95 / len(p)))


def test_the_interval_of_a_clear_step_holds_it():
    rng = np.random.default_rng(6)
    found = []
    for _ in range(150):
        x = rng.standard_t(8, 24)
        x[14:] += 3.5
        found.append(change_point(x))
    holds = np.array([abs(one.after - one.before - 3.5) <= one.ci95 for one in found])
    assert holds.mean() == pytest.approx(0.95, abs=3 * np.sqrt(0.95 * 0.05 / len(holds)))


def test_the_interval_of_a_step_is_that_of_students_t_test():
    x = np.random.default_rng(7).standard_normal(25)
    x[12:] += 10.0
    low, high = ttest_ind(x[12:], x[:12]).confidence_interval()
    found = change_point(x)
    assert found.first == 12 and found.ci95 == pytest.approx((high - low) / 2)


def test_few_or_constant_values_have_no_step():
    assert change_point(np.arange(9.0)) is None and change_point(np.full(20, 3.0)) is None


def test_many_values_are_averaged_in_groups():
    rng = np.random.default_rng(5)
    x = rng.standard_normal(20_000)
    x[12_000:] += 0.2
    found = change_point(x)
    assert found.first == pytest.approx(12_000, abs=800) and found.p < 0.01
