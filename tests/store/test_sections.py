"""Runs of imported files: the top speed of motions that are not steady."""

import numpy as np
import pytest

from hbench.store.importing.sections import _top_speed


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_triangle_has_the_sign_of_its_first_motion_whatever_the_noise(direction):
    t_s = np.arange(0, 12, 0.002)
    cycle = np.abs((t_s / 2 + 1) % 2 - 1)  # up in 2 s, down in 2 s
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0, 2e-5, len(t_s))
        x_m = 0.15 + direction * 0.04 * cycle + noise
        found = _top_speed({"t_s": t_s, "x_m": x_m}, "triangle", None)
        assert found == pytest.approx(direction * 0.02, rel=0.05)
        assert _top_speed({"t_s": t_s, "x_m": x_m}, "triangle", 0.02) == direction * 0.02


def test_a_log_without_motion_has_no_speed():
    t_s = np.arange(0, 1, 0.01)
    assert _top_speed({"t_s": t_s, "x_m": np.zeros(100)}, "triangle", None) == 0.0
