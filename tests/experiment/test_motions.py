"""Each kind of experiment becomes the motion that its words say, on paper and on the rig."""

import copy
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from hbench.analysis.screening.calibrate import calibrate
from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.config.schedule import parse_schedule
from hbench.errors import ConfigError
from hbench.experiment.motions import ideal_path
from hbench.experiment.plan import plan_runs
from hbench.experiment.upload import uploads
from hbench.records import KINDS, Motion, Segment
from hbench.rig.client import Identity

CONFIGS = Path(__file__).parents[2] / "configs"
BENCH = parse_bench(read_yaml(CONFIGS / "bench-aau.yaml"), "bench")
DYNAMICS = read_yaml(CONFIGS / "dynamics.yaml")
LOAD = {"p_lr": "15 bar", "loads": ["2000 N"], "hold": "0.2 s", "trials": 1}
TRAVEL = {"start": "60 mm", "end": "330 mm"}


def plans_of(*experiments):
    data = {"name": "test", "bench": "bench.yaml", "experiments": [LOAD | e for e in experiments]}
    return plan_runs(parse_schedule(data, "s.yaml"), BENCH, "s.yaml").runs


def integrated(motion, brake, dt=1e-4):
    """The board's own rule, tick by tick."""
    x, v, seconds, xs = motion.x_start_m, 0.0, 0.0, [motion.x_start_m]
    for segment in motion.segments * motion.cycles:
        since = 0.0
        while since < segment.duration_s - dt / 2:
            if (min(segment.v_m_s, v) > 0 and x >= motion.x_max_m) or (
                max(segment.v_m_s, v) < 0 and x <= motion.x_min_m
            ):
                break
            before = v
            v += max(-segment.a_m_s2 * dt, min(segment.v_m_s - v, segment.a_m_s2 * dt))
            x += 0.5 * (before + v) * dt
            since += dt
            xs.append(x)
        seconds += since
    x += v * abs(v) / (2 * brake)
    return seconds, min(*xs, x), max(*xs, x), x


speeds = st.floats(-0.3, 0.3).map(lambda v: round(v, 3))
segments = st.builds(
    Segment, speeds, st.floats(0.05, 3.0), st.floats(0.05, 1.0).map(lambda s: round(s, 3))
)


@settings(max_examples=40)
@given(st.lists(segments, min_size=1, max_size=4), st.integers(1, 2))
def test_the_way_is_that_of_the_boards_rule_integrated(row, cycles):
    motion = Motion(0.2, 0.1, 0.3, 0.0, tuple(row), cycles)
    found, expected = ideal_path(motion, 1.0), integrated(motion, 1.0)
    # A tick more or less at each limit, at up to 0.3 m/s, and what the later segments make of it.
    got = (found.seconds, found.x_low_m, found.x_high_m, found.x_end_m)
    np.testing.assert_allclose(got, expected, atol=2e-3)


def test_a_ramp_rises_to_its_speed_or_to_the_end_of_the_travel():
    plans = plans_of(
        {
            "kind": "ramp",
            "direction": "retract",
            "p_lr": "110 bar",
            "loads": ["-2000 N"],
            "speed": "200 mm/s",
            "accelerations": ["0.1 m/s^2", "0.0335 m/s^2"],
            "travel": {"start": "40 mm", "end": "340 mm"},
        }
    )
    (fast, slow) = (ideal_path(plan.motion, 1.0) for plan in plans)
    assert [plan.a_ref_m_s2 for plan in plans] == [0.1, 0.0335]
    assert {plan.v_ref_m_s for plan in plans} == {-0.2}
    assert fast.seconds == pytest.approx(2.0)
    # v^2 / 2a = 0.2 m of 0.3 m; then the brake's v^2 / 2 = 0.02 m.
    assert fast.x_end_m == pytest.approx(0.34 - 0.2 - 0.02)
    # 0.3 m are path after sqrt(2 0.3 / 0.0335) s, at 142 mm/s.
    assert slow.seconds == pytest.approx(np.sqrt(0.6 / 0.0335))
    assert slow.x_end_m == pytest.approx(0.04 - 0.6 * 0.0335 / 2)


