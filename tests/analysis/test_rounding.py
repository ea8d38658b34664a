"""No verdict turns with a last digit: every input is shaken by 1e-13 of itself, no verdict changes.

Another processor adds in another order, so its numbers differ by about that much. The data here is
where rounding would decide if it could: exact curves, laws on their bounds, parameters without any
effect, equal trials, samples and speeds that lie on a limit.
"""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from hbench.analysis.comparison.differences import welch
from hbench.analysis.curves.leakage import chamber_leakage
from hbench.analysis.curves.ramp_tests import ramp_comparisons
from hbench.analysis.curves.surface import friction_surfaces
from hbench.analysis.fitting.fit import fit_law, fits, unfitted_curves
from hbench.analysis.fitting.fit_data import fit_points
from hbench.analysis.fitting.joint import fitted, joint_fits
from hbench.analysis.fitting.marton_lantos import TWO_LINES
from hbench.analysis.fitting.tustin import TUSTIN_LAW
from hbench.analysis.fleet.population import robust_deviations, trend_line
from hbench.analysis.rounding import distinct, exceeds, is_constant, merged, ranked
from hbench.analysis.screening.screen import screen
from hbench.analysis.statistics.intervals import covariance, covariance_over_runs, has_effect
from hbench.analysis.uncertainty.efficiency import SteadyForces, driving_side, efficiency_curve
from hbench.config.campaign_settings import Chambers
from hbench.config.fitting import Fitting
from hbench.config.schedule import Screening
from hbench.records import Run, RunPlan, ScreenedRun, Specimen
from tests.support.analysis.shaking import shaken

SPEEDS = np.linspace(0.005, 0.2, 15)
seeds = st.integers(0, 2**32 - 1)
pure = [HealthCheck.function_scoped_fixture]  # the fixtures return functions without a state
few = settings(max_examples=4, deadline=None, suppress_health_check=pure)
of_fits = settings(max_examples=12, deadline=None, suppress_health_check=pure)
quick = settings(max_examples=60, deadline=None, suppress_health_check=pure)

# F_C, F_s, v_s, B. On the bounds (v_s: the measured speeds), without a Stribeck part, without any
# friction.
TRUTHS = {
    "inside": (250.0, 500.0, 0.07, 1500.0),
    "no Stribeck part": (300.0, 300.0, 0.07, 1000.0),
    "constant": (300.0, 300.0, 0.07, 0.0),
    "F_C at 0": (0.0, 616.0, 0.1, 1341.0),
    "v_s at 5 mm/s": (300.0, 535.0, 0.005, 2250.0),
    "v_s at 200 mm/s": (67.0, 566.0, 0.2, 300.0),
    "B at 0": (400.0, 600.0, 0.08, 0.0),
    "two at their bounds": (0.0, 600.0, 0.2, 500.0),
    "v_s beyond": (300.0, 535.0, 0.002, 2250.0),
    "nothing": (0.0, 0.0, 0.1, 0.0),
}
truths = st.sampled_from(sorted(TRUTHS))
noises = st.sampled_from([0.0, 0.0, 0.3, 3.0])


def curve_of(truth, noise, seed):
    f_c, f_s, v_s, b = TRUTHS[truth]
    friction = f_c + (f_s - f_c) * np.exp(-SPEEDS / v_s) + b * SPEEDS
    return friction + noise * np.random.default_rng(seed).standard_normal(len(SPEEDS))


def with_trials(curve, count, scatter, seed):
    """Return a curve of several trials; without scatter they are equal but for rounding."""
    rng, points = np.random.default_rng(seed), []
    for point in curve.points:
        trials = shaken(point.friction_n + scatter * rng.standard_normal(count), rng.integers(9**9))
        points.append(
            replace(
                point,
                n=count,
                trials=tuple(range(1, count + 1)),
                trials_n=tuple(trials.tolist()),
                trials_f_test_n=tuple((point.f_applied_n + trials).tolist()),
            )
        )
    return replace(curve, points=tuple(points))


def in_words(message):
    return re.sub(r"-?\d+(\.\d+)?(e[-+]\d+)?", "#", message)


def verdict(fit):
    """All that a fit decides; its numbers may change in their last digits."""
    known = {
        name: (p.se is None, p.ci95 is None, p.at_bound, p.disagree, sorted(p.intervals))
        for name, p in fit.parameters.items()
    }
    return fit.converged, known, in_words(fit.message)


# ---- what a fit determines, and which bounds hold it


