"""What is foreseen of runs, against what a search then finds in them: hidden laws, other plants."""

import re
import subprocess
import sys
from dataclasses import replace

import pytest
import yaml

from hbench.config.bench import merge, parse_bench, parse_plant, plant_sections
from hbench.config.files.loading import read_yaml
from hbench.experiment.closed_loop import record
from hbench.reconcile.diagnose import ReconcileTask, diagnose
from hbench.reconcile.separation.next_experiment import ExperimentLibrary
from hbench.reconcile.separation.planned_runs import planned_effects
from hbench.records import Provenance
from tests.support import ROOT
from tests.support.reconcile.blind import outcome, task_of
from tests.support.reconcile.few_candidates import try_only
from tests.support.reconcile.rounds import plans_of

GENERATE = ROOT / "tests" / "support" / "hidden" / "generate.py"
LIBRARY = ROOT / "configs" / "discriminate.yaml"
BENCH, MODEL = ROOT / "configs" / "bench-aau.yaml", ROOT / "configs" / "model-aau.yaml"
INERTIAS = {"added_mass", "friction_lag"}
STEADY = {
    "kind": "steady",
    "travel": {"start": "60 mm", "end": "330 mm"},
    "acceleration": "1 m/s^2",
    "hold": "0.2 s",
    "window": "0.5 s",
}
POOR = {  # one direction, one rod-side pressure: the pressures follow the load
    "name": "Extending only",
    "order": "passes",
    "experiments": [
        STEADY
        | {
            "direction": "extend",
            "p_lr": "15 bar",
            "loads": ["500 N", "2500 N", "5000 N"],
            "velocities": ["30 mm/s", "80 mm/s", "150 mm/s"],
            "trials": 2,
        }
    ],
}
MORE_POINTS = {
    "loads": [f"{load} N" for load in range(500, 5000, 1000)],
    "velocities": ["20 mm/s", "50 mm/s", "100 mm/s", "150 mm/s"],
}
ONE_WAY = {**POOR, "experiments": [POOR["experiments"][0] | MORE_POINTS]}
SLOW = {  # a lag then delays little, and a mass needs no force
    "kind": "triangle",
    "label": "slow",
    "p_lr": "15 bar",
    "loads": ["500 N"],
    "speed": "20 mm/s",
    "cycles": 2,
    "travel": {"start": "190 mm", "end": "210 mm"},
    "hold": "0.2 s",
}
MORE = POOR["experiments"][0] | {"label": "more", "loads": ["4000 N"]}
CANDIDATES = INERTIAS | {"load_friction"}
HIDDEN = (("supply_droop", "slope"), ("tank_back_pressure", "resistance"), ("friction_lag", "time"))
UNTUNED = {"oil": {"bulk_modulus": "680 bar"}, "valve": {"gain": "7.5e-7 m^2/V"}}


@pytest.fixture(scope="module")
def poor(bench):
    """What is foreseen of ``POOR``."""
    return planned_effects(bench, bench, plans_of(bench, POOR))


def pair(planned, *names):
    return next(p for p in planned.separability.pairs if {p.first, p.second} == set(names))


def sizes(planned):
    """Return the smallest detectable sizes, in typical ones."""
    return {
        (size.effect, size.coefficient): size.smallest / size.typical
        for size in planned.separability.sizes
    }


# ---- who looks like whom, by physics


@pytest.mark.slow
def test_at_one_acceleration_a_lag_of_friction_is_like_a_mass(poor, bench):
    """Both act while the speed changes. Slow reversals separate them; more loads do not."""
    assert pair(poor, *INERTIAS).distinguishable is False
    assert pair(poor, *INERTIAS).lead < 1
    leads = {}
    for more in (SLOW, MORE):
        plan = {**POOR, "experiments": [*POOR["experiments"], more]}
        planned = planned_effects(bench, bench, plans_of(bench, plan))
        leads[more["label"]] = pair(planned, *INERTIAS).lead
    assert leads["slow"] > 5 > 1 > leads["more"]


def test_steady_runs_one_way_show_leaks_but_no_inertia_and_no_deadband(poor):
    """A deadband is then the null of a valve, which is refitted."""
    found = sizes(poor)
    assert found["internal_leakage", "test"] <= 1.0
    for key in (
        ("added_mass", "test"),
        ("presliding", "force"),
        ("entrained_air", "fraction"),
        ("valve_deadband", "test"),
    ):
        assert not found[key] <= 1.0
    assert not poor.shortfalls
    assert any("reversals" in item for item in poor.missing)


# ---- the next experiment


def diagnosed(bench, data, schedule, hidden):
    """Diagnose runs of a hidden plant with the shipped model."""
    runs = record(bench, schedule, parse_plant(data, hidden, "hidden"), seed=8)
    assert not runs.stopped
    model = read_yaml(MODEL)
    plant = parse_plant(data, model, "model")
    return diagnose(
        ReconcileTask(
            provenance=Provenance("made", "simulated", "bench", "sim", "2026-01-01", ""),
            bench=bench,
            model=MODEL.name,
            plant=plant,
            plant_data=plant_sections(data, model, "model"),
            runs=runs.runs,
            instruments=bench.instruments,
            experiments=ExperimentLibrary(bench, plant, bench.instruments, schedule),
        )
    )