def test_a_triangle_goes_over_the_whole_travel_and_returns_in_each_cycle():
    (plan,) = plans_of(
        {"kind": "triangle", "speed": "100 mm/s", "cycles": 7, "travel": TRAVEL, "loads": ["0 N"]}
    )
    path = ideal_path(plan.motion, 1.0)
    assert (path.x_low_m, path.x_high_m) == pytest.approx((0.06, 0.33))
    assert path.x_end_m == pytest.approx(0.06)
    assert path.seconds == pytest.approx(7 * 4 * 0.27 / 0.1)  # mean speed is half the largest
    assert plan.a_ref_m_s2 == pytest.approx(0.1**2 / 0.27)


def test_steps_that_first_retract_begin_at_the_travels_end():
    levels = ["-50 mm/s", "100 mm/s"]
    (plan,) = plans_of({"kind": "steps", "levels": levels, "dwell": "0.5 s", "travel": TRAVEL})
    assert plan.motion.x_start_m == 0.33 and plan.v_ref_m_s == 0.1
    path = ideal_path(plan.motion, 1.0)
    assert path.x_low_m == pytest.approx(0.33 - 0.025, abs=1e-4)
    assert path.x_end_m == pytest.approx(0.33 + 0.005, abs=1e-4), "cut where the travel ends"


def test_what_leads_beyond_the_limits_of_travel_is_refused():
    profile = [{"velocity": "-200 mm/s", "acceleration": "1 m/s^2", "duration": "3 s"}]
    with pytest.raises(ConfigError, match=r"experiments\.0\.travel: .*-10 .*330 mm"):
        plans_of(
            {
                "kind": "verification",
                "profile": profile,
                "travel": {"start": "20 mm", "end": "330 mm"},
            }
        )


@pytest.mark.parametrize(
    ("profile", "words"),
    [
        (("200 mm/s", "100 m/s^2", "1 ms"), r"experiments.0: .*0.001 s.*0.02 s"),
        (("0.1 mm/s", "0.01 m/s^2", "0.01 s"), r"experiments.0: .*0.01 s.*0.02 s"),
    ],
)
def test_a_run_too_short_for_its_log_is_refused(profile, words):
    keys = ("velocity", "acceleration", "duration")
    piece = dict(zip(keys, profile, strict=True))
    with pytest.raises(ConfigError, match=words):
        plans_of({"kind": "verification", "profile": [piece], "travel": TRAVEL})


def test_a_triangle_too_slow_for_the_boards_numbers_is_refused():
    with pytest.raises(ConfigError, match=r"experiments.0: .*0.0001 m/s\^2"):
        plans_of({"kind": "triangle", "speed": "1 mm/s", "cycles": 1, "travel": TRAVEL})


def test_a_kind_that_is_none_is_refused_with_those_that_are():
    with pytest.raises(ConfigError, match=rf"experiments.0.kind = 'creep'.*{', '.join(KINDS)}"):
        plans_of({"kind": "creep"})


def test_keys_in_errors_are_those_of_the_file():
    with pytest.raises(ConfigError, match="experiments.0.until.within = '2 mm'"):
        plans_of(
            {
                "kind": "triangle",
                "speed": "100 mm/s",
                "cycles": 3,
                "travel": TRAVEL,
                "until": {"quantity": "friction", "within": "2 mm"},
            }
        )


BOARD = Identity("f", "b", 1, 10_000, 1024, max_steps=128, max_segments=104)


def test_steps_share_the_rows_that_they_have_in_common():
    schedule = parse_schedule(DYNAMICS, "dynamics.yaml")
    (upload,) = uploads(plan_runs(schedule, BENCH, "dynamics.yaml").runs, BOARD)
    # 6 speeds and 3 accelerations in either direction, 5 triangles of 3, steps of 6, a profile of
    # 6, a hold.
    assert len(upload.segments) == 12 + 6 + 15 + 6 + 6 + 1
    assert sum(step["trials"] for step in upload.steps) == 113


def test_a_plan_is_cut_where_the_board_is_full():
    plans = plan_runs(parse_schedule(read_yaml(CONFIGS / "stribeck.yaml"), "s"), BENCH, "s").runs
    small = Identity("f", "b", 1, 10_000, 1024, max_steps=50, max_segments=20)
    parts = list(uploads(plans, small))
    assert max(len(part.steps) for part in parts) <= 50
    assert max(len(part.segments) for part in parts) <= 20
    runs = [step["run"] + n for part in parts for step in part.steps for n in range(step["trials"])]
    assert runs == list(range(1, 363))
    assert [part.supply_is_off for part in parts] == [True, *[False] * (len(parts) - 2), True]
    for part in parts:
        assert all(s["segment"] + s["segments"] <= len(part.segments) for s in part.steps)


