"""LuGre from logs with a noisy position, of a made-up bench; see ``bristle_triangles``."""

import re

import numpy as np
import pytest

from hbench.analysis.identification.identify import identify_laws
from hbench.analysis.identification.lugre import UNKNOWNS, fit_lugre
from hbench.analysis.identification.position_noise import LARGEST_SHARE, with_position_noise
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from hbench.records import Fit
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


def fit_of(motions):
    known = {UNKNOWNS[name].field: value for name, value in START.items()}
    law = FrictionParameters(law=LAWS["lugre"].code, **known)
    return fit_lugre(motions, law, list(START)[:6])


def fitted(noise_m, seed):
    return fit_of(logged_motions(campaign(noise_m, seed), MASS_KG)).parameters


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


@pytest.mark.parametrize(
    ("noise_m", "stiffness_n_m", "warned"),
    [(5e-6, 1.2e6, False), (20e-6, 1.2e6, True), (2e-6, 4e6, False), (10e-6, 4e6, True)],
)
def test_noise_that_hides_the_bristles_is_stated_with_its_size(noise_m, stiffness_n_m, warned):
    """It counts beside the deflection: 10 um are much for stiff bristles, and 20 um for soft."""
    motions = logged_motions(campaign(noise_m, 1, stiffness_n_m, unlike=True), MASS_KG)
    estimates = [motion.noise_m for motion in motions]
    assert np.median(estimates) == pytest.approx(noise_m, rel=0.25)
    found = with_position_noise(Fit("lugre", {}, 0.0, True, ""), motions, 450 / stiffness_n_m)
    share = 100 * np.median(estimates) * stiffness_n_m / 450
    stated = re.search(
        r"is ([\d.]+) % of the deflection .*, ([\d.]+) mm\. Above 5 %", found.message
    )
    assert bool(stated) == warned
    if stated:
        assert float(stated[1]) == pytest.approx(share, rel=0.05)
        assert float(stated[2]) == pytest.approx(450e3 / stiffness_n_m, rel=0.05)
        assert "sensor with less noise" in found.message


@pytest.mark.slow
def test_intervals_lose_the_values_where_the_noise_is_above_the_limit():
    """Counted against the fits without noise, since the fit's law is not that of these bristles."""
    stiffness_n_m = 1.2e6
    deflection_m = TRUTH["f_stiction_n"] / stiffness_n_m
    inside = {}
    for share in (0.0, 0.015, LARGEST_SHARE, 0.08, 0.12):
        found = [
            fit_of(
                logged_motions(
                    campaign(share * deflection_m, 50 + seed, stiffness_n_m, unlike=True), MASS_KG
                )
            ).parameters
            for seed in range(8)
        ]
        for name in ("sigma0_n_m", "f_stiction_n"):
            if share == 0.0:
                inside[share, name] = np.mean([each[name].value for each in found])
                continue
            true = inside[0.0, name]
            inside[share, name] = sum(
                each[name].ci95[0] <= true <= each[name].ci95[1] for each in found
            )
            print(f"noise {100 * share:.1f} %: {name} in {inside[share, name]} of 8 intervals")
    for name in ("sigma0_n_m", "f_stiction_n"):
        assert inside[0.015, name] >= 7 > 4 >= inside[0.08, name] >= inside[0.12, name]


def test_both_laws_with_bristles_have_the_remark():
    motions = logged_motions(campaign(25e-6, 1, unlike=True)[::4], MASS_KG)
    fits = {law.law: law.fit for law in identify_laws([], motions)}
    remarks = [fits[law].message for law in ("lugre", "leuven")]
    assert all("% of the deflection of the bristles" in remark for remark in remarks)
