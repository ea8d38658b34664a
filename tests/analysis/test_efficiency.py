"""Efficiency and its uncertainty, against hand numbers, Monte Carlo and another library."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.screening.screen import screen
from hbench.analysis.summary.headline import headline
from hbench.analysis.uncertainty.budget import root_sum_square
from hbench.analysis.uncertainty.efficiency import (
    SteadyForces,
    driving_side,
    efficiency_curve,
    efficiency_of,
    efficiency_parts,
)
from hbench.analysis.uncertainty.input_errors import MeasuredForces, input_errors
from hbench.config.sensors import Instruments
from hbench.records import Specimen

SPECIMEN = Specimen(1.25e-3, 0.75e-3, 0.4)


def instruments(of="reading"):
    return Instruments.model_validate(
        {
            "force": {"tolerance": "1.0 %", "of": of, "full_scale": "12 kN"},
            "pressure": {"tolerance": "0.8 %", "of": of, "full_scale": "250 bar"},
        }
    )


def forces(v, f_applied, friction, p_tr=20e5):
    """Steady motion with a friction (positive number) against it."""
    f_test = f_applied + np.sign(v) * friction
    return SteadyForces(v, f_applied, (f_test + p_tr * 0.75e-3) / 1.25e-3, p_tr, SPECIMEN)


def instrument_sigma(state, tolerances):
    """As printed: tolerances are standard uncertainties."""
    measured = MeasuredForces(state.f_applied_n, state.p_tp_pa, state.p_tr_pa)
    errors = input_errors(tolerances.as_printed, measured, state.specimen)
    return root_sum_square(efficiency_parts(state, errors))


HYDRAULICS = forces(0.1, 2000.0, 400.0)  # eta = 2000/2400
LOAD = forces(-0.1, 2000.0, 400.0)  # the load pushes the piston in; eta = 1600/2000


def test_both_flows_of_power_by_hand():
    assert driving_side(HYDRAULICS)[0] == "hydraulics"
    assert efficiency_of(HYDRAULICS) == pytest.approx(2000 / 2400)
    assert driving_side(LOAD)[0] == "load"
    assert efficiency_of(LOAD) == pytest.approx(1600 / 2000)


def test_retracting_against_a_pulling_load_the_hydraulics_drive():
    against = forces(-0.1, -2000.0, 400.0, p_tr=80e5)
    assert driving_side(against)[0] == "hydraulics"
    assert efficiency_of(against) == pytest.approx(2000 / 2400)


@pytest.mark.parametrize("v", [0.05, -0.05])
@pytest.mark.parametrize("f_applied", [-3000.0, -1000.0, -200.0, 0.0, 200.0, 1000.0, 3000.0])
def test_passive_friction_never_gives_an_efficiency_above_one(v, f_applied):
    state = forces(v, f_applied, 400.0, p_tr=80e5)
    value = efficiency_of(state)
    f_test = state.f_test_n
    both_dissipate = np.sign(f_applied) != np.sign(f_test)
    assert (value is None) == both_dissipate
    if value is not None:
        power_in = max(abs(f_applied * v), abs(f_test * v))
        assert 0 < value < 1
        assert (1 - value) * power_in == pytest.approx(400 * abs(v))  # what friction takes


def test_a_driving_force_lost_in_the_pressures_is_left_out():
    # F_T = 110 N is the difference of two forces of about 3000 N.
    state = forces(0.1, 10.0, 20.0, p_tr=40e5)
    side, reason = driving_side(state)
    assert side is None and "30 N" in reason and "60 N" in reason


def test_sigma_of_reading_by_hand():
    # F_T = 2400, P_Tp A_p = 3900, P_Tr A_r = 1500: relative 1 %, 1.3 %, 0.5 % of eta.
    expected = 2000 / 2400 * np.sqrt(0.01**2 + (0.008 * 3900 / 2400) ** 2 + 0.005**2)
    assert instrument_sigma(HYDRAULICS, instruments()) == pytest.approx(expected, rel=1e-12)


def test_sigma_of_full_scale_by_hand():
    parts = [120 / 2400, 2000 / 2400**2 * 2e5 * 1.25e-3, 2000 / 2400**2 * 2e5 * 0.75e-3]
    expected = np.sqrt(np.sum(np.square(parts)))
    assert instrument_sigma(HYDRAULICS, instruments("full_scale")) == pytest.approx(expected)


@pytest.mark.parametrize("of", ["reading", "full_scale"])
@pytest.mark.parametrize("state", [HYDRAULICS, LOAD])
def test_sigma_agrees_with_the_uncertainties_package(state, of):
    uncertainties = pytest.importorskip("uncertainties")
    tolerances = instruments(of)

    def measured(value, instrument):
        base = abs(value) if of == "reading" else instrument.full_scale
        return uncertainties.ufloat(value, instrument.tolerance * base)

    f_applied = measured(state.f_applied_n, tolerances.force)
    p_tp = measured(state.p_tp_pa, tolerances.pressure)
    p_tr = measured(state.p_tr_pa, tolerances.pressure)
    f_test = p_tp * SPECIMEN.area_piston_m2 - p_tr * SPECIMEN.area_rod_m2
    eta = f_applied / f_test if state is HYDRAULICS else f_test / f_applied
    assert instrument_sigma(state, tolerances) == pytest.approx(eta.std_dev, rel=1e-9)
    assert efficiency_of(state) == pytest.approx(eta.nominal_value)


@pytest.mark.parametrize("state", [HYDRAULICS, LOAD])
def test_sigma_is_the_scatter_of_drawn_readings(state):
    rng = np.random.default_rng(0)
    n = 200_000
    f_applied = state.f_applied_n * (1 + 0.01 * rng.standard_normal(n))
    piston = state.piston_n * (1 + 0.008 * rng.standard_normal(n))
    rod = state.rod_n * (1 + 0.008 * rng.standard_normal(n))
    eta = f_applied / (piston - rod)
    scatter = np.std(eta if state is HYDRAULICS else 1 / eta)
    assert instrument_sigma(state, instruments()) == pytest.approx(scatter, rel=0.01)


def test_a_side_without_area_takes_no_part():
    plunger = SteadyForces(0.1, 2000.0, 2400.0 / 1.25e-3, None, Specimen(1.25e-3, 0.0))
    assert efficiency_of(plunger) == pytest.approx(2000 / 2400)
    expected = 2000 / 2400 * np.hypot(0.01, 0.008)
    assert instrument_sigma(plunger, instruments()) == pytest.approx(expected)


def test_points_of_a_curve(make_curve):
    curve = make_curve([0.05, 0.1], [500.0, 400.0], f_applied_n=2000.0)
    found = efficiency_curve(curve, instruments())
    assert (found.direction, found.f_load_n) == ("extend", 2000.0)
    assert [point.efficiency for point in found.points] == pytest.approx([0.8, 2000 / 2400])
    printed = instrument_sigma(HYDRAULICS, instruments())
    assert found.points[1].sigma_as_printed == pytest.approx(printed)
    assert found.points[1].sigma == pytest.approx(printed / np.sqrt(3))
    assert found.points[0].sigma_trials is None and found.points[0].reason == ""


def test_retracting_under_a_pushing_load_the_load_drives(make_curve):
    found = efficiency_curve(make_curve([0.1], [400.0], "retract", 2000.0), instruments())
    assert found.points[0].efficiency == pytest.approx(0.8)
    assert found.points[0].v_m_s == -0.1


def test_points_without_flow_of_power_carry_a_reason(make_curve):
    found = efficiency_curve(make_curve([0.1], [400.0], "retract", 200.0), instruments())
    point = found.points[0]
    assert point.efficiency is None and point.sigma is None
    assert "-200 N" in point.reason and " 200 N" in point.reason


def test_forces_that_both_take_power_out_have_no_efficiency(make_curve):
    point = efficiency_curve(make_curve([0.1], [-2500.0]), instruments()).points[0]
    assert point.efficiency is None
    assert "-500 N" in point.reason and "2000 N" in point.reason


def test_friction_in_the_direction_of_motion_is_called_a_fault(make_curve):
    point = efficiency_curve(make_curve([0.1], [-100.0]), instruments()).points[0]
    assert point.efficiency == pytest.approx(2000 / 1900)
    assert "above 1" in point.reason


def test_another_benchs_log_has_no_sigma_and_says_so(make_curve):
    point = efficiency_curve(make_curve([0.1], [400.0]), None).points[0]
    assert point.efficiency == pytest.approx(2000 / 2400)
    assert point.sigma is None and "tolerances" in point.reason


@pytest.mark.parametrize("direction", ["extend", "retract"])
def test_the_trials_part_is_the_standard_error_of_their_efficiencies_and_students_interval(
    make_curve, direction
):
    sign = 1 if direction == "extend" else -1
    curve = make_curve([0.1], [400.0], direction)
    f_test, f_applied = np.array([2390.0, 2400.0, 2430.0]), np.array([2000.0, 2010.0, 1990.0])
    if sign < 0:
        f_test = f_test - 800
    point = replace(
        curve.points[0],
        n=3,
        trials_n=tuple(f_test - f_applied),
        trials_f_test_n=tuple(f_test),
    )
    eta = f_applied / f_test if sign > 0 else f_test / f_applied
    found = efficiency_curve(replace(curve, points=(point,)), None).points[0]
    assert found.sigma_trials == pytest.approx(np.std(eta, ddof=1) / np.sqrt(3))
    low, high = stats.t.interval(0.95, 2, eta.mean(), stats.sem(eta))
    assert found.ci95 == pytest.approx((high - low) / 2) and found.u95 is None
    known = efficiency_curve(replace(curve, points=(point,)), instruments()).points[0]
    assert known.ci95 == found.ci95
    combined = np.hypot(found.sigma_trials, known.sigma)
    dof = combined**4 / (found.sigma_trials**4 / 2)  # JCGM 100, G.2b
    assert known.u95_dof == pytest.approx(dof)
    assert known.u95 == pytest.approx(stats.t.ppf(0.975, dof) * combined)


def test_a_trial_without_load_leaves_the_trials_part_unknown(make_curve):
    curve = make_curve([0.1], [400.0], "retract")
    point = replace(
        curve.points[0], n=2, trials_n=(-100.0, -100.0), trials_f_test_n=(-100.0, 400.0)
    )
    found = efficiency_curve(replace(curve, points=(point,)), None).points[0]
    assert found.efficiency is not None
    assert found.sigma_trials is None and found.ci95 is None


@pytest.mark.parametrize(("v", "expected"), [(0.1, 2000 / 2400), (-0.1, 1600 / 2000)])
def test_a_screened_run_carries_its_efficiency(make_run, rules, v, expected):
    run = make_run(v_m_s=v, friction_n=400.0, f_applied_n=2000.0)
    assert screen(run, rules).means.efficiency == pytest.approx(expected)


def test_the_headline_has_no_efficiency_without_load_and_the_curve_keeps_it(make_curve):
    for load, stated in ((2000.0, True), (0.0, False)):
        curve = replace(make_curve([0.05, 0.1], [500.0, 400.0], f_applied_n=200.0), f_load_n=load)
        shares = efficiency_curve(curve, instruments())
        (series,) = headline([curve], [shares]).series
        assert all(point.efficiency is not None for point in shares.points)
        assert (series.efficiency is not None) == stated and series.friction_n is not None
