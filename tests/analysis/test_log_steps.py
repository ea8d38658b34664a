"""Coarse steps of a log are a part of U, unless noise averages them out."""

import numpy as np
import pytest

from hbench.analysis.screening.log_steps import rounding_error, with_common_steps
from hbench.analysis.screening.screen import screen
from hbench.config.schedule import Screening
from hbench.records import Run, RunPlan, Specimen


def rounded_means(noise, draws=1000, n=2000, seed=1):
    """Return the errors of means of values rounded to whole numbers, at places in between."""
    rng = np.random.default_rng(seed)
    truth = rng.uniform(0, 1, draws)
    values = np.rint(truth[:, None] + noise * rng.standard_normal((draws, n)))
    return values, values.mean(axis=1) - truth


def test_without_noise_the_error_is_that_of_drawn_samples():
    values, errors = rounded_means(noise=0.0)
    stated = np.sqrt(np.mean([rounding_error(each, 1.0) ** 2 for each in values]))
    assert stated == pytest.approx(np.std(errors), rel=0.03)


@pytest.mark.parametrize("noise", [0.1, 0.2, 0.3, 0.4])
def test_with_little_noise_the_stated_error_is_not_too_small(noise):
    values, errors = rounded_means(noise)
    stated = np.sqrt(np.mean([rounding_error(each, 1.0) ** 2 for each in values]))
    by_scatter = np.mean(values.var(axis=1)) / values.shape[1]
    by_rounding = np.sqrt(max(np.mean(errors**2) - by_scatter, 0.0))
    assert 0.95 * by_rounding < stated < np.sqrt(1 / 12)


def test_noise_of_a_step_averages_the_rounding_out():
    values, errors = rounded_means(noise=1.0)
    assert max(rounding_error(each, 1.0) for each in values) < 1e-4
    assert np.std(errors) == pytest.approx(1 / np.sqrt(values.shape[1]), rel=0.1)


def test_values_without_steps_have_no_such_error():
    assert rounding_error(np.array([1.0, 1.0]), 0.0) == 0.0


def steady(run, p_tp_bar, p_tr_bar=6.0):
    """Run at 50 mm/s with the given pressures (n,) in bar, against 1 kN."""
    t = np.arange(0.0, 3.0, 0.01)
    channels = {
        "p_tp_pa": 1e5 * np.broadcast_to(p_tp_bar, t.shape),
        "p_tr_pa": 1e5 * np.broadcast_to(p_tr_bar, t.shape),
        "f_applied_n": np.full(len(t), 1000.0) + np.sin(t),
    }
    plan = RunPlan(run, "steady", 1, 0.05, Specimen(1.25e-3, 0.75e-3, None))
    return screen(Run(plan, t, 0.1 + 0.05 * t, **channels), Screening())


def test_a_sensor_with_one_value_in_a_run_has_the_steps_of_other_runs():
    pressures = np.where(np.arange(300) < 20, 12.0, 14.0)
    coarse, constant = with_common_steps([steady("1", pressures), steady("2", 14.0)])
    assert coarse.means.u_steps == pytest.approx({"p_tp_pa": 2e5 / np.sqrt(12)}, rel=1e-6)
    assert constant.means.u_steps == coarse.means.u_steps


def test_a_known_constant_has_no_steps():
    (alone,) = with_common_steps([steady("1", 14.0, 0.0)])
    assert alone.means.friction_n is not None and alone.means.u_steps == {}