def written(folder, schedule):
    """Write a schedule for the shipped bench; return its path."""
    path = folder / "s.yaml"
    path.write_text(yaml.safe_dump(schedule | {"bench": str(CONFIGS / "bench-aau.yaml")}))
    return path


@pytest.fixture(scope="module")
def measured(tmp_path_factory, on_the_rig):
    """One run of each kind of configs/dynamics.yaml on the virtual rig, in SI."""
    data = copy.deepcopy(DYNAMICS)
    kinds = {}
    for experiment in data["experiments"]:
        kinds.setdefault(experiment["kind"], experiment)
        experiment |= {"trials": 1, "loads": experiment["loads"][-1:]}
    kinds["ramp"]["accelerations"] = ["0.067 m/s^2"]
    kinds["triangle"] |= {"speed": "150 mm/s", "cycles": 2}
    folder = tmp_path_factory.mktemp("dynamics")
    schedule = written(folder, data | {"experiments": list(kinds.values())})
    campaign = on_the_rig(schedule, folder / "campaign")
    assert all(entry.stop.outcome == "done" for entry in campaign.entries)
    return {raw.plan.kind: calibrate(raw, campaign.bench()) for raw in campaign.raw_runs()}


def test_every_kind_is_run_as_long_as_its_profile_lasts(measured):
    assert set(measured) == {"steady", "ramp", "triangle", "steps", "verification", "hold"}
    for run in measured.values():
        planned = ideal_path(run.plan.motion, 1.0).seconds
        # A triangle turns where the piston is, which lags behind its reference.
        slack = 0.02 * 100 * planned if run.plan.kind == "triangle" else 6
        assert len(run.t_s) == pytest.approx(100 * planned, abs=slack), run.plan.kind


@pytest.mark.parametrize("kind", ["ramp", "triangle", "verification"])
def test_the_piston_follows_the_profile(measured, kind):
    run = measured[kind]
    moving = slice(20, None)  # after breakaway
    error = run.v_m_s[moving] - run.v_ref_m_s[moving]
    # The ramps lag by a / K_v = 0.5 / 59.9 = 8 mm/s at the steepest; reversals add stiction.
    assert np.percentile(np.abs(error), 90) < 9e-3
    # The log ends before the brake.
    np.testing.assert_allclose(
        run.x_m.max(), ideal_path(run.plan.motion, np.inf).x_high_m, atol=8e-3
    )


def test_steps_reach_each_level(measured):
    run = measured["steps"]
    for number, segment in enumerate(run.plan.motion.segments):
        end = slice(80 * number + 60, 80 * number + 78)
        assert np.mean(run.v_m_s[end]) == pytest.approx(segment.v_m_s, abs=2e-3)


def test_a_hold_keeps_position_and_pressures_with_closed_valves(measured):
    """The plant has no leakage, so nothing decays."""
    run = measured["hold"]
    for u in (run.u_t_v, run.u_l1_v, run.u_l2_v):
        assert not u.any()
    assert np.ptp(run.x_m) < 2e-4
    for p in (run.p_tp_pa, run.p_tr_pa, run.p_lp_pa, run.p_lr_pa):
        assert np.ptp(p) < 0.5e5 and p.mean() > 5e5


@pytest.mark.parametrize(
    ("within", "cycles", "numbers"),
    [
        ("50 %", 3, ["50 %"]),  # one to compare with, then two in a row
        ("0.001 %", 4, ["not", "0.001 %", "4 cycles"]),
    ],
)
def test_a_warm_up_tells_whether_it_ended_because_friction_had_settled(
    tmp_path, on_the_rig, within, cycles, numbers
):
    """The plant does not warm up: its friction is the same from cycle to cycle but for noise."""
    experiment = LOAD | {
        "kind": "triangle",
        "speed": "200 mm/s",
        "cycles": 4,
        "travel": {"start": "150 mm", "end": "250 mm"},
        "until": {"quantity": "friction", "within": within},
    }
    schedule = written(tmp_path, {"name": "warm-up", "experiments": [experiment]})
    campaign = on_the_rig(schedule, tmp_path / "campaign")
    (entry,) = campaign.entries
    assert entry.stop.outcome == "done" and all(part in entry.stop.why for part in numbers)
    assert entry.stop.records == pytest.approx(100 * cycles * 4 * 0.1 / 0.2, rel=0.03)
