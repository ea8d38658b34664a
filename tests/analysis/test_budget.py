"""Uncertainty budgets against another library, drawn readings and the limits of their formulas."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.curves.average import student_interval
from hbench.analysis.uncertainty.budget import (
    expanded,
    friction_contributions,
    root_sum_square,
    with_instruments,
)
from hbench.analysis.uncertainty.efficiency import efficiency_curve
from hbench.config.sensors import Instruments

GAINS = {"load cell": 0.01, "piston-side pressure": 0.008, "rod-side pressure": 0.008}


@pytest.fixture
def instruments():
    return Instruments.model_validate(
        {
            "force": {"tolerance": "1.0 %", "of": "reading", "full_scale": "12 kN"},
            "pressure": {"tolerance": "0.8 %", "of": "reading", "full_scale": "250 bar"},
        }
    )


@pytest.fixture
def curve(make_curve):
    """Five speeds, three trials each."""
    speeds = np.array([0.01, 0.03, 0.06, 0.1, 0.19])
    friction = np.array([520.0, 410.0, 380.0, 400.0, 480.0])
    made = make_curve(speeds, friction, f_applied_n=2000.0)
    rng = np.random.default_rng(5)
    points = []
    for point in made.points:
        off = rng.normal(0, 8.0, 3)
        off -= off.mean()
        trials_n = tuple((point.friction_n + off).tolist())
        f_test = tuple((point.f_test_n + off).tolist())
        points.append(replace(point, n=3, trials_n=trials_n, trials_f_test_n=f_test))
    return replace(made, points=tuple(points))


def shared_errors(curve):
    """The readings of each point, with one error for each instrument in all of them."""
    uncertainties = pytest.importorskip("uncertainties")
    gain = {name: uncertainties.ufloat(1.0, sigma) for name, sigma in GAINS.items()}
    areas = curve.specimen
    for point in curve.points:
        f_test = (
            point.p_tp_pa * gain["piston-side pressure"] * areas.area_piston_m2
            - point.p_tr_pa * gain["rod-side pressure"] * areas.area_rod_m2
        )
        yield f_test, point.f_applied_n * gain["load cell"]


def test_the_instruments_part_of_a_mean_is_that_of_the_uncertainties_package(curve, instruments):
    etas = [f_applied / f_test for f_test, f_applied in shared_errors(curve)]
    mean = efficiency_curve(curve, instruments).mean
    expected = sum(etas) / len(etas)
    assert mean.efficiency == pytest.approx(expected.nominal_value, rel=1e-9)
    assert mean.sigma == pytest.approx(expected.std_dev, rel=1e-9)


def test_errors_of_instruments_do_not_average_out_and_those_of_trials_do(curve, instruments):
    found = efficiency_curve(curve, instruments)
    sigmas = [point.sigma for point in found.points]
    of_trials = [point.sigma_trials for point in found.points]
    assert min(sigmas) <= found.mean.sigma <= max(sigmas)
    assert found.mean.sigma_trials == pytest.approx(np.sqrt(np.mean(np.square(of_trials)) / 5))
    assert found.mean.sigma_combined == pytest.approx(
        np.hypot(found.mean.sigma, found.mean.sigma_trials)
    )


def test_frictions_part_is_that_of_the_uncertainties_package(curve, instruments):
    found = with_instruments(curve, instruments)
    for point, (f_test, f_applied) in zip(found.points, shared_errors(curve), strict=True):
        assert point.sigma_instruments_n == pytest.approx((f_test - f_applied).std_dev, rel=1e-9)
        parts = friction_contributions(point, curve.specimen, instruments)
        assert parts["load cell"] == pytest.approx(-0.01 * 2000.0)
        assert root_sum_square(parts) == point.sigma_instruments_n


def test_without_tolerances_a_curve_stays_as_it_is(curve):
    assert with_instruments(curve, None) is curve


def test_together_they_are_students_interval_of_the_trials_or_the_normal_one_of_instruments():
    assert expanded(12.5, 0.0) == 12.5
    assert expanded(0.0, 7.0) == pytest.approx(1.959964 * 7.0)


@pytest.mark.parametrize("ratio", [0.2, 1.0, 5.0])  # instruments' error over one trial's
def test_the_interval_of_trials_and_instruments_holds_the_truth(ratio):
    rng = np.random.default_rng(1)
    trials = rng.standard_normal((20_000, 3)) + ratio * rng.standard_normal((20_000, 1))
    held = [abs(t.mean()) <= expanded(student_interval(t), ratio) for t in trials]
    assert 0.95 < np.mean(held) < 0.98
