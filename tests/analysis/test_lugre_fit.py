"""LuGre along logged motions: against an ODE solver, curve_fit, and the virtual rig's truth."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import curve_fit

from hbench.analysis.identification.driven_law import _along, driven_friction
from hbench.analysis.identification.lugre import UNKNOWNS, fit_lugre
from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.model.build import friction_parameters
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from hbench.records import Run, RunPlan, Specimen
from tests.support.analysis.fits import stribeck
from tests.support.analysis.other_plant import (
    OTHER_MASS_KG,
    OTHER_PLANT,
    REVERSALS,
    logged_motions,
)

TRUTH = {
    "sigma0_n_m": 2.6e5,
    "sigma1_n_s_m": 100.0,
    "f_coulomb_n": 310.0,
    "f_stiction_n": 480.0,
    "v_stribeck_m_s": 0.055,
    "b_viscous_n_s_m": 2350.0,
    "k_piston_n_pa": 1e-5,
    "k_rod_n_pa": 0.5e-5,
}
STEADY = ("f_coulomb_n", "f_stiction_n", "v_stribeck_m_s", "b_viscous_n_s_m")
DT = 0.01


def parameters(**values):
    named = {UNKNOWNS[name].field: value for name, value in (TRUTH | values).items()}
    return FrictionParameters(law=LAWS["lugre"].code, **named)


def motion_of(v, friction, p_p=40e5, p_r=20e5, run="0001"):
    return LoggedMotion(
        run=run,
        dt_s=DT,
        v_m_s=v,
        p_p_pa=np.full(len(v), p_p),
        p_r_pa=np.full(len(v), p_r),
        friction_n=friction,
        compared=np.cumsum(np.abs(v)) * DT > 0.02,
        f_applied_n=np.zeros(len(v)),
    )


def swing(seconds=6.0, peak=0.08, slow=0.4):
    """Velocity [m/s] over time, of two periods."""
    return np.arange(
        0.0, seconds, DT
    ), lambda t: peak * np.sin(2 * np.pi * slow * t) * (1 + 0.5 * np.sin(2 * np.pi * 0.17 * t))


def means(t, v_of):
    """Of a velocity, over the sampling intervals."""
    return np.mean([v_of(t + (k + 0.5) / 50 * DT - DT / 2) for k in range(50)], axis=0)


def solved(t, v_of, sigma0, sigma1, f_c, f_s, v_s, b, seal=0.0):
    """Equations 3.8 to 3.12 by scipy, as means over the sampling intervals."""

    def dry(v):
        return f_c + seal + (f_s - f_c) * np.exp(-np.abs(v) / v_s)

    fine = np.arange(t[0], t[-1] + 1e-9, DT / 20)
    z = solve_ivp(
        lambda s, z: v_of(s) - abs(v_of(s)) * z * sigma0 / dry(v_of(s)),
        (fine[0], fine[-1]),
        [0.0],
        t_eval=fine,
        rtol=1e-8,
        atol=1e-12,
        method="LSODA",
        max_step=DT,
    ).y[0]
    rate = v_of(fine) - np.abs(v_of(fine)) * z * sigma0 / dry(v_of(fine))
    force = sigma0 * z + sigma1 * rate + b * v_of(fine)
    centre = np.arange(1, len(t) - 1) * 20
    return np.array([np.mean(force[c - 10 : c + 11]) for c in centre])


def test_the_law_along_a_motion_is_that_of_an_ode_solver():
    t, v_of = swing()
    par = parameters()
    seal = 1e-5 * 20e5 + 0.5e-5 * 20e5
    expected = solved(t, v_of, *[TRUTH[n] for n in list(UNKNOWNS)[:6]], seal)
    found = driven_friction(motion_of(means(t, v_of), 0 * t), par)[1:-1]
    assert np.abs(found - expected).max() < 2.0
    assert np.sqrt(np.mean((found - expected) ** 2)) < 0.5  # of 600 N


def test_columns_of_a_table_need_no_further_compilation():
    t, v_of = swing()
    motion = motion_of(v_of(t), 0 * t)
    contiguous = driven_friction(motion, parameters())
    compiled = len(_along.signatures)
    table = np.column_stack([motion.v_m_s, motion.p_p_pa, motion.p_r_pa])
    columns = dict(zip(("v_m_s", "p_p_pa", "p_r_pa"), table.T, strict=True))
    np.testing.assert_array_equal(
        driven_friction(replace(motion, **columns), parameters()), contiguous
    )
    assert len(_along.signatures) == compiled


def test_bristles_that_can_not_slip_have_gone_as_far_as_the_piston():
    """v = A sin^2(w t), x = A t/2 - A sin(2 w t)/(4 w); at most 0.6 m/s^2."""
    t, peak, w = np.arange(0.0, 2.0, DT), 0.1, 2 * np.pi
    quiet = {name: 0.0 for name in TRUTH} | {"sigma0_n_m": 1e5}
    par = parameters(**quiet | {"f_coulomb_n": 1e12, "f_stiction_n": 1e12})
    found_m = driven_friction(motion_of(means(t, lambda s: peak * np.sin(w * s) ** 2), 0 * t), par)
    expected_m = means(t, lambda s: peak * s / 2 - peak * np.sin(2 * w * s) / (4 * w))
    assert np.abs(found_m / 1e5 - expected_m)[1:-1].max() < 0.5e-6


def test_stiff_bristles_are_the_steady_curve():
    t, v_of = swing()
    found = driven_friction(motion_of(v_of(t), 0 * t), parameters(sigma0_n_m=1e9, sigma1_n_s_m=0.0))
    v = v_of(t)
    steady = np.sign(v) * (310 + 30 + 170 * np.exp(-np.abs(v) / 0.055)) + 2350 * v
    away = np.abs(v) > 0.005  # a sample over a reversal is a mean of both signs
    assert np.abs(found - steady)[away].max() < 1.0


def test_with_stiff_bristles_the_fit_is_that_of_the_tustin_law():
    rng = np.random.default_rng(5)
    known = parameters(sigma0_n_m=1e9, sigma1_n_s_m=0.0, k_piston_n_pa=0.0, k_rod_n_pa=0.0)

    def tustin(v, f_c, f_s, v_s, b):
        return np.sign(v) * (f_c + (f_s - f_c) * np.exp(-np.abs(v) / v_s)) + b * v

    t, _ = swing()
    up = 0.01 + 0.15 * t / t[-1]  # no reversal, so that each sample has one sign
    motions = [
        motion_of(sign * up, tustin(sign * up, 310, 480, 0.055, 2350) + rng.standard_normal(len(t)))
        for sign in (1, -1, 1, -1)
    ]
    fit = fit_lugre(motions, known, STEADY)
    v = np.concatenate([m.v_m_s[m.compared] for m in motions])
    friction = np.concatenate([m.friction_n[m.compared] for m in motions])
    expected, _ = curve_fit(tustin, v, friction, p0=[300, 500, 0.05, 2000], xtol=1e-12)
    found = [fit.parameters[name].value for name in STEADY]
    np.testing.assert_allclose(found, expected, rtol=1e-3)


def test_a_micro_damping_that_the_data_would_have_negative_is_said_to_be_at_its_bound():
    t, v_of = swing()
    values = [TRUTH[name] for name in list(UNKNOWNS)[:6]]
    values[1] = -800.0
    friction = np.concatenate(([0.0], solved(t, v_of, *values), [0.0]))
    motion = motion_of(v_of(t), friction)
    motion.compared[-1] = False
    known = parameters(k_piston_n_pa=0.0, k_rod_n_pa=0.0)
    fit = fit_lugre([motion, motion, motion], known, list(UNKNOWNS)[:6])
    assert fit.parameters["sigma1_n_s_m"].at_bound == "lower"
    assert re.search(r"\bsigma1_n_s_m\b.* lower .* 0 N s/m", fit.message)
    assert fit.parameters["sigma0_n_m"].value == pytest.approx(2.6e5, rel=0.05)


def coverage(bench, rig_runs, seeds):
    """Print and return the share of the 95 % intervals that hold the plant's parameter."""
    inside, damping = [], []
    for seed in seeds:
        motions = logged_motions(rig_runs(REVERSALS, seed), OTHER_MASS_KG)
        fit = fit_lugre(motions, friction_parameters(bench.friction.test), list(UNKNOWNS))
        assert fit.converged, fit.message
        damping.append(fit.parameters["sigma1_n_s_m"].value)
        inside += [
            p.ci95[0] <= TRUTH[name] <= p.ci95[1] for name, p in fit.parameters.items() if p.ci95
        ]
    print(f"LuGre: coverage {sum(inside)} of {len(inside)}")
    print(
        f"sigma1: mean {np.mean(damping):.0f}, "
        f"standard error {np.std(damping, ddof=1) / np.sqrt(len(damping)):.0f} N s/m"
    )
    return np.mean(inside)


