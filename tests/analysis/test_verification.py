"""Identified laws against the rig: on the verification profile, and steady fits against ramps."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from other_plant import OTHER_MASS_KG, OTHER_PLANT, REVERSALS, STEADY

from hbench import workflow
from hbench.analysis import leuven_fit
from hbench.analysis.fit import NAMES, fit_tustin
from hbench.analysis.logged_motion import LoggedMotion, logged_motions
from hbench.analysis.lugre_fit import fit_lugre
from hbench.analysis.marton_lantos import marton_lantos
from hbench.analysis.pressure_fit import fit_pressure_based
from hbench.analysis.verification import (
    SETTLE_S,
    curve_error,
    model_errors,
    ramp_curve,
    unchanged,
)
from hbench.config.loading import read_yaml
from hbench.errors import DataError
from hbench.model.parameters import friction_parameters
from hbench.records import Fit, FitParameter, Motion

DYNAMICS = Path(__file__).parents[2] / "configs" / "dynamics.yaml"
SPEEDS = np.linspace(0.005, 0.195, 20)


def test_the_reference_is_unchanged_after_three_tenths_of_a_second_and_not_before():
    v_ref = np.concatenate([np.linspace(0, 0.1, 21), np.full(80, 0.1), [0.09], np.zeros(40)])
    found = np.flatnonzero(unchanged(v_ref, 0.01))
    after = round(SETTLE_S / 0.01)
    np.testing.assert_array_equal(found, [*range(20 + after, 101), *range(102 + after, 142)])


def profile_run(make_run, **changes):
    """0.5 s at rest, then 80 mm/s at once."""
    run = make_run(v_m_s=0.08, duration_s=2.0)
    v_ref = np.where(run.t_s < 0.5, 0.0, 0.08)
    plan = replace(run.plan, motion=Motion(0.0, 0.0, 0.4, 0.0, ()))
    return replace(run, plan=plan, v_ref_m_s=v_ref, **changes)


def test_errors_are_those_that_were_put_in_part_by_part(make_run):
    real = profile_run(make_run)
    part = np.where(real.t_s < 0.5, 3e4, np.where(real.t_s < 0.8, 2e4, 1e4))
    model = replace(real, p_tp_pa=real.p_tp_pa + part)
    errors = model_errors([real, real], [model, model], 0.0)
    area = real.plan.specimen.area_piston_m2
    assert errors["steady"].p_tp_pa == pytest.approx(1e4)
    assert errors["steady"].friction_n == pytest.approx(1e4 * area)
    assert errors["rest"].p_tp_pa == pytest.approx(3e4)
    assert errors["unsteady"].p_tp_pa == pytest.approx(np.sqrt((30 * 9 + 30 * 4) / 60) * 1e4)
    assert {e.v_m_s for e in errors.values()} == {e.p_tr_pa for e in errors.values()} == {0.0}
    assert [e.samples for e in errors.values()] == [240, 120, 40]


def test_a_model_of_another_profile_is_refused(make_run):
    real = profile_run(make_run)
    other = replace(real, plan=replace(real.plan, motion=Motion(0.1, 0.0, 0.4, 0.0, ())))
    with pytest.raises(DataError, match="run 0001: its model has not followed the same profile"):
        model_errors([real], [other], 0.0)


def test_a_ramp_on_the_steady_curve_gives_the_steady_fit(make_curve):
    truth = (300.0, 500.0, 0.07, 1500.0)

    def law(v):
        return 300 + 200 * np.exp(-v / 0.07) + 1500 * v

    steady = make_curve(SPEEDS, law(SPEEDS), "retract")
    v = np.arange(1, 2000) * 1e-4
    zero = np.zeros(len(v))
    ramp = LoggedMotion("0001", 0.01, -v, zero + 40e5, zero + 20e5, -law(v), zero == 0)
    found = ramp_curve(steady, [ramp], SPEEDS)
    assert len(found.points) == 19 and found.kind == "ramp"
    assert all(point.v_m_s < 0 and point.friction_n < 0 for point in found.points)
    given = {n: FitParameter(x, None, None, None, "") for n, x in zip(NAMES, truth, strict=True)}
    fit = Fit("tustin", given, 0.0, True, "")
    assert curve_error(fit, found) < 1.0  # a bin's mean is not the law at its mean speed
    assert curve_error(fit, steady) < 1e-9


def of_kind(kind, **conditions):
    chosen = {"kind": kind} | conditions
    experiments = read_yaml(DYNAMICS)["experiments"]
    return [e for e in experiments if chosen.items() <= e.items()]


def values(fit):
    return {name: p.value for name, p in fit.parameters.items()}


def as_config(fit):
    """The keys of a bench file's friction, in SI."""
    keys = {
        "f_coulomb_n": ("coulomb", "N"),
        "f_stiction_n": ("stiction", "N"),
        "v_stribeck_m_s": ("stribeck_velocity", "m/s"),
        "b_viscous_n_s_m": ("viscous", "N s/m"),
        "sigma0_n_m": ("bristle_stiffness", "N/m"),
        "sigma1_n_s_m": ("bristle_damping", "N s/m"),
        "delta_max_m": ("presliding", "m"),
        "k1_n": ("stribeck_force", "N"),
        "k2_s_m": ("stribeck_rate", "s/m"),
        "k5_n_s_m": ("viscous", "N s/m"),
    }
    seals = {"k_piston_n_pa", "k3_n_pa"}, {"k_rod_n_pa", "k4_n_pa"}
    config = {"law": fit.law}
    for name, value in values(fit).items():
        if name in keys:
            key, unit = keys[name]
            config[key] = f"{value!r} {unit}"
        elif name in seals[0] | seals[1]:
            config["piston_seal" if name in seals[0] else "rod_seal"] = f"{1e5 * value!r} N/bar"
    if fit.law == "marton_lantos":
        found = values(fit)
        lines = {f"{line}_force": f"{found[f'{line}_force_n']!r} N" for line in ("low", "high")}
        for line in ("low", "high"):
            lines[f"{line}_slope"] = f"{found[f'{line}_slope_n_s_m']!r} N s/m"
        config |= {"extend": lines, "retract": lines}
    if fit.law == "leuven":
        thetas = [value for name, value in values(fit).items() if name.startswith("theta")]
        config["elements"] = [f"{theta!r} N" for theta in thetas]
    return config


