"""Marton and Lantos, and the pressure-based law: what their equations say, in both directions."""

import numpy as np
import pytest

from hbench.config.friction import MartonLantos, PressureBased
from hbench.model.build import friction_parameters
from hbench.model.friction.laws import LAWS, steady_friction
from hbench.model.friction.static_laws import REST_VELOCITY_M_S, regularised_sign
from hbench.model.parameters import FrictionParameters

LINES = MartonLantos.model_validate(
    {
        "law": "marton_lantos",
        "extend": {
            "low_force": "500 N",
            "low_slope": "-3000 N s/m",
            "high_force": "250 N",
            "high_slope": "2000 N s/m",
        },
        "retract": {
            "low_force": "600 N",
            "low_slope": "-4000 N s/m",
            "high_force": "300 N",
            "high_slope": "1000 N s/m",
        },
    }
)
PRESSURE = PressureBased.model_validate(
    {
        "law": "pressure_based",
        "stribeck_force": "200 N",
        "stribeck_rate": "-16 s/m",
        "piston_seal": "1.2 N/bar",
        "rod_seal": "0.8 N/bar",
        "viscous": "1500 N s/m",
    }
)


@pytest.mark.parametrize(
    ("v", "force"),
    [
        (0.02, 500 - 60),  # below v_SW = (500 - 250) / (2000 + 3000) = 50 mm/s
        (0.05, 350.0),
        (0.1, 250 + 200),
        (-0.02, -(600 - 80)),  # v_SW = (600 - 300) / (1000 + 4000) = 60 mm/s
        (-0.06, -360.0),
        (-0.1, -400.0),
    ],
)
def test_marton_lantos_is_its_low_line_up_to_the_switch_velocity(v, force):
    par = friction_parameters(LINES)
    assert steady_friction(v, 50e5, 10e5, par) == pytest.approx(force, rel=1e-12)


@pytest.mark.parametrize("v", [-0.1, -0.01, 0.01, 0.1])
def test_the_pressure_based_law_is_3_7_for_both_signs(v):
    par = friction_parameters(PRESSURE)
    speed = abs(v)
    expected = 200 * np.exp(-16 * speed) + 1.2 * 40 + 0.8 * 10 + 1500 * speed
    assert steady_friction(v, 50e5, 10e5, par) == pytest.approx(np.sign(v) * expected, rel=1e-12)


def test_with_the_same_exponential_the_pressure_based_law_is_tustins():
    par = friction_parameters(PRESSURE)
    tustin = FrictionParameters(
        law=LAWS["tustin"].code,
        coulomb=0.0,
        stiction=200.0,
        stribeck_velocity=1 / 16,
        viscous=1500.0,
        piston_seal=1.2e-5,
        rod_seal=0.8e-5,
    )
    for v in (-0.2, -0.03, 0.004, 0.1):
        assert steady_friction(v, 70e5, 20e5, par) == pytest.approx(
            steady_friction(v, 70e5, 20e5, tustin), rel=1e-12
        )


def test_the_regularised_sign_is_sharp_above_a_few_widths_and_zero_at_rest():
    assert regularised_sign(0.0) == 0.0
    assert regularised_sign(-4 * REST_VELOCITY_M_S) == pytest.approx(1.0, abs=7e-4)