def test_the_rigs_parameters_lie_in_the_95_percent_intervals(bench, rig_runs):
    assert coverage(bench, rig_runs, range(6)) >= 0.85


def test_the_rigs_bristle_stiffness_is_found_within_two_percent(bench, rig_runs):
    motions = logged_motions(rig_runs(REVERSALS, 9), OTHER_MASS_KG)
    fit = fit_lugre(motions, friction_parameters(bench.friction.test), list(UNKNOWNS))
    sigma0 = fit.parameters["sigma0_n_m"]
    assert sigma0.value == pytest.approx(2.6e5, rel=0.02) and sigma0.se < 5e3
    assert fit.rmse_n < 12  # the level's scatter of 1.5 % of 500 N, and no more than that


def test_without_noise_and_scatter_the_rigs_bristle_damping_is_found_within_five_percent(
    bench, rig_runs
):
    friction = OTHER_PLANT["friction"]["test"] | {"scatter": 0.0}
    motions = logged_motions(rig_runs(REVERSALS, 1, friction, exact=True), OTHER_MASS_KG)
    fit = fit_lugre(motions, friction_parameters(bench.friction.test), list(UNKNOWNS))
    assert fit.parameters["sigma1_n_s_m"].value == pytest.approx(TRUTH["sigma1_n_s_m"], rel=0.05)
    assert fit.parameters["sigma0_n_m"].value == pytest.approx(TRUTH["sigma0_n_m"], rel=1e-3)


