"""Each effect of the catalogue does what its law says; none changes the plant where it is off."""

import numba
import numpy as np
import pytest
from scipy.signal import lsim

from hbench.config.bench import Bench
from hbench.config.effects import Coefficient
from hbench.errors import ConfigError
from hbench.model.build import plant_parameters
from hbench.model.effects.applied import compose
from hbench.model.effects.catalogue import EFFECTS, Effect, changed_by, with_effects
from hbench.model.effects.couplings import ChamberFlows, OilProperties, Openings, PortFlows
from hbench.model.effects.flows import uneven_ports, with_air
from hbench.model.effects.openings import valve_hysteresis, valve_trim
from hbench.model.noise import new_noise
from hbench.model.plant import (
    P_LP,
    P_LR,
    P_S,
    P_TP,
    P_TR,
    SPOOL_L1,
    TICK_S,
    Z_L,
    V,
    X,
    forces,
    initial_state,
    n_states,
)  # fmt: skip
from hbench.model.sensing import convert
from hbench.model.sensors import FRACTION, SENSORS, sensor_gains, sensor_parameters
from hbench.model.simulation import simulate

BAR, LITRE_MIN = 1e5, 1e-3 / 60
A_P, A_R = np.pi / 4 * 0.04**2, np.pi / 4 * (0.04**2 - 0.025**2)
BETA = 700 * BAR
V_TP, V_TR = 251.2e-6 + A_P * 0.15, 251.2e-6 + A_R * 0.25  # at x = 150 mm
V_LP, V_LR = 199.3e-6 + A_P * 0.23, 112.7e-6 + A_R * 0.17
FIRST = Z_L + 1  # of the effects' states
STATE = {
    name: FIRST + sum(row.states for row in list(EFFECTS.values())[:i])
    for i, name in enumerate(EFFECTS)
}


@pytest.fixture(scope="module")
def fixed(par):
    """The plant with pistons that nothing moves."""
    return par._replace(mass_test_kg=1e15)


@pytest.fixture(scope="module")
def start(par):
    return initial_state(par, 0.15, 15 * BAR, 20 * BAR)


def run(par, start, u, seconds=1.0):
    state = np.zeros(n_states(par))
    state[: len(start)] = start
    return simulate(par, state, np.tile(u, (round(seconds / TICK_S), 1)))


def through_ports(flows, c, state, par):
    """Flows of uneven ports; the openings take no part."""
    terms = PortFlows(flows, Openings(0.0, 0.0, 0.0), par.supply.tank_pa)
    return uneven_ports(terms, c, state, FIRST, np.zeros(len(state)), par).q


def typical(name):
    return {
        key: one.to_si(one.typical or one.default)
        for key, one in EFFECTS[name].coefficients.items()
    }


def test_with_all_coefficients_at_zero_the_plant_is_the_one_without_effects_to_the_bit(
    par, start, there_and_back
):
    off = simulate(par, start, there_and_back)
    par = with_effects(par, {"valve_lag": {}})
    zero = simulate(par, np.append(start, np.zeros(n_states(par) - len(start))), there_and_back)
    assert zero.state.shape[1] == off.state.shape[1] + sum(e.states for e in EFFECTS.values())
    assert np.array_equal(zero.state[:, : len(start)], off.state)
    assert not zero.state[:, len(start) :].any()
    for name in ("friction_test_n", "friction_load_n", "f_applied_n", "q_supply_m3_s"):
        assert np.array_equal(getattr(zero, name), getattr(off, name))


def test_no_effect_or_one_of_a_sensor_leaves_the_code_without_effects(par):
    assert par.effects is None
    assert with_effects(par, {"load_cell_gain": {"error": 0.02}}) is par


# ---- valves


