"""Example files for a cylinder of any size: consistent, with their comments, and usable."""

import re

import numpy as np
import pytest
import yaml

from hbench.analysis.screening.screen import screen
from hbench.cli.commands.init import _FILES
from hbench.config.bench import parse_bench
from hbench.config.conformity.limits import parse_limits
from hbench.config.files.edited_yaml import with_values
from hbench.config.files.sized_examples import BENCH_FILE, Size, sized
from hbench.config.schedule import parse_schedule
from hbench.errors import HbenchError
from hbench.experiment import design_verification
from hbench.experiment.closed_loop import record
from hbench.experiment.plan import plan_runs
from hbench.experiment.steady_demand import steady_demand
from hbench.workflow import sized_files
from hbench.workflow.campaign import load_experiment
from tests.support import ROOT
from tests.support.commands import hbench

EXAMPLES = {name: (ROOT / "configs" / name).read_text() for name in _FILES}
SIZES = [Size(0.020, 0.014, 0.100, 40e5), Size(0.300, 0.030, 2.000, 350e5)]
MORE_SIZES = [
    Size(0.050, 0.036, 0.250, 100e5),
    Size(0.100, 0.056, 0.800, 210e5),
    Size(0.063, 0.045, 1.500, 280e5),
    Size(0.200, 0.110, 0.300, 63e5),
    Size(0.016, 0.008, 0.200, 100e5),
]


def drawn_sizes(count):
    rng = np.random.default_rng(3)
    for _ in range(count):
        bore = rng.uniform(0.02, 0.2)
        stroke, supply = np.exp(rng.uniform(np.log([0.06, 50e5]), np.log([1.8, 330e5])))
        yield Size(bore, bore * rng.uniform(0.3, 0.75), stroke, supply)


def slow(sizes):
    return [pytest.param(size, marks=pytest.mark.slow) for size in sizes]


@pytest.mark.parametrize(
    "size", [*SIZES, *slow([*MORE_SIZES, *drawn_sizes(12)])], ids=lambda size: size.words
)
def test_every_schedule_can_be_planned_on_the_bench_and_limits_are_read(size):
    plan(sized_files(EXAMPLES, size).files, size)


def plan(texts, size):
    """Read all files of a size, and plan the runs of the schedules on its bench."""
    files = {name: yaml.safe_load(text) for name, text in texts.items()}
    bench = parse_bench(files[BENCH_FILE], "bench")
    assert bench.test_cylinder.piston_diameter == pytest.approx(size.bore_m, rel=1e-4)
    assert bench.supply.pressure == pytest.approx(size.supply_pa, rel=1e-4)
    schedules = [name for name, data in files.items() if "experiments" in data]
    assert len(schedules) == 10
    for name in schedules:
        assert files[name]["bench"] == BENCH_FILE
        try:
            runs = plan_runs(parse_schedule(files[name], name), bench, name).runs
            assert runs
            steady_demand(runs, bench, name)  # raises if pressures or valves do not suffice
        except HbenchError as error:
            pytest.fail(f"{name}: {error.message}")
    check = parse_schedule(design_verification.schedule(bench), "design")
    assert len(plan_runs(check, bench, "design").runs) > 8
    assert parse_limits(files["limits.yaml"], "limits").limits
    assert parse_limits(files["acceptance-limits.yaml"], "limits").limits


@pytest.mark.parametrize(
    ("bore", "rod", "stroke", "supply", "message"),
    [
        (
            50,
            47,
            250,
            100,
            "--rod: is 47 mm: .* 2286 N .* leave 40 N .* limit 114 N",
        ),
        (16, 15, 100, 350, "--rod: is 15 mm: .* leave 0 N"),
        (300, 280, 600, 40, "--rod: is 280 mm: .* leave 0 N"),
        (25, 12, 50, 100, "--stroke: is 50 mm; limits 60 to 2000 mm"),
        (50, 60, 250, 100, r"--rod: is 60 mm; limits 5 to 47.5 mm .*--bore"),
        (2, 1.4, 10, 100, "--bore: is 2 mm; limits .*\n.* without a unit is in mm; .*'2 in'"),
        (
            50,
            36,
            250,
            10,
            "--supply: is 10 bar; limits .*\n.* without a unit is in bar; .*'10 MPa'",
        ),
    ],
)
def test_a_size_whose_schedules_could_not_run_is_refused(
    tmp_path, bore, rod, stroke, supply, message
):
    size = ("--bore", bore, "--rod", rod, "--stroke", stroke, "--supply", supply)
    done = hbench("init", tmp_path / "b", *size)
    assert done.returncode == 2
    assert re.search(message, done.stderr), done.stderr
    assert not (tmp_path / "b").exists()


