"""Capability against limits: closed form, coverage of the interval, and what has none."""

import numpy as np
import pytest

from hbench.analysis.fleet.capability import capabilities, without_capability
from hbench.records.conformity.acceptance import ConformityCheck, Measurement, Requirement

FRICTION = {"quantity": "friction", "unit": "N"}


def of(x, *requirements, v_m_s=0.1, decided=(), by_date=True):
    def values(quantity, side):
        return np.asarray(x) if (quantity.name, side) == ("friction_n", "extend") else np.zeros(0)

    return list(capabilities(values, decided, requirements, v_m_s, by_date))


def test_ppk_is_the_distance_to_the_nearer_limit_in_three_standard_deviations():
    x = np.arange(12.0)
    (both,) = of(x, Requirement(**FRICTION, low=-1.0, high=20.0))
    s = x.std(ddof=1)
    assert both.ppk.value == pytest.approx((5.5 + 1.0) / (3 * s))
    assert (both.series.value, both.sigma, both.outside) == (
        pytest.approx(5.5),
        pytest.approx(s),
        0,
    )
    (one,) = of(x, Requirement(**FRICTION, low=None, high=10.0))
    assert one.ppk.value == pytest.approx(4.5 / (3 * s)) and one.outside == 1


def test_cpk_is_by_the_moving_range_and_keeps_its_value_where_the_mean_steps():
    x = np.tile([0.0, 1.0], 10)
    limit = Requirement(**FRICTION, low=None, high=30.0)
    (steady,) = of(x, limit)
    assert steady.sigma_within == pytest.approx(1.0 / 1.128)
    assert steady.cpk.value == pytest.approx((30.0 - 0.5) / (3 * steady.sigma_within))
    (stepped,) = of(x + 10.0 * (np.arange(20) >= 10), limit)
    assert stepped.sigma / steady.sigma > 9 and stepped.sigma_within / steady.sigma_within < 1.6
    assert stepped.ppk.value < 0.5 * stepped.cpk.value
    (unordered,) = of(x, limit, by_date=False)
    assert unordered.cpk is None and unordered.ppk == steady.ppk


@pytest.mark.parametrize("n", [12, 50])
@pytest.mark.parametrize("true", [0.8, 1.6])
def test_the_intervals_contain_the_true_index(n, true):
    rng, inside, count = np.random.default_rng(n), np.zeros(2), 2000
    requirement = Requirement(**FRICTION, low=None, high=3 * true)
    for _ in range(count):
        (found,) = of(rng.standard_normal(n), requirement)
        inside += [index.low <= true <= index.high for index in (found.ppk, found.cpk)]
    print(f"n = {n}, true index {true}: Ppk {inside[0] / count:.1%}, Cpk {inside[1] / count:.1%}")
    assert (inside / count > 0.91).all() and (inside / count < 0.97).all()


def test_what_the_fleets_numbers_are_not_has_no_capability_and_a_reason():
    x = np.arange(12.0)
    for other, words in (
        (Requirement("friction", "bar", low=None, high=1e5), "in bar"),
        (Requirement(**FRICTION, low=None, high=10.0, f_load_n=500.0), "to one load"),
        (Requirement(**FRICTION, low=None, high=10.0, v_m_s=0.2), "200 mm/s"),
        (Requirement("drift", "%", low=-0.1, high=0.1), "does not have"),
    ):
        assert not of(x, other)
        ((limit, reason),) = without_capability([], [other], 0.1, len(x))
        assert limit == other and words in reason
    assert not of(x, Requirement(**FRICTION, low=None, high=10.0, direction="retract"))
    good = Requirement(**FRICTION, low=None, high=10.0, v_m_s=0.11)
    assert not list(without_capability([], [good], 0.1, len(x)))
    assert "10 campaigns" in next(without_capability([], [good], 0.1, 9))[1]


def test_a_limit_of_one_load_takes_the_values_of_the_acceptances():
    of_a_load = Requirement("breakaway", "bar", low=None, high=9e5, f_load_n=500.0)
    x = {"extend": 1e5 * np.arange(12.0), "retract": 4e5 + 1e4 * np.arange(12.0)}

    def check(requirement, direction, i):
        measured = Measurement(
            x[direction][i], 1e4, None, "", direction, 500.0, v_m_s=0.05 + i / 1e5
        )
        return ConformityCheck(requirement, measured, 0.5, "PASS")

    other = Requirement("breakaway", "bar", low=None, high=8e5, f_load_n=500.0)
    untested = ConformityCheck(of_a_load, None, None, "NOT TESTED", "no runs")
    decided = [
        (check(other, "extend", i), untested, *(check(of_a_load, side, i) for side in x))
        for i in range(12)
    ]
    extending, retracting = of([], of_a_load, decided=decided)
    for found, side in ((extending, "extend"), (retracting, "retract")):
        mean, s = x[side].mean(), x[side].std(ddof=1)
        assert found.ppk.value == pytest.approx((9e5 - mean) / (3 * s)) and found.n == 12
        assert (found.series.value, found.series.direction) == (pytest.approx(mean), side)
    assert (extending.outside, retracting.outside) == (2, 0)
    assert not list(without_capability(decided, [of_a_load], 0.1, 12))
    assert not of([], of_a_load, decided=decided[:9])
    ((_, reason),) = without_capability(decided[:9], [of_a_load], 0.1, 12)
    assert "one load" in reason and "9 so far" in reason