@pytest.mark.slow
def test_the_rigs_parameters_lie_in_the_95_percent_intervals_over_many_seeds(bench, rig_runs):
    """40 campaigns of 8 runs, 8 parameters that go together: two standard deviations are 3 %."""
    assert 0.91 <= coverage(bench, rig_runs, range(100, 140)) <= 0.985


def another_benchs_log(number, rate_hz):
    """Two triangles of velocity with rests, friction by the law, position noise of 3 um."""
    dt, rng = 1 / rate_hz, np.random.default_rng(number)
    t = np.arange(0.0, 10.0, dt)
    rate = 0.25 * (1 + number % 3)  # periods a second
    phase = np.clip(t - 1.0, 0.0, 2 / rate) * rate
    v = 0.08 * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * phase)) * (phase < 2)
    par = parameters(k_piston_n_pa=0.0, k_rod_n_pa=0.0)
    friction = driven_friction(replace(motion_of(v, 0 * v), dt_s=dt), par)
    x = 0.1 + (np.cumsum(v) - v / 2) * dt + 3e-6 * rng.standard_normal(len(t))
    plan = RunPlan(f"{number:04d}", "triangle", 1, 0.08, Specimen(1e-3, 1e-3))
    noise = 2.0 * rng.standard_normal(len(t))
    return Run(
        plan,
        t,
        x,
        p_tp_pa=20e5 + 1e3 * friction,
        p_tr_pa=np.full(len(t), 20e5),
        f_applied_n=noise,
    )


@pytest.mark.parametrize("rate_hz", [100, 500])
def test_noise_of_the_position_at_rest_is_no_static_friction(rate_hz):
    motions = [logged_motion(another_benchs_log(n, rate_hz), 0.0) for n in range(6)]
    known = parameters(k_piston_n_pa=0.0, k_rod_n_pa=0.0)
    fit = fit_lugre(motions, known, list(UNKNOWNS)[:6])
    assert fit.parameters["f_stiction_n"].value == pytest.approx(480.0, rel=0.01)
    v = np.array([0.003, 0.01, 0.04, 0.08])
    found = [fit.parameters[name].value for name in STEADY]
    np.testing.assert_allclose(stribeck(v, *found), stribeck(v, 310, 480, 0.055, 2350), rtol=0.005)