def test_the_examples_own_size_changes_nothing_but_names_and_comments():
    own = Size(0.040, 0.025, 0.400, 150e5)
    for text in EXAMPLES.values():
        before, after = yaml.safe_load(text), yaml.safe_load(sized(text, own))
        for data in (before, after):
            data.pop("name", None), data.pop("bench", None)
        if "test_cylinder" in before:
            before, after = (parse_bench({**data, "name": ""}, "b") for data in (before, after))
        assert after == before


@pytest.mark.parametrize("size", [Size(0.125, 0.090, 0.4, 250e5), Size(0.025, 0.014, 0.3, 150e5)])
def test_a_zero_check_has_the_tanks_pressure_at_every_size(size):
    """A supply of another pressure does not change the tank's, which the vented chambers have."""
    tank = yaml.safe_load(sized(EXAMPLES["bench-aau.yaml"], size))["supply"]["tank"]
    checks = [
        experiment["pressure"]
        for text in EXAMPLES.values()
        for experiment in yaml.safe_load(sized(text, size)).get("experiments", ())
        if experiment["kind"] == "check" and "pressure" in experiment
    ]
    assert checks and set(checks) == {tank}
    limits = yaml.safe_load(sized(EXAMPLES["acceptance-limits.yaml"], size))["limits"]
    scaled = 100 * size.pressure
    assert any(float(limit.get("pressure", "0 bar").split()[0]) == pytest.approx(scaled, rel=0.05)
               for limit in limits)  # fmt: skip


def test_a_push_may_rise_by_what_the_friction_of_a_small_cylinder_needs():
    """Seals of 25 mm have 0.63 of the example's friction, and the piston 0.39 of its area."""
    size = Size(0.025, 0.014, 0.3, 150e5)
    push = yaml.safe_load(sized(EXAMPLES["breakaway.yaml"], size))["experiments"][1]
    own = yaml.safe_load(EXAMPLES["breakaway.yaml"])["experiments"][1]
    rise, of_example = (float(each["rise"].split()[0]) for each in (push, own))
    assert rise == pytest.approx(of_example * 0.625, rel=0.02)


def test_scaled_lines_say_so_and_given_ones_too():
    lines = sized(EXAMPLES["bench-aau.yaml"], MORE_SIZES[0]).splitlines()
    assert sum(line.endswith("# given") for line in lines) == 4
    assert any(
        line.startswith("name: Bench with a cylinder 50/36, stroke 250 mm") for line in lines
    )
    scaled = [line for line in lines if "# scaled" in line]
    assert len(scaled) >= 20
    assert len({line.index("#") for line in scaled}) == 1  # in their column
    assert not any(re.search("printed|fitted", line) for line in scaled)
    own = EXAMPLES["bench-aau.yaml"][EXAMPLES["bench-aau.yaml"].index("\nname:") + 1 :].splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("name:"))
    pairs = zip(own[1:], lines[start + 1 :], strict=True)
    changed = [
        now for before, now in pairs if before.split("#")[0].rstrip() != now.split("#")[0].rstrip()
    ]
    assert [line for line in changed if not re.search("# (scaled|given)", line)] == []


def test_a_long_cylinder_has_fewer_cycles_of_warm_up_and_as_many_of_the_experiments():
    def cycles(name, size):
        return re.findall(r"cycles: (\d+)", sized(EXAMPLES[name], size))

    long, longest = Size(0.100, 0.070, 1.2, 280e5), Size(0.300, 0.210, 2.0, 350e5, time=3.0)
    assert cycles("warm-up.yaml", long) == ["20", "67"]
    assert cycles("run-in.yaml", long) == ["30", "30"]
    assert cycles("run-in.yaml", longest) == ["22", "22"]
    assert cycles("dynamics.yaml", longest) == cycles("dynamics.yaml", Size(0.04, 0.025, 0.4, 15e6))