def test_internal_leakage_lets_the_pressure_drop_decay_and_loses_no_oil(fixed, start):
    g = 3e-3 * LITRE_MIN / BAR
    leaky = with_effects(fixed, {"internal_leakage": {"test": g, "load": 2 * g}})
    decay = run(leaky, start, [0, 0, 0], 2.0)
    for p, r, v_p, v_r, gain in (
        (P_TP, P_TR, V_TP, V_TR, g),
        (P_LP, P_LR, V_LP, V_LR, 2 * g),
    ):
        drop = decay.state[:, p] - decay.state[:, r]
        rate = BETA * gain * (1 / v_p + 1 / v_r)
        assert drop == pytest.approx(drop[0] * np.exp(-rate * decay.t_s), rel=1e-6)
        oil = v_p * decay.state[:, p] + v_r * decay.state[:, r]
        assert oil == pytest.approx(oil[0], rel=1e-9)
        assert abs(drop[-1]) < 0.9 * abs(drop[0])


def test_external_leakage_empties_each_chamber_by_itself(fixed, start):
    g = np.array([1, 2, 3, 4]) * 1e-3 * LITRE_MIN / BAR
    leaky = with_effects(
        fixed, {"external_leakage": dict(zip(("tp", "tr", "lp", "lr"), g, strict=True))}
    )
    decay = run(leaky, start, [0, 0, 0])
    volumes = np.array([V_TP, V_TR, V_LP, V_LR])
    expected = start[P_TP : P_LR + 1] * np.exp(-np.outer(decay.t_s, BETA * g / volumes))
    assert decay.state[:, P_TP : P_LR + 1] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("way", [1, -1])
def test_a_deadband_shifts_the_command_that_gives_a_velocity(par, start, way):
    u = way * np.array([0.7, 0.3, -1.4])
    shift = way * np.array([0.2, 0.1, -0.1])
    dead = with_effects(par, {"valve_deadband": {"test": 0.2, "load": 0.1}})
    plain, shifted = run(par, start, u), run(dead, start, u + shift)
    assert shifted.state[-1, V] == pytest.approx(plain.state[-1, V], rel=5e-4)
    assert abs(plain.state[-1, V]) > 0.03
    still = run(dead, start, 0.99 * shift)
    assert np.abs(still.q_supply_m3_s).max() == 0.0


@pytest.mark.parametrize("way", [1, -1])
def test_an_asymmetric_valve_is_one_with_another_gain_in_each_direction(par, start, way):
    """At each instant: the same opening times 1 +- k gives the same flows."""
    shares = {"test": 0.1, "load": -0.05, "load_apart": 0.02}
    uneven = with_effects(par, {"valve_asymmetry": shares})
    u = way * np.array([0.7, 0.3, -1.4])
    gain = np.array([1 + way * 0.1, 1 - way * 0.03, 1 + way * 0.07])
    one, other = run(uneven, start, u), run(par, start, u * gain)
    assert one.state[:, X : P_LR + 1] == pytest.approx(other.state[:, X : P_LR + 1], rel=1e-9)


@pytest.mark.parametrize("way", [1, -1])
def test_valves_with_gains_of_their_own_are_those_with_other_commands(par, start, way):
    """At each instant: the same opening times 1 + g, with a g for each valve."""
    trimmed = with_effects(
        par, {"valve_trim": {"gain_test": 0.1, "gain_load_1": -0.05, "gain_load_2": 0.02}}
    )
    u = way * np.array([0.7, 0.3, -1.4])
    one, other = run(trimmed, start, u), run(par, start, u * [1.1, 0.95, 1.02])
    assert one.state[:, X : P_LR + 1] == pytest.approx(other.state[:, X : P_LR + 1], rel=1e-9)


@pytest.mark.parametrize("way", [1, -1])
def test_nulls_and_curvature_shift_the_command_of_a_steady_velocity(par, start, way):
    """u + k |u| u + u_0 of a held command: once the spools are there, motion is the same."""
    nulls, k = np.array([0.05, -0.03, 0.1]), 0.02
    values = {"null_test": 0.05, "null_load_1": -0.03, "null_load_2": 0.1, "curvature": k}
    u = way * np.array([0.7, 0.3, -1.4])
    trimmed = run(with_effects(par, {"valve_trim": values}), start, u)
    other = run(par, start, u + k * np.abs(u) * u + nulls)
    plain = run(par, start, u)
    steady = slice(-2000, None)
    speed = [each.state[steady, V].mean() for each in (trimmed, other, plain)]
    assert speed[0] == pytest.approx(speed[1], rel=2e-3)
    assert speed[0] != pytest.approx(speed[2], rel=6e-3)


