"""Learned laws of a plant file: tables that the plant adds to its equations."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import RegularGridInterpolator

from hbench.config.bench import Plant, merge, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.model.build import plant_parameters
from hbench.model.effects.applied import flow_effects, friction_effects, position_reading
from hbench.model.effects.couplings import ChamberFlows
from hbench.model.effects.learned import corrected_motion
from hbench.model.friction.laws import steady_parts
from hbench.model.plant import drawn_flow, initial_state
from hbench.model.simulation import simulate
from hbench.model.states import P_S, P_TP, P_TR, SPOOL_T, V, X
from tests.support import ROOT
from tests.support.pump import PUMP

BENCH = read_yaml(ROOT / "configs" / "bench-aau.yaml")
ALONG_BORE = {
    "adds_to": "friction_test",
    "over": {"position": ["50 mm", "150 mm", "250 mm"]},
    "values": ["4 N", "-8 N", "2 N"],
}
TWO = {
    "adds_to": "flow_tr",
    "over": {"opening": ["-2 V", "1 V"], "pressure_drop": ["-10 bar", "0 bar", "40 bar"]},
    "values": [["0.1 l/min", "0 l/min", "0.2 l/min"], ["0 l/min", "0.3 l/min", "-0.6 l/min"]],
}

SUPPLY = {
    "adds_to": "supply",
    "over": {"drawn_flow": ["0 l/min", "4 l/min", "30 l/min"]},
    "values": ["1 bar", "-3 bar", "-8 bar"],
}
SENSOR = {
    "adds_to": "position_sensor",
    "over": {"position": ["50 mm", "120 mm", "150 mm", "300 mm"]},
    "values": ["4 %", "-3 %", "2 %", "1 %"],
}


def plant(*laws) -> Plant:
    return parse_plant(merge(BENCH, {"learned": list(laws)}), {}, "plant")


def at(par, **values):
    """A state of the plant, with room for the effects' states."""
    state = np.zeros(80)
    state[[P_TP, P_TR]] = 30e5, 20e5
    for name, value in values.items():
        state[{"x": X, "v": V, "p_tp": P_TP, "p_tr": P_TR, "spool": SPOOL_T}[name]] = value
    return state, par, par.effects, np.zeros(80)


@pytest.mark.parametrize(
    ("x", "more"), [(0.0, 4.0), (0.05, 4.0), (0.1, -2.0), (0.2, -3.0), (0.25, 2.0), (0.4, 2.0)]
)
def test_a_table_is_linear_between_its_knots_and_constant_beyond(x, more):
    par, without = plant_parameters(plant(ALONG_BORE)), plant_parameters(plant(TWO))
    level = friction_effects(1.0, 1.0, *at(par, x=x, v=0.1))[0]
    dry, _ = steady_parts(0.1, 30e5, 20e5, 1.0, par.test.friction)
    assert (level - 1.0) * dry == pytest.approx(more)
    assert friction_effects(1.0, 1.0, *at(without, x=x, v=0.1)) == (1.0, 1.0, 0.0, 0.0)


def test_a_table_over_two_quantities_is_bilinear_as_in_scipy():
    par = plant_parameters(plant(TWO))
    law = plant(TWO).learned[0]
    expected = RegularGridInterpolator(
        [np.array(knots) for knots in law.over.values()], np.array(law.values)
    )
    q = ChamberFlows(1e-5, 2e-5, 3e-5, 4e-5, 5e-5, 6e-5, 1.0)
    for u, drop in np.random.default_rng(3).uniform((-2, -10e5), (1, 40e5), (20, 2)):
        changed = flow_effects(q, *at(par, spool=u, p_tp=50e5 + drop, p_tr=50e5))
        assert changed.tr - q.tr == pytest.approx(float(expected((u, drop))), abs=1e-15)
        assert changed._replace(tr=q.tr) == q


def test_laws_of_one_target_add_up_and_the_file_keeps_them():
    par = plant_parameters(plant(ALONG_BORE, ALONG_BORE, TWO))
    twice = friction_effects(1.0, 1.0, *at(par, x=0.05, v=0.1))[0]
    once = friction_effects(1.0, 1.0, *at(plant_parameters(plant(ALONG_BORE)), x=0.05, v=0.1))[0]
    assert twice - 1.0 == pytest.approx(2 * (once - 1.0))
    given = plant(ALONG_BORE, TWO)
    assert plant(*(law.section() for law in given.learned)) == given


@pytest.mark.parametrize("more", [{}, {"effects": {"supply_droop": {"slope": "0.2 bar min/l"}}}])
def test_the_supply_settles_at_its_law_of_the_flow_that_is_drawn(more):
    par = plant_parameters(parse_plant(merge(BENCH, {"learned": [SUPPLY], **more}), {}, "plant"))
    start = initial_state(par, 0.1, 15e5, 30e5)
    made = simulate(par, start, np.tile([1.0, 0.5, -1.0], (4000, 1)))
    flow, pressure = made.q_supply_m3_s[-1], made.state[-1, P_S]
    litres = 6e4 * flow
    assert litres > 2 and drawn_flow(made.state[-1], par, np.zeros(80)) == flow
    law = np.interp(litres, [0, 4, 30], [1e5, -3e5, -8e5])
    droop = 0.2e5 * litres if more else 0.0
    assert pressure == pytest.approx(150e5 + law - droop, abs=2e3)


def test_the_reading_of_a_position_sensor_moves_by_its_slope_and_is_corrected_back():
    par = plant_parameters(plant(SENSOR, SENSOR))
    x = np.linspace(0.02, 0.35, 2000)
    shown = np.array([position_reading(*at(par, x=each)[:3]) for each in x])
    more = np.interp(shown, [0.05, 0.12, 0.15, 0.3], [0.08, -0.06, 0.04, 0.02])
    moved = cumulative_trapezoid(1 + more, shown, initial=0.0)
    np.testing.assert_allclose(x - x[0], moved, atol=1e-6)
    assert shown[x.searchsorted(0.05)] == pytest.approx(0.05, abs=2e-4)
    back, speed = shown.copy(), np.full(len(x), 0.1)
    corrected_motion(back, speed, par.learned)
    np.testing.assert_allclose(back, x, atol=1e-7)
    np.testing.assert_allclose(speed, 0.1 * (1 + more), rtol=1e-9)
    straight = plant_parameters(plant(ALONG_BORE))
    assert position_reading(*at(straight, x=0.2)[:3]) == 0.2


def test_a_law_of_the_supply_is_of_a_source_without_pump():
    with pytest.raises(ConfigError, match="source without pump"):
        plant_parameters(
            parse_plant(merge(BENCH, {"learned": [SUPPLY], "supply": {"pump": PUMP}}), {}, "x")
        )


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"over": {"speed": ["1 m/s", "2 m/s"]}}, "over.speed: known are velocity"),
        ({"over": {"opening": ["1 V", "2 V", "3 V"]}}, "has no over.opening"),
        ({"over": {"drawn_flow": ["1 l/min", "2 l/min", "3 l/min"]}}, "has no over.drawn_flow"),
        ({"over": {"position": ["1 mm", "3 mm", "2 mm"]}}, "ascending knots"),
        ({"values": ["4 N", "2 N"]}, "3 numbers"),
        ({"values": ["4 N", "2 N", "1 bar"]}, "wrong unit"),
        ({"values": [4.0, 2.0, 1.0]}, "has no unit"),
        ({"over": {}}, "one or two quantities"),
    ],
)
def test_a_table_with_a_fault_is_refused(change, fault):
    with pytest.raises(ConfigError, match=fault):
        plant(ALONG_BORE | change)
