"""The two lines against tangents drawn by differences, and their intervals against a draw."""

from dataclasses import replace

import numpy as np
import pytest

from hbench import workflow
from hbench.analysis.fitting.marton_lantos import PARAMETER_UNITS, lines, lines_from_tustin
from hbench.analysis.fitting.tustin import PARAMETER_NAMES
from tests.support.analysis.fits import fit_tustin, stribeck
from tests.support.analysis.other_plant import STEADY

SPEEDS = np.linspace(0.005, 0.2, 15)
TRUTH = (250.0, 500.0, 0.07, 1500.0)
V_MAX = SPEEDS[-1]


def found(make_curve, friction, direction="extend"):
    curve = make_curve(SPEEDS, friction, direction)
    return lines_from_tustin([curve], fit_tustin(curve))


def values(fit):
    return np.array([fit.parameters[name].value for name in PARAMETER_UNITS])


@pytest.mark.parametrize("direction", ["extend", "retract"])
def test_the_lines_touch_the_curve_at_rest_and_at_the_largest_speed(make_curve, direction):
    a_1, b_1, a_2, b_2, _ = values(found(make_curve, stribeck(SPEEDS, *TRUTH), direction))
    h = 1e-6
    assert a_1 == pytest.approx(stribeck(0.0, *TRUTH))
    assert b_1 == pytest.approx((stribeck(h, *TRUTH) - stribeck(0.0, *TRUTH)) / h, rel=1e-4)
    assert a_2 + b_2 * V_MAX == pytest.approx(stribeck(V_MAX, *TRUTH))
    assert b_2 == pytest.approx(
        (stribeck(V_MAX + h, *TRUTH) - stribeck(V_MAX - h, *TRUTH)) / (2 * h)
    )


def test_the_lines_meet_at_the_switch_velocity(make_curve):
    a_1, b_1, a_2, b_2, v_switch = values(found(make_curve, stribeck(SPEEDS, *TRUTH)))
    assert v_switch == pytest.approx((a_1 - a_2) / (b_2 - b_1))  # equation 3.6
    assert 0 < v_switch < V_MAX


def test_the_line_to_draw_is_signed_like_the_curve_and_bends_once(make_curve):
    fit = found(make_curve, stribeck(SPEEDS, *TRUTH), "retract")
    v, friction = np.array(fit.line).T
    assert (v < 0).all() and (friction < 0).all()
    bends = np.abs(np.diff(np.diff(friction) / np.diff(v))) > 1e-3
    assert bends.sum() == 1


@pytest.mark.parametrize("count", [60, pytest.param(150, marks=pytest.mark.slow)])
def test_standard_errors_are_the_scatter_of_repeated_fits(make_curve, count):
    """To first order: a standard deviation is known to 1 / sqrt(2 n), 6 % over 150 draws.

    The limits are 2.6 times that, and of the four parameters' intervals 1.7 times that of ``count``
    independent ones.
    """
    rng = np.random.default_rng(3)
    fits = [
        found(make_curve, stribeck(SPEEDS, *TRUTH) + rng.standard_normal(len(SPEEDS)))
        for _ in range(count)
    ]
    drawn = np.array([values(fit) for fit in fits])
    stated = np.array([[fit.parameters[name].se for name in PARAMETER_UNITS] for fit in fits])
    np.testing.assert_allclose(
        np.sqrt(np.mean(stated**2, axis=0)), drawn.std(axis=0), rtol=2.6 / np.sqrt(2 * count)
    )
    true = values(found(make_curve, stribeck(SPEEDS, *TRUTH)))
    lower, upper = np.moveaxis(
        [[f.parameters[name].ci95 for name in PARAMETER_UNITS] for f in fits], 2, 0
    )
    off = np.mean((lower <= true) & (true <= upper)) - 0.95
    assert abs(off) <= 1.7 * np.sqrt(0.95 * 0.05 / count)


def test_what_the_tustin_fit_says_against_itself_stays_said(make_curve):
    curve = make_curve(SPEEDS, stribeck(SPEEDS, 300, 535, 0.02, 2250))
    tustin = fit_tustin(curve)
    assert tustin.parameters["v_stribeck_m_s"].at_bound == "lower"
    fit = lines_from_tustin([curve], tustin)
    assert fit.message.endswith(tustin.message)
    assert "lower bound" in tustin.message
    assert set(tustin.parameters) == set(PARAMETER_NAMES)


