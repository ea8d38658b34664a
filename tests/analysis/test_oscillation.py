"""Stick-slip that is faster than 0.1 s means show, in logs that have the position alone.

The plant is a mass on a soft column of oil, driven at a constant flow; its bristles and the flow
are integrated by steps of 0.1 ms.
"""

from dataclasses import replace
from math import copysign, exp

import numpy as np
import pytest

from hbench.analysis.screening.screen import screen
from hbench.config.schedule import Screening
from hbench.records import Run, RunPlan, Specimen

CYLINDER = Specimen(3.1e-3, 2.1e-3, 0.3)
LOAD_N, MASS_KG, BRISTLE_N_M = 1500.0, 40.0, 4e6
RATES = (50, 100, 200, 1000)


def law(v):
    return 260.0 + 160.0 * exp(-v / 0.018) + 1500.0 * v


def driven(v_ref, column_n_m, duration_s=5.0, dt=1e-4):
    """Return position, force of the oil and speed (n,) every ``dt``."""
    x = v = z = 0.0
    force, rows = LOAD_N, []
    for step in range(int(duration_s / dt)):
        flow = v_ref * min(1.0, max(0.0, (step * dt - 0.6) / 0.1))
        level = law(abs(v)) - 1500.0 * abs(v)
        if v:
            end = copysign(level / BRISTLE_N_M, v)
            z = end + (z - end) * exp(-BRISTLE_N_M * abs(v) * dt / level)
        v += dt * (force - LOAD_N - BRISTLE_N_M * z - 1500.0 * v) / MASS_KG
        x += dt * v
        force += dt * column_n_m * (flow - v)
        rows.append((x, force, v))
    return np.array(rows).T


def logged(motion, v_ref, rate_hz, noise_m=4e-6, step_m=0.0, seed=1):
    """Return a foreign run: no velocity is logged, and nothing says when the speed is reached."""
    rng = np.random.default_rng(seed)
    x, force, _ = motion[:, :: round(1e4 / rate_hz)]
    t = np.arange(len(x)) / rate_hz
    x = x + noise_m * rng.standard_normal(len(t))
    if step_m:
        x = step_m * np.round(x / step_m)
    plan = RunPlan("1", "steady", 1, v_ref, CYLINDER, f_load_n=LOAD_N)
    return Run(
        plan=plan,
        t_s=t,
        x_m=x,
        p_tp_pa=(force + 4e5 * CYLINDER.area_rod_m2) / CYLINDER.area_piston_m2,
        p_tr_pa=np.full(len(t), 4e5),
        f_applied_n=np.full(len(t), LOAD_N),
        at_reference=(t > 0.7).astype(float),
    )


@pytest.fixture(scope="module")
def sticking():
    """At 10 mm/s it sticks and slips some eleven times a second."""
    return driven(0.01, 2e5)


@pytest.fixture(scope="module")
def smooth():
    return driven(0.01, 3e7)


@pytest.mark.parametrize("rate_hz", RATES)
def test_fast_stick_slip_is_rejected_since_its_mean_is_not_friction_at_this_speed(
    sticking, rate_hz
):
    moving = sticking[:, 15000:]
    assert np.std(moving[2]) > 0.008 and np.mean(moving[2]) == pytest.approx(0.01, rel=0.03)
    assert np.mean(moving[1]) - LOAD_N < 0.97 * law(0.01)  # what the log would state
    verdict = screen(logged(sticking, 0.01, rate_hz), Screening())
    assert not verdict.accepted
    assert any(reason.startswith("not_steady: the speed over") for reason in verdict.reasons)


@pytest.mark.parametrize("rate_hz", RATES)
@pytest.mark.parametrize(
    ("noise_m", "step_m"), [(4e-6, 0.0), (1e-4, 0.0), (4e-6, 1e-4), (0.0, 5e-4), (3e-5, 2e-5)]
)
def test_noise_and_the_steps_of_a_position_are_no_oscillation(smooth, rate_hz, noise_m, step_m):
    for seed in range(20):
        run = logged(smooth, 0.01, rate_hz, noise_m, step_m, seed)
        reasons = screen(run, Screening()).reasons
        assert not any("oscillates" in reason for reason in reasons), reasons


def test_steps_of_a_position_that_hide_its_ripple_are_named(smooth, sticking):
    """A position rounded to whole millimetres, and a ripple that its steps do not explain."""
    slower = smooth * np.array([[0.55], [1.0], [0.55]])
    rules = Screening(settle_travel="5 mm")
    (reason,) = screen(logged(slower, 0.0055, 100, 0.0, 1e-3), rules).reasons
    assert "varies by" in reason and "as the steps of 1 mm in the position cause; limit" in reason
    slow = replace(logged(sticking, 0.01, 100), at_reference=None)
    jerks = replace(slow, x_m=np.round(slow.x_m + 2e-3 * np.sin(6.0 * slow.t_s), 4))
    (reason, *_) = screen(jerks, Screening()).reasons
    assert "varies by" in reason and "the steps of" not in reason


@pytest.mark.parametrize("rate_hz", [100, 200, 1000])
def test_hum_of_a_position_is_no_oscillation(smooth, rate_hz):
    t = np.arange(smooth.shape[1]) / 1e4
    hum = smooth + np.outer([5e-5, 0.0, 0.0], np.sin(2 * np.pi * 50.0 * t + 0.4))
    reasons = screen(logged(hum, 0.01, rate_hz), Screening()).reasons
    assert not any("oscillates" in reason for reason in reasons), reasons


def test_late_time_stamps_are_no_oscillation(smooth):
    """Of a logger that is late by up to 7 ms for every twentieth sample."""
    rng = np.random.default_rng(2)
    run = logged(smooth, 0.01, 100)
    late = np.where(rng.uniform(size=len(run.t_s)) < 0.05, rng.uniform(3e-3, 7e-3, len(run.t_s)), 0)
    reasons = screen(replace(run, t_s=run.t_s + late), Screening()).reasons
    assert not any("oscillates" in reason for reason in reasons), reasons


def test_the_limit_is_that_of_the_schedule(sticking):
    wide = Screening(speed_oscillation="20 mm/s", speed_ripple="20 mm/s")
    assert screen(logged(sticking, 0.01, 200), wide).accepted