def test_scaled_loads_are_written_without_powers_of_ten():
    size = Size(0.100, 0.070, 1.2, 280e5)
    texts = [sized(EXAMPLES[name], size) for name in ("demo.yaml", "acceptance-test.yaml")]
    assert re.findall(r"\d000 N\b", texts[0]) and not re.findall(r"\de\d+ k?N\b", "".join(texts))


def test_values_are_replaced_in_place():
    text = "a: 1  # one\nb: [2, {c: 3}]\nd: 'x'\n"
    changed = with_values(text, lambda path, value: f"{value}0" if path != ("d",) else None)
    assert changed == "a: 10  # one\nb: [20, {c: 30}]\nd: 'x'\n"
    assert with_values("a: &x 1  # n\nb: *x\n", lambda path, value: "2") == "a: &x 2  # n\nb: *x\n"


@pytest.mark.parametrize(
    "size", [(300, 210, 2000, 350), *slow([(25, 12, 100, 160), (50, 45, 250, 100)])], ids=str
)
def test_sized_schedules_can_be_planned_and_the_demo_runs_and_every_run_is_accepted(tmp_path, size):
    options = zip(("--bore", "--rod", "--stroke", "--supply"), size, strict=True)
    done = hbench("init", tmp_path, *(part for option in options for part in option))
    assert done.returncode == 0, done.stderr
    assert "at least 45 degrees" in done.stderr and "at least 6 dB" in done.stderr
    texts = {path.name: path.read_text() for path in tmp_path.iterdir()}
    bore, rod, stroke, supply = size
    plan(texts, Size(1e-3 * bore, 1e-3 * rod, 1e-3 * stroke, 1e5 * supply))
    for path in tmp_path.iterdir():
        if "\nexperiments:" in path.read_text():
            load_experiment(path, None)  # refuses logs that would be too large
    bench = parse_bench(yaml.safe_load(texts[BENCH_FILE]), "bench")
    schedule = yaml.safe_load(texts["demo.yaml"])
    schedule.pop("bench")
    for experiment in schedule["experiments"]:
        experiment |= {"trials": 1, "velocities": experiment["velocities"] | {"count": 2}}
    recorded = record(bench, schedule)
    assert (len(recorded.runs), recorded.stopped) == (8, "")
    rules = parse_schedule({**schedule, "bench": BENCH_FILE}, "demo").screening
    rejected = [verdict.reasons for run in recorded.runs if (verdict := screen(run, rules)).reasons]
    assert not rejected


def test_a_size_without_its_supply_is_refused(tmp_path):
    done = hbench("init", tmp_path / "b", "--bore", 25, "--rod", "12 mm", "--stroke", 100)
    assert done.returncode == 2 and "--supply" in done.stderr


def test_slower_loops_lower_speeds_and_accelerations():
    """Half the bandwidth: lag a / K_v as before needs a quarter of the acceleration at most."""
    size = Size(0.040, 0.025, 0.400, 150e5, time=2.0)
    bench = yaml.safe_load(sized(EXAMPLES["bench-aau.yaml"], size))["controllers"]
    assert (bench["acceleration"], bench["return_speed"]) == ("0.25 m/s^2", "75 mm/s")
    demo = yaml.safe_load(sized(EXAMPLES["demo.yaml"], size))["experiments"][0]
    assert demo["acceleration"] == "0.25 m/s^2" and demo["velocities"]["last"] == "100 mm/s"


def test_an_acceleration_that_the_board_refuses_is_refused_in_the_bench_file():
    data = yaml.safe_load(EXAMPLES[_FILES[0]])
    data["controllers"]["acceleration"] = "0.005 m/s^2"
    with pytest.raises(HbenchError, match=r"controllers\.acceleration"):
        parse_bench(data, "bench.yaml")


@pytest.mark.parametrize(
    ("bore", "rod", "stroke", "words"),
    [
        (10, 6, 100, "take the nearest one, then edit the files"),
        (63, 36, 3000, "take the nearest one, then edit the files"),
        (50, 0, 250, "a rod on both sides"),
        (50, 50, 250, "a rod on both sides"),
    ],
)
def test_a_size_that_is_refused_has_a_next_step(tmp_path, bore, rod, stroke, words):
    size = ("--bore", bore, "--rod", rod, "--stroke", stroke, "--supply", 210)
    done = hbench("init", tmp_path / "b", *size)
    assert done.returncode == 2 and words in " ".join(done.stderr.split())
    assert not (tmp_path / "b").exists()
