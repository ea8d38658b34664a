"""A schedule becomes the source's runs, and what a bench can't do is refused in words."""

import copy
import re
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from scipy.stats import spearmanr

from hbench import workflow
from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.config.schedule import parse_schedule
from hbench.errors import ConfigError
from hbench.experiment.plan import load_pressure, plan_runs, trials_in_a_row

CONFIGS = Path(__file__).parents[2] / "configs"
BENCH = parse_bench(read_yaml(CONFIGS / "bench-aau.yaml"), "bench")
WHOLE = read_yaml(CONFIGS / "stribeck.yaml")
STRIBECK = WHOLE | {"order": "experiments", "experiments": WHOLE["experiments"][1:-1]}


def plans_of(data):
    return plan_runs(parse_schedule(data, "s.yaml"), BENCH, "s.yaml").runs


def test_the_sources_experiment_has_360_runs_between_two_zero_checks():
    plans = plans_of(WHOLE | {"order": "experiments"})
    assert [plans[n].kind for n in (0, -1)] == ["check", "check"]
    plans = [plan for plan in plans if plan.kind == "steady"]
    assert len(plans) == 360
    assert len({plan.run for plan in plans}) == 360
    assert {plan.p_lr_ref_pa for plan in plans if plan.direction == "extend"} == {15e5}
    assert {plan.p_lr_ref_pa for plan in plans if plan.direction == "retract"} == {110e5}
    assert {abs(plan.f_load_n) for plan in plans} == {500, 1000, 2000, 5000}
    assert max(abs(plan.v_ref_m_s) for plan in plans) == pytest.approx(0.2)
    assert [plan.trial for plan in plans[:6]] == [1, 2, 3, 1, 2, 3]


def test_load_pressures_are_the_printed_ones():
    assert load_pressure(BENCH, 10e3, 15e5) / 1e5 == pytest.approx(88.7, abs=0.05)
    assert load_pressure(BENCH, 1e3, 75e5) / 1e5 == pytest.approx(53.7, abs=0.05)


def test_the_load_opposes_the_motion_in_both_directions():
    for plan in plans_of(STRIBECK):
        assert plan.f_load_n * plan.v_ref_m_s > 0


def test_a_run_starts_at_the_far_end_of_its_way():
    for plan in plans_of(STRIBECK):
        motion = plan.motion
        ahead = motion.x_max_m if plan.v_ref_m_s > 0 else motion.x_min_m
        assert (ahead - motion.x_start_m) * plan.v_ref_m_s > 0


def test_trials_in_a_row_are_one_step_and_holes_part_them():
    plans = plans_of(STRIBECK)
    assert [len(step) for step in trials_in_a_row(plans)] == [3] * 120
    assert [len(step) for step in trials_in_a_row([*plans[:1], *plans[2:5]])] == [1, 1, 2]


def test_passes_go_over_all_loads_and_speeds_before_the_next_trial():
    data = copy.deepcopy(STRIBECK)
    data["experiments"] = [
        {**data["experiments"][0], "velocities": ["50 mm/s", "60 mm/s"], "order": "passes"}
    ]
    plans = plans_of(data)
    assert [plan.run for plan in plans] == [f"{number:04d}" for number in range(1, 25)]
    loads = [500, 500, 1000, 1000, 2000, 2000, 5000, 5000]
    assert [(plan.trial, plan.f_load_n, plan.v_ref_m_s) for plan in plans] == [
        (trial, load, speed)
        for trial in (1, 2, 3)
        for load, speed in zip(loads, [0.05, 0.06] * 4, strict=True)
    ]
    assert [len(step) for step in trials_in_a_row(plans)] == [1] * 24


