"""Velocity of a log as a derivative of its position."""

from dataclasses import replace

import numpy as np

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