@pytest.mark.parametrize("n", [-0.1, 0.05, 0.3])
def test_a_ports_exponent_changes_the_power_of_the_drop_and_nothing_at_50_bar(par, start, n):
    """Q = k u sqrt(50 bar) (dP / 50 bar)^(1/2 + n), to the tank and from the supply."""
    state = np.array(start)
    state[[P_TP, P_TR, P_LP, P_LR, P_S]] = np.array([100, 32, 52, 149, 150]) * BAR
    sharp = np.array([1.0, -2.0, 3.0, 0.5]) * np.sqrt(np.array([50, 30, 98, 1]) * BAR)
    before = ChamberFlows(*sharp, 7.0, 8.0, 1.0)
    c = (*(0.0,) * 8, n, *(0.0,) * 5)
    after = through_ports(before, c, state, par)
    drops = np.array([50, 30, 98, 1]) / 50  # Lp from the supply: 150 - 52 bar
    power = np.array([1.0, -2.0, 3.0, 0.5]) * np.sqrt(50 * BAR) * drops ** (0.5 + n)
    assert np.array(after[:4]) == pytest.approx(power)
    assert after[:1] == pytest.approx(before[:1]) and after.fluidity == before.fluidity
    supplied = np.maximum(power, 0.0).sum() - np.maximum(sharp, 0.0).sum()
    assert after.drawn - before.drawn == pytest.approx(supplied)
    kept = sum(after[:4]) - sum(before[:4])  # continuity: what is drawn and not kept returns
    assert after.returned - before.returned == pytest.approx(supplied - kept)
    assert through_ports(before, (0.0,) * 14, state, par) == before


@pytest.mark.parametrize("r_bar_min_l", [0.03, 0.5])
def test_a_hose_takes_its_loss_from_the_drop_across_the_port(par, start, r_bar_min_l):
    """Q = k u sqrt(dP - R Q), from the supply and to the tank, at every port."""
    state, r = np.array(start), r_bar_min_l * BAR * 60e3
    state[[P_TP, P_TR, P_LP, P_LR, P_S]] = np.array([100, 32, 52, 149, 150]) * BAR
    drops = np.array([50, 32 - par.supply.tank_pa / BAR, 98, 1]) * BAR
    sharp = np.array([3.0, -2.0, 1.0, 0.4]) * 1e-4
    c = (*(0.0,) * 11, r, 0.0, 0.0)
    before = ChamberFlows(*sharp, 4.4e-4, 2e-4, 1.0)
    after = through_ports(before, c, state, par)
    flows = np.array(after[:4])
    left = drops - r * np.abs(flows)
    assert np.all(left > 0) and np.all(np.abs(flows) < np.abs(sharp))
    np.testing.assert_allclose(flows, sharp * np.sqrt(left / drops), rtol=1e-9)


def test_small_openings_may_have_another_slope(par, start):
    """5 % lower within 2 V, the former slope beyond: an offset of 0.1 V at large openings."""
    c = (*(0.0,) * 7, 0.05, *(0.0,) * 6)
    commands = Openings(1.0, -2.0, 8.0)
    after = valve_trim(commands, c, np.array(start), FIRST, np.zeros(len(start)), par)
    assert tuple(after) == pytest.approx((0.95, -1.9, 7.9))


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_test_valves_four_edges_have_gains_of_their_own(par, start, way):
    """Piston side 4 % above the rod side, inlets 2 % below outlets; load valves are as they were.

    Extending, oil enters the piston side and leaves the rod side; retracting, the other way.
    """
    before = ChamberFlows(way * 2e-4, way * -1.2e-4, -3e-4, 1e-4, 3e-4, 4.2e-4, 1.0)
    c = (*(0.0,) * 9, 0.02, -0.01, 0.0, 0.0, 0.0)
    after = through_ports(before, c, np.array(start), par)
    factors = (1.01, 0.99) if way > 0 else (1.03, 0.97)
    assert after.tp == pytest.approx(factors[0] * before.tp)
    assert after.tr == pytest.approx(factors[1] * before.tr)
    assert (after.lp, after.lr) == (before.lp, before.lr)
    kept = sum(after[:4]) - sum(before[:4])
    more = (after.drawn - before.drawn) - (after.returned - before.returned)
    assert more == pytest.approx(kept), "what is drawn and not kept returns"