def test_passes_over_the_whole_plan_make_a_trial_of_each_point_before_the_next():
    """Two directions, of three and of two trials; the last pass has but the first."""
    extend, retract = (
        {**one, "velocities": ["50 mm/s"], "loads": one["loads"][:2]}
        for one in STRIBECK["experiments"]
    )
    data = {**STRIBECK, "order": "passes", "experiments": [extend, {**retract, "trials": 2}]}
    data["experiments"] = [
        {key: value for key, value in one.items() if key != "order"} for one in data["experiments"]
    ]
    plans = plans_of(data)
    assert [plan.run for plan in plans] == [f"{number:04d}" for number in range(1, 11)]
    once = [("extend", 500), ("extend", 1000), ("retract", -500), ("retract", -1000)]
    assert [(plan.trial, plan.direction, plan.f_load_n) for plan in plans] == [
        (trial, *point) for trial in (1, 2, 3) for point in once if trial < 3 or point in once[:2]
    ]


def test_passes_over_the_whole_plan_are_the_same_runs_as_experiments_in_order():
    data = copy.deepcopy(STRIBECK)
    row, passes = (plans_of({**data, "order": order}) for order in ("experiments", "passes"))
    assert {replace(plan, run="") for plan in row} == {replace(plan, run="") for plan in passes}
    assert row != passes
    assert plans_of(data) == row


def points_of(plans):
    return [(plan.direction, plan.f_load_n, plan.v_ref_m_s) for plan in plans]


def test_a_random_order_makes_each_point_once_in_each_pass():
    row, drawn = plans_of(STRIBECK), plans_of({**STRIBECK, "order": "random"})
    assert {replace(plan, run="") for plan in row} == {replace(plan, run="") for plan in drawn}
    passes = [drawn[first : first + 120] for first in (0, 120, 240)]
    orders = [points_of(one) for one in passes]
    for trial, plans in enumerate(passes, 1):
        assert {plan.trial for plan in plans} == {trial}
        assert len(set(points_of(plans))) == 120
    assert orders[0] != orders[1] != orders[2] != orders[0]
    assert [plan.run for plan in drawn] == [f"{number:04d}" for number in range(1, 361)]


def test_a_random_order_does_not_depend_on_speed():
    """Spearman's correlation of 120 places has a standard deviation of 1/sqrt(119) = 0.09."""
    drawn = plans_of({**STRIBECK, "order": "random"})
    for first in (0, 120, 240):
        speeds = [abs(plan.v_ref_m_s) for plan in drawn[first : first + 120]]
        assert abs(spearmanr(range(120), speeds).statistic) < 0.3


def test_the_seed_decides_a_random_order_and_its_default_is_1():
    data = {**STRIBECK, "order": "random"}
    assert plans_of(data) == plans_of({**data, "seed": 1})
    assert plans_of(data) != plans_of({**data, "seed": 2})


def test_the_order_of_a_seed_stays_as_it_is():
    """A campaign that an earlier version began is resumed with the same plan."""
    data = {**STRIBECK, "experiments": [{**STRIBECK["experiments"][0], "loads": ["500 N"]}]}
    in_pass = [plan.v_ref_m_s for plan in plans_of(data)[::3]]
    drawn = [plan.v_ref_m_s for plan in plans_of({**data, "order": "random"})]
    assert [in_pass.index(speed) for speed in drawn[:15]] == [
        13, 9, 8, 0, 3, 11, 14, 5, 4, 6, 12, 2, 7, 10, 1
    ]  # fmt: skip


