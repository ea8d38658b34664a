"""What the drifts of two campaigns account for in the differences of their means."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.analysis.comparison.difference_tests import InstrumentPair
from hbench.analysis.comparison.drift_effects import with_drift_effects
from hbench.analysis.comparison.matching import SPEED_TOLERANCE
from hbench.analysis.summary.run_clock import RunClock
from hbench.records import CurveDifference, Difference, Drift

SPEEDS = np.array([0.02, 0.05, 0.1, 0.2])
LOADS_N = (500.0, 5000.0, 9000.0)
DURATION_S = 110.0


def drift(change, change_ci95=0.0, scale="absolute"):
    return Drift(
        "time", scale, change, change_ci95, 0.0, 0.0, None, None, DURATION_S, 0.5, 4, 12, 7, 72.0,
        0.3, False,
    )  # fmt: skip


def campaign(make_curve, level_n, order, change_n=0.0):
    """Return curves in an ``order`` of points, with a drift of ``change_n``, and their clock."""
    times = dict(zip(order, np.linspace(0.0, DURATION_S, len(order)), strict=True))
    curves = []
    for i, load in enumerate(LOADS_N):
        at = np.array([times[i, k] for k in range(len(SPEEDS))])
        made = make_curve(SPEEDS, level_n + 100.0 * i + change_n * at / DURATION_S)
        points = tuple(
            replace(
                point,
                runs=(f"{i}-{k}",),
                trials=(1, 2),
                trials_n=(point.friction_n - 1.0, point.friction_n + 1.0),
            )
            for k, point in enumerate(made.points)
        )
        curves.append(replace(made, f_load_n=load, points=points))
    return curves, RunClock({f"{i}-{k}": t for (i, k), t in times.items()}, True)


def effects(a, b, drift_a, drift_b):
    """Return the effect of each curve and of their mean, and the means' differences."""
    (curves_a, clock_a), (curves_b, clock_b) = a, b
    pairs = []
    for one, other in zip(curves_a, curves_b, strict=True):
        means = [float(np.mean([p.friction_n for p in each.points])) for each in (one, other)]
        mean = Difference(*means, se=1.0, ci95=2.0, u95=3.0, p_value=0.01)
        pairs.append(CurveDifference(one, other, (), mean, None, ()))
    results = (
        SimpleNamespace(curves=curves_a, drift=drift_a),
        SimpleNamespace(curves=curves_b, drift=drift_b),
    )
    unknown = InstrumentPair(None, None, False)
    changed, mean = with_drift_effects(pairs, results, (clock_a, clock_b), unknown, SPEED_TOLERANCE)
    return [each.drift_n for each in changed], mean, [pair.mean_n.value for pair in pairs]


ROWS = [(i, k) for i in range(len(LOADS_N)) for k in range(len(SPEEDS))]


@pytest.mark.parametrize("order", [ROWS, ROWS[::-1], ROWS[6:] + ROWS[:6]])
def test_the_effect_is_what_a_drift_of_known_size_adds_to_the_differences(make_curve, order):
    """Friction at the mean time of a campaign is the level and half of the drift."""
    a = campaign(make_curve, 400.0, ROWS, 12.0)
    b = campaign(make_curve, 430.0, order, -40.0)
    found, mean, differences = effects(a, b, drift(12.0), drift(-40.0))
    at_mean_times = 30.0 - 40.0 / 2 - 12.0 / 2
    added = [difference - at_mean_times for difference in differences]
    assert [each.value_n for each in found] == pytest.approx(added, abs=1e-9)
    assert mean.value_n == pytest.approx(at_mean_times)
    assert mean.drift_n.largest_n == pytest.approx(0.0, abs=1e-9)
    assert mean.half_n == mean.ci95_n


def test_a_drift_that_both_campaigns_have_cancels_in_the_same_order_alone(make_curve):
    a = campaign(make_curve, 400.0, ROWS)
    same, _, _ = effects(a, a, drift(50.0, 8.0), drift(50.0, 6.0))
    other, _, _ = effects(a, campaign(make_curve, 400.0, ROWS[::-1]), drift(50.0), drift(50.0))
    first = (1.5 - 5.5) / 11  # of the first four of twelve points
    assert [each.value_n for each in same] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert [each.ci95_n for each in same] == pytest.approx([-10 * first, 0.0, -10 * first])
    assert other[0].value_n == pytest.approx(-2 * first * 50.0)


def test_a_relative_drift_counts_as_a_share_of_friction(make_curve):
    a, b = (campaign(make_curve, level, ROWS) for level in (400.0, 600.0))
    found, _, _ = effects(a, b, drift(0.0), drift(0.1, 0.02, "relative"))
    first = (1.5 - 5.5) / 11
    assert found[0].value_n == pytest.approx(0.1 * first * 600.0)
    assert found[0].ci95_n == pytest.approx(-0.02 * first * 600.0)


@pytest.mark.parametrize("unknown", [None, replace(drift(1.0), basis="order")])
def test_without_the_drift_of_a_campaign_its_effect_is_not_known(make_curve, unknown):
    """As where the order of undated runs alone is known, and mixes the drift with speed."""
    a, b = (campaign(make_curve, level, ROWS) for level in (400.0, 430.0))
    found, mean, _ = effects(a, b, drift(1.0), unknown)
    assert found == [None, None, None] and mean.drift_n is None
    assert mean.value_n == pytest.approx(30.0) and mean.real