@pytest.mark.parametrize("way", [1, -1])
def test_small_openings_of_an_uneven_valve_with_a_knee_are_more_equal(par, start, way):
    """Half of the share at the knee; the gain of each direction is that of its opening."""
    section = {"valve_asymmetry": {"test": 0.1, "load": 0.1, "knee": 0.7}}
    u = way * np.array([0.7, 0.3, -1.4])
    gain = 1 + way * np.array([0.1 / 2, 0.1 * 0.3, -0.1 * 2 / 3])
    one, other = run(with_effects(par, section), start, u), run(par, start, u * gain)
    # once the spools, of second order, stand
    assert one.q_supply_m3_s[-1] == pytest.approx(other.q_supply_m3_s[-1], rel=1e-3)
    assert one.state[-1, V] == pytest.approx(other.state[-1, V], rel=1e-3)


def test_a_slow_valve_is_the_spool_with_a_first_order_lag(par, start):
    omega, tau = 2 * np.pi * 90, 0.004
    lagged = run(with_effects(par, {"valve_lag": {"time": tau}}), start, [0.7, 0.3, -1.4], 0.05)
    system = ([omega**2], np.polymul([1, 2 * omega, omega**2], [tau, 1]))
    _, expected, _ = lsim(system, np.ones(len(lagged.t_s)), lagged.t_s)
    at = STATE["valve_lag"]
    for place, volts in zip(range(at, at + 3), (0.7, 0.3, -1.4), strict=True):
        assert lagged.state[:, place] == pytest.approx(volts * expected, abs=2e-5)


def test_a_slow_valve_in_two_parts_is_two_lags_in_a_row(par, start):
    omega, tau, share = 2 * np.pi * 90, 0.004, 0.3
    section = {"valve_lag": {"time": tau, "second": share}}
    lagged = run(with_effects(par, section), start, [0.7, 0.3, -1.4], 0.05)
    stage = np.polymul([tau * (1 - share), 1], [tau * share, 1])
    system = ([omega**2], np.polymul([1, 2 * omega, omega**2], stage))
    _, expected, _ = lsim(system, np.ones(len(lagged.t_s)), lagged.t_s)
    at, weight = STATE["valve_lag"], share / (1 - 2 * share)
    for place, volts in zip(range(at, at + 3), (0.7, 0.3, -1.4), strict=True):
        slow, fast = lagged.state[:, place], lagged.state[:, place + 3]
        assert slow + weight * (slow - fast) == pytest.approx(volts * expected, abs=2e-5)


@pytest.mark.parametrize("rate", [2.0, 40.0])
def test_a_spool_with_play_follows_a_triangle_as_a_loop_of_twice_the_play(par, rate):
    """A closed form at each sample: behind by the play on the way, at rest after each turn."""
    play, amplitude = 0.1, 0.5
    t_s = np.arange(0.0, 4 * amplitude / rate, 1e-4)
    u = amplitude - np.abs((rate * t_s + amplitude) % (4 * amplitude) - 2 * amplitude)
    state, rates = np.zeros((2, 3))
    found = []
    for command in u:
        c, opened = (play, 0.0), Openings(command, command, 0.0)
        found.append(valve_hysteresis(opened, c, state, 0, rates, par))
        state += 1e-4 * rates
    test, load_1, _ = np.array(found).T
    expected = [0.0]
    for command in u[1:]:
        expected.append(min(max(expected[-1], command - play), command + play))
    assert test == pytest.approx(np.array(expected), abs=2e-3 * rate)
    assert np.array_equal(load_1, u)
    assert test.max() == pytest.approx(amplitude - play, abs=1e-3 * rate)


