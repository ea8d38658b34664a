"""What compares a law's model with the measurement, and steady fits with ramps."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hbench.analysis.curves.ramp_fits import curve_error
from hbench.analysis.curves.ramps import ramp_curve
from hbench.analysis.fitting.tustin import PARAMETER_NAMES
from hbench.analysis.identification.verification import (
    SETTLE_S,
    model_errors,
    steady_parts,
    trial_scatter,
    unchanged,
)
from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.config.files.loading import read_yaml
from hbench.errors import DataError
from hbench.records import Fit, FitParameter, Motion
from tests.support.analysis.other_plant import OTHER_MASS_KG, OTHER_PLANT

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
    first = int(np.argmax(logged_motion(real, 0.0).compared))
    assert abs(real.x_m[first] - real.x_m[0]) == pytest.approx(0.02, abs=1e-3)
    early = 30 - first  # samples between 20 mm and 0.3 s
    unsteady = np.sqrt((early * 9 + 30 * 4) / (early + 30)) * 1e4
    assert errors["unsteady"].p_tp_pa == pytest.approx(unsteady)
    assert {e.v_m_s for e in errors.values()} == {e.p_tr_pa for e in errors.values()} == {0.0}
    assert [e.samples for e in errors.values()] == [240, 2 * (early + 30), 40]


def test_the_state_before_the_log_changes_no_error_and_no_scatter(make_run):
    real = profile_run(make_run)
    early = np.where(np.abs(real.x_m - real.x_m[0]) < 0.019, 5e5, 0.0)
    model = replace(real, p_tp_pa=real.p_tp_pa + early)
    assert {e.friction_n for e in model_errors([real], [model], 0.0).values()} == {0.0}
    assert {e.friction_n for e in trial_scatter([real, model], 0.0).values()} == {0.0}
    late = replace(real, p_tp_pa=real.p_tp_pa + np.where(early > 0, 0.0, 5e5))
    assert model_errors([real], [late], 0.0)["unsteady"].friction_n > 100.0


def test_a_steady_part_in_which_only_the_model_oscillates_is_apart(make_run):
    """An amplitude of 8e4 Pa on the piston is 8e4 A / sqrt(2) in the RMS of friction."""
    base = profile_run(make_run)
    noise = 1e3 * np.random.default_rng(1).standard_normal(len(base.t_s))
    real = replace(base, p_tp_pa=base.p_tp_pa + noise)
    wave = 8e4 * np.sin(2 * np.pi * 10 * real.t_s)
    shifted = replace(real, p_tp_pa=real.p_tp_pa + 1e4)
    rough = replace(real, p_tp_pa=real.p_tp_pa + wave)
    parts = steady_parts([real, real], [shifted, rough], 0.0)
    area = real.plan.specimen.area_piston_m2
    speed = abs(real.v_ref_m_s[-1])
    assert parts.smooth.friction_n == pytest.approx(1e4 * area)
    assert parts.oscillating.friction_n == pytest.approx(8e4 / np.sqrt(2) * area, rel=0.05)
    assert parts.parts == 2 * len(parts.speeds_m_s) and set(parts.speeds_m_s) == {speed}
    assert parts.smooth.samples + parts.oscillating.samples == 240


def test_a_model_of_another_profile_is_refused(make_run):
    real = profile_run(make_run)
    other = replace(real, plan=replace(real.plan, motion=Motion(0.1, 0.0, 0.4, 0.0, ())))
    with pytest.raises(DataError, match="run 0001: .*profile"):
        model_errors([real], [other], 0.0)


def test_a_ramp_on_the_steady_curve_gives_the_steady_fit(make_curve):
    truth = (300.0, 500.0, 0.07, 1500.0)

    def law(v):
        return 300 + 200 * np.exp(-v / 0.07) + 1500 * v

    steady = make_curve(SPEEDS, law(SPEEDS), "retract")
    v = np.arange(1, 2000) * 1e-4
    zero = np.zeros(len(v))
    ramp = LoggedMotion("0001", 0.01, -v, zero + 40e5, zero + 20e5, -law(v), zero == 0, zero)
    found = ramp_curve(replace(steady, kind="ramp"), [ramp], SPEEDS)
    assert len(found.points) == 19 and found.kind == "ramp"
    assert all(point.v_m_s < 0 and point.friction_n < 0 for point in found.points)
    given = {
        n: FitParameter(x, None, None, None, "")
        for n, x in zip(PARAMETER_NAMES, truth, strict=True)
    }
    fit = Fit("tustin", given, 0.0, True, "")
    assert curve_error(fit, found) < 1.0  # a bin's mean is not the law at its mean speed
    assert curve_error(fit, steady) < 1e-9


def test_friction_in_the_direction_of_motion_is_as_far_from_a_law_as_its_sign_says(make_curve):
    curve = make_curve([0.01, 0.1], [-3.0, 4.0], "retract")
    given = dict.fromkeys(PARAMETER_NAMES, FitParameter(0.0, None, None, None, ""))
    # The law is 1 N at all speeds.
    given |= {n: FitParameter(1.0, None, None, None, "") for n in PARAMETER_NAMES[:3]}
    found = curve_error(Fit("tustin", given, 0.0, True, ""), curve)
    assert found == pytest.approx(np.sqrt((4**2 + 3**2) / 2))


def of_kind(kind, **conditions):
    chosen = {"kind": kind} | conditions
    experiments = read_yaml(DYNAMICS)["experiments"]
    return [e for e in experiments if chosen.items() <= e.items()]


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


def test_the_scatter_of_trials_is_their_standard_deviation(make_run):
    base = profile_run(make_run)
    steps = np.array([-3e4, 1e4, 2e4])
    runs = [replace(base, p_tp_pa=base.p_tp_pa + step) for step in steps]
    found = trial_scatter(runs, 0.0)
    area = base.plan.specimen.area_piston_m2
    for part in ("steady", "unsteady", "rest"):
        assert found[part].p_tp_pa == pytest.approx(np.std(steps, ddof=1))
        assert found[part].friction_n == pytest.approx(np.std(steps, ddof=1) * area)
        assert found[part].v_m_s == 0.0
    other = replace(base, plan=replace(base.plan, f_load_n=1.0))
    assert trial_scatter([base, other], 0.0) == {}, "one trial of each load tells no scatter"
