"""Correction of zeros over time, and what it leaves in the budget, on made-up logs."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.screening.screen import screen
from hbench.analysis.screening.zero_check import (
    closed_part,
    corrected,
    with_zero_checks,
    zero_check,
    zeros_over_time,
)
from hbench.analysis.summary.quality import quality
from hbench.config.schedule import Screening
from hbench.records import LevelReference, Motion, Run, RunPlan, Segment, Specimen, Zero, ZeroCheck

SPECIMEN = Specimen(1.25664e-3, 7.65763e-4, 0.4)
MOTION = Motion(
    0.2, 0.2, 0.2, 0.0, (Segment(0.0, 1.0, 3.0, vented=True), Segment(0.0, 1.0, 2.0, closed=True))
)
LEVEL = LevelReference(2e5, 1e4)


def levelled(noise_pa=300.0, seed=1, level=LEVEL, **errors):
    """Chambers that fall to the tank's 2 bar within a second; sensors with constant errors."""
    t = np.arange(0.0, 5.0, 0.01) + 0.005
    random = np.random.default_rng(seed)
    names = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa")
    pressures = {
        name: 2e5 + 60e5 * np.exp(-t / 0.15) * (name != "p_s_pa") + errors.get(name, 0.0)
        + noise_pa * random.standard_normal(len(t))
        for name in names
    }  # fmt: skip
    force = errors.get("f_applied_n", 0.0) + 2.0 * random.standard_normal(len(t))
    plan = RunPlan("0001", "check", 1, 0.0, SPECIMEN, motion=MOTION, level=level)
    x = np.full(len(t), 0.21)
    return Run(plan, t, x, f_applied_n=force, u_t_v=0 * t, **pressures)


def check_at(time_s, **errors):
    zeros = tuple(Zero(name, error, 2e5) for name, error in errors.items())
    return ZeroCheck(f"at {time_s}", time_s, 2e5, 1e4, zeros)


def test_a_zero_is_the_mean_with_closed_valves_less_the_reference(bench):
    run = levelled(p_tp_pa=1.5e5, p_lr_pa=-0.7e5)
    assert screen(run, Screening()).accepted
    found = {zero.channel: zero for zero in zero_check(run, 0.0, bench).zeros}
    samples = len(run.t_s[closed_part(run)])
    assert samples == 170, "2 s less 0.3 s"
    for name, error in (("p_tp_pa", 1.5e5), ("p_tr_pa", 0.0), ("p_lr_pa", -0.7e5)):
        assert found[name].error == pytest.approx(error, abs=4 * 300 / np.sqrt(samples))
        assert found[name].limit == bench.instruments.pressure.largest == 2e5
    assert "f_applied_n" not in found


def test_a_free_load_cell_has_a_zero_too(bench):
    run = levelled(level=replace(LEVEL, load_cell_free=True), f_applied_n=35.0)
    (force,) = (z for z in zero_check(run, 0.0, bench).zeros if z.channel == "f_applied_n")
    assert force.error == pytest.approx(35.0, abs=1.0) and force.limit == pytest.approx(120.0)


@pytest.mark.parametrize("time_s, expected", [(-5, 1e5), (0, 1e5), (300, 1.25e5), (900, 1.5e5)])
def test_zeros_follow_a_straight_line_from_check_to_check(time_s, expected):
    run = levelled(noise_pa=0.0)
    checks = (check_at(0.0, p_tp_pa=1e5), check_at(600.0, p_tp_pa=1.5e5))
    changed = corrected(run, zeros_over_time(checks), time_s)
    np.testing.assert_allclose(run.p_tp_pa - changed.p_tp_pa, expected)
    assert changed.p_tr_pa is run.p_tr_pa and changed.f_applied_n is run.f_applied_n


def test_without_times_the_mean_zero_counts():
    run = levelled(noise_pa=0.0)
    checks = (check_at(None, p_tp_pa=1e5), check_at(None, p_tp_pa=2e5))
    np.testing.assert_allclose(
        run.p_tp_pa - corrected(run, zeros_over_time(checks), None).p_tp_pa, 1.5e5
    )


def test_the_budget_gets_the_reference_and_the_largest_drift(bench):
    checks = (
        check_at(0.0, p_tp_pa=1e5, p_tr_pa=0.0),
        check_at(9.0, p_tp_pa=1.1e5, p_tr_pa=-0.3e5),
    )
    pressure = with_zero_checks(bench.instruments, checks).pressure
    limits = {name: each.tolerance * pressure.full_scale for name, each in pressure.further.items()}
    assert limits == {"zero reference": pytest.approx(1e4), "zero drift": pytest.approx(0.3e5)}
    assert pressure.further["zero reference"].common and not pressure.further["zero drift"].common
    assert with_zero_checks(bench.instruments, ()) is bench.instruments
    assert with_zero_checks(None, checks) is None


@pytest.mark.parametrize("moved_s", [1.0, 300.0, 599.0])
def test_a_zero_that_moves_at_once_is_off_the_line_by_at_most_the_drift(bench, moved_s):
    run = levelled(noise_pa=0.0)
    checks = (check_at(0.0, p_tp_pa=0.0), check_at(600.0, p_tp_pa=1e5))
    limit = with_zero_checks(bench.instruments, checks).pressure.further["zero drift"]
    off = [
        1e5 * (t > moved_s) - (run.p_tp_pa - corrected(run, zeros_over_time(checks), t).p_tp_pa)[0]
        for t in np.linspace(0.0, 600.0, 601)
    ]
    assert np.abs(off).max() <= limit.tolerance * bench.instruments.pressure.full_scale
    assert np.abs(off).max() >= 0.49e5


@pytest.mark.parametrize(
    "errors, grades",
    [
        ((1e5, 1.1e5), ("good", "good")),
        ((2.5e5, 2.6e5), ("with care", "good")),
        ((-1.5e5, 1.5e5), ("good", "poor")),
    ],
)
def test_zeros_and_their_drift_are_graded_against_the_class(errors, grades):
    checks = tuple(check_at(float(n), p_tp_pa=error) for n, error in enumerate(errors))
    graded = {each.name: each for each in quality((), (), zeros=checks).checks}
    assert (graded["zeros"].grade, graded["zero_drift"].grade) == grades
    assert graded["zeros"].value == pytest.approx(100 * max(map(abs, errors)) / 2e5)


@pytest.mark.parametrize(
    "change, reason",
    [
        ({"p_s_pa": 148e5}, "not_steady: the supply was on, 150.0 bar; limit 10 bar"),
        ({"p_lp_pa": None}, "not_steady: p_lp changed by"),
        ({"x_m": None}, "off_reference: the piston moved by"),
    ],
)
def test_a_check_that_was_not_level_is_rejected(change, reason):
    run = levelled(p_s_pa=change.get("p_s_pa", 0.0))
    if "p_lp_pa" in change:  # a load valve that did not open
        run = replace(run, p_lp_pa=run.p_lp_pa + 40e5 * np.exp(-run.t_s / 20))
    if "x_m" in change:
        run = replace(run, x_m=run.x_m + 2e-3 * (run.t_s > 4))
    reasons = screen(run, Screening()).reasons
    assert len(reasons) == 1 and reasons[0].startswith(reason)
