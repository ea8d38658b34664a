"""Simulated motion under a measured force, against closed forms and scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hbench.config.stroke_model import parse_motion
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.motion.measured_motion import measured_motion
from hbench.reconcile.motion.open_loop import open_loop_positions
from hbench.records import Run, RunPlan, Specimen

MASS_KG, COULOMB_N, VISCOUS = 5.0, 20.0, 40.0
T_S = np.arange(1200) / 400
TUSTIN = {
    "law": "tustin",
    "coulomb": f"{COULOMB_N} N",
    "stiction": f"{COULOMB_N} N",
    "stribeck_velocity": "10 mm/s",
    "viscous": f"{VISCOUS} N s/m",
}


def simulated(force, x, friction, effects=None):
    """Return the positions in a model under a force, from the first sample of ``x`` on."""
    sections = {"moving_mass": {"test": f"{MASS_KG} kg"}, "friction": {"test": friction}}
    plant = parse_motion(sections | ({"effects": effects} if effects else {}), "axis.yaml")
    plan = RunPlan("0001", "triangle", 1, 0.1, Specimen(0.0, 0.0))
    measured = measured_motion(plant, [Run(plan, T_S, x, f_drive_n=force)], 0.002)
    (log,) = measured.logs
    return open_loop_positions(log, measured.balance_model(Hypothesis()))


def test_a_constant_force_gives_the_exponential_of_viscous_friction():
    force, late = 50.0, np.maximum(T_S - 0.5, 0)
    tau, v = MASS_KG / VISCOUS, (force - COULOMB_N) / VISCOUS
    x = v * (late - tau * (1 - np.exp(-late / tau)))
    # The force is linear between samples: half an interval of its step is earlier.
    step = np.where(T_S > 0.5, force, 0.0)
    assert simulated(step, x, TUSTIN) == pytest.approx(x, abs=0.003)


def test_a_mass_sticks_below_its_dry_friction_and_stops_after_its_impulse_is_spent():
    pushes = np.where((T_S > 0.5) & (T_S < 0.9), 60.0, 0.9 * COULOMB_N)
    sliding = {**TUSTIN, "viscous": "0 N s/m"}
    fast = np.clip(T_S - 0.5, 0, 0.4)
    v_top, back = 0.4 * (60 - COULOMB_N) / MASS_KG, 0.1 * COULOMB_N / MASS_KG
    slow = np.clip(T_S - 0.9, 0, v_top / back)
    x = 0.5 * (60 - COULOMB_N) / MASS_KG * fast**2 + v_top * slow - 0.5 * back * slow**2
    found = simulated(pushes, x, sliding)
    assert found == pytest.approx(x, abs=0.01 * x.max())
    assert np.ptp(found[T_S < 0.45]) == 0.0


def test_bristles_are_integrated_as_by_scipy():
    stiffness = 3e4
    friction = {**TUSTIN, "law": "lugre", "bristle_stiffness": f"{stiffness} N/m"}
    force = 45 * np.sin(2 * np.pi * 0.8 * T_S) ** 3 + 12 * np.sin(2 * np.pi * 2.1 * T_S)

    def rates(t, y):
        _, v, z = y
        dz = v - abs(v) * z * stiffness / COULOMB_N
        return v, (np.interp(t, T_S, force) - stiffness * z - VISCOUS * v) / MASS_KG, dz

    exact = solve_ivp(rates, (0, T_S[-1]), (0.1, 0, 0), t_eval=T_S, rtol=1e-8, atol=1e-10).y[0]
    assert np.ptp(exact) > 0.1
    assert simulated(force, exact, friction) == pytest.approx(exact, abs=0.01 * np.ptp(exact))


def test_an_added_mass_of_the_model_slows_the_motion():
    force = np.where(T_S > 0.5, 50.0, 0.0)
    sliding = {**TUSTIN, "viscous": "0 N s/m"}
    late = np.maximum(T_S - 0.5, 0)
    x = 0.5 * (50 - COULOMB_N) / (MASS_KG + 3) * late**2
    effects = {"added_mass": {"test": "3 kg"}}
    assert simulated(force, x, sliding, effects) == pytest.approx(x, abs=0.02 * x.max())