def test_play_gives_another_flow_up_than_down(par, start):
    """The opening of the same command differs by twice the play."""
    play, u = 0.1, np.array([0.8, 0.3, -1.4])
    loose = with_effects(par, {"valve_hysteresis": {"test": play}})
    state = np.zeros(n_states(loose))
    state[: len(start)] = start
    up = simulate(loose, state, np.tile(u, (3000, 1)))
    more = simulate(loose, up.state[-1], np.tile(u + [0.3, 0, 0], (3000, 1)))
    down = simulate(loose, more.state[-1], np.tile(u, (3000, 1)))
    tight = with_effects(par, {"valve_hysteresis": {"test": 0.0}})
    for loop, opening in ((up, u[0] - play), (down, u[0] + play)):
        at = np.zeros(n_states(tight))
        at[: len(start)] = loop.state[-1, : len(start)]
        plain = simulate(tight, at, np.tile([opening, *u[1:]], (3000, 1)))
        assert loop.state[-1, V] == pytest.approx(plain.state[-1, V], rel=2e-2)


# ---- oil and lines


def test_air_takes_the_volume_of_the_isothermal_gas_law():
    """1 / beta_eff = -dV/dP of oil and gas at p V = const, per volume of oil."""
    p_0, alpha = 1.013e5, 0.01
    for p in np.array([0.5, 2, 10, 50, 150]) * BAR:
        h = 1e-3 * p
        oil = (p + h - (p - h)) / BETA
        gas = alpha * p_0 * (1 / (p_0 + p - h) - 1 / (p_0 + p + h))
        assert with_air(BETA, p, alpha) == pytest.approx(2 * h / (oil + gas), rel=1e-5)
    assert (
        with_air(BETA, 2 * BAR, alpha) < 0.6 * BETA < 0.99 * BETA < with_air(BETA, 90 * BAR, alpha)
    )


def test_filling_a_chamber_with_air_in_it_takes_the_oil_and_the_gas_it_compresses(fixed, start):
    alpha, p_0 = 0.02, 1.013e5
    low = start.copy()
    low[P_LR] = 3 * BAR
    filled = run(
        with_effects(fixed, {"entrained_air": {"fraction": alpha}}), low, [0, 0.05, 0], 0.5
    )
    p = filled.state[:, P_LR]
    compressed = (p - p[0]) / BETA + alpha * p_0 * (1 / (p_0 + p[0]) - 1 / (p_0 + p))
    flow = 7.43e-7 * np.sqrt(2 / 870) * filled.state[:, SPOOL_L1] * np.sqrt(150 * BAR - p)
    came = np.append(0, np.cumsum((flow[1:] + flow[:-1]) / 2)) * TICK_S
    assert V_LR * compressed == pytest.approx(came, rel=1e-4, abs=3e-12)
    assert p[-1] > 9 * BAR


def test_the_return_lines_pressure_is_that_of_the_square_of_the_flow(par, start):
    """In extension the test rod side and the load piston side return A_r v and A_p v."""
    r = 0.03 * BAR / LITRE_MIN**2
    moved = run(
        with_effects(par, {"tank_back_pressure": {"resistance": r, "lag": 0.005}}),
        start, [0.7, 0.3, -1.4],
    )  # fmt: skip
    returned = (A_R + A_P) * moved.state[-1, V]
    line = moved.state[-1, STATE["tank_back_pressure"]]
    assert line == pytest.approx(r * returned**2, rel=1e-2)
    assert line > 0.5 * BAR


def test_the_supply_droops_with_what_is_drawn(par, start):
    slope = 0.5 * BAR / LITRE_MIN
    drooped = run(
        with_effects(par, {"supply_droop": {"slope": slope, "lag": 0.02}}), start, [0.7, 0.3, -1.4]
    )
    drawn = (A_P + A_R) * drooped.state[-1, V]
    assert 150 * BAR - drooped.state[-1, P_S] == pytest.approx(slope * drawn, rel=5e-3)
    assert drooped.state[-1, P_S] < 148 * BAR


