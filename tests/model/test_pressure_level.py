"""Pressure level after a reversal, compared with the plant's own equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.model.build import plant_parameters
from hbench.model.cylinders import extending_volumes, pressure_rate
from hbench.model.pressure_level import level_travel
from hbench.model.valves import port_flow
from tests.support import ROOT


@pytest.mark.parametrize("rod", ["18 mm", "25 mm", "34 mm"])
def test_the_rod_side_reaches_the_pressure_after_the_travel(rod):
    """At constant force the valve that holds the speed leads P_r to the remaining deviation."""
    data = read_yaml(ROOT / "configs" / "bench-aau.yaml")
    data["test_cylinder"]["rod_diameter"] = rod
    par = plant_parameters(parse_bench(data, "bench"))
    test, p_s, p_t, v = par.test, par.supply.pressure_pa, par.supply.tank_pa, 0.05
    r = test.area_rod_m2 / test.area_piston_m2
    v_p, v_r = extending_volumes(0.2, test)

    def rates(p_r, spool):
        p_p = p_t + r * (p_r - p_t)
        q_p = port_flow(spool, p_p, p_s, p_t, par.valve) - test.area_piston_m2 * v
        q_r = port_flow(-spool, p_r, p_s, p_t, par.valve) + test.area_rod_m2 * v
        beta = par.bulk_modulus_pa
        return pressure_rate(p_p, v_p, q_p, beta), pressure_rate(p_r, v_r, q_r, beta)

    def force_rate(spool, p_r):
        rate_p, rate_r = rates(p_r, spool)
        return rate_p * test.area_piston_m2 - rate_r * test.area_rod_m2

    def slope(x, p_r):
        return [rates(p_r[0], brentq(force_rate, 0.0, 10.0, (p_r[0],)))[1] / v]

    start = p_t + (p_s - p_t) / (1 + r**3)
    steady = p_t + r**2 * (p_s - p_t) / (1 + r**3)
    travel = level_travel(par, 25e5)
    reached = solve_ivp(slope, (0.0, travel), [start], rtol=1e-8).y[0, -1]
    assert reached == pytest.approx(steady + 25e5, rel=2e-3)
    assert level_travel(par, start - steady) == 0.0
    assert np.isclose(level_travel(par._replace(bulk_modulus_pa=1.4e8), 25e5), travel / 2)
