"""Learned laws of a plant file: tables that the plant adds to its equations."""

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from hbench.config.bench import Plant, merge, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.model.build import plant_parameters
from hbench.model.effects.applied import flow_effects, friction_effects
from hbench.model.effects.couplings import ChamberFlows
from hbench.model.friction.laws import steady_parts
from hbench.model.states import P_TP, P_TR, SPOOL_T, V, X
from tests.support import ROOT

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


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"over": {"speed": ["1 m/s", "2 m/s"]}}, "over.speed: known are velocity"),
        ({"over": {"opening": ["1 V", "2 V", "3 V"]}}, "has no valve"),
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
