"""Friction reduced to a reference temperature, on cylinders that do not obey its assumptions.

The oil warms by 19 K in 7.5 min, as in a campaign of 90 runs. Its viscosity follows Vogel's
equation and the reduction takes ASTM D341; dry friction falls with the temperature by itself, or
all friction is one function of viscosity times speed. See ``tests/support/analysis/warming.py``.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.curves.average import curves
from hbench.analysis.fitting.fit import fits
from hbench.analysis.summary.drift import friction_drift
from hbench.analysis.summary.run_clock import RunClock
from hbench.analysis.temperature.hersey import with_hersey
from hbench.analysis.temperature.oil_temperature import NO_VISCOSITY, oil_temperature
from hbench.analysis.temperature.reduction import reduced_curves
from hbench.config.fitting import Fitting
from hbench.config.oil.record import OilRecord
from hbench.config.setup import Setup
from tests.support.analysis.warming import (
    RUN_S,
    SPEEDS,
    ZERO_K,
    Friction,
    data_sheet,
    order_of,
    vogel,
    warm_runs,
    warming,
)

REF_K = 40 + ZERO_K
OIL = data_sheet()
CYLINDERS = {
    "viscous": Friction(),
    "dry falls": Friction(dry_per_k=0.01),
    "film": Friction(film=True),
}


def campaign(order, friction, seed, **how):
    rng = np.random.default_rng(seed)
    return curves(warm_runs(order_of(order, rng), friction, rng, **how))


def reduced(measured, ref_k=REF_K, oil=OIL):
    return reduced_curves(measured, oil, ref_k, None)


def covered(of_curves, friction, interval):
    """Share of points whose interval contains the friction at the reference temperature."""
    inside = [
        abs(curve.against_motion * point.friction_n - friction(abs(point.v_m_s), REF_K))
        <= getattr(point, interval)
        for curve in of_curves
        for point in curve.points
    ]
    return np.mean(inside)


def viscous(curve):
    return fits(curve, Fitting(laws=("tustin",)))[0].parameters["b_viscous_n_s_m"]


@pytest.mark.parametrize("name", CYLINDERS)
def test_in_a_random_order_the_intervals_contain_friction_at_the_reference_temperature(name):
    """1200 points: 92 to 97 %, by intervals a quarter as wide as those of the measured trials."""
    friction = CYLINDERS[name]
    after, narrower = [], []
    for seed in range(40):
        measured = campaign("random", friction, seed)
        effects, at_reference = reduced(measured)
        assert all(effect.determined for effect in effects) and len(at_reference) == 2
        after.append(covered(at_reference, friction, "u95_n"))
        narrower += [
            b.u95_n / a.ci95_n
            for before, reduced_curve in zip(measured, at_reference, strict=True)
            for a, b in zip(before.points, reduced_curve.points, strict=True)
        ]
    print(f"{name}: {100 * np.mean(after):.1f} % of points; interval {np.median(narrower):.2f} of "
          "that of the measured trials (median)")  # fmt: skip
    assert 0.92 < np.mean(after) < 0.97
    assert np.median(narrower) < 0.25


@pytest.mark.parametrize("name", CYLINDERS)
def test_in_a_random_order_viscous_friction_is_that_at_the_reference_temperature(name):
    """10 curves: within 4 % in the mean, and in the root mean square less than a third as far."""
    before, after = [], []
    for seed in range(5):
        measured = campaign("random", CYLINDERS[name], seed)
        _, at_reference = reduced(measured)
        before += [viscous(curve).value / 2400 - 1 for curve in measured]
        after += [viscous(curve).value / 2400 - 1 for curve in at_reference]
    for what, away in (("as measured", before), ("reduced", after)):
        rms = np.sqrt(np.mean(np.square(away)))
        print(f"{name}, {what}: B {100 * np.mean(away):+.1f} %, root mean square {100 * rms:.1f} %")
    assert abs(np.mean(after)) < 0.04
    assert np.mean(np.square(after)) < np.mean(np.square(before)) / 9


@pytest.mark.slow
@pytest.mark.parametrize(("name", "least"), [("viscous", 44), ("dry falls", 34), ("film", 44)])
def test_coverage_of_viscous_friction_at_the_reference_temperature(name, least):
    """50 intervals, which do not include the correction's error, nor what it leaves."""
    inside = 0
    for seed in range(25):
        _, at_reference = reduced(campaign("random", CYLINDERS[name], seed))
        for curve in at_reference:
            low, high = viscous(curve).ci95
            inside += low <= 2400 <= high
    print(f"{name}: {inside} of 50 intervals contain B")
    assert inside >= least


