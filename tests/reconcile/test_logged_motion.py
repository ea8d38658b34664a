"""What the logged motion of a run contains, whatever the kind that its map states."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.reconcile.separation.logged_motion import LoggedMotion, logged_motion
from hbench.reconcile.separation.missing_data import MISSING, missing_data, missing_experiments
from hbench.records import Run, RunPlan, Specimen

T = 0.005 * np.arange(1600)  # 8 s


def logged(v_m_s, kind="steps"):
    """Return a log of a velocity with 5 um of noise in the position."""
    noise = np.random.default_rng(3).normal(0.0, 5e-6, len(T))
    plan = RunPlan("0001", kind, 1, 0.1, Specimen(20e-4, 12e-4))
    return Run(plan, T, 0.15 + np.cumsum(v_m_s) * 0.005 + noise)


def random_steps():
    levels = np.random.default_rng(7).uniform(-0.12, 0.12, 20)
    return levels[np.minimum((T / 0.4).astype(int), 19)]


def one_way():
    return np.array([0.02, 0.12, 0.05, 0.11, 0.03])[(T / 0.4).astype(int) % 5]


def multi_sine():
    return sum(0.04 * np.sin(2 * np.pi * f * T + f) for f in (0.7, 1.3, 2.9))


def test_random_steps_of_both_directions_reverse_change_fast_and_have_several_speeds():
    assert logged_motion(logged(random_steps())) == LoggedMotion(True, True, True, True)


def test_steps_of_one_direction_do_not_reverse():
    found = logged_motion(logged(one_way()))
    assert found == LoggedMotion(False, False, True, True)


def test_a_sum_of_sines_reverses_and_has_several_speeds():
    found = logged_motion(logged(multi_sine()))
    assert found.has_both_directions and found.reverses and found.has_several_speeds


def test_a_stroke_and_its_return_at_one_speed_are_neither_reversals_nor_steps():
    """Ramps of 0.5 s, with a rest between both."""
    v = 0.08 * np.interp(T, [0, 0.5, 3, 3.5, 4.5, 5, 7.5, 8], [0, 1, 1, 0, 0, -1, -1, 0])
    found = logged_motion(logged(v))
    assert found.has_both_directions and not found.reverses and not found.has_fast_changes


def test_rest_contains_no_motion():
    assert logged_motion(logged(np.zeros(1600))) == LoggedMotion(False, False, False, False)


@pytest.mark.parametrize("kind", ["steps", "ramp"])
def test_an_imported_campaign_is_not_asked_for_the_motion_that_it_contains(kind):
    motion = {"speeds", "directions", "reversals", "steps"}
    assert not motion & missing_experiments([logged(random_steps(), kind)]).keys()
    asked = missing_experiments([logged(one_way(), kind)])
    assert motion & asked.keys() == {"directions", "reversals"}


def test_a_bench_of_one_cylinder_is_not_asked_for_one_load_at_two_pressures():
    runs = [logged(multi_sine())]
    assert MISSING["pressures"] in missing_experiments(runs).values()
    assert "pressures" not in missing_experiments(runs, absent=("flow_lp", "force_load"))


def test_what_runs_that_are_left_out_have_measured_is_not_asked_for_again():
    """Two loads, eight plans; the logs of all are left out, as for gaps of samples."""
    channels = {name: np.ones(1600) for name in ("v_m_s", "p_tp_pa", "p_tr_pa", "p_s_pa", "u_t_v")}
    every = [
        replace(
            (run := logged(random_steps())),
            plan=replace(run.plan, label=f"plan {i}"),
            f_applied_n=np.full(1600, 500.0 + 1500.0 * (i % 2)),
            **channels,
        )
        for i in range(8)
    ]
    of_load = ("flow_lp", "flow_lr", "force_load")
    assert missing_data(every, every, absent=of_load) == (True, (MISSING["hold"],))
    logs = "the runs that are left out, with complete logs"
    assert missing_data([], every, absent=of_load) == (False, (logs, MISSING["hold"]))
    suffices, (first, *_) = missing_data(every[:1], every, absent=of_load)
    assert not suffices and first == f"{logs} (the others do not suffice)"
    aborted = [replace(run, aborted="emergency stop") for run in every]
    suffices, (first, *others) = missing_data(every[:7], [*every[:7], aborted[7]], absent=of_load)
    assert first.startswith("at least 8 operating points (") and first.endswith("have 7")
    assert not suffices and others == [MISSING["hold"]]
