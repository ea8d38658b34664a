import numpy as np
import pytest

from hbench.model.noise import new_noise
from hbench.model.plant import LEVEL_L, LEVEL_T
from hbench.model.scatter import new_levels, update_levels


@pytest.fixture
def scattering(par):
    def cylinder(c):
        return c._replace(friction=c.friction._replace(scatter=0.05))

    return par._replace(test=cylinder(par.test), load=cylinder(par.load))


def drawn(par, velocities):
    """Return how often the levels changed along the velocities."""
    noise = new_noise(3)
    levels = new_levels(noise, par)
    changes = 0
    for v in velocities:
        before = levels[LEVEL_T]
        update_levels(levels, v, noise, par)
        changes += levels[LEVEL_T] != before
    return changes


def test_each_reversal_draws_once(scattering):
    t = np.arange(0, 3, 1e-3)
    assert drawn(scattering, 0.05 * np.sin(2 * np.pi * t)) == 5


def test_trembling_at_rest_draws_nothing(scattering):
    assert drawn(scattering, 1e-3 * np.sin(np.arange(1000.0))) == 0
    stop_trembling = np.concatenate([np.full(10, 0.05), 1e-3 * np.sin(np.arange(1000.0))])
    assert drawn(scattering, stop_trembling) == 1


def test_a_stop_without_reversal_keeps_the_level(scattering):
    assert drawn(scattering, [0.05, 0.01, 0.0, 0.0, 0.01, 0.05]) == 0


def test_levels_scatter_about_one_in_each_cylinder(scattering):
    noise = new_noise(4)
    levels = np.array([new_levels(noise, scattering) for _ in range(5000)])
    for column in (LEVEL_T, LEVEL_L):
        assert levels[:, column].mean() == pytest.approx(1, abs=4 * 0.05 / np.sqrt(5000))
        assert levels[:, column].std() == pytest.approx(0.05, rel=0.05)
    assert abs(np.corrcoef(levels[:, LEVEL_T], levels[:, LEVEL_L])[0, 1]) < 4 / np.sqrt(5000)