def test_a_pump_droops_by_itself(bench):
    pump = {
        "flow": 5e-4, "cut_off": 150e5, "band": 5e5, "compensator_lag": 0.01, "swash_lag": 0.01,
        "relief": 170e5, "relief_gain": 1e-9, "leakage": 1e-13, "capacity": 1e-12,
    }  # fmt: skip
    par = plant_parameters(bench)
    par = par._replace(supply=par.supply._replace(has_pump=True, **{"flow_m3_s": pump["flow"]}))
    with pytest.raises(ConfigError, match="pump"):
        with_effects(par, {"supply_droop": {"slope": 1e9}})


def test_warm_oil_has_less_viscous_friction_and_leaks_more(par, start, fixed):
    """theta follows the power with its lag; viscosity is exp(-k theta) of the cold one."""
    rise, pump, tau, k = 0.03, 5.0, 0.5, 0.03
    values = {"oil_warming": {"rise": rise, "pump": pump, "time": tau, "viscosity": k}}
    warmed = run(with_effects(par, values), start, [0.7, 0.3, -1.4])
    power = 150 * BAR * warmed.q_supply_m3_s
    lag = np.exp(-TICK_S / tau)
    theta = np.zeros(len(power))
    for i in range(1, len(theta)):
        mean = (power[i] + power[i - 1]) / 2
        theta[i] = lag * theta[i - 1] + (1 - lag) * (pump + rise * mean)
    at = STATE["oil_warming"]
    assert warmed.state[:, at] == pytest.approx(theta, rel=1e-4, abs=1e-4)
    assert theta[-1] > 10
    hot = np.append(start, np.zeros(n_states(with_effects(par, values)) - len(start)))
    hot[at] = 40.0
    thin = with_effects(fixed, {"oil_warming": {"rise": 1e-9, "time": 1e9, "viscosity": k},
                                "internal_leakage": {"test": 1e-12}})  # fmt: skip
    decay = simulate(thin, hot, np.zeros((5000, 3)))
    drop = decay.state[:, P_TP] - decay.state[:, P_TR]
    rate = BETA * 1e-12 * np.exp(40 * k) * (1 / V_TP + 1 / V_TR)
    assert drop == pytest.approx(drop[0] * np.exp(-rate * decay.t_s), rel=1e-6)


# ---- friction


@pytest.fixture(scope="module")
def friction_of(with_law, start):
    """Return ``friction(v, values, **states)``: test's and load's [N], of Tustin's law."""
    par = with_law("tustin")

    def at(v, values, x=0.15, **states):
        changed = with_effects(par, values)
        state = np.append(start, np.zeros(n_states(changed) - len(start)))
        state[[X, V]] = x, v
        for name, value in states.items():
            state[STATE[name]] = value
        moment = forces(state, np.ones(2), changed, np.zeros(len(state)))
        return np.array([moment.friction_test, moment.friction_load])

    return at


def dry(v, p_p, p_r, coulomb, stiction):
    """Tustin's dry part with the seals of the bench file."""
    seals = 1.5e-5 * abs(p_p - p_r) + 0.1e-5 * p_r
    return coulomb + seals + (stiction - coulomb) * np.exp(-abs(v) / 0.06)


