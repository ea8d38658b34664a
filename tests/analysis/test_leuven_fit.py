"""Leuven's elements, in one batch and online: against a hand-made law and the rig's truth."""

import numpy as np
import pytest
from scipy.stats import t as student

from hbench.analysis.identification.driven_law import friction_along
from hbench.analysis.identification.leuven import (
    STEADY,
    fit_leuven,
    hysteresis_at,
    identify_online,
    steady_curve,
)
from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motions
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from tests.support.analysis.other_plant import LEUVEN_FRICTION, OTHER_MASS_KG, REVERSALS

THETA = np.array([120.0, 80.0, 400.0])
TRUTH = {
    "theta_1_n": 120.0,
    "theta_2_n": 80.0,
    "theta_3_n": 400.0,
    "f_coulomb_n": 310.0,
    "f_stiction_n": 480.0,
    "v_stribeck_m_s": 0.055,
    "b_viscous_n_s_m": 2350.0,
    "delta_max_m": 2e-3,
}
# Where the searches start; the seals' terms are taken as known.
GUESS = FrictionParameters(
    law=LAWS["leuven"].code,
    coulomb=200.0,
    stiction=400.0,
    stribeck_velocity=0.08,
    viscous=3000.0,
    piston_seal=1e-5,
    rod_seal=0.5e-5,
    elements=(200.0, 200.0, 200.0),
    presliding=2e-3,
)
STEADY_KNOWN = GUESS._replace(
    coulomb=310.0, stiction=480.0, stribeck_velocity=0.055, viscous=2350.0
)


def motion_of(v):
    zero = np.zeros(len(v))
    return LoggedMotion("0001", 0.01, v, zero + 40e5, zero + 20e5, zero, zero == 0, zero)


def by_hand(v, dt):
    """Equations 3.14 to 3.20 with positions xi of the elements, in very short steps."""
    limits = 2e-3 * np.arange(1, 4) / 3
    u, xi, force = 0.0, np.zeros(3), np.zeros(len(v))
    for k, speed in enumerate(v):
        y = np.clip((u - xi) / limits, -1, 1)
        f_h = THETA @ y
        s = np.sign(speed) * (310 + 30 + 170 * np.exp(-abs(speed) / 0.055))
        force[k] = f_h + 2350 * speed
        if s:
            u += dt * speed * (1 - f_h / s)
        xi = np.clip(xi, u - limits, u + limits)
    return force


def test_the_law_along_a_motion_is_that_of_the_source_in_short_steps():
    fine = np.arange(0, 4, 1e-4)
    v = 0.04 * np.sin(2 * np.pi * 0.6 * fine) * (1 + 0.5 * np.sin(2 * np.pi * 0.2 * fine))
    truth = STEADY_KNOWN._replace(elements=tuple(THETA))
    found = friction_along(motion_of(v[::100]), truth)
    expected = np.convolve(by_hand(v, 1e-4), np.ones(100) / 100, "same")[::100]
    assert np.abs(found - expected)[1:-1].max() < 3.0  # of 550 N


def test_the_steady_curve_is_that_of_the_source():
    v = np.array([-0.1, 0.02])
    expected = 310 + 20 + 10 + 170 * np.exp(-np.abs(v) / 0.055)
    np.testing.assert_allclose(steady_curve(motion_of(v), STEADY_KNOWN), expected)


@pytest.fixture
def leuven_motions(rig_runs):
    """Return a function that makes the reversals on the rig with a Leuven cylinder."""
    return lambda seed: logged_motions(rig_runs(REVERSALS, seed, LEUVEN_FRICTION), OTHER_MASS_KG)


def inside(fit):
    return [p.ci95[0] <= TRUTH[name] <= p.ci95[1] for name, p in fit.parameters.items()]