def test_a_line_whose_interval_exceeds_its_value_is_not_determined(make_curve):
    noise = 40.0 * np.random.default_rng(5).standard_normal(len(SPEEDS))
    fit = found(make_curve, stribeck(SPEEDS, 250.0, 500.0, 0.07, 200.0) + noise)
    slope = fit.parameters["high_slope_n_s_m"]
    assert slope.ci95[1] - slope.value > max(abs(slope.value), 0.1 * 500.0 / V_MAX)
    assert "high_slope_n_s_m" in fit.undetermined
    assert fit.parameters["low_force_n"].determination == "determined"
    assert "does not determine" in fit.message.partition("Tustin fit")[0]


def test_the_force_at_rest_has_the_same_error_as_in_the_tustin_fit_weighted_by_trials(make_curve):
    rng = np.random.default_rng(4)
    noise = 60.0 * SPEEDS[:, None] * rng.standard_normal((len(SPEEDS), 3))  # grows with speed
    trials = stribeck(SPEEDS, *TRUTH)[:, None] + noise
    curve = make_curve(SPEEDS, trials.mean(axis=1))
    points = zip(curve.points, trials.tolist(), strict=True)
    curve = replace(curve, points=tuple(replace(p, trials_n=tuple(t)) for p, t in points))
    tustin = fit_tustin(curve)
    stiction = tustin.parameters["f_stiction_n"]
    at_rest = lines_from_tustin([curve], tustin).parameters["low_force_n"]
    assert at_rest.value == stiction.value and at_rest.se == pytest.approx(stiction.se)
    assert at_rest.ci95 == pytest.approx(stiction.intervals["linearised"])


def test_where_the_stribeck_speed_is_at_its_bound_the_switch_velocity_has_no_interval(make_curve):
    noise = np.random.default_rng(1).standard_normal(len(SPEEDS))
    fit = found(make_curve, stribeck(SPEEDS, 300, 535, 0.02, 2250) + noise)
    switch = fit.parameters["v_switch_m_s"]
    assert switch.se is None and switch.ci95 is None and "v_switch_m_s" in fit.message
    assert fit.parameters["low_force_n"].ci95


def test_a_switch_velocity_beyond_the_speeds_is_never_in_its_interval(make_curve):
    """Tangents at rest and at the largest speed of a curve that bends one way meet between."""
    without = 0
    for seed in range(12):
        noise = 3.0 * np.random.default_rng(seed).standard_normal(len(SPEEDS))
        fit = found(make_curve, stribeck(SPEEDS, 200, 300, 0.1, 1500) + noise)
        switch = fit.parameters["v_switch_m_s"]
        assert 0 < switch.value < V_MAX
        if switch.ci95:
            assert 0 <= switch.ci95[0] <= switch.ci95[1] <= V_MAX
        else:
            without += 1
            assert switch.se is None and "v_switch_m_s" in fit.message
    assert 0 < without


NO_SEALS = {  # what a plant file leaves out is the bench file's, so they are set to zero
    "law": "lugre",
    "coulomb": "300 N",
    "stiction": "480 N",
    "stribeck_velocity": "60 mm/s",
    "viscous": "2350 N s/m",
    "bristle_stiffness": "2.6e5 N/m",
    "piston_seal": "0 N/bar",
    "rod_seal": "0 N/bar",
    "scatter": "1 %",
}
VELOCITIES = [f"{v} mm/s" for v in (5, 10, 20, 35, 55, 80, 110, 145, 180, 195)]
WIDE = dict.fromkeys(PARAMETER_NAMES, (-1e5, 1e5)) | {"v_stribeck_m_s": (0.01, 1.0)}


@pytest.mark.slow
def test_the_rigs_lines_lie_in_the_95_percent_intervals_over_many_seeds(rig_campaign):
    """80 curves of 5 values that go together: two standard deviations are about 4 %."""
    inside = []
    schedule = [experiment | {"velocities": VELOCITIES, "trials": 3} for experiment in STEADY]
    for seed in range(100, 120):
        for curve in workflow.analyze(rig_campaign(schedule, seed, NO_SEALS)).curves:
            v_max = max(abs(point.v_m_s) for point in curve.points)
            true = lines(np.array([300.0, 480.0, 0.06, 2350.0]), v_max)
            found = lines_from_tustin([curve], fit_tustin(curve, WIDE)).parameters.values()
            inside += [p.ci95[0] <= t <= p.ci95[1] for p, t in zip(found, true, strict=True)]
    print(f"lines: coverage {sum(inside)} of {len(inside)}")
    assert 0.90 <= np.mean(inside) <= 0.99