@pytest.mark.parametrize("name", CYLINDERS)
def test_in_rows_of_rising_speed_friction_is_left_alone_and_the_reason_is_given(name):
    """Viscous friction is half of the true one there, at any temperature."""
    away = []
    for seed in range(5):
        measured = campaign("experiments", CYLINDERS[name], seed)
        effects, at_reference = reduced(measured)
        assert not at_reference
        assert all("does not separate temperature from speed" in e.reason for e in effects)
        assert min(effect.speed_vif for effect in effects) > 40
        away += [viscous(curve).value / 2400 - 1 for curve in measured]
    print(f"{name}: B {100 * np.mean(away):+.1f} %")
    assert np.mean(away) < -0.4


def test_the_coefficients_are_those_of_least_squares_with_an_indicator_for_each_point():
    """With the same scatter everywhere, so that the points have equal weights."""
    rng = np.random.default_rng(4)
    runs = warm_runs(order_of("random", rng), Friction(), rng, scatter=0.0, sensor_k=0.0)
    runs = [
        replace(run, means=replace(run.means, friction_n=run.means.friction_n + noise))
        for run, noise in zip(runs, 8.0 * rng.standard_normal(len(runs)), strict=True)
    ]
    effects, _ = reduced(curves(runs))
    extend = next(effect for effect in effects if effect.direction == "extend")
    means = [run.means for run in runs if run.means.v_m_s > 0]
    v = np.array([mean.v_m_s for mean in means])
    r = OIL.viscosity_ratio(np.array([mean.temp_tank_k for mean in means]), REF_K)
    x = np.column_stack([v[:, None] == SPEEDS, r, r * v])
    y = np.array([mean.friction_n for mean in means])
    (*_, dry, slope), squares, *_ = np.linalg.lstsq(x, y)
    dof = len(y) - x.shape[1]
    se = np.sqrt(squares[0] / dof * np.diag(np.linalg.inv(x.T @ x)))[-2:]
    assert (extend.dry_n, extend.viscous_n_s_m) == pytest.approx((dry, slope))
    half = (extend.dry_ci95_n, extend.viscous_ci95_n_s_m)
    assert half == pytest.approx(stats.t.ppf(0.975, dof) * se)
    without = np.linalg.lstsq(x[:, :-2], y)[1][0]
    f = (without - squares[0]) / 2 / (squares[0] / dof)
    assert extend.p == pytest.approx(stats.f.sf(f, 2, dof), rel=1e-6)


def test_scatter_is_that_of_the_trials_at_one_temperature():
    """Without the oil's part the interval of the fastest point is less than half as wide."""
    measured = campaign("random", Friction(), 2)
    _, at_reference = reduced(measured)
    for before, after in zip(measured, at_reference, strict=True):
        assert after.points[-1].ci95_n < 0.5 * before.points[-1].ci95_n
        assert after.points[-1].u95_n > after.points[-1].sigma_temperature_n > 0


def test_a_reference_far_from_the_measured_temperatures_is_refused():
    measured = campaign("random", Friction(), 1)
    effects, at_reference = reduced(measured, ref_k=90 + ZERO_K)
    assert not at_reference
    assert all("too narrow a range to extrapolate to 90.0 °C" in e.reason for e in effects)


def test_oil_of_constant_temperature_needs_no_reduction_and_can_not_be_extrapolated():
    """The sensor's noise alone shows no effect of viscosity."""

    def constant(seconds):
        return 40.0 + ZERO_K

    for seed in range(5):
        measured = campaign("random", Friction(), seed, temperature=constant)
        _, at_reference = reduced(measured)
        for before in measured:
            for after in (c for c in at_reference if c.direction == before.direction):
                change = [b.friction_n - a.friction_n
                          for a, b in zip(before.points, after.points, strict=True)]  # fmt: skip
                assert np.abs(change).max() < 10.0
        _, warmer = reduced(measured, ref_k=45 + ZERO_K)
        assert not warmer


