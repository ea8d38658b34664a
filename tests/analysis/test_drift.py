"""Drift of friction over a campaign: its estimate, its test, and the plan that separates it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.curves.average import curves
from hbench.analysis.fitting.fit import CURVE_LAWS, fit_law
from hbench.analysis.fitting.joint import fitted
from hbench.analysis.summary.drift import drift_checks, friction_drift
from hbench.analysis.summary.drift_uncertainty import efficiency_with_drift, with_drift
from hbench.analysis.summary.run_clock import RunClock
from hbench.analysis.uncertainty.budget import with_instruments
from hbench.analysis.uncertainty.efficiency import efficiency_curve
from hbench.config.fitting import Fitting
from hbench.config.sensors import Instruments
from hbench.records import Run, RunPlan, ScreenedRun, Specimen, SteadyMeans
from hbench.records.numbers import NORMAL_95
from tests.support.analysis.chance import binomial_limits

SPEEDS = np.linspace(0.005, 0.2, 8)
STEP_S = 5.0  # from the start of one run to that of the next


def screened(number, v_m_s, trial, friction_n):
    plan = RunPlan(f"{number:04d}", "steady", trial, v_m_s, Specimen(1e-3, 6e-4), f_load_n=500.0)
    means = SteadyMeans(0.0, 1.0, 100, v_m_s, friction_n, friction_n, 0.0, 1e5, 1e5)
    return ScreenedRun(Run(plan, np.zeros(0), np.zeros(0)), (), means)


def campaign(order, friction):
    """Runs of (speed, trial) in ``order``; ``friction(v, t)`` against the motion [N]."""
    return [
        screened(number, v, trial, float(np.sign(v) * friction(abs(v), STEP_S * number)))
        for number, (v, trial) in enumerate(order)
    ]


def times(runs):
    return {run.run.plan.run: STEP_S * number for number, run in enumerate(runs)}


def drift_of(runs, known=None):
    clock = RunClock.of(runs, times(runs) if known is None else known)
    return friction_drift(curves(runs), runs, clock)


def rows(speeds=SPEEDS):
    return [(v, trial) for v in speeds for trial in (1, 2, 3)]


def passes(speeds=SPEEDS):
    return [(v, trial) for trial in (1, 2, 3) for v in speeds]


def both_directions(rng):
    """Three passes over both directions in random order."""
    points = [*SPEEDS, *-SPEEDS]
    return [(v, trial) for trial in (1, 2, 3) for v in rng.permutation(points)]


def level(v):
    return 300.0 + 2000.0 * v


def test_the_estimate_is_that_of_least_squares_with_an_indicator_for_each_point():
    rng = np.random.default_rng(3)
    order = both_directions(rng)
    runs = campaign(order, lambda v, t: level(v) - 0.1 * t + 2.0 * rng.standard_normal())
    drift = drift_of(runs)
    assert (drift.basis, drift.scale, drift.points, drift.trials) == ("time", "absolute", 16, 48)
    points = sorted(set(v for v, _ in order))
    indicators = np.array([[v == point for point in points] for v, _ in order], dtype=float)
    t = STEP_S * np.arange(48)
    y = np.array([run.means.friction_n for run in runs]) * np.sign([v for v, _ in order])
    x = np.column_stack([indicators, t])
    (*_, rate), squares, *_ = np.linalg.lstsq(x, y)
    se = np.sqrt(squares[0] / (48 - 17) * np.linalg.inv(x.T @ x)[-1, -1])
    assert drift.per_hour == pytest.approx(3600 * rate)
    assert drift.per_hour_ci95 == pytest.approx(3600 * se * stats.t.ppf(0.975, 31))
    assert drift.p == pytest.approx(2 * stats.t.sf(abs(rate / se), 31), rel=1e-6)
    assert drift.span_s == STEP_S * 47
    assert drift.change == pytest.approx(drift.per_hour * drift.span_s / 3600)


@pytest.mark.parametrize("count", [100, pytest.param(500, marks=pytest.mark.slow)])
@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("share", [0.0, -0.1])
def test_the_scale_follows_the_scatter_and_the_intervals_contain_the_drift(relative, share, count):
    """Of many campaigns: 95 % of the intervals contain the true change."""
    inside, scales, significant = 0, 0, 0
    for seed in range(count):
        rng = np.random.default_rng(seed)
        order = both_directions(rng)
        span = STEP_S * (len(order) - 1)

        def friction(v, t, rng=rng, span=span):
            scale = level(v) if relative else 500.0
            return level(v) + scale * (share * t / span + 0.015 * rng.standard_normal())

        drift = drift_of(campaign(order, friction))
        mean = (1 + share / 2) if relative else 1 / 500.0  # a share of the point's mean
        true = share / mean if relative else 500.0 * share
        scales += drift.scale == ("relative" if relative else "absolute")
        significant += drift.significant
        if drift.scale == ("relative" if relative else "absolute"):
            inside += abs(drift.change - true) <= drift.change_ci95
    assert scales >= binomial_limits(count, 5 / 6)[0]
    least, most = binomial_limits(scales, 0.95)
    assert least <= inside <= most
    least, most = binomial_limits(count, 0.05, 0.97)
    assert least <= significant <= most if share == 0 else significant > 0.98 * count


@pytest.mark.parametrize(
    ("order", "vif", "share"),
    [
        (rows(), 575 / 8, 21 / 23),
        (passes(), 575 / 512, 7 / 23),
        (passes(SPEEDS[[3, 0, 6, 5, 2, 7, 1, 4]]), 575 / 512, 7 / 23 * 6 / 42),
    ],
)
def test_the_plan_separates_time_from_speed_in_passes_of_mixed_speeds(order, vif, share):
    """Variances in squared steps: (24^2 - 1)/12 of all runs, 2/3 of three in a row, 64 2/3.

    Of the 23 steps, 21 are between the slowest and the fastest speed in rows, and 7 in passes; with
    mixed speeds times the correlation 6/42 of their ranks with their places.
    """
    rng = np.random.default_rng(1)
    drift = drift_of(campaign(order, lambda v, t: level(v) + rng.standard_normal()))
    assert drift.speed_vif == pytest.approx(vif)
    assert drift.speed_share == pytest.approx(share)
    assert drift.separated == (abs(share) < 0.25)


def test_runs_without_times_are_taken_in_their_order():
    rng = np.random.default_rng(1)
    runs = campaign(passes(), lambda v, t: level(v) - 0.1 * t + rng.standard_normal())
    by_order, by_time = drift_of(runs, {}), drift_of(runs)
    assert (by_order.basis, by_order.per_hour, by_order.span_s) == ("order", None, None)
    assert by_order.change == pytest.approx(by_time.change)
    assert by_order.p == pytest.approx(by_time.p)


def test_strokes_of_one_trial_are_one_measurement():
    """Each trial twice, at half the distance in time: the degrees of freedom stay."""
    rng = np.random.default_rng(5)
    runs = campaign(passes(), lambda v, t: level(v) + rng.standard_normal())
    twice = [
        replace(run, run=replace(run.run, plan=replace(run.run.plan, run=f"{number:04d}")))
        for number, run in enumerate(run for run in runs for _ in (0, 1))
    ]
    one, two = drift_of(runs), drift_of(twice)
    assert two.trials == one.trials and two.p == pytest.approx(one.p)


@pytest.mark.parametrize("order", [[(0.1, 1), (0.2, 1), (0.3, 1)], [(0.1, 1), (0.1, 2), (0.1, 3)]])
def test_no_drift_is_estimated_without_two_degrees_of_freedom(order):
    assert drift_of(campaign(order[:2], lambda v, t: level(v))) is None
    assert drift_of([]) is None


def test_trials_without_any_scatter_have_no_drift():
    drift = drift_of(campaign(passes(), lambda v, t: 300.0))
    assert (drift.change, drift.p, drift.significant) == (0.0, 1.0, False)


def test_a_significant_drift_adds_the_deviation_at_the_points_time_to_its_interval():
    """u = |t_i - t| sqrt(d^2 + se^2), about the mean time of the points."""
    rng = np.random.default_rng(2)
    runs = campaign(passes(), lambda v, t: level(v) - 0.5 * t + rng.standard_normal())
    clock = RunClock.of(runs, times(runs))
    before, drift = curves(runs), drift_of(runs)
    (curve,) = with_drift(before, drift, clock)
    se = drift.per_hour_ci95 / 3600 / stats.t.ppf(0.975, 15)
    for place, (point, old) in enumerate(zip(curve.points, before[0].points, strict=True)):
        away = STEP_S * (place - 3.5)
        assert point.sigma_drift_n == pytest.approx(
            away * np.hypot(drift.per_hour / 3600, se), rel=1e-6
        )
        assert point.u95_n == pytest.approx(np.hypot(old.ci95_n, NORMAL_95 * point.sigma_drift_n))
        assert point.ci95_n == old.ci95_n
        of_trials = np.std(old.trials_n, ddof=1) / np.sqrt(old.n)
        whole = np.hypot(of_trials, point.sigma_drift_n)
        assert point.u95_dof == pytest.approx((old.n - 1) * (whole / of_trials) ** 4)
    assert with_drift(before, replace(drift, p=0.06), clock) == before
    assert with_drift(before, None, clock) == before


def test_a_significant_drift_widens_an_efficiency_with_and_without_instruments():
    """Friction is a part of F_T: d(eta) = -F_a / F_T^2 d(F_T) where the hydraulics drive."""
    rng = np.random.default_rng(2)
    runs = campaign(passes(), lambda v, t: level(v) - 0.5 * t + rng.standard_normal())
    clock, drift, f_load_n = RunClock.of(runs, times(runs)), drift_of(runs), 4000.0
    (bare,) = curves(runs)

    def loaded(point):
        f_test_n = f_load_n + point.friction_n
        return replace(
            point,
            f_test_n=f_test_n,
            trials_f_test_n=tuple(f_load_n + trial for trial in point.trials_n),
            f_applied_n=f_load_n,
            p_tp_pa=f_test_n / bare.specimen.area_piston_m2,
            p_tr_pa=0.0,
        )

    before = replace(bare, points=tuple(map(loaded, bare.points)))
    stated = {
        "force": {"tolerance": "0.2 %", "full_scale": "5 kN"},
        "pressure": {"tolerance": "0.2 %", "full_scale": "100 bar"},
    }
    for instruments in (None, Instruments.model_validate(stated)):
        (curve,) = with_drift([with_instruments(before, instruments)], drift, clock)
        old = efficiency_curve(before, instruments)
        (new,) = efficiency_with_drift([old], [curve])
        for was, now, point in zip(old.points, new.points, curve.points, strict=True):
            away = f_load_n / point.f_test_n**2 * abs(point.sigma_drift_n)
            u, half = was.sigma_trials, was.ci95
            if instruments is not None:
                u, half = was.sigma_combined, was.u95
            assert now.u95 == pytest.approx(np.hypot(half, NORMAL_95 * away)) and now.u95 > half
            assert now.sigma_combined == pytest.approx(np.hypot(u, away))


@pytest.mark.parametrize(
    ("percent", "half", "p", "separated", "grade"),
    [
        (3.0, 1.0, 0.001, True, "good"),
        (10.0, 4.0, 0.001, True, "with care"),
        (30.0, 4.0, 0.001, True, "with care"),
        (-10.0, 4.0, 0.001, False, "with care"),
        (-30.0, 4.0, 0.001, False, "poor"),
        (2.0, 4.0, 0.3, True, "good"),
        (2.0, 4.0, 0.3, False, "good"),  # 15 % would have shown
        (2.0, 20.0, 0.8, False, "with care"),
    ],
)
def test_a_drift_is_graded_by_its_size_and_by_the_plan(percent, half, p, separated, grade):
    rng = np.random.default_rng(1)
    drift = replace(
        drift_of(campaign(passes(), lambda v, t: level(v) + rng.standard_normal())),
        change_percent=percent,
        change_percent_ci95=half,
        p=p,
        separated=separated,
    )
    (check,) = drift_checks(drift)
    assert (check.name, check.grade, check.value) == ("drift", grade, abs(percent))
    unknown = drift_checks(replace(drift, basis="order"))
    assert bool(unknown) == (half < 20)  # no claim if neither times nor drift are known
    assert drift_checks(None) == ()


def test_a_drift_widens_the_intervals_of_a_fit_by_what_it_shifts_its_parameters():
    """A fit to points moved by a thousandth of their deviations shows the same shift."""
    rng = np.random.default_rng(4)
    runs = campaign(passes(), lambda v, t: level(v) - 0.5 * t + rng.standard_normal())
    clock, drift = RunClock.of(runs, times(runs)), drift_of(runs)
    (before,) = (fitted(curve, Fitting(weights="equal")) for curve in curves(runs))
    (after,) = with_drift((before,), drift, clock, "equal")
    for old, new in zip(before.fits, after.fits, strict=True):
        if not old.converged:
            continue
        # The same fit to points moved by their deviations shifts its parameters by as much.
        moved = tuple(
            replace(
                point,
                friction_n=point.friction_n + 1e-3 * wider.sigma_drift_n,
            )
            for point, wider in zip(before.points, after.points, strict=True)
        )
        law = CURVE_LAWS[old.law]
        shifted = fit_law(law, [replace(before, points=moved)], Fitting(weights="equal"))
        for name, parameter in old.parameters.items():
            if parameter.ci95 is None or parameter.at_bound is not None:
                continue
            shift = 1e3 * (shifted.parameters[name].value - parameter.value)
            half = parameter.ci95[1] - parameter.value
            wide = new.parameters[name].ci95[1] - parameter.value
            assert wide == pytest.approx(np.hypot(half, NORMAL_95 * shift), rel=0.02)
            assert new.parameters[name].se == parameter.se
        assert "contain the drift" in new.message


def test_a_parameter_whose_interval_a_drift_widens_beyond_its_value_is_not_determined():
    rng = np.random.default_rng(4)

    def friction(v, t):
        tustin = 250.0 + 250.0 * np.exp(-v / 0.05) + 1500.0 * v
        return tustin + 0.05 * t + 0.5 * rng.standard_normal()

    runs = campaign(passes(), friction)
    clock, drift = RunClock.of(runs, times(runs)), drift_of(runs)
    (before,) = (fitted(curve, Fitting(weights="equal")) for curve in curves(runs))
    undetermined = []
    for factor in (1.0, 300.0):
        larger = replace(drift, change=factor * drift.change)
        (after,) = with_drift((before,), larger, clock, "equal")
        fit = next(fit for fit in after.fits if fit.law == "tustin")
        for name, parameter in fit.parameters.items():
            half = (parameter.ci95[1] - parameter.ci95[0]) / 2
            if half > abs(parameter.value):
                assert name in fit.undetermined
        undetermined.append(fit.undetermined)
    assert not undetermined[0] and undetermined[1]


def test_a_drift_over_a_mere_order_that_is_not_separated_from_speed_widens_nothing():
    """Files sorted by speed: neighbours differ by noise, which is no drift of a campaign."""
    rng = np.random.default_rng(2)
    runs = campaign(passes(), lambda v, t: level(v) - 0.5 * t + rng.standard_normal())
    clock, drift = RunClock.of(runs, times(runs)), drift_of(runs)
    by_name = replace(drift, basis="order", separated=False)
    assert with_drift(curves(runs), by_name, clock) == curves(runs)
    known = replace(drift, basis="order", separated=True)
    assert with_drift(curves(runs), known, clock) != curves(runs)


def strokes_of_files(rng, together):
    """Three trials at each speed, out and back in a file; a share of their scatter is common."""
    order = [(v, trial) for trial in (1, 2, 3) for v in SPEEDS]
    runs, files = [], {}
    for file, (v, trial) in enumerate(order):
        common = rng.standard_normal()
        for way in (1, -1):
            error = 5.0 * (common if together else rng.standard_normal())
            run = screened(len(runs), way * v, trial, way * (level(v) + error))
            files[run.run.plan.run] = f"{file}.csv"
            runs.append(run)
    return runs, files


@pytest.mark.parametrize("count", [150, pytest.param(600, marks=pytest.mark.slow)])
@pytest.mark.parametrize("together", [True, False])
def test_strokes_out_and_back_of_one_file_are_one_set_up(together, count):
    """Without a drift, p is below 0.05 in 5 % of campaigns; 10 to 20 % if each stroke counted."""
    rng = np.random.default_rng(8)
    p = []
    for _ in range(count):
        runs, files = strokes_of_files(rng, together)
        drift = friction_drift(curves(runs), runs, RunClock.of(runs, times(runs), files))
        assert (drift.trials, drift.dof) == (48, 24 - 8 - 1)
        p.append(drift.p)
    least, most = binomial_limits(count, 0.05)
    assert least <= np.sum(np.array(p) < 0.05) <= most


def test_strokes_of_a_file_with_several_trials_count_by_themselves():
    rng = np.random.default_rng(9)
    runs, files = strokes_of_files(rng, together=False)
    one_file = dict.fromkeys(files, "all.csv")
    clocks = [RunClock.of(runs, times(runs), each) for each in (one_file, {})]
    of_file, of_runs = (friction_drift(curves(runs), runs, clock) for clock in clocks)
    assert of_file == of_runs
    assert of_runs.dof == 48 - 16 - 1
