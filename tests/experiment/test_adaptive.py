"""The adaptive rule: short steps where friction is curved and steep, and not for noise."""

import numpy as np
import pytest

from hbench.config.velocities import AdaptiveSpeeds
from hbench.experiment.adaptive import SpeedFriction, next_speed

RULE = AdaptiveSpeeds(
    strategy="adaptive",
    first="5 mm/s",
    last="200 mm/s",
    min_step="2 mm/s",
    max_step="40 mm/s",
    tolerance="2 N",
)


def tustin(v):
    return 80 + 370 * np.exp(-v / 0.06) + 2500 * v


def steps_of(friction, scatter_n=0.0, rule=RULE, seed=0, rejected=()):
    """Follow a friction curve to the end; return the speeds."""
    rng = np.random.default_rng(seed)
    measured, speed = [], rule.first
    while speed is not None:
        trials = friction(speed) + scatter_n * rng.standard_normal(3)
        measured.append(SpeedFriction(speed, () if len(measured) in rejected else tuple(trials)))
        speed = next_speed(rule, measured)
        assert len(measured) < 200
    return np.array([one.speed_m_s for one in measured])


def test_without_noise_a_parabola_is_met_by_its_own_step():
    """sqrt(8 tolerance / |F''|), which the rule knows from the third speed on."""
    curvature = 64e3
    found = steps_of(lambda v: 500 + 4e3 * v + curvature / 2 * v**2)
    steps = np.diff(found)
    np.testing.assert_allclose(steps[:2], RULE.min_step)
    np.testing.assert_allclose(steps[2:-2], np.sqrt(8 * 2 / curvature), rtol=1e-6)


@pytest.mark.parametrize("slope", [-3e3, 0.0, 3e3])
def test_where_friction_is_straight_the_steps_are_the_longest_however_steep_it_is(slope):
    steps = np.diff(steps_of(lambda v: 500 + slope * v))
    np.testing.assert_allclose(steps[2:-2], RULE.max_step)


def test_at_the_bottom_of_a_curve_the_slope_allows_a_longer_step_than_the_curvature():
    """F' = 0 at the last of these speeds; curvature alone would allow 16 mm/s."""
    rule = RULE.model_copy(update={"max_step": 0.1})
    speeds = np.array([0.02, 0.03, 0.04, 0.05, 0.06])
    friction = 300 + 64e3 / 2 * (speeds - 0.06) ** 2
    measured = [SpeedFriction(v, (f, f)) for v, f in zip(speeds, friction, strict=True)]
    assert next_speed(rule, measured) == pytest.approx(0.16)


@pytest.mark.parametrize("scatter_n", [0.0, 3.0, 10.0])
def test_steps_stay_within_their_limits_and_end_at_the_last_speed(scatter_n):
    for seed in range(20):
        found = steps_of(tustin, scatter_n, seed=seed)
        steps = np.diff(found)
        assert found[[0, -1]].tolist() == [RULE.first, RULE.last]
        assert steps.min() >= RULE.min_step - 1e-12 and steps.max() <= RULE.max_step + 1e-12


def test_more_than_half_of_the_speeds_lie_below_the_knee():
    """The curve's minimum: v_s ln(370 N / (v_s B)) = 54 mm/s, a quarter of the range."""
    shares = [np.mean(steps_of(tustin, 6.0, seed=seed) < 0.054) for seed in range(20)]
    assert np.mean(shares) > 0.5 and min(shares) > 0.4


def test_noise_alone_does_not_keep_the_steps_short():
    """A straight line with 10 N of scatter, of which the tolerance is a fifth."""
    for seed in range(20):
        found = steps_of(lambda v: 400 + 2500 * v, 10.0, seed=seed)
        assert len(found) < 30  # of at most 98
        assert np.diff(found)[-4:].mean() > 5 * RULE.min_step


def test_more_noise_never_means_fewer_speeds_on_average():
    counts = [
        np.mean([len(steps_of(tustin, scatter_n, seed=seed)) for seed in range(20)])
        for scatter_n in (1.0, 3.0, 10.0)
    ]
    assert counts == sorted(counts)


def test_a_rejected_reference_is_passed_by_the_smallest_step():
    everything = range(200)
    found = steps_of(tustin, rejected=everything)
    np.testing.assert_allclose(np.diff(found)[:-1], RULE.min_step)
    assert found[-1] == RULE.last
    few = steps_of(tustin, 3.0, rejected=(4, 9))
    assert few[[5, 10]] - few[[4, 9]] == pytest.approx(RULE.min_step)
    assert few[-1] == RULE.last


def test_one_accepted_trial_a_reference_tells_no_noise_so_the_steps_stay_small():
    measured = [SpeedFriction(v, (400.0,)) for v in (0.02, 0.04, 0.06)]
    assert next_speed(RULE, measured) == pytest.approx(0.06 + RULE.min_step)