@pytest.mark.parametrize("law", [TUSTIN_LAW, TWO_LINES], ids=lambda law: law.name)
@of_fits
@example(truth="constant", noise=0.0, loss="linear", seed=85616)
@example(truth="constant", noise=0.3, loss="linear", seed=138)
@example(truth="constant", noise=0.3, loss="huber", seed=3465)
@example(truth="no Stribeck part", noise=0.3, loss="huber", seed=29)
@example(truth="no Stribeck part", noise=0.3, loss="huber", seed=57)
@example(truth="no Stribeck part", noise=3.0, loss="huber", seed=100017)
@example(truth="constant", noise=0.3, loss="huber", seed=100009)
@example(truth="nothing", noise=3.0, loss="linear", seed=44079105)
@given(truth=truths, noise=noises, loss=st.sampled_from(["linear", "huber"]), seed=seeds)
def test_what_a_fit_determines(make_curve, law, truth, noise, loss, seed):
    friction, how = curve_of(truth, noise, seed), Fitting(loss=loss)
    found = fit_law(law, [make_curve(SPEEDS, friction)], how)
    other = make_curve(shaken(SPEEDS, seed), shaken(friction, seed + 1))
    assert verdict(fit_law(law, [other], how)) == verdict(found)


@pytest.mark.parametrize("truth", sorted(TRUTHS))
def test_what_an_exact_fit_determines(make_curve, truth):
    """Every case once, whatever hypothesis draws; and it is what the truth says."""
    friction = curve_of(truth, 0.0, 0)
    found = fit_law(TUSTIN_LAW, [make_curve(SPEEDS, friction)], Fitting())
    for seed in range(5):
        other = make_curve(shaken(SPEEDS, seed), shaken(friction, seed + 9))
        assert verdict(fit_law(TUSTIN_LAW, [other], Fitting())) == verdict(found)
    unknown = [name for name, p in found.parameters.items() if p.se is None and not p.at_bound]
    held = [name for name, p in found.parameters.items() if p.at_bound]
    flat = truth in ("no Stribeck part", "constant", "nothing")
    assert unknown == (["v_stribeck_m_s"] if flat else []) or truth == "v_s beyond"
    assert held == (["v_stribeck_m_s"] if truth == "v_s beyond" else [])


@few
@given(truth=st.sampled_from(["inside", "no Stribeck part"]), scatter=st.just(0.0), seed=seeds)
def test_what_a_bootstrap_disagrees_with(make_curve, truth, scatter, seed):
    how = Fitting(laws=("tustin",), bootstrap=10)
    made = with_trials(make_curve(SPEEDS, curve_of(truth, 0.0, 0)), 3, scatter, seed)
    other = make_curve(shaken(SPEEDS, seed), curve_of(truth, 0.0, 0))
    (found,), (again,) = fits(made, how), fits(with_trials(other, 3, scatter, seed), how)
    assert verdict(again) == verdict(found)


@of_fits
@given(k=st.sampled_from([(300.0, -15.0), (300.0, 0.0), (0.0, -15.0)]), seed=seeds)
def test_what_the_law_of_all_loads_determines(make_curve, k, seed):
    def found(shake):
        curves = []
        for i, (p_p, p_r) in enumerate([(40e5, 30e5), (80e5, 20e5), (30e5, 60e5), (60e5, 110e5)]):
            friction = k[0] * np.exp(k[1] * SPEEDS) + 2000 * SPEEDS + 1.5e-5 * abs(p_p - p_r)
            curve = make_curve(shake(SPEEDS), shake(friction), "extend" if i < 2 else "retract")
            points = tuple(
                replace(point, p_tp_pa=float(shake(p_p)), p_tr_pa=float(shake(p_r)))
                for point in curve.points
            )
            curve = replace(curve, points=points)
            curves.append(replace(curve, fits=fits(curve, Fitting(laws=("tustin",)))))
        (joint,) = joint_fits(curves, Fitting(laws=("pressure_based",)))
        return verdict(joint.fits[0])

    draw = np.random.default_rng(seed)
    assert found(lambda values: shaken(values, draw.integers(9**9))) == found(np.asarray)


@of_fits
@given(truth=truths, noise=noises, seed=seeds)
def test_which_law_predicts_best(make_curve, truth, noise, seed):
    def found(v, friction):
        chosen = fitted(make_curve(v, friction), Fitting()).selection
        return [one.law for one in chosen.laws], chosen.distinguishable

    friction = curve_of(truth, noise, seed)
    assert found(shaken(SPEEDS, seed), shaken(friction, seed + 1)) == found(SPEEDS, friction)


def test_laws_that_both_fit_exactly_are_not_told_apart(make_curve):
    """A straight line is in both."""
    found = fitted(make_curve(SPEEDS, 300 + 1500 * SPEEDS), Fitting()).selection
    assert not found.distinguishable and [one.law for one in found.laws] == [
        "tustin",
        "marton_lantos",
    ]


# ---- ranks


