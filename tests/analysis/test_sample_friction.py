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