@pytest.mark.parametrize("v", [0.05, -0.05])
def test_friction_effects_add_their_closed_forms(friction_of, start, v):
    p_tp, p_tr, p_lp, p_lr = start[P_TP : P_LR + 1]
    way = np.sign(v)
    own = np.array([dry(v, p_tp, p_tr, 80, 450), dry(v, p_lp, p_lr, 180, 260)])
    viscous = np.array([2500, 3000]) * v
    assert friction_of(v, {}) == pytest.approx(way * own + viscous, rel=1e-9)
    seal = np.array([p_tp + 3 * p_tr, 2 * p_lp + 4 * p_lr])
    chambers = dict(
        zip(("test_piston", "test_rod", "load_piston", "load_rod"), (1, 3, 2, 4), strict=True)
    )
    lips = {key: times * 1e-5 for key, times in chambers.items()}
    load = np.abs([p_tp * A_P - p_tr * A_R, p_lp * A_P - p_lr * A_R])
    two, factor = {"test": 0.1, "load": 0.2}, np.array([0.1, 0.2])
    bent = [30 * (2 * 0.35 / 0.4 - 1) + 50 * (2 * 0.35 / 0.4 - 1) ** 2, 0]
    slower = np.array([dry(0.02, p_tp, p_tr, 80, 450), dry(0.02, p_lp, p_lr, 180, 260)]) - own
    for more, name, values, extra in (
        (1e-5 * seal, "seal_pressure_friction", lips, {}),
        (factor * load, "load_friction", two, {}),
        (factor * way * own, "direction_asymmetry", two, {}),
        (bent, "position_friction", {"slope": 30, "bow": 50}, {"x": 0.35}),
        (slower, "friction_lag", {"time": 0.05}, {"friction_lag": 0.02}),
        ([0, 0], "presliding", {"force": 60, "length": 1e-3}, {"presliding": way}),
        ([-60, 0], "presliding", {"force": 60, "length": 1e-3}, {"presliding": 0}),
        ([-120, 0], "presliding", {"force": 60, "length": 1e-3}, {"presliding": -way}),
    ):
        got = friction_of(v, {name: values}, **extra)
        assert got == pytest.approx(way * (own + more) + viscous, rel=1e-9), name
    warm = {"oil_warming": {"rise": 1.0, "time": 1.0, "viscosity": 0.03}}
    got = friction_of(v, warm, oil_warming=10.0)
    assert got == pytest.approx(way * own + viscous * np.exp(-0.3), rel=1e-9)


@pytest.mark.parametrize("v", [0.005, -0.02, 0.05, 0.2])
def test_added_friction_may_follow_the_stribeck_curve_in_part(friction_of, start, v):
    """At 50 mm/s it is the same; at other speeds a share changes as the cylinder's own does."""
    p_tp, p_tr, p_lp, p_lr = start[P_TP : P_LR + 1]
    ratio = np.array(
        [
            dry(v, p_tp, p_tr, 80, 450) / dry(0.05, p_tp, p_tr, 80, 450),
            dry(v, p_lp, p_lr, 180, 260) / dry(0.05, p_lp, p_lr, 180, 260),
        ]
    )
    for name, values in (
        ("load_friction", {"test": 0.1, "load": 0.2}),
        ("seal_pressure_friction", {"test_piston": 1e-5, "load_rod": 2e-5}),
    ):
        none, constant, part = (
            np.abs(friction_of(v, section))
            for section in ({}, {name: values}, {name: values | {"stribeck": 0.4}})
        )
        assert np.all(constant > none + 1)
        assert part - none == pytest.approx((constant - none) * (0.6 + 0.4 * ratio), rel=1e-9)


def test_friction_stays_passive_however_much_an_effect_takes_off(friction_of):
    bare = friction_of(0.05, {}) - np.array([2500, 3000]) * 0.05
    left = friction_of(0.05, {"position_friction": {"slope": 0, "bow": -1e5}}, x=0.39)
    assert left[0] == pytest.approx(0.1 * bare[0] + 125, rel=1e-9)


def test_a_sheared_seal_builds_its_force_up_over_its_length(fixed, start):
    """Dahl from rest at constant speed: z = 1 - exp(-x / L)."""
    moving = start.copy()
    moving[V] = 0.01
    par = with_effects(fixed, {"presliding": {"force": 60, "length": 1e-3}})
    slid = run(par, moving, [0, 0, 0], 0.4)
    x = slid.state[:, X] - 0.15
    z = slid.state[:, STATE["presliding"]]
    assert z == pytest.approx(1 - np.exp(-x / 1e-3), abs=1e-6)
    assert x[-1] == pytest.approx(4e-3, rel=1e-6)


def test_friction_follows_a_step_of_speed_with_its_lag(fixed, start):
    moving = start.copy()
    moving[V] = -0.05
    lagged = run(with_effects(fixed, {"friction_lag": {"time": 0.03}}), moving, [0, 0, 0], 0.1)
    expected = 0.05 * (1 - np.exp(-lagged.t_s / 0.03))
    assert lagged.state[:, STATE["friction_lag"]] == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(
    ("x", "v", "depth"),
    [(0.35, 0.1, 0.5), (0.05, -0.1, 0.5), (0.35, -0.1, 0), (0.05, 0.1, 0), (0.2, 0.1, 0)],
)
def test_a_cushion_brakes_only_towards_its_end(friction_of, x, v, depth):
    cushion = {"end_cushion": {"length": 0.1, "damping": 2000}}
    change = friction_of(v, cushion, x) - friction_of(v, {}, x)
    assert change == pytest.approx([2000 * depth * v, 0], abs=1e-9)


