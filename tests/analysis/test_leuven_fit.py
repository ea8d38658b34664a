"""Leuven's elements: against a hand-made law and the rig's truth."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from hbench.analysis.identification.driven_law import driven_friction
from hbench.analysis.identification.identify import identify_laws
from hbench.analysis.identification.leuven import STEADY, fit_leuven
from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.config.friction import parse_friction
from hbench.model.build import friction_parameters
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from tests.support.analysis.other_plant import (
    LEUVEN_FRICTION,
    OTHER_MASS_KG,
    REVERSALS,
    logged_motions,
)

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
    fine = np.arange(0, 2, 1e-4)
    v = 0.04 * np.sin(2 * np.pi * 0.6 * fine) * (1 + 0.5 * np.sin(2 * np.pi * 0.2 * fine))
    truth = STEADY_KNOWN._replace(elements=tuple(THETA))
    found = driven_friction(motion_of(v[::100]), truth)
    expected = np.convolve(by_hand(v, 1e-4), np.ones(100) / 100, "same")[::100]
    assert np.abs(found - expected)[1:-1].max() < 3.0  # of 550 N


def test_short_elements_are_the_steady_curve():
    """Elements of 3 um carry 800 N and slip within 1 mm/s in each step of 1 ms."""
    v = 0.04 * np.sin(2 * np.pi * 0.6 * np.arange(0, 4, 1e-2))
    law = STEADY_KNOWN._replace(elements=(200.0, 200.0, 400.0), presliding=1e-5)
    found = driven_friction(motion_of(v), law)
    dry = 310 + 30 + 170 * np.exp(-np.abs(v) / 0.055)
    sliding = np.abs(v) > 0.02
    assert np.abs(found - np.sign(v) * dry - 2350 * v)[sliding].max() < 1.0


def test_sliding_without_presliding_is_fitted_as_the_steady_law():
    """Of a friction that depends on the velocity alone, the elements' stiffness is not found."""
    t = np.arange(0, 8, 5e-3)
    v = 0.06 * np.sin(2 * np.pi * 0.4 * t)
    noise = 5.0 * np.random.default_rng(1).standard_normal(len(v))
    friction = np.tanh(v / 1e-3) * (250 + 90 / (1 + (v / 0.02) ** 2)) + 900 * v + noise
    motion = replace(motion_of(v), dt_s=5e-3, friction_n=friction)
    calls = []

    def counted(*arguments):
        calls.append(1)
        return driven_friction(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hbench.analysis.identification.lugre.driven_friction", counted)
        start = GUESS._replace(presliding=5e-5, piston_seal=0.0, rod_seal=0.0)
        fit = fit_leuven([motion], start, (*STEADY, "delta_max_m"), spans=(1.0,))
    assert fit.converged, fit.message
    assert fit.rmse_n < 20.0  # of 500 N; the curve of this friction is no Stribeck curve
    assert len(calls) < 1500


def test_the_written_laws_err_along_the_motions_as_their_fits_do():
    """Also in the damping of the bristles: of a viscoelastic contact with a curved viscous part."""
    motions = []
    for number, top in enumerate((0.03, 0.06, 0.1)):
        t = np.arange(0, 6, 1e-4)
        v = top * np.sin(2 * np.pi * 0.5 * t)
        z, rate = np.zeros(len(t)), np.zeros(len(t))
        for k in range(1, len(t)):
            rate[k] = v[k] - abs(v[k]) * z[k - 1] * 3e5 / (240 + 90 / (1 + (v[k] / 0.02) ** 2))
            z[k] = z[k - 1] + 1e-4 * rate[k]
        force = 3e5 * z + 4e3 * rate + 150 * np.arcsinh(v / 0.05)
        means = [signal.reshape(-1, 50).mean(axis=1) for signal in (v, force)]
        motion = replace(motion_of(means[0]), dt_s=5e-3, friction_n=means[1])
        motions.append(replace(motion, run=f"{number:04d}"))
    laws = {law.law: law for law in identify_laws([], motions)}
    for name in ("lugre", "leuven"):
        law = laws[name]
        par = friction_parameters(parse_friction(law.section, name))
        errors = [(driven_friction(m, par) - m.friction_n)[m.compared] for m in motions]
        rmse_n = np.sqrt(np.mean(np.concatenate(errors) ** 2))
        assert rmse_n == pytest.approx(law.fit.rmse_n, rel=0.01), name


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


@pytest.mark.slow
def test_held_out_runs_tell_the_right_delta_max_from_a_wrong_one(leuven_motions):
    train, held_out = leuven_motions(0), leuven_motions(1)
    rmse = {}
    for given in (1.4e-3, 2e-3, 2.8e-3):
        fit = fit_leuven(train, GUESS._replace(presliding=given), STEADY)
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
        errors = [(driven_friction(m, law) - m.friction_n)[m.compared] for m in held_out]
        rmse[given] = np.sqrt(np.mean(np.concatenate(errors) ** 2))
    print("Leuven: rmse [N] of held-out runs by Delta_max [m]:", rmse)
    assert min(rmse, key=rmse.get) == 2e-3


def coverage(leuven_motions, seeds):
    held = [one for s in seeds for one in inside(fit_leuven(leuven_motions(s), GUESS, STEADY))]
    print(f"Leuven: coverage {sum(held)} of {len(held)}")
    return np.mean(held)


@pytest.mark.slow
def test_the_rigs_parameters_lie_in_the_95_percent_intervals_over_many_seeds(leuven_motions):
    """40 campaigns of 8 runs, 7 parameters that go together: two standard deviations are 3 %."""
    assert 0.90 <= coverage(leuven_motions, range(100, 140)) <= 0.985
