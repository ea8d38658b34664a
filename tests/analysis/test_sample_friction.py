"""Velocity of a log as a derivative of its position."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.screening.sample_friction import logged_motion


def test_the_noise_of_the_position_is_amplified_at_the_ends_of_a_log_and_not_within(make_run):
    rng = np.random.default_rng(1)
    ends, within = [], []
    run = make_run(v_m_s=0.1)
    exact, centred = logged_motion(run, 0.0).v_m_s, logged_motion(run, 0.0).centred
    for _ in range(200):
        noisy = run.x_m + 10e-6 * rng.standard_normal(len(run.x_m))
        error = logged_motion(replace(run, x_m=noisy), 0.0).v_m_s - exact
        ends.append(error[[0, -1]])
        within.append(error[centred][[0, -1]])
    assert len(error) - len(error[centred]) == 6  # three samples at each end
    assert np.std(ends) > 4 * np.std(within)


def test_a_position_that_rarely_leaves_one_step_of_its_sensor_is_at_rest(make_run):
    """A step of 10 um is then about 15 um/s over 0.3 s; over 60 ms it would be 0.9 mm/s."""
    rng = np.random.default_rng(2)
    run = make_run(v_m_s=0.1)
    toggling = 10e-6 * (rng.random(len(run.x_m)) < 0.05)
    v = np.abs(logged_motion(replace(run, x_m=0.2 + toggling), 0.0).v_m_s)
    assert v.max() < 80e-6


def stopping(rng, rests_s=(0.6, 0.6), creep_m_s=0.0, noise_m=5e-6):
    """Return time and position of a piston that rests, moves by 20 mm, and rests (or creeps)."""
    dt, move = 0.005, 0.5
    t = np.arange(round((sum(rests_s) + move) / dt)) * dt
    s = np.clip((t - rests_s[0]) / move, 0, 1)
    way = 0.02 * np.where(s < 0.5, 2 * s**2, 1 - 2 * (1 - s) ** 2)
    x = 0.1 + way + creep_m_s * np.maximum(t - rests_s[0] - move, 0.0)
    return t, x + noise_m * rng.standard_normal(len(t)), s >= 1


def test_a_piston_that_has_stopped_does_not_move_to_and_fro_by_the_noise(make_run):
    """The path of 60 ms slopes is 26 um in the first 0.15 s, and bristles bend by some 100 um."""
    paths, lost = [], []
    for seed in range(20):
        t, x, stopped = stopping(np.random.default_rng(seed))
        run = make_run(duration_s=0.01 * len(t))
        motion = logged_motion(replace(run, t_s=t, x_m=x), 0.0)
        paths.append(np.abs(motion.v_m_s[stopped][:30]).sum() * motion.dt_s)
        lost.append(0.02 - motion.v_m_s.sum() * motion.dt_s)
    assert np.median(paths) < 8e-6
    assert abs(np.median(lost)) < 15e-6  # of 20 mm


def test_a_creep_after_the_stop_is_no_rest(make_run):
    """Its mean velocity is kept."""
    found = []
    for seed in range(10):
        t, x, stopped = stopping(np.random.default_rng(seed), (0.6, 1.5), creep_m_s=50e-6)
        run = make_run(duration_s=0.01 * len(t))
        motion = logged_motion(replace(run, t_s=t, x_m=x), 0.0)
        found.append(motion.v_m_s[stopped][:-30].mean())
    assert np.mean(found) == pytest.approx(50e-6, rel=0.15)
