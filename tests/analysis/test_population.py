"""One number among many campaigns, against fleets whose truth is known."""

import numpy as np
import pytest
from scipy.stats import norm

from hbench.analysis.fleet.population import histogram, robust_deviations, trend_line
from hbench.records import FEWEST_CAMPAIGNS

TRIALS = 3


def fleet(rng, n, between, own=1.0):
    """Numbers and standard errors of campaigns of three trials each."""
    trials = rng.normal(0, own * np.sqrt(TRIALS), (n, TRIALS)) + rng.normal(0, between, (n, 1))
    return trials.mean(axis=1), trials.std(axis=1, ddof=1) / np.sqrt(TRIALS)


@pytest.mark.parametrize("fleets", [120, pytest.param(400, marks=pytest.mark.slow)])
@pytest.mark.parametrize("n", [20, 200])
@pytest.mark.parametrize("between", [0.0, 1.0, 10.0])
def test_one_fleet_in_twenty_of_good_cylinders_has_an_outlier_at_most(n, between, fleets):
    rng = np.random.default_rng(3)
    alarms = 0
    for _ in range(fleets):
        x, se = fleet(rng, n, between)
        alarms += n * robust_deviations(x, se, np.median(x)).p.min() < 0.05
    assert alarms / fleets < 0.05 + 2.5 * np.sqrt(0.05 * 0.95 / fleets)


def test_the_spread_between_cylinders_is_told_from_the_scatter_of_their_trials():
    rng = np.random.default_rng(4)
    found = [
        robust_deviations(*fleet(rng, 500, between), 0.0).between
        for between in (0.0, 1.0, 5.0)
        for _ in range(30)
    ]
    none, equal, large = np.reshape(found, (3, 30)).mean(axis=1)
    assert none < 0.35 and equal == pytest.approx(1.0, abs=0.1)
    assert large == pytest.approx(5.0, rel=0.05)


def test_a_third_of_wild_campaigns_hides_none_of_them():
    rng = np.random.default_rng(5)
    x, se = fleet(rng, 90, 2.0)
    x[:30] += rng.uniform(40, 400, 30)
    found = robust_deviations(x, se, np.median(x))
    assert (90 * found.p[:30] < 0.05).all() and not (90 * found.p[30:] < 0.05).any()


def test_far_off_counts_less_where_a_campaigns_own_trials_scatter():
    rng = np.random.default_rng(6)
    x, se = fleet(rng, 100, 2.0)
    x[:2] = 20.0
    se[0] = 15.0
    found = robust_deviations(x, se, np.median(x))
    assert 100 * found.p[1] < 0.01 and found.p[0] > 0.1
    assert found.z[0] == pytest.approx(
        (20.0 - np.median(x)) / np.hypot(found.between, 15.0), rel=1e-12
    )


def test_three_trials_that_agree_by_chance_make_no_outlier():
    rng = np.random.default_rng(7)
    x, se = fleet(rng, 200, 0.0)
    se[np.argmax(np.abs(x))] = 1e-6
    assert (200 * robust_deviations(x, se, np.median(x)).p > 0.05).all()


def test_without_any_standard_error_or_with_equal_numbers_it_stands():
    x = np.arange(12.0)
    found = robust_deviations(x, np.full(12, np.nan), np.median(x))
    assert found.between == pytest.approx(3.0 / norm.ppf(0.75), rel=1e-4)
    same = robust_deviations(np.full(12, 5.0), np.zeros(12), 5.0)
    assert (same.z == 0).all() and same.between == 0


def test_a_straight_line_is_found_through_a_third_of_wild_values():
    rng = np.random.default_rng(8)
    t = np.sort(rng.uniform(0, 30, 120))
    x = 400 + 2.0 * t + rng.normal(0, 0.5, 120)
    x[::3] += rng.choice([-200.0, 200.0], 40)
    found = trend_line(t, x)
    assert found.slope == pytest.approx(2.0, abs=0.1) and found.low < 2.0 < found.high
    assert found.intercept == pytest.approx(400, abs=2.0) and found.p < 1e-6


def test_the_interval_of_a_slope_holds_the_truth_in_95_percent_for_few_and_many():
    rng = np.random.default_rng(9)
    for n, fleets in ((15, 300), (3000, 12)):
        held = 0
        for _ in range(fleets):
            t = rng.uniform(0, 10, n)
            found = trend_line(t, 0.3 * t + rng.normal(0, 1, n))
            held += found.low <= 0.3 <= found.high
        assert held / fleets > 0.95 - 3 * np.sqrt(0.05 * 0.95 / fleets)


def test_there_is_no_line_through_few_values_or_one_moment():
    assert trend_line(np.arange(FEWEST_CAMPAIGNS - 1.0), np.arange(FEWEST_CAMPAIGNS - 1.0)) is None
    assert trend_line(np.zeros(50), np.arange(50.0)) is None
    assert trend_line(np.arange(50.0), np.ones(50)) is None


@pytest.mark.parametrize("x", [np.ones(20), np.r_[np.zeros(30), 1e9, -1e9], np.arange(1e5)])
def test_a_histogram_counts_each_campaign_once_in_few_bins(x):
    edges, counts, below, above = histogram(x)
    assert counts.sum() + below + above == len(x) and len(edges) == len(counts) + 1 <= 41
    assert (np.diff(edges) > 0).all()


def test_a_histogram_leaves_out_what_would_hide_the_rest():
    x = np.r_[np.random.default_rng(1).normal(0, 1, 500), 1e6, -1e6]
    edges, _, below, above = histogram(x)
    assert (below, above) == (1, 1) and -7 < edges[0] and edges[-1] < 7
