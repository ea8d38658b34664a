"""LuGre from logs with a noisy position, of a made-up bench; see ``bristle_triangles``."""

import numpy as np
import pytest

from hbench.analysis.identification.lugre import UNKNOWNS, fit_lugre
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from tests.support.analysis.bristle_triangles import MASS_KG, TRUTH, campaign
from tests.support.analysis.other_plant import logged_motions

START = {
    "sigma0_n_m": 1e6,
    "sigma1_n_s_m": 0.0,
    "f_coulomb_n": 310.0,
    "f_stiction_n": 480.0,
    "v_stribeck_m_s": 0.03,
    "b_viscous_n_s_m": 2000.0,
    "k_piston_n_pa": 0.0,
    "k_rod_n_pa": 0.0,
}


def fitted(noise_m, seed):
    known = {UNKNOWNS[name].field: value for name, value in START.items()}
    return fit_lugre(
        logged_motions(campaign(noise_m, seed), MASS_KG),
        FrictionParameters(law=LAWS["lugre"].code, **known),
        list(START)[:6],
    ).parameters


def test_the_steady_curve_is_found_with_a_usual_noise():
    """5 um, in one campaign; the intervals of eight are below."""
    found = fitted(5e-6, seed=0)
    assert found["f_stiction_n"].value == pytest.approx(TRUTH["f_stiction_n"], rel=0.03)
    assert found["f_coulomb_n"].value == pytest.approx(TRUTH["f_coulomb_n"], rel=0.1)
    assert found["v_stribeck_m_s"].value == pytest.approx(TRUTH["v_stribeck_m_s"], rel=0.2)
    assert found["b_viscous_n_s_m"].value == pytest.approx(TRUTH["b_viscous_n_s_m"], rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(("noise_m", "most"), [(0.0, 0.1), (5e-6, 0.1), (20e-6, 0.2)])
def test_the_steady_curve_is_found_in_eight_campaigns(noise_m, most):
    found = [fitted(noise_m, seed) for seed in range(8)]
    inside = 0
    for name, true in TRUTH.items():
        values = [each[name].value for each in found]
        own = sum(each[name].ci95[0] <= true <= each[name].ci95[1] for each in found)
        inside += own
        print(
            f"{1e6 * noise_m:.0f} um: {name} {true}: mean {np.mean(values):.4g}, "
            f"{min(values):.4g} to {max(values):.4g}, in the interval in {own} of 8"
        )
        assert np.mean(values) == pytest.approx(true, rel=most)
    sigma1 = [each["sigma1_n_s_m"].value for each in found]
    print(f"{1e6 * noise_m:.0f} um: sigma1 0: {min(sigma1):.0f} to {max(sigma1):.0f} N s/m")
    assert noise_m > 10e-6 or inside >= 24  # of 32