# ---- numbers


def test_masses_that_move_with_the_piston_take_acceleration_off_and_load_the_cell(par, start):
    """In a push that is slow beside the mounts' lag: as many kg more on either side."""
    heavier = with_effects(par, {"added_mass": {"test": 5.0, "load": 10.0, "lag": 1e-4}})
    pushed = np.append(start, np.zeros(n_states(heavier) - len(start)))
    pushed[P_TP] += 10 * BAR
    light = forces(pushed[: len(start)], np.ones(2), par, np.zeros(len(start)))
    at, rates = STATE["added_mass"], np.zeros(len(pushed))
    compose = light.acceleration * 10 / 25
    pushed[at] = pushed[V] - 1e-4 * compose  # the mounts, once they are pressed
    heavy = forces(pushed, np.ones(2), heavier, rates)
    assert rates[at] == pytest.approx(compose, rel=1e-9)
    assert heavy.acceleration == pytest.approx(compose, rel=1e-9)
    assert heavy.applied - 15 * heavy.acceleration == pytest.approx(
        light.applied - 5 * light.acceleration, rel=1e-9
    )


def test_sensor_errors_show_in_their_channels_alone(bench: Bench):
    values = np.array([0.2, 60 * BAR, 40 * BAR, 20 * BAR, 15 * BAR, 150 * BAR, 3000.0])
    sensors = bench.sensors.model_copy(
        update={"adc": bench.sensors.adc.model_copy(update={"noisy": False, "quantised": False})}
    )
    gains = sensor_gains(sensors)
    shown, step = np.zeros(7), np.zeros(7)
    for name, change in {
        "load_cell_gain": [0, 0, 0, 0, 0, 0, 60],
        "load_cell_offset": [0, 0, 0, 0, 0, 0, 30],
        "pressure_offset": [0, *[0.5 * BAR] * 5, 0],
        "pressure_gain": [0, *(0.01 * values[1:6]), 0],
    }.items():
        par = changed_by("sensors", sensor_parameters(sensors), {name: typical(name)})
        words = np.zeros(7, np.uint16)
        convert(values, 313.15, par, new_noise(1), words)
        for i, channel in enumerate(SENSORS):
            gain, offset = gains[channel]
            shown[i], step[i] = gain * words[i] / FRACTION + offset, gain / FRACTION
        assert np.abs(shown - values - change).max() < np.inf
        assert np.all(np.abs(shown - values - change) <= 0.51 * np.abs(step)), name


# ---- a user's own


def soft_hose(oil, c, state, at, rates, par):
    """1 / beta of the test cylinder's rod side grows by c."""
    soft = 1.0 / (1.0 / oil.beta_tr + c[0])
    return OilProperties(oil.tank_pa, oil.beta_tp, soft, oil.beta_lp, oil.beta_lr)


def test_a_function_and_a_row_make_a_new_effect(par, start):
    row = Effect(
        "1 / beta of Tr grows",
        {"compliance": Coefficient("1/bar", 1e-4, 0, 0.1)},
        ("flow_tr",),
        {"oil": soft_hose},
    )
    table = EFFECTS | {"soft_hose": row}
    par = with_effects(par, {"entrained_air": {"fraction": 0.01}})
    par = par._replace(effects=(*par.effects, (1e-9,)))
    before = OilProperties(2 * BAR, BETA, BETA, BETA, BETA)
    state = np.append(start, np.zeros(n_states(par) - len(start)))
    after = numba.njit(compose("oil", table))(before, FIRST, state, np.zeros(len(state)), par)
    assert after.beta_tp == with_air(BETA, start[P_TP], 0.01)
    assert after.beta_tr == pytest.approx(
        1 / (1 / with_air(BETA, start[P_TR], 0.01) + 1e-9), rel=1e-12
    )
