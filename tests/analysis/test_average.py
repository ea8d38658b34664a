"""Averages and Student intervals, against tables, hand numbers and simulated coverage."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.stats

from hbench.analysis.curves.average import curves, student_interval
from hbench.analysis.screening.screen import screen
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.summary.quality import quality
from hbench.analysis.uncertainty.efficiency import efficiency_curve
from hbench.report.campaign.quality.verdict import quality_verdict


@pytest.fixture
def trial(make_run, rules):
    """Return a function that makes a screened run with a given friction."""

    def make(friction_n, number, v=0.1, run="0001", f_load_n=2000.0, label="", p_lr=None):
        made = make_run(v_m_s=v, friction_n=friction_n, trial=number, f_applied_n=f_load_n)
        plan = replace(made.plan, run=run, label=label, p_lr_ref_pa=p_lr)
        return screen(replace(made, plan=plan), rules)

    return make


def test_student_factors_are_the_printed_ones():
    printed = {1: 12.706, 2: 4.303, 3: 3.182, 9: 2.262, 30: 2.042}
    for dof, factor in printed.items():
        assert student_factor(dof) == pytest.approx(factor, abs=5e-4)
        assert student_factor(dof) == pytest.approx(scipy.stats.t.ppf(0.975, dof), rel=1e-9)


def test_the_interval_of_three_trials_uses_two_degrees_of_freedom():
    # S = 10 N, so t S / sqrt(3) = 4.303 * 5.774 N.
    assert student_interval(np.array([390.0, 400.0, 410.0])) == pytest.approx(24.84, abs=0.01)


def test_one_trial_has_no_interval():
    assert student_interval(np.array([400.0])) is None


@pytest.mark.parametrize("n", [2, 3, 5])
def test_the_interval_covers_the_truth_in_95_of_100(n):
    rng = np.random.default_rng(n)
    samples = 400 + 15 * rng.standard_normal((2000, n))
    covered = [abs(s.mean() - 400) <= student_interval(s) for s in samples]
    assert abs(np.mean(covered) - 0.95) < 0.015


def test_a_point_averages_its_trials(trial):
    (curve,) = curves([trial(f, i) for i, f in enumerate([390, 400, 410], start=1)])
    (point,) = curve.points
    assert point.friction_n == pytest.approx(400)
    assert point.ci95_n == pytest.approx(24.84, abs=0.01)
    assert point.n == 3
    assert point.trials_n == pytest.approx((390, 400, 410))
    assert point.trials_f_test_n == pytest.approx((2390, 2400, 2410))
    assert point.f_test_n - point.f_applied_n == pytest.approx(point.friction_n)


def test_strokes_of_one_trial_count_once(trial):
    strokes = [trial(f, n) for n, f in ((1, 380), (1, 400), (2, 400), (3, 410), (3, 410), (3, 410))]
    (point,) = curves(strokes)[0].points
    assert point.trials_n == pytest.approx((390, 400, 410))
    assert point.n == 3 and len(point.runs) == 6
    assert point.ci95_n == pytest.approx(24.84, abs=0.01)


def test_rejected_runs_do_not_count(trial):
    good = [trial(f, i) for i, f in enumerate([390, 410], start=1)]
    bad = replace(trial(900, 3), reasons=("end_stop: there",))
    (point,) = curves([*good, bad])[0].points
    assert point.n == 2 and point.friction_n == pytest.approx(400)


def test_curves_are_parted_by_direction_load_and_label_and_sorted_by_speed(trial):
    runs = [
        trial(400, 1, v=0.1),
        trial(400, 1, v=0.05),
        trial(400, 1, v=-0.1),
        trial(400, 1, v=-0.02),
        trial(400, 1, v=0.1, f_load_n=500.0),
        trial(400, 1, v=0.1, label="other seal"),
    ]
    found = curves(runs)
    assert [(c.direction, c.f_load_n, c.label, len(c.points)) for c in found] == [
        ("extend", 500.0, "", 1),
        ("extend", 2000.0, "", 2),
        ("retract", 2000.0, "", 2),
        ("extend", 2000.0, "other seal", 1),
    ]
    assert [p.v_m_s for p in found[1].points] == pytest.approx([0.05, 0.1])
    assert [p.v_m_s for p in found[2].points] == pytest.approx([-0.02, -0.1])
    assert [p.friction_n for p in found[2].points] == pytest.approx([-400, -400])


def test_series_of_a_label_are_in_the_order_of_direction_and_size_of_load(trial):
    """Runs may have a random order, and files that of their names: −5000 before −500."""
    loads = (-5000.0, 500.0, -500.0, 5000.0)
    runs = [trial(400, 1, v=np.copysign(0.1, load), f_load_n=load) for load in loads]
    assert all(run.run.plan.motion is None for run in runs)  # as imported
    found = [(curve.direction, curve.f_load_n) for curve in curves(runs)]
    assert found == [
        ("extend", 500.0), ("extend", 5000.0), ("retract", -500.0), ("retract", -5000.0),
    ]  # fmt: skip


def test_rod_side_pressures_of_the_load_are_curves_of_their_own(trial):
    found = curves([trial(f, 1, p_lr=p) for p, f in ((15e5, 400), (60e5, 600), (None, 500))])
    assert [(c.p_lr_ref_pa, len(c.points)) for c in found] == [(15e5, 1), (60e5, 1), (None, 1)]
    assert [c.points[0].friction_n for c in found] == pytest.approx([400, 600, 500])
    assert [efficiency_curve(curve, None).p_lr_ref_pa for curve in found] == [15e5, 60e5, None]


def test_a_load_cell_that_contradicts_the_nominal_load_makes_the_data_of_care(make_run, rules):
    def found(*loads_n, nominal_n=2000.0, p_lr=None):
        runs = []
        for number, load_n in enumerate(loads_n, start=1):
            run = make_run(f_applied_n=load_n, trial=number)
            plan = replace(run.plan, run=f"{number:04d}", f_load_n=nominal_n, p_lr_ref_pa=p_lr)
            runs.append(screen(replace(run, plan=plan), rules))
        return quality(runs, curves(runs))

    tared = found(0.0, 3.0, 2000.0)
    (check,) = [c for c in tared.checks if c.name == "nominal_load"]
    assert (check.grade, check.count, check.of) == ("with care", 2, 3)
    assert check.value == pytest.approx(100, rel=1e-3) and tared.grade != "good"
    assert "in 2 of 3 runs the load cell differs from the nominal load" in quality_verdict(tared)
    (in_kn,) = [c for c in found(2.0, 2.0).checks if c.name == "nominal_load"]
    assert in_kn.value == pytest.approx(99.9, abs=1e-6)
    unsigned = found(-2000.0, 1700.0)  # a name has no sign; friction of a load cylinder
    by_pressure, no_load = found(100.0, p_lr=15e5), found(40.0, nominal_n=0.0)
    for right in (unsigned, by_pressure, no_load):
        assert not any(check.name == "nominal_load" for check in right.checks)


def test_runs_of_different_loads_without_a_nominal_load_make_the_data_poor(make_run, rules):
    def verdict(*loads_n, nominal=False):
        runs = []
        for number, load_n in enumerate(loads_n, start=1):
            run = make_run(f_applied_n=load_n, trial=number)
            f_load_n = load_n if nominal else None
            plan = replace(run.plan, run=f"{number:04d}", f_load_n=f_load_n)
            runs.append(screen(replace(run, plan=plan), rules))
        return quality(runs, curves(runs))

    (mixed,) = [c for c in verdict(2000, 2000, 6000).checks if c.name == "load_spread"]
    assert (mixed.grade, mixed.count, mixed.of) == ("poor", 1, 1)
    assert mixed.value == pytest.approx(100 * 4000 / 6000, rel=1e-6)
    words = quality_verdict(verdict(2000, 2000, 6000))
    assert "at 1 of 1 points runs of different loads are averaged" in words and "66.7 %" in words
    for same in (verdict(2000, 2050, 1990), verdict(-30, 5, 9), verdict(2000, 6000, nominal=True)):
        assert not any(check.name == "load_spread" for check in same.checks)