def test_trials_of_an_experiment_that_is_listed_twice_go_on_counting():
    data = copy.deepcopy(STRIBECK)
    first = {**data["experiments"][0], "velocities": ["50 mm/s"], "loads": ["500 N"], "trials": 2}
    data["experiments"] = [first, {**first, "label": "another"}, {**first, "trials": 3}]
    plans = plans_of(data)
    assert [(plan.label, plan.trial) for plan in plans] == [
        ("", 1), ("", 2), ("another", 1), ("another", 2), ("", 3), ("", 4), ("", 5)
    ]  # fmt: skip
    assert len({plan.run for plan in plans}) == 7


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            {"travel": {"start": "20 mm", "end": "350 mm"}},
            ["experiments.0.travel", "20 and 380 mm", "5 to 375 mm", "200 mm/s"],
        ),
        ({"travel": {"start": "100 mm", "end": "160 mm"}}, ["steady window", "mm/s"]),
        ({"loads": ["30 kN"]}, ["experiments.0.loads: 30000 N", "150 bar", "18696 N"]),
        ({"loads": ["-5000 N"]}, ["experiments.0.loads", "-5000 N", "tank"]),
        ({"loads": ["13 kN"]}, ["experiments.0.loads: 13000 N", "-12257 to 12257 N"]),
        ({"p_lr": "150 bar"}, ["experiments.0.p_lr", "p_lr = 150 bar", "(150 bar)"]),
        ({"velocities": ["0.39 m/s"]}, ["travel"]),
    ],
)
def test_what_the_bench_cant_do_is_refused_before_anything_moves(change, words):
    data = copy.deepcopy(STRIBECK)
    data["experiments"] = [{**data["experiments"][0], **change}]
    with pytest.raises(ConfigError) as error:
        plans_of(data)
    for word in ["s.yaml", "experiments.0", *words]:
        assert any(part in str(error.value) for part in word.split("|"))


def test_the_hint_tells_by_how_much_the_travel_is_too_long():
    data = copy.deepcopy(STRIBECK)
    first = data["experiments"][0]

    def plan(end: int):
        travel = {"start": "20 mm", "end": f"{end} mm"}
        data["experiments"] = [{**first, "travel": travel}]
        return plans_of(data)

    with pytest.raises(ConfigError) as error:
        plan(360)
    too_long = int(re.search(r"(\d+) mm", error.value.hint)[1])
    assert plan(360 - too_long)
    with pytest.raises(ConfigError):
        plan(360 - too_long + 1)


def test_the_hint_tells_the_loads_that_a_rod_side_pressure_allows():
    """(P_t A_p - P_Lr A_r) and (P_s A_p - P_Lr A_r) of 40 mm and 25 mm: at 15 bar, by hand."""
    data = copy.deepcopy(STRIBECK)
    data["experiments"][0]["loads"] = ["-1 kN"]
    with pytest.raises(ConfigError) as error:
        plans_of(data)
    assert re.search("p_lr = 15 bar .*-897 .*17701 N", error.value.hint)


def test_a_load_that_the_test_cylinder_cant_move_is_refused():
    """At 150 bar a piston of 20 mm with a rod of 12 mm pushes 4672 N and pulls 2953 N.

    That is 150 bar on one side and 2 bar of the tank on the other.
    """
    small = BENCH.test_cylinder.model_copy(update={"piston_diameter": 20e-3, "rod_diameter": 12e-3})
    bench = BENCH.model_copy(update={"test_cylinder": small})
    data = copy.deepcopy(STRIBECK)
    for number, load, reach in ((0, "4700 N", "4672 N"), (1, "-4000 N", "2953 N")):
        one = {**STRIBECK["experiments"][number], "loads": [load]}
        data["experiments"] = [one]
        with pytest.raises(ConfigError, match=rf"experiments.0.loads: {load} .*150 bar, {reach}"):
            plan_runs(parse_schedule(data, "s.yaml"), bench, "s.yaml")


def test_a_load_pressure_at_which_the_board_would_stop_is_refused():
    bench = BENCH.model_copy(
        update={"limits": BENCH.limits.model_copy(update={"pressure_max": 100e5})}
    )
    schedule = parse_schedule(STRIBECK, "s.yaml")
    told = r"experiments.1.p_lr: .* p_lr = 110 bar.* limits.pressure_max \(100 bar\)"
    with pytest.raises(ConfigError, match=told):
        plan_runs(schedule, bench, "s.yaml")


@pytest.mark.parametrize("section", [5, -1e300, True, None, "text", b"hi", [], [[1]]])
def test_an_experiment_that_is_no_section_is_an_error(quick_schedule, section):
    file = quick_schedule()
    content = yaml.safe_load(file.read_text())
    file.write_text(yaml.safe_dump(content | {"experiments": [*content["experiments"], section]}))
    with pytest.raises(ConfigError, match=r"experiments\.1"):
        workflow.load_experiment(file, None)
