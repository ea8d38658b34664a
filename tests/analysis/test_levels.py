"""Velocity steps: settled friction, overshoot and settling, against what the runs were made of."""

import numpy as np
import pytest

from hbench.analysis.curves.average import curves
from hbench.analysis.curves.step_levels import level_runs, step_levels
from hbench.records import ScreenedRun
from tests.support.analysis.moving import TICK_S, levels_velocity, motion_of, moving_run

LEVELS = [0.05, 0.1, -0.05, 0.05]
DWELL_S = 0.8
MASS_KG = 6.0


def smooth(v_ref, tau_s=0.02):
    """The velocity follows with a lag, so that its inertia is finite."""
    v, out = 0.0, np.empty(len(v_ref))
    for i, target in enumerate(v_ref):
        v += (target - v) * TICK_S / tau_s
        out[i] = v
    return out


def steps_run(overshoot_n=0.0, tau_s=0.1, level=1.0, mass_kg=MASS_KG, **options):
    v_ref = levels_velocity(LEVELS, DWELL_S)
    v = smooth(v_ref)
    since = np.arange(len(v)) % round(DWELL_S / TICK_S) * TICK_S
    friction = level * (300 * np.tanh(v / 1e-3) + 2000 * v)
    friction += np.where(v_ref > 0.09, overshoot_n, 0.0) * np.exp(-since / tau_s)
    plan = {"motion": motion_of(LEVELS)} | options.pop("plan", {})
    return moving_run("steps", v, friction, mass_kg, v_ref=v_ref, x0=0.15, plan=plan, **options)


def screened(*runs):
    return [ScreenedRun(run, (), None) for run in runs]


def test_settled_friction_before_and_after_each_step_is_the_laws():
    found = step_levels(screened(steps_run(noise_n=1.0)), MASS_KG)
    assert [(one.number, one.v_to_m_s) for one in found] == list(enumerate(LEVELS, start=1))
    after = [300 * np.sign(v) + 2000 * v for v in LEVELS]
    assert [one.after_n for one in found] == pytest.approx(after, abs=0.8)
    assert found[0].before_n is None
    assert [one.before_n for one in found[1:]] == pytest.approx(after[:-1], abs=0.8)
    assert [one.v_from_m_s for one in found] == [0.0, *LEVELS[:-1]]


def test_an_overshoot_decays_as_it_was_made_and_none_is_seen_where_there_is_none():
    size, tau = 80.0, 0.08
    found = step_levels(screened(steps_run(size, tau, noise_n=1.0)), MASS_KG)
    over = found[1]
    # Friction itself rises by 100 N while the velocity comes up, so the largest is a later one.
    t = np.arange(0, 0.4, 1e-3)
    truth = np.max(size * np.exp(-t / tau) - 100 * np.exp(-t / 0.02))
    assert over.overshoot_n == pytest.approx(truth, abs=4)
    swing = 100 - size  # at the jump; then up to the overshoot, of which a tenth is near
    near = 0.1 * max(truth, swing)
    assert over.settling_s == pytest.approx(tau * np.log(size / near), abs=0.03)
    assert all(one.overshoot_n is None for one in (found[0], found[2], found[3]))


def test_a_swing_below_the_noise_has_no_settling_time():
    v = levels_velocity([0.05, 0.0501], DWELL_S)
    run = moving_run("steps", v, 300 + 0 * v, noise_n=5.0)
    assert step_levels(screened(run), 0.0)[1].settling_s is None


def test_intervals_are_over_trials():
    runs = [
        steps_run(level=level, plan={"trial": trial, "run": f"{trial:04d}"})
        for trial, level in enumerate((0.98, 1.0, 1.04), start=1)
    ]
    found = step_levels(screened(*runs), MASS_KG)
    assert len(found) == 4 and found[0].n == 3 and found[0].runs == ("0001", "0002", "0003")
    spread = np.std(np.array([0.98, 1.0, 1.04]) * 400, ddof=1)
    assert found[0].after_ci95_n == pytest.approx(4.302653 * spread / np.sqrt(3), rel=1e-3)


def test_levels_are_points_of_kind_steps_and_a_repeated_level_counts_once_a_trial():
    found = curves(level_runs(screened(steps_run(noise_n=0.5))))
    assert [(curve.kind, curve.direction) for curve in found] == [
        ("steps", "extend"),
        ("steps", "retract"),
    ]
    extend, retract = found
    assert [point.v_m_s for point in extend.points] == pytest.approx([0.05, 0.1], abs=1e-5)
    assert [point.n for point in extend.points] == [1, 1]
    assert extend.points[0].friction_n == pytest.approx(400, abs=0.5)
    assert retract.points[0].friction_n == pytest.approx(-400, abs=0.5)


def three_trials(overshoots, **options):
    runs = []
    for trial, size in enumerate(overshoots, start=1):
        plan = {"trial": trial, "run": f"{trial:04d}"}
        runs.append(steps_run(size, 0.08, noise_n=1.0, seed=trial, plan=plan, **options))
    return screened(*runs)


def test_overshoot_and_settling_have_intervals_over_trials_and_one_trial_has_none():
    sizes = (70.0, 80.0, 96.0)
    over = step_levels(three_trials(sizes), MASS_KG)[1]
    one_by_one = [step_levels(three_trials([size]), MASS_KG)[1] for size in sizes]
    peaks = [one.overshoot_n for one in one_by_one]
    half = 4.302653 * np.std(peaks, ddof=1) / np.sqrt(3)
    assert over.overshoot_ci95_n == pytest.approx(half, rel=0.3)  # their noise differs
    assert {one.overshoot_ci95_n for one in one_by_one} == {None}
    assert {one.settling_ci95_s for one in one_by_one} == {None}
    assert over.settling_step_s == pytest.approx(0.01)
    assert over.settling_ci95_s >= 0.005, "half a record, even where all trials agree"


def test_without_an_overshoot_in_one_trial_the_remark_says_so():
    over = step_levels(three_trials((80.0, 80.0, 0.0)), MASS_KG)[1]
    assert over.overshoot_n is None
    assert "1 of 3 trials" in over.remark


def test_an_overshoot_beside_a_jumps_inertia_of_its_size_is_not_resolved():
    light = step_levels(three_trials([80.0]), MASS_KG)[1]
    assert light.resolved and light.remark == ""
    heavy = step_levels(three_trials([80.0], mass_kg=20.0), 20.0)[1]
    assert not heavy.resolved and "100 Hz" in heavy.remark
