"""Runs that are not steady: each kind's rules, and the reason that a broken one gives."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.screening.screen import screen
from hbench.config.schedule import Screening
from tests.support.analysis.moving import (
    levels_velocity,
    motion_of,
    moving_run,
    ramp_velocity,
    triangle_velocity,
)

RULES = Screening()


def ramp(**changes):
    v = ramp_velocity(0.1, 0.2)
    plan = {"a_ref_m_s2": 0.1, "motion": motion_of()} | changes.pop("plan", {})
    return moving_run("ramp", changes.pop("v", v), 300.0, v_ref=v, plan=plan, **changes)


def triangle(**changes):
    v = triangle_velocity(0.2, 0.1, 2)
    return moving_run("triangle", changes.pop("v", v), 300.0, v_ref=v, **changes)


def steps(**changes):
    v = levels_velocity([0.05, 0.1, -0.05], 0.8)
    return moving_run("steps", changes.pop("v", v), 300.0, v_ref=v, **changes)


def hold(**changes):
    return moving_run("hold", changes.pop("v", np.zeros(20_000)), 0.0, **changes)


def codes(run):
    return [reason.split(":")[0] for reason in screen(run, RULES).reasons]


@pytest.mark.parametrize("run", [ramp(), triangle(), steps(), hold()], ids=lambda r: r.plan.kind)
def test_a_run_that_does_what_it_should_is_accepted_and_has_no_steady_means(run):
    screened = screen(run, RULES)
    assert screened.reasons == () and screened.notes == () and screened.means is None


@pytest.mark.parametrize("run", [ramp(), triangle(), steps(), hold()], ids=lambda r: r.plan.kind)
def test_every_kind_is_rejected_for_an_incomplete_log_and_a_saturated_sensor(run):
    flagged = run.sensor_saturated.copy()
    flagged[7] = True
    assert codes(replace(run, truncated="cut")) == ["truncated"]
    assert codes(replace(run, truncated="cut", aborted="fault")) == ["aborted"]
    assert codes(replace(run, sensor_saturated=flagged)) == ["sensor_saturated"]
    assert codes(replace(run, p_tp_pa=None)) == ["missing_channel"]


def test_a_hold_needs_no_load_cell():
    assert codes(replace(hold(), f_applied_n=None)) == []


def test_a_ramp_that_lags_too_far_is_off_its_reference_and_one_just_within_is_not():
    v = ramp_velocity(0.1, 0.2)
    limit = 0.05 * v.max()
    assert codes(ramp(v=np.maximum(v - 1.1 * limit, 0))) == ["off_reference"]
    assert codes(ramp(v=np.maximum(v - 0.9 * limit, 0))) == []


def test_a_ramp_must_reach_its_speed_or_its_travels_end():
    v = ramp_velocity(0.1, 0.12)
    end = 0.05 + 0.12**2 / 0.2
    plan = {"v_ref_m_s": 0.2, "a_ref_m_s2": 0.1}
    short, to_the_end = (
        moving_run("ramp", v, 300.0, plan=plan | {"motion": motion_of(x_max=x)}) for x in (0.3, end)
    )
    assert codes(short) == ["incomplete"] and codes(to_the_end) == []


@pytest.mark.parametrize("run,wanted", [(ramp(), ["valve_saturated"]), (triangle(), [])])
def test_a_valve_at_its_limit_spoils_a_ramps_load_but_a_triangle_has_none(run, wanted):
    flags = run.valve_saturated.copy()
    flags[30] = True
    screened = screen(replace(run, valve_saturated=flags), RULES)
    assert [reason.split(":")[0] for reason in screened.reasons] == wanted
    assert bool(wanted) or f" 1 of {len(run.t_s)} " in screened.notes[0]


def test_a_triangle_needs_a_whole_cycle():
    v = triangle_velocity(0.2, 0.1, 1)[:15_000]
    assert codes(moving_run("triangle", v, 300.0)) == ["incomplete"]


def test_a_level_of_steps_must_be_held_in_the_second_half_of_its_time():
    v = levels_velocity([0.05, 0.1, -0.05], 0.8)
    late, off = v.copy(), v.copy()
    late[8000:11_000] = 0.08
    off[8000:16_000] = 0.096
    assert codes(steps(v=late)) == []
    assert codes(steps(v=off)) == ["off_reference"]
    assert re.search(r"level 2 .*\b96\.00 mm/s.*100\.00", screen(steps(v=off), RULES).reasons[0])
    flags = steps().valve_saturated.copy()
    flags[82] = True  # the jump itself
    assert codes(steps(valve_saturated=flags)) == []
    flags[150] = True
    assert codes(steps(valve_saturated=flags)) == ["valve_saturated"]


def test_a_hold_must_rest_and_last():
    assert codes(hold(v=np.full(20_000, 0.4e-3))) == ["off_reference"]
    assert codes(hold(v=np.full(20_000, 0.2e-3))) == []
    assert codes(hold(v=np.zeros(5000))) == ["too_short"]


@pytest.mark.parametrize("run", [ramp(), triangle(), steps(), hold()], ids=lambda r: r.plan.kind)
def test_a_piston_at_its_head_is_told(run):
    assert "end_stop" in codes(replace(run, x_m=run.x_m - run.x_m.min() + 1e-3))


def test_an_unknown_reference_is_told_and_not_judged():
    screened = screen(replace(ramp(), v_ref_m_s=None), RULES)
    assert screened.accepted and "reference" in screened.notes[0]
