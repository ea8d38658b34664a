"""Drift of a force's zero: found beside a drift of friction, and a part of U."""

import numpy as np
import pytest

from hbench.analysis.curves.average import curves
from hbench.analysis.summary.drift import friction_drift
from hbench.analysis.summary.drift_uncertainty import with_drift, with_zero_drift
from hbench.analysis.summary.run_clock import RunClock
from hbench.analysis.summary.zero_drift import zero_drift
from hbench.records import Run, RunPlan, ScreenedRun, Specimen, SteadyMeans
from tests.support.analysis.chance import binomial_limits

SPEEDS_M_S = (0.01, 0.03, 0.1)
STEP_S, RUNS = 5.0, 18
LAST_S = STEP_S * (RUNS - 1)
SCATTER_N = 2.0


def level(v):
    return 300.0 + 500.0 * v


def measured(seed, zero_n, friction_share=0.0, one_way=False, in_passes=True):
    """Curves, runs, clock and drift of points in random order; changes are from 0 s on.

    The three trials are passes over all points, or follow one another.
    """
    rng = np.random.default_rng(seed)
    speeds = np.array(SPEEDS_M_S if one_way else [*SPEEDS_M_S, *(-v for v in SPEEDS_M_S)])
    if in_passes:
        order = [(v, trial) for trial in (1, 2, 3) for v in rng.permutation(speeds)]
    else:
        order = [(v, trial) for v in rng.permutation(speeds) for trial in (1, 2, 3)]
    runs, times_s = [], {}
    for number, (v, trial) in enumerate(order):
        name, t = f"{number:04d}", STEP_S * number
        friction = level(abs(v)) * (1 + friction_share * t / LAST_S)
        force = np.sign(v) * friction + zero_n * t / LAST_S + SCATTER_N * rng.standard_normal()
        plan = RunPlan(name, "steady", trial, v, Specimen(1e-3, 6e-4), f_load_n=500.0)
        means = SteadyMeans(0.0, 1.0, 100, v, float(force), float(force), 0.0, 1e5, 1e5)
        runs.append(ScreenedRun(Run(plan, np.zeros(0), np.zeros(0)), (), means))
        times_s[name] = t
    clock = RunClock.of(runs, times_s)
    return curves(runs), runs, clock, friction_drift(curves(runs), runs, clock)


@pytest.mark.parametrize("friction_share", [0.0, -0.1])
def test_its_interval_contains_the_change_beside_a_drift_of_friction(friction_share):
    inside = 0
    for seed in range(100):
        found = zero_drift(*measured(seed, 72.0, friction_share))
        inside += abs(found.change_n - 72.0) <= found.half_n
        assert found.note.startswith("drift: F_T - F_applied changes by")
        assert found.check.value == pytest.approx(100 * abs(found.change_n) / 330, rel=0.1)
        assert found.check.grade == "with care"
    least, most = binomial_limits(100, 0.95)
    assert least <= inside <= most


@pytest.mark.parametrize("friction_share", [0.0, -0.1])
def test_none_is_found_where_only_friction_drifts(friction_share):
    found = [zero_drift(*measured(seed, 0.0, friction_share)) for seed in range(100)]
    assert found == [None] * 100


def test_one_direction_alone_does_not_show_it():
    assert zero_drift(*measured(1, 72.0, one_way=True)) is None


def test_u_then_contains_the_friction_at_the_campaigns_mean_time():
    """Trials that follow one another do not show it in their scatter."""
    inside = {"without": 0, "with": 0}
    for seed in range(60):
        found, runs, clock, drift = measured(seed, 72.0, in_passes=False)
        plain = with_drift(found, drift, clock)
        wider = with_zero_drift(plain, zero_drift(found, runs, clock, drift), clock)
        for name, each in (("without", plain), ("with", wider)):
            for curve in each:
                for point in curve.points:
                    true = curve.against_motion * level(abs(point.v_m_s)) + 36.0
                    half = point.u95_n or point.ci95_n
                    inside[name] += abs(point.friction_n - true) <= half
    print(inside)
    assert inside["without"] < 0.6 * 360 < 0.95 * 360 <= inside["with"]