@quick
@given(
    repeats=st.sampled_from([(), (0,), (1,), (0, 1)]),
    zeros=st.booleans(),
    power=st.integers(-8, 8),
    seed=seeds,
)
def test_which_columns_determine_nothing(repeats, zeros, power, seed):
    """Columns that are sums of others, or less than rounding of them; in units of any size."""
    rng = np.random.default_rng(seed)
    matrix, size = rng.standard_normal((40, 3)), np.ones(6)
    copies = [matrix[:, [i]] * 3.0 - matrix[:, [2]] for i in repeats]
    tiny = [np.zeros((40, 1)) if zeros else 1e-14 * rng.standard_normal((40, 1))]
    units = 10.0 ** (power * rng.uniform(-1, 1, 4 + len(repeats)))
    matrix = np.hstack([matrix, *copies, *tiny]) * units
    size, run, residual = 1 / units, np.repeat(np.arange(8), 5), rng.standard_normal(40)
    other = shaken(matrix, seed + 1)
    expected = np.ones(len(units), dtype=bool)
    expected[[i for i in range(3) if not repeats or (i != 2 and i not in repeats)]] = False
    for of in (
        lambda m: covariance(m, residual, has_effect(m, size)),
        lambda m: covariance_over_runs(m, residual, run, has_effect(m, size)).covariance,
    ):
        unknown = np.isnan(np.diag(of(matrix)))
        assert np.array_equal(np.isnan(np.diag(of(other))), unknown)
        assert np.array_equal(unknown, expected)


def test_a_run_that_alone_determines_a_parameter_leaves_it_unknown():
    rng = np.random.default_rng(0)
    matrix, run = rng.standard_normal((40, 2)), np.repeat(np.arange(8), 5)
    matrix[5:, 1] = 1e-14 * rng.standard_normal(35)
    for seed in range(20):
        found, _ = covariance_over_runs(shaken(matrix, seed), rng.standard_normal(40), run)
        assert np.isnan(found[1, 1])


@of_fits
@given(
    loads=st.sampled_from([1, 3]),
    plunger=st.booleans(),
    still=st.booleans(),
    seed=seeds,
)
def test_which_leaks_are_distinguished(bench, loads, plunger, still, seed):
    """Holds at one load, at one pressure of the rod side, and without any leak."""
    rng, cylinder = np.random.default_rng(seed), bench.test_cylinder
    specimen = Specimen(
        cylinder.area_piston_m2, 0.0 if plunger else cylinder.area_rod_m2, cylinder.stroke
    )
    t = (np.arange(300) + 0.5) / 100
    starts = [(60e5, 20e5), (30e5, 85e5), (110e5, 40e5)][:loads]

    def found(shake):
        runs = []
        for number, start in enumerate([one for one in starts for _ in range(2)]):
            fall = 1.0 if still else np.exp(-0.01 * t)
            p_p, p_r = (shake(p * fall + 0 * t) for p in start)
            plan = RunPlan(f"{number:04d}", "hold", 1, 0.0, specimen, f_load_n=0.0)
            x = shake(0.15 + 0 * t)
            p_r = None if plunger else p_r
            runs.append(ScreenedRun(Run(plan, shake(t), x, p_tp_pa=p_p, p_tr_pa=p_r), (), None))
        (found,) = chamber_leakage(runs, Chambers.of(bench))
        return [one.value is None for one in found.coefficients]

    assert found(lambda values: shaken(values, rng.integers(9**9))) == found(np.asarray)


# ---- no scatter


@quick
@given(level=st.floats(1.0, 1e4), count=st.integers(2, 7), equal=st.booleans(), seed=seeds)
def test_whether_trials_scatter(make_curve, level, count, equal, seed):
    rng = np.random.default_rng(seed)
    rows = level * (1 + (0.0 if equal else 0.01) * rng.standard_normal((6, count)))
    assert (welch([(1.0, list(row)) for row in shaken(rows, seed)]) is None) == equal
    made = with_trials(make_curve(SPEEDS, level + 0 * SPEEDS), count, 0.0 if equal else 5.0, seed)
    assert fit_points([made], "trials").weighted == (not equal)


@quick
@given(level=st.floats(0.1, 1e4), count=st.integers(10, 40), seed=seeds)
def test_which_of_equal_campaigns_stand_out(level, count, seed):
    x = shaken(np.full(count, level), seed)
    found = robust_deviations(x, np.zeros(count), float(np.median(x)))
    assert np.array_equal(found.z, np.zeros(count)) and np.all(found.p == 1.0)
    assert trend_line(np.arange(count, dtype=float), x) is None


# ---- limits that samples lie on


