"""Distance of a run, and the trend of friction over the distance and the work of a cylinder."""

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.fleet.wear import corrected, cumulated, wear_trends
from hbench.motion.reversals import travel
from hbench.records import QUANTITIES

FRICTION = next(q for q in QUANTITIES if q.name == "friction_n")


@pytest.mark.parametrize("noise_m", [0.0, 2e-5, 1e-4])
def test_the_distance_of_a_sine_is_four_amplitudes_a_period_whatever_the_noise(noise_m):
    """2.5 periods of 50 mm with a rest of 5 s before and after, sampled at 100 Hz."""
    t = np.arange(0, 20, 0.01)
    x = 0.1 + 0.05 * np.sin(2 * np.pi * np.clip((t - 5) / 4, 0, 2.5))
    x = x + np.random.default_rng(0).normal(0, noise_m, len(t))
    assert travel(t, x) == pytest.approx(2.5 * 4 * 0.05, abs=10 * 6 * noise_m + 1e-5)


def test_rest_has_no_distance_and_a_ramp_its_length():
    t = np.arange(0, 10, 0.01)
    noise = np.random.default_rng(1).normal(0, 2e-5, len(t))
    assert travel(t, 0.2 + noise) < 3e-4  # the sum of all steps would be 23 mm
    assert travel(t, 0.01 * t + noise) == pytest.approx(0.1, abs=3e-4)
    assert travel(t[:1], noise[:1]) == 0.0


def test_sums_are_of_the_same_cylinder_in_the_order_of_the_dates():
    cylinders = np.array([0, 1, 0, 0, 1, 0, 1, 1])
    at = np.array([3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0])
    way = np.array([1.0, 10.0, 2.0, 4.0, 10.0, 8.0, 10.0, 10.0])
    found = cumulated(way, cylinders, at)
    assert found.tolist() == [14.5, 5.0, 9.0, 12.0, 35.0, 4.0, 15.0, 25.0]


def drawn(seed, cylinders, campaigns, slope):
    """Friction that rises with distance by ``slope``; heavy tails, unequal campaigns."""
    rng = np.random.default_rng(seed)
    of = np.repeat(np.arange(cylinders), campaigns)
    at = np.tile(np.arange(float(campaigns)), cylinders)
    distance = rng.uniform(50, 300, len(of))
    sums = cumulated(distance, of, at)
    x = 400 + 20 * rng.normal(size=cylinders)[of] + slope * sums + 3 * rng.standard_t(4, len(of))
    return list(
        wear_trends(
            FRICTION, None, x, {"distance_m": sums}, of, [f"C{i}" for i in range(cylinders)]
        )
    ), (sums, x, of)


def test_each_line_is_scipys_regression():
    trends, (sums, x, of) = drawn(1, 3, 8, 0.02)
    assert [trend.specimen for trend in trends] == ["C0", "C1", "C2"]
    for number, trend in enumerate(trends):
        peer = stats.linregress(sums[of == number], x[of == number])
        half = stats.t.ppf(0.975, 6) * peer.stderr
        assert (trend.slope, trend.intercept) == pytest.approx((peer.slope, peer.intercept))
        assert (trend.low, trend.high) == pytest.approx((peer.slope - half, peer.slope + half))
        assert trend.p == pytest.approx(peer.pvalue)


def test_intervals_hold_the_slope_and_few_cylinders_without_wear_show_any():
    held, false = [], []
    for seed in range(60):
        trends, _ = drawn(seed, 10, 8, 0.02)
        held += [trend.low <= 0.02 <= trend.high for trend in trends]
        none = corrected(drawn(1000 + seed, 10, 8, 0.0)[0])
        false.append(any(trend.real for trend in none))
    assert 0.93 < np.mean(held) < 0.98 and np.mean(false) < 0.12


def test_too_few_campaigns_have_no_trend():
    assert drawn(1, 3, 3, 0.02)[0] == [] and corrected([]) == ()
