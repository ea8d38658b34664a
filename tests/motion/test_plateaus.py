"""The section of constant speed is found wherever it is in a log, from 1 to 500 mm/s."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hbench.motion.plateaus import plateau_at, plateaus


def trapezoids(speeds, rate_hz, holds_s, rest_s=(1.0, 1.0), a_m_s2=1.0):
    """Return t, x of speeds one after the other, and the start and end of each constant speed."""
    corners, v, times = [0.0, rest_s[0]], [0.0, 0.0], []
    for speed, hold in zip(speeds, holds_s, strict=True):
        reached = corners[-1] + abs(speed - v[-1]) / a_m_s2
        corners += [reached, reached + hold]
        v += [speed, speed]
        times.append((reached, reached + hold))
    corners += [corners[-1] + abs(v[-1]) / a_m_s2]
    corners += [corners[-1] + rest_s[1]]
    v += [0.0, 0.0]
    t = np.arange(0.0, corners[-1], 1 / rate_hz)
    corners, v = np.array(corners), np.array(v)
    x_corners = np.concatenate(([0.0], np.cumsum(np.diff(corners) * (v[1:] + v[:-1]) / 2)))
    i = np.clip(np.searchsorted(corners, t, side="right") - 1, 0, len(corners) - 2)
    dt, span = t - corners[i], np.maximum(np.diff(corners)[i], 1e-12)
    return t, x_corners[i] + v[i] * dt + np.diff(v)[i] / span * dt**2 / 2, times


def sensed(x, noise, step, drift, seed):
    """Return positions with white noise, a drift a sample, and a resolution."""
    rng = np.random.default_rng(seed)
    x = x + noise * rng.standard_normal(len(x)) + np.linspace(0, drift, len(x))
    return np.rint(x / step) * step if step else x


logs = {
    "v": st.floats(np.log(1e-3), np.log(0.5)).map(lambda x: float(np.exp(x))),
    "sign": st.sampled_from([-1, 1]),
    "rate": st.sampled_from([20, 50, 100, 333, 1000, 10_000]),
    "rests": st.tuples(*2 * [st.sampled_from([0.0, 0.3, 3.0, 30.0])]),
    "noise": st.sampled_from([0.0, 5e-6, 2e-5, 1e-4]),
    "step": st.sampled_from([0.0, 1e-5, 1e-4]),
    "drift": st.sampled_from([0.0, 2e-4]),
    "seed": st.integers(0, 10**6),
}


@settings(max_examples=60, deadline=None)
@given(error=st.sampled_from([0.97, 1.0, 1.03]), **logs)
def test_the_plateau_is_found_at_its_nominal_speed(
    v, sign, rate, rests, noise, step, drift, seed, error
):
    hold = max(0.8, 0.025 / v, 20 / rate)
    rate = min(rate, 1000) if hold + sum(rests) > 5 else rate
    t, x, [(start, stop)] = trapezoids([sign * v], rate, [hold], rests)
    x = sensed(x, noise, step, drift, seed)
    section = plateau_at(t, x, sign * v * error)
    # Beyond its ends the position leaves the line within the time of a few noises at its speed.
    late = 0.06 + 2 / rate + 0.03 * v + 6 * max(noise, step / 2) / v
    assert start - late <= t[section][0] and t[section][-1] <= stop + late
    # Where noise or resolution permits speeds over short times only, up to a block is lost.
    covered = min(t[section][-1], stop) - max(t[section][0], start)
    assert covered >= 0.9 * hold - 0.1 - 3 / rate - 6 * max(noise, step / 2) / v


@settings(max_examples=30, deadline=None)
@given(**logs)
def test_the_plateau_is_found_without_a_nominal_speed(
    v, sign, rate, rests, noise, step, drift, seed
):
    rate = max(rate, 50)
    hold = max(1.2, 0.05 / v)
    rate = min(rate, 1000) if hold + sum(rests) > 5 else rate
    t, x, [(start, stop)] = trapezoids([sign * v], rate, [hold], rests)
    found = plateaus(t, sensed(x, min(noise, 2e-5), min(step, 1e-5), drift, seed), least_m=0.01)
    assert [round(p.v_m_s / (sign * v), 1) for p in found] == [1.0]
    assert t[found[0].section][0] < (start + stop) / 2 < t[found[0].section][-1]


@settings(max_examples=30, deadline=None)
@given(
    speeds=st.lists(st.sampled_from([0.005, 0.02, 0.06, 0.2]), min_size=2, max_size=5).filter(
        lambda v: all(a != b for a, b in zip(v, v[1:], strict=False))
    ),
    signs=st.lists(st.sampled_from([-1, 1]), min_size=5, max_size=5),
    rate=st.sampled_from([50, 200, 2000]),
    seed=st.integers(0, 10**6),
)
def test_each_of_several_plateaus_is_found(speeds, signs, rate, seed):
    speeds = [sign * v for sign, v in zip(signs, speeds, strict=False)]
    t, x, times = trapezoids(speeds, rate, [1.0 if abs(v) > 0.01 else 4.0 for v in speeds])
    found = plateaus(t, sensed(x, 1e-5, 0.0, 0.0, seed), least_m=0.01)
    assert [round(p.v_m_s / v, 1) for p, v in zip(found, speeds, strict=True)] == [1.0] * len(times)


@pytest.mark.parametrize("a_m_s2", [0.05, 0.1, 0.5])
def test_a_slow_ramp_has_no_plateau(a_m_s2):
    t = np.arange(0, 0.2 / a_m_s2, 0.01)
    assert plateaus(t, a_m_s2 * t**2 / 2, least_m=0.01) == []


def test_stick_slip_is_one_plateau_of_its_mean_speed():
    t = np.arange(0, 8, 0.01)
    v = np.where((t > 1) & (t < 7), np.where(t % 0.6 > 0.3, 0.02, 0.0), 0.0)
    x = np.cumsum(v) * 0.01 + 1e-5 * np.random.default_rng(1).standard_normal(len(t))
    section = plateau_at(t, x, 0.01)
    assert t[section][0] < 2 and t[section][-1] > 6


def test_of_two_strokes_the_longer_is_taken_and_the_return_is_not_part_of_it():
    t, x, times = trapezoids([0.05, -0.05, 0.05], 100, [2.0, 2.0, 3.0])
    section = plateau_at(t, x, 0.05)
    assert t[section][0] == pytest.approx(times[2][0], abs=0.1)
    assert t[section][-1] == pytest.approx(times[2][1], abs=0.1)


@pytest.mark.parametrize("n", [0, 1, 2, 3])
def test_a_log_of_few_samples_has_no_plateau(n):
    t = np.arange(n) / 100
    assert plateaus(t, 0.1 * t) == []


@pytest.mark.parametrize("rate", [100, 500, 1000])
@pytest.mark.parametrize("a_m_s2", [0.5, 2.0, 5.0])
@pytest.mark.parametrize("v", [0.1, 0.4])
def test_braking_is_not_part_of_a_plateau(v, a_m_s2, rate):
    """A mass of 100 kg at 2 m/s^2 turns 10 ms of braking into percents of friction."""
    t, x, [(_, stop)] = trapezoids([v], rate, [0.8], a_m_s2=a_m_s2)
    section = plateau_at(t, sensed(x, 5e-6, 0.0, 0.0, 1), v)
    assert stop - 0.035 <= t[section][-1] <= stop + 0.002