@quick
@given(limit=st.sampled_from(["speed", "drift", "travel", "length", "gap", "end"]), seed=seeds)
def test_whether_a_run_on_a_limit_is_accepted(make_run, limit, seed):
    """Each run lies on one limit of the rules, as nearly as a float can."""
    rules = Screening(settle_travel="10 mm", settle_time="0.3 s", max_gap="0.1 s")
    v = 0.05 * (1 + rules.low_speed_error_relative) if limit == "speed" else 0.05
    drift = None
    if limit == "drift":
        drift = lambda t: 40.0 * (t - t[0]) / (1.9 - 0.3) + 0 * t  # noqa: E731
    run = make_run(v, 0.05, drift_n=drift)
    if limit == "length":
        rules = rules.model_copy(update={"min_window": 1.6})
    if limit == "travel":
        rules = rules.model_copy(update={"settle_travel": 0.05 * 0.4})
    if limit == "gap":
        keep = np.arange(len(run.t_s))
        keep = keep[(keep < 100) | (keep > 108)]
        channels = ("t_s", "x_m", "p_tp_pa", "p_tr_pa", "f_applied_n", "at_reference")
        flags = ("sensor_saturated", "valve_saturated")
        run = replace(run, **{name: getattr(run, name)[keep] for name in (*channels, *flags)})
    if limit == "end":
        stroke = float(run.x_m.max()) + rules.end_stop_margin
        run = replace(
            run, plan=replace(run.plan, specimen=replace(run.plan.specimen, stroke_m=stroke))
        )
    other = replace(
        run,
        t_s=shaken(run.t_s, seed),
        x_m=shaken(run.x_m, seed + 1),
        p_tp_pa=shaken(run.p_tp_pa, seed + 2),
        f_applied_n=shaken(run.f_applied_n, seed + 3),
    )
    one, two = screen(run, rules), screen(other, rules)
    assert [in_words(why) for why in one.reasons] == [in_words(why) for why in two.reasons]
    assert (one.means is None) == (two.means is None)
    assert one.means is None or one.means.n == two.means.n


@quick
@given(power=st.sampled_from(["none", "frictionless", "no load", "no pressure"]), seed=seeds)
def test_which_way_the_power_flows(make_curve, power, seed):
    specimen, draw = Specimen(1.25e-3, 0.75e-3, 0.4), np.random.default_rng(seed)
    p_p, p_r = (0.0, 0.0) if power == "no pressure" else (40e5, 20e5)
    f_test = p_p * specimen.area_piston_m2 - p_r * specimen.area_rod_m2
    applied = {"none": 0.9 * f_test, "frictionless": f_test, "no pressure": 0.0}.get(power, 0.0)
    rounded = applied or 1e-13 * f_test * draw.uniform(-1, 1)  # a sum that ought to be zero
    one = driving_side(SteadyForces(0.1, applied, p_p, p_r, specimen))
    two = driving_side(
        SteadyForces(0.1, *(float(shaken(x, seed)) for x in (rounded, p_p, p_r)), specimen)
    )
    assert one[0] == two[0]
    (point,) = make_curve([0.1], [0.0], f_applied_n=2000.0).points
    point = replace(point, f_applied_n=float(shaken(2000.0, seed)))
    curve = replace(make_curve([0.1], [0.0]), points=(point,))
    assert "above 1" not in efficiency_curve(curve, None).points[0].reason


# ---- speeds that are the same


@quick
@given(seed=seeds)
def test_which_speeds_are_the_same(make_curve, seed):
    twice = shaken(np.repeat([0.02, 0.06, 0.12], 3), seed)
    assert len(distinct(twice)) == 3
    curve = make_curve(twice, 300 + 1000 * twice)
    assert fits(curve) == () and " 3 " in unfitted_curves([curve])[0]
    assert fit_points([curve]).speeds == 3
    v = np.array([0.02, 0.06, 0.12, 0.2])
    loads = [make_curve(shaken(v, seed + i), 300 + v, f_applied_n=float(i)) for i in range(3)]
    (found,) = friction_surfaces(loads)
    assert len(found.v_m_s) == 4
    both = [
        replace(with_trials(make_curve(shaken(v, seed + i), 300 + v), 3, 1.0, i), kind=kind)
        for i, kind in enumerate(("ramp", "steady"))
    ]
    assert len(ramp_comparisons(both)) == 2  # the lower and the upper half have two speeds each


# ---- the comparisons themselves


@quick
@given(st.lists(st.integers(-50, 50), min_size=1, max_size=30), st.floats(1e-9, 1e9), seeds)
def test_equal_numbers_are_one_and_ties_keep_their_order(whole, unit, seed):
    exact = np.array(whole) * unit
    values = shaken(exact, seed)
    assert len(distinct(values)) == len(set(whole))
    assert is_constant(values) == (len(set(whole)) == 1)
    assert np.array_equal(
        np.unique(merged(values), return_inverse=True)[1], np.unique(exact, return_inverse=True)[1]
    )
    order = ranked(range(len(whole)), lambda i: values[i], 1e-6 * unit)
    assert order == sorted(range(len(whole)), key=lambda i: -whole[i])
    assert not exceeds(float(shaken(unit, seed)), unit) and exceeds(1.001 * unit, unit)
