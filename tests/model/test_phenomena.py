"""Phenomena of friction: the defining property of each, against closed forms worked out here."""

from dataclasses import fields

import numpy as np
import pytest

from hbench.model.parameters import FrictionParameters
from hbench.studies.catalogue import PHENOMENA
from hbench.studies.phenomena import lag, presliding, stick_slip
from hbench.studies.phenomena.driven_friction import driven_mass, prescribed_friction
from hbench.studies.phenomena.laws import LEUVEN, LUGRE, TUSTIN
from tests.support import shared

F_C, F_S, V_S, B = 300.0, 500.0, 0.03, 2500.0
LAWS_ALONE = ("stribeck", "lag", "presliding", "stick-slip", "breakaway")


@pytest.fixture(scope="module")
def shown():
    return shared.once("phenomena", lambda: {name: PHENOMENA[name]({}) for name in LAWS_ALONE})


def found(phenomenon, quantity):
    return next(f.simulated for f in phenomenon.findings if f.quantity == quantity)


def test_the_shared_curve_is_the_one_of_these_tests():
    for law in (TUSTIN, LUGRE, LEUVEN):
        assert (law.coulomb, law.stiction, law.stribeck_velocity, law.viscous) == (F_C, F_S, V_S, B)


def test_the_stribeck_minimum_lies_where_its_slope_vanishes(shown):
    v_min = V_S * np.log((F_S - F_C) / (B * V_S))
    stribeck = shown["stribeck"]
    (speed,) = (f.simulated for f in stribeck.findings if f.unit == "mm/s")
    assert speed == pytest.approx(1e3 * v_min, rel=1e-3)
    assert found(stribeck, "least friction") == pytest.approx(F_C + B * (V_S + v_min), rel=1e-6)


def test_the_laws_with_a_state_settle_on_the_curve_in_all_regimes(shown):
    for line in shown["stribeck"].panels[0].lines[1:]:
        v = line.x / 1e3
        curve = F_C + (F_S - F_C) * np.exp(-v / V_S) + B * v
        np.testing.assert_allclose(line.y, curve, rtol=2e-3)


def test_friction_is_larger_while_accelerating_and_a_static_law_has_no_loop():
    for f in (0.05, 0.2, 1.0):
        assert lag.lag_width(f, LUGRE) > 0.3 and lag.lag_width(f, LEUVEN) > 0
        assert lag.lag_width(f, TUSTIN) == pytest.approx(0, abs=1e-9)


def test_the_loop_of_lag_widens_with_the_rate_and_closes_as_it_vanishes():
    """Proportional to the rate at low rates, with the first-order lag's own factor."""
    widths = np.array([lag.lag_width(f, LUGRE) for f in (0.01, 0.02, 0.04)])
    np.testing.assert_allclose(widths[1:] / widths[:-1], 2.0, rtol=2e-3)
    dry = (F_S - F_C) * np.exp(-0.015 / V_S)
    tau = (F_C + dry) / (3e5 * 0.015)
    expected = 2 * 0.002 * dry / V_S * 2 * np.pi * 0.01 * tau
    assert widths[0] == pytest.approx(expected, rel=2e-3)


def test_an_inner_loop_closes_and_is_forgotten_with_leuven_alone(shown):
    show = shown["presliding"]
    for law, low, high in (("Leuven", 0.0, 0.01), ("LuGre", 10.0, 380.0)):
        forces = [f for f in show.findings if f.quantity.startswith(f"{law}: ") and f.unit == "N"]
        assert len(forces) == 2  # back at C, and on the way to E
        assert all(low <= abs(force.simulated) < high for force in forces)


