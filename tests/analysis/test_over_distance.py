"""Friction over the distance, from made-up cycles whose friction and distance are known."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.curves.over_distance import SETTLED_WITHIN, distance_trends
from hbench.analysis.screening.screen import screen
from hbench.config.schedule import Screening
from hbench.records import Breakaway, Motion, Run, RunPlan, Series, Specimen

SPECIMEN = Specimen(1.2e-3, 7e-4, 0.4)
AMPLITUDE_M, OMEGA, RATE_HZ = 0.1, 1.5, 100.0
VISCOUS, MASS_KG = 900.0, 40.0
CYCLE_M = 4 * AMPLITUDE_M
MEAN_VISCOUS_N = VISCOUS * AMPLITUDE_M * OMEGA * np.pi / 4  # mean of v^2 over that of |v|


def cycles(number, dry_n, middle_m=0.2, noise_n=0.0, seed=0):
    """Log a run with a cycle for each dry friction [N]; the pressure carries the inertia too."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(len(dry_n) * 2 * np.pi / OMEGA * RATE_HZ)) / RATE_HZ
    phase = OMEGA * t
    x = middle_m - AMPLITUDE_M * np.cos(phase)
    v = AMPLITUDE_M * OMEGA * np.sin(phase)
    a = AMPLITUDE_M * OMEGA**2 * np.cos(phase)
    of_cycle = np.minimum((phase / (2 * np.pi)).astype(int), len(dry_n) - 1)
    friction = np.asarray(dry_n)[of_cycle] * np.sign(v) + VISCOUS * v + MASS_KG * a
    p_tr = np.full(len(t), 20e5)
    f_applied = np.full(len(t), 300.0)
    p_tp = (friction + f_applied + p_tr * SPECIMEN.area_rod_m2) / SPECIMEN.area_piston_m2
    p_tp += noise_n / SPECIMEN.area_piston_m2 * rng.standard_normal(len(t))
    motion = Motion(middle_m - AMPLITUDE_M, 0.0, 0.4, 0.0, ())
    top = AMPLITUDE_M * OMEGA
    plan = RunPlan(f"{number:04d}", "triangle", number, top, SPECIMEN, 0.1, 0.0, 5e5, motion=motion)
    run = Run(plan, t, x, v_m_s=v, p_tp_pa=p_tp, p_tr_pa=p_tr, f_applied_n=f_applied, v_ref_m_s=v)
    return screen(run, Screening())


def test_the_friction_of_a_cycle_and_its_distance_are_those_of_the_closed_form():
    dry = 400.0 + 120.0 * np.exp(-np.arange(12) / 3.0)
    (trend,) = distance_trends([cycles(1, dry)], (), (), ())
    assert trend.values == pytest.approx(dry + MEAN_VISCOUS_N, rel=2e-3)
    assert trend.distance_m == pytest.approx((np.arange(12) + 0.5) * CYCLE_M, rel=5e-3)
    assert trend.direction is None and trend.kind == "triangle"


def test_the_way_back_between_runs_counts():
    """The second run begins 50 mm from the end of the first; its series is the same."""
    runs = [cycles(1, [400.0] * 4), cycles(2, [410.0] * 4, middle_m=0.25)]
    (trend,) = distance_trends(runs, (), (), ())
    assert trend.distance_m[4] == pytest.approx(4.5 * CYCLE_M + 0.05, rel=5e-3)


def test_a_push_has_the_distance_travelled_before_it():
    runs = [cycles(number, [400.0] * 2) for number in range(1, 7)]
    names = tuple(run.run.plan.run for run in runs)
    pushed = Breakaway(
        Series("", 0.0, 5e5), "extend", 10.0, 500.0, 470.0, None, None, 6,
        (480.0, 476.0, 472.0, 468.0, 464.0, 460.0), 1e-3, None, None, 0.0, names,
    )  # fmt: skip
    *_, trend = distance_trends(runs, (), (pushed,), ())
    assert trend.quantity == "breakaway_n" and trend.dwell_s == 10.0
    assert trend.distance_m == pytest.approx(2 * CYCLE_M * np.arange(6), abs=0.02)
    assert trend.slope == pytest.approx(-4.0 / (2 * CYCLE_M), rel=0.01)


@pytest.mark.parametrize(
    ("drop_n", "length_m", "verdict"),
    [(0.0, 5.0, "settled"), (200.0, 1.0, "settled"), (200.0, 8.0, "changing")],
)
def test_run_in_has_settled_when_friction_changes_by_less_than_a_twentieth(
    drop_n, length_m, verdict
):
    """Exponential run-in, no straight line; friction scatters by 1 % from cycle to cycle."""
    rng = np.random.default_rng(5)
    at = (np.arange(20) + 0.5) * CYCLE_M
    truth = 400.0 + drop_n * np.exp(-at / length_m)
    found = []
    for seed in range(10):
        dry = truth + 4.0 * rng.standard_normal(20)
        (trend,) = distance_trends([cycles(1, dry, noise_n=20.0, seed=seed)], (), (), ())
        found.append(trend.verdict)
    change = truth[-1] - truth[10]
    assert (abs(change) < SETTLED_WITHIN * truth[-1]) == (verdict == "settled")
    assert found.count(verdict) >= 9, found


def test_intervals_of_the_last_change_contain_a_linear_change_as_often_as_they_say():
    rng, inside = np.random.default_rng(8), 0
    at = (np.arange(16) + 0.5) * CYCLE_M
    for _ in range(100):
        dry = 400.0 - 6.0 * at + 5.0 * rng.standard_normal(16)
        (trend,) = distance_trends([cycles(1, dry)], (), (), ())
        inside += abs(trend.last_change + 6.0 * (at[-1] - at[8])) <= trend.last_change_ci95
    assert inside >= 90, inside


def test_imported_logs_have_no_trend_since_the_way_between_them_is_not_known():
    run = cycles(1, [400.0] * 8)
    foreign = replace(run, run=replace(run.run, plan=replace(run.run.plan, motion=None)))
    assert distance_trends([run], (), (), ()) != ()
    assert distance_trends([foreign], (), (), ()) == ()


def test_four_values_make_no_trend():
    assert distance_trends([cycles(1, [400.0] * 4)], (), (), ()) == ()