@pytest.mark.parametrize("trials", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_the_rigs_elements_and_delta_max_are_found_from_a_delta_max_half_as_long_again(
    leuven_motions, trials
):
    start = GUESS._replace(presliding=3e-3)
    motions = leuven_motions(0)[:: 3 - trials]  # of each load
    fit = fit_leuven(motions, start, (*STEADY, "delta_max_m"))
    assert fit.converged, fit.message
    assert fit.parameters["delta_max_m"].value == pytest.approx(2e-3, rel=0.05)
    # All at once in 99 % of campaigns of so many runs.
    limit = student.ppf(1 - 0.005 / len(TRUTH), len(motions) - 1)
    for name, p in fit.parameters.items():
        assert abs(p.value - TRUTH[name]) < limit * p.se, name


EXCITED_M = (0.3e-3, 1.0e-3, 1.3e-3)


def online(motions, forgetting=1.0):
    """The recursive estimate, and its hysteresis force beside the true elements'."""
    estimate = identify_online(motions, STEADY_KNOWN, forgetting)
    found = [hysteresis_at(z, estimate.theta, STEADY_KNOWN) for z in EXCITED_M]
    return estimate, np.array(found) / [by_elements(z) for z in EXCITED_M]


def by_elements(z):
    return 120 * min(z / (2e-3 / 3), 1) + 80 * min(z / (4e-3 / 3), 1) + 400 * min(z / 2e-3, 1)


def test_online_the_hysteresis_force_is_found_but_not_the_elements_one_by_one(leuven_motions):
    for seed in range(3):
        estimate, ratio = online(leuven_motions(seed))
        assert ratio == pytest.approx([1, 1, 1], abs=0.03)
        assert ratio[1:] == pytest.approx([1, 1], abs=0.015)
        said = np.sqrt(estimate.error * np.diag(estimate.p))
        assert np.abs(estimate.theta - THETA).max() > 10 * said.max()


def test_online_where_it_begins_is_where_further_passes_stay(leuven_motions):
    """Sliding deflects by the estimate itself: as long as that changes, so does what is learnt."""
    motions = leuven_motions(0)
    _, first = online(motions)
    _, again = online((*motions, *motions, *motions))
    assert first == pytest.approx(again, abs=2e-3)


def test_forgetting_follows_elements_that_soften_between_two_campaigns(rig_runs):
    motions = []
    for seed, factor in ((0, 1.0), (20, 0.85)):
        changed = LEUVEN_FRICTION | {"elements": [f"{factor * theta} N" for theta in THETA]}
        motions += logged_motions(rig_runs(REVERSALS, seed, changed), OTHER_MASS_KG)
    _, following = online(motions, forgetting=0.99)
    _, mean = online(motions)
    assert following == pytest.approx([0.85, 0.85, 0.85], abs=0.03)
    assert (mean[1:] > 0.88).all() and (mean < 0.93).all()


@pytest.mark.slow
def test_held_out_runs_tell_the_right_delta_max_from_a_wrong_one(leuven_motions):
    train, held_out = leuven_motions(0), leuven_motions(1)
    rmse = {}
    for given in (1.4e-3, 2e-3, 2.8e-3):
        fit = fit_leuven(train, GUESS._replace(presliding=given))
        value = [fit.parameters[name].value for name in list(TRUTH)[:7]]
        coulomb, stiction, stribeck, viscous = value[3:]
        law = STEADY_KNOWN._replace(
            elements=tuple(value[:3]),
            presliding=given,
            coulomb=coulomb,
            stiction=stiction,
            stribeck_velocity=stribeck,
            viscous=viscous,
        )
        errors = [(friction_along(m, law) - m.friction_n)[m.compared] for m in held_out]
        rmse[given] = np.sqrt(np.mean(np.concatenate(errors) ** 2))
    print("Leuven: rmse [N] of held-out runs by Delta_max [m]:", rmse)
    assert min(rmse, key=rmse.get) == 2e-3


def coverage(leuven_motions, seeds):
    held = [one for s in seeds for one in inside(fit_leuven(leuven_motions(s), GUESS))]
    print(f"Leuven: coverage {sum(held)} of {len(held)}")
    return np.mean(held)


@pytest.mark.slow
def test_the_rigs_parameters_lie_in_the_95_percent_intervals_over_many_seeds(leuven_motions):
    """40 campaigns of 8 runs, 7 parameters that go together: two standard deviations are 3 %."""
    assert 0.90 <= coverage(leuven_motions, range(100, 140)) <= 0.985