def test_the_hersey_number_is_viscosity_times_speed_over_the_higher_pressure():
    measured = campaign("random", Friction(), 1, sensor_k=0.0)
    for curve in with_hersey(measured, OIL):
        for point in curve.points:
            eta = np.mean(OIL.dynamic_pa_s(np.array(point.trials_temp_k)))
            assert point.hersey_m == pytest.approx(eta * abs(point.v_m_s) / 6e6)
            assert eta == pytest.approx(np.mean(vogel(np.array(point.trials_temp_k))), rel=0.03)
    assert with_hersey(measured, OilRecord(density="880 kg/m^3")) == measured


def test_drift_names_the_temperature_and_vanishes_with_it():
    rng = np.random.default_rng(3)
    runs = warm_runs(order_of("random", rng), Friction(), rng)
    times = {run.run.plan.run: RUN_S * number for number, run in enumerate(runs)}
    clock = RunClock.of(runs, times)
    setup = Setup(None, None, None, OIL)
    measured = curves(runs)
    drift = friction_drift(measured, runs, clock)
    assert drift.significant and drift.temp_correlation < -0.6 and drift.temp_p < 1e-6
    assert drift.temp_change_k == pytest.approx(warming(445) - warming(0), abs=3)
    oil = oil_temperature(measured, runs, setup, Fitting(laws=("tustin",)), clock)
    assert (oil.sensor, oil.runs, oil.reason) == ("temp_tank_k", 90, "")
    assert oil.low_k == pytest.approx(warming(0), abs=1.5)
    assert oil.high_k == pytest.approx(warming(445), abs=1.5)
    assert abs(oil.reduction.drift.change_percent) < 0.3 * abs(drift.change_percent)
    assert all(curve.fits for curve in oil.reduction.curves)


def test_without_a_viscosity_the_temperature_is_reported_with_the_reason():
    rng = np.random.default_rng(3)
    runs = warm_runs(order_of("random", rng), Friction(), rng)
    clock = RunClock.of(runs, {})
    oil = oil_temperature(curves(runs), runs, Setup(None, None, None), Fitting(), clock)
    assert oil.reduction is None and oil.reason == NO_VISCOSITY


def test_runs_without_a_sensor_have_no_temperature():
    rng = np.random.default_rng(3)
    runs = [
        replace(run, means=replace(run.means, temp_tank_k=None))
        for run in warm_runs(order_of("random", rng), Friction(), rng)
    ]
    measured = curves(runs)
    setup = Setup(None, None, None, OIL)
    assert measured[0].temp_range_k is None
    assert oil_temperature(measured, runs, setup, Fitting(), RunClock.of(runs, {})) is None


def test_the_sensor_nearest_to_the_seal_counts_if_all_runs_have_it():
    rng = np.random.default_rng(3)
    runs = warm_runs(order_of("random", rng), Friction(), rng)
    hot = [replace(run, means=replace(run.means, temp_seal_k=350.0)) for run in runs]
    assert {p.temp_k for c in curves(hot) for p in c.points} == {350.0}
    some = [*hot[:-1], runs[-1]]
    assert all(p.temp_k < 330 for c in curves(some) for p in c.points)


def test_a_wrong_viscosity_changes_the_coefficients_and_hardly_the_reduced_friction():
    """An oil of half the true grade, whose viscosity falls by another law."""
    wrong = OilRecord(viscosity={"40 degC": "46 mm^2/s", "100 degC": "6.8 mm^2/s"})
    other, away = [], []
    for seed in range(5):
        measured = campaign("random", Friction(), seed)
        effects, _ = reduced(measured)
        of_wrong, at_reference = reduced(measured, oil=wrong)
        other += [b.viscous_n_s_m / a.viscous_n_s_m
                  for a, b in zip(effects, of_wrong, strict=True)]  # fmt: skip
        away.append(covered(at_reference, Friction(), "u95_n"))
    assert np.mean(other) > 1.1
    assert np.mean(away) > 0.92