def test_leuvens_path_is_that_of_springs_that_slip_one_by_one():
    """Masing: from a turn on, each spring slips after twice its limit."""
    law = LEUVEN._replace(viscous=0.0, coulomb=F_S, shape=60.0)
    x, force = presliding.traced((0.0, 0.3e-3, -0.05e-3), law)
    limits = 1e-3 * np.arange(1, 11) / 10
    rising = x < 0.3e-3 - 1e-9
    turn = int(np.argmax(x))
    for k in (turn // 3, turn, turn + 1000, len(x) - 1):
        deflected = np.minimum(x[min(k, turn)], limits)
        if k > turn:
            deflected = np.maximum(deflected - (0.3e-3 - x[k]), -limits)
        assert force[k] == pytest.approx(np.sum(60.0 * deflected / limits), abs=0.1)
    assert rising.any()


def test_lugre_drifts_by_the_same_way_in_each_cycle_and_leuven_rests(shown):
    drift = next(p for p in shown["presliding"].panels if p.name == "drift")
    ways = {line.label: np.diff(line.y)[2:] for line in drift.lines}
    stiffness = np.sum(60.0 / (1e-3 * np.arange(1, 11) / 10))
    u_1, u_2 = 150 / F_S, 350 / F_S
    expected = 1e6 * F_S / stiffness * np.log((1 - u_1**2) / (1 - u_2**2))
    np.testing.assert_allclose(ways["LuGre"], expected, rtol=5e-3)
    assert np.abs(ways["Leuven"]).max() < 1e-3 * expected


@pytest.mark.parametrize("speed,stiffness", [(2e-3, 2e4), (5e-3, 5e4), (1e-2, 2e4)])
def test_it_rests_for_twice_the_drop_over_the_rate_and_slips_for_half_a_period(speed, stiffness):
    t, v, force = stick_slip.pulled(speed, stiffness, stick_slip.STICK_SLIP)
    dwell, slip = stick_slip.measured_times(t, v, speed)
    drop = force.max() - F_C  # what the spring has reached when it breaks away
    assert dwell == pytest.approx(2 * drop / (stiffness * speed), rel=0.03)
    omega = np.sqrt(stiffness / 10.0)
    assert slip == pytest.approx(
        2 / omega * (np.pi - np.arctan(drop * omega / (stiffness * speed))), rel=0.03
    )


def test_dwell_time_falls_with_speed_and_stiffness_and_slip_time_with_stiffness_alone(shown):
    panels = {panel.name: panel for panel in shown["stick-slip"].panels}
    soft, stiff = (line.y for line in panels["dwell"].lines if line.points)
    assert (np.diff(soft) < 0).all() and (np.diff(stiff) < 0).all() and (stiff < soft).all()
    soft, stiff = (line.y for line in panels["slip"].lines if line.points)
    np.testing.assert_allclose(soft / stiff, np.sqrt(5e4 / 2e4), rtol=0.03)
    assert np.ptp(soft) < 0.03 * soft.mean()


def test_even_sliding_is_stable_above_the_speed_where_the_linear_laws_poles_cross():
    """Poles of m tau s^3 + (m + B tau) s^2 + (B + F' + K tau) s + K, numerically."""
    law, mass, stiffness = stick_slip.DAMPED, 10.0, 5e4
    b, s_0 = law.viscous, law.bristle_stiffness

    def fastest(v):
        fallen = (F_S - F_C) * np.exp(-v / V_S)
        tau = (F_C + fallen) / (s_0 * v)
        slope = b - fallen / V_S
        roots = np.roots([mass * tau, mass + b * tau, slope + stiffness * tau, stiffness])
        return roots.real.max()

    even = stick_slip.critical_speed(stiffness, law)
    assert fastest(0.999 * even) > 0 > fastest(1.001 * even)
    for ratio in (0.9, 1.1):
        assert stick_slip.growth(ratio * even, stiffness, law) == pytest.approx(
            fastest(ratio * even), rel=0.02
        )
    v_min = V_S * np.log((F_S - F_C) / (b * V_S))
    assert 0.5 * v_min < even < v_min, "the bristles' lag steadies what the static law would not"


def test_it_does_not_stick_above_that_speed():
    law = stick_slip.DAMPED
    even = stick_slip.critical_speed(5e4, law)
    t, v, _ = stick_slip.pulled(1.3 * even, 5e4, law, cycles=300)
    late = v[len(v) // 2 :]
    assert np.ptp(late) < 0.02 * even


def test_breakaway_falls_with_the_rate_of_the_force_from_stiction(shown):
    panel = shown["breakaway"].panels[0]
    for line in panel.lines[1:]:
        assert (np.diff(line.y) < 0).all() and line.y[0] > 0.95 * F_S and line.y[-1] > F_C
    # the light mass follows the closed form without mass, found by root of its derivative
    for rate, force in zip(panel.lines[2].x, panel.lines[2].y, strict=True):
        creep = rate / 3e5
        v = np.linspace(creep, 0.2, 400_001)[1:]
        balance = (F_C + (F_S - F_C) * np.exp(-v / V_S)) * (1 - creep / v)
        assert force == pytest.approx(balance.max(), rel=0.015)


def test_a_driven_mass_without_friction_swings_as_a_spring_does():
    none = FrictionParameters(law=TUSTIN.law)
    force = np.full(20_001, 100.0)
    moved = driven_mass(force, 1000.0, 10.0, 1e-4, none)
    t = 1e-4 * np.arange(len(force))
    np.testing.assert_allclose(moved.x_m, 0.1 * (1 - np.cos(10 * t)), atol=1e-9)


def test_friction_at_a_constant_velocity_is_lugres_exponential():
    law = LUGRE._replace(viscous=0.0, coulomb=F_S)
    force = prescribed_friction(np.full(2000, 1e-3), 1e-3, law)
    t = 1e-3 * (np.arange(2000) + 0.5)
    np.testing.assert_allclose(force, F_S * (1 - np.exp(-3e5 * 1e-3 / F_S * t)), atol=0.05)


def test_each_phenomenon_agrees_with_its_closed_forms(shown):
    """Within 10 %, the formulas' own simplifications, or 1 % of the largest number expected."""
    for name, phenomenon in shown.items():
        expected = [f.expected for f in phenomenon.findings if f.expected is not None]
        for finding in phenomenon.findings:
            assert finding.unit, name
            if finding.expected is not None:
                room = max(0.1 * abs(finding.expected), 0.01 * max(map(abs, expected)))
                assert abs(finding.simulated - finding.expected) <= room, finding
        assert all(getattr(phenomenon, field.name) is not None for field in fields(phenomenon))