def test_a_model_with_the_plants_own_law_leaves_scatter_and_noise_and_a_softer_one_does_not(
    rig_runs,
):
    (profile,) = of_kind("verification")
    profile |= {"loads": ["500 N"], "trials": 1}
    own = OTHER_PLANT["friction"]["test"] | {"scatter": 0.0}
    softer = own | {"bristle_stiffness": "1.3e5 N/m"}
    measured = rig_runs([profile], 1)
    good, bad = (
        model_errors(measured, rig_runs([profile], 1, friction, exact=True), OTHER_MASS_KG)
        for friction in (own, softer)
    )
    assert good["steady"].friction_n < 25 and good["unsteady"].friction_n < 25
    assert bad["unsteady"].friction_n > 5 * good["unsteady"].friction_n
    assert bad["unsteady"].v_m_s > 2 * good["unsteady"].v_m_s
    assert abs(bad["steady"].friction_n - good["steady"].friction_n) < 25, "sliding is the same"


def identified(bench, rig_campaign, rig_runs):
    """All five laws, from steady runs and reversals that are not the verification's."""
    curves = workflow.analyze(rig_campaign(STEADY, 2)).curves
    points = [
        replace(p, v_m_s=abs(p.v_m_s), friction_n=abs(p.friction_n))
        for curve in curves
        for p in curve.points
    ]
    both = replace(curves[0], points=tuple(sorted(points, key=lambda p: p.v_m_s)))
    tustin = fit_tustin(both)
    motions = logged_motions(rig_runs(REVERSALS, 3), OTHER_MASS_KG)
    known = friction_parameters(bench.friction.test)
    guess = known._replace(elements=(150.0, 150.0, 300.0), presliding=2e-3)
    names = (*leuven_fit.STEADY, "k_piston_n_pa", "k_rod_n_pa", "delta_max_m")
    return [
        tustin,
        marton_lantos(both, tustin),
        fit_pressure_based(curves),
        fit_lugre(motions, known),
        leuven_fit.fit_leuven(motions, guess, names),
    ]


@pytest.mark.slow
def test_laws_with_a_memory_follow_the_verification_profile_and_static_ones_less(
    bench, rig_campaign, rig_runs
):
    """The plant has LuGre's law, 1.5 % scatter and noise; the models' rest is the plant's own."""
    profile = of_kind("verification")
    measured = rig_runs(profile, 1)
    found = {}
    print("\nroot mean square errors: friction N, velocity mm/s, P_Tp bar, P_Tr bar")
    for fit in identified(bench, rig_campaign, rig_runs):
        modelled = rig_runs(profile, 1, as_config(fit), exact=True)
        found[fit.law] = model_errors(measured, modelled, OTHER_MASS_KG)
        for part, e in found[fit.law].items():
            pressures = f"{e.p_tp_pa / 1e5:6.2f} {e.p_tr_pa / 1e5:6.2f}"
            print(
                f"{fit.law:15}{part:9}{e.friction_n:7.1f} {1e3 * e.v_m_s:6.2f} {pressures}"
                f"  ({e.samples} samples)"
            )
    for law in ("lugre", "leuven"):
        assert found[law]["steady"].friction_n < 15 > found[law]["unsteady"].friction_n
        assert found[law]["unsteady"].v_m_s < 0.3e-3
        for static in ("tustin", "marton_lantos", "pressure_based"):
            ours, theirs = found[law]["unsteady"], found[static]["unsteady"]
            assert 5 * ours.friction_n < theirs.friction_n
            assert 5 * ours.v_m_s < theirs.v_m_s


@pytest.mark.slow
def test_steady_and_ramp_fits_differ_as_the_source_found(rig_campaign, rig_runs):
    """Section 6.2: each fit is good for its own data and not for the other's."""
    curves = workflow.analyze(rig_campaign(STEADY, 2)).curves
    runs = rig_runs(of_kind("ramp", direction="extend"), 4)
    print("\nerror of a Tustin fit, N:   steady fit on   ramp fit on")
    print("load N  ramp m/s^2        steady    ramp   steady    ramp")
    for steady in curves:
        if steady.direction == "retract":
            continue
        for a in (0.0335, 0.067, 0.1005):
            own = [
                run
                for run in runs
                if run.plan.f_load_n == steady.f_load_n and run.plan.a_ref_m_s2 == pytest.approx(a)
            ]
            ramp = ramp_curve(steady, logged_motions(own, OTHER_MASS_KG), SPEEDS)
            on = [curve_error(fit_tustin(c), d) for c in (steady, ramp) for d in (steady, ramp)]
            print(f"{steady.f_load_n:6.0f} {a:8.4f}        " + "  ".join(f"{e:7.1f}" for e in on))
            assert on[1] > 5 * on[0] and on[2] > 1.2 * on[3] and on[2] > 5 * on[0]