def offer_alone(monkeypatch, experiments):
    """Replace the experiments from which the next is chosen."""
    library = yaml.safe_dump({"experiments": experiments}).encode()
    place = "hbench.reconcile.separation.next_experiment.example"
    monkeypatch.setattr(place, lambda name: library)


def test_no_experiment_is_proposed_where_none_separates(bench, bench_data, monkeypatch):
    """A further load has the same acceleration: lag and mass stay alike."""
    try_only(monkeypatch, *CANDIDATES)
    offer_alone(monkeypatch, [MORE])
    hidden = merge(UNTUNED, {"effects": {"added_mass": {"test": "50 kg"}}})
    found = diagnosed(bench, bench_data, POOR, hidden)
    assert found.verdict == "ambiguous"
    assert {candidate.name for candidate in found.alternatives} == INERTIAS
    assert found.next_experiment is None and found.next_schedule is None


# ---- campaigns with hidden laws, in a process of their own


def hidden_outcomes(folder, schedule, hide):
    """Make campaigns with effects (name, severity, seed); return diagnoses by effect and seed."""
    bench = {"bench": str(BENCH)}
    folder.mkdir(exist_ok=True)
    (folder / "schedule.yaml").write_text(yaml.safe_dump({**schedule, **bench}))
    hidden = [word for row in hide for word in ("--hide", *map(str, row))]
    made = [folder / "made", "--schedule", folder / "schedule.yaml", *hidden]
    subprocess.run([sys.executable, GENERATE, *made], check=True)
    return {row: folder / "made" / "-".join(map(str, row)) for row in hide}


def of_campaign(folder, schedule):
    """Diagnose a campaign, with the proposals of the whole library."""
    task = task_of(folder)
    library = ExperimentLibrary(task.bench, task.plant, task.instruments, schedule)
    data = plant_sections(read_yaml(BENCH), read_yaml(MODEL), "model")
    return diagnose(replace(task, plant_data=data, experiments=library))


def next_campaign(folder, hidden):
    """Return the diagnosis of ``ONE_WAY`` on a hidden bench, and that with the proposed runs."""
    (first,) = hidden_outcomes(folder / "first", ONE_WAY, [hidden]).values()
    diagnosis = of_campaign(first, ONE_WAY)
    (second,) = hidden_outcomes(folder / "next", diagnosis.next_schedule, [hidden]).values()
    return diagnosis, outcome(second)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "kinds"), [(72, {"steps", "triangle"}), (72, set()), (82, set())])
def test_the_proposed_experiment_distinguishes_guides_and_seals(tmp_path, monkeypatch, seed, kinds):
    """In strokes one way at one rod-side pressure, the pressures follow the load.

    The bench is a hidden one, and its friction levels off with the force. The proposal is the best
    of the shipped experiments of these kinds, or of all.
    """
    shipped = yaml.safe_load(LIBRARY.read_bytes())["experiments"]
    offered = [one for one in shipped if not kinds or one["kind"] in kinds]
    assert len(offered) > 1
    offer_alone(monkeypatch, offered)
    first, second = next_campaign(tmp_path, ("load_friction", 2, seed))
    assert first.verdict == "ambiguous"
    rivals = {candidate.name for candidate in first.alternatives}
    assert rivals == {"load_friction", "seal_pressure_friction"}
    lead = re.search(
        r"expected to lead by (\S+) nats, without them by (\S+);", first.next_experiment
    )
    assert float(lead[1]) > 10 > 3 > float(lead[2])
    assert second.verdict == "named" and second.named == ("load_friction",)


@pytest.mark.slow
@pytest.mark.parametrize(
    "hidden", [("seal_pressure_friction", 2, 71), ("direction_asymmetry", 3, 84)]
)
def test_runs_proposed_where_nothing_is_missing_show_what_the_first_could_not(tmp_path, hidden):
    first, second = next_campaign(tmp_path, hidden)
    assert first.verdict == "none" and hidden[0] in first.next_experiment
    assert second.verdict == "named" and second.named == (hidden[0],)


@pytest.mark.slow
def test_effects_of_three_times_the_smallest_size_are_found_and_of_a_fifth_are_not(tmp_path):
    """Some four minutes. Severity 1 of a hidden law does what the typical size does.

    Not in the list is a lag of the valves: three times its smallest size is seen, but its hidden
    form of second order is called unknown.
    """
    schedule = read_yaml(ROOT / "data_samples" / "blind.yaml")
    bench = parse_bench(read_yaml(BENCH), "bench")
    plans = plans_of(bench, schedule)
    smallest = sizes(planned_effects(bench, bench, plans))
    hide = []
    for i, key in enumerate(HIDDEN):
        for j, factor in enumerate((3.0, 0.2)):
            hide.append((key[0], round(factor * smallest[key], 3), 31 + 2 * i + j))
    for row, folder in hidden_outcomes(tmp_path, schedule, hide).items():
        found = outcome(folder)
        print(row, found.verdict, found.named, found.first)
        is_large = row[2] % 2 == 1
        assert found.named[:1] == ((row[0],) if is_large else ())
