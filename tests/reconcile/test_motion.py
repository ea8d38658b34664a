"""Motion of a driven mass: effects of another form than the catalogue's, and two errors."""

import json
from collections import Counter
from copy import deepcopy
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.config.stroke_model import parse_motion
from hbench.errors import DataError
from hbench.reconcile.motion.motion_diagnosis import MotionTask, diagnose_motion
from hbench.records import HeldOutError, Provenance
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.revised_yaml import revised_yaml
from hbench.report.diagnosis.terminal import diagnosis_text
from hbench.report.diagnosis.verdict import verdict_words
from hbench.report.diagnosis.words.error import errors_in_words, one_sided_words
from tests.support import driven_axis as axis
from tests.support.commands import hbench
from tests.support.shared import once

DATA = Path(__file__).parents[2].parent / "shared" / "data" / "tudelft-cylinder"
PROVENANCE = Provenance("axis", "imported", "axis", "", "2026-01-01", "2026-01-01")
FORCES = ("coulomb", "stiction", "viscous")
SLOW = pytest.mark.slow  # other seeds, starts and cylinders of the same claim


def model(friction=1.0, size=1.0):
    """The first guess, with its friction or all its forces and masses multiplied."""
    sections = deepcopy(axis.MODEL)
    law = sections["friction"]["test"]
    for key in FORCES:
        value, unit = law[key].split(" ", 1)
        law[key] = f"{friction * size * float(value):g} {unit}"
    sections["moving_mass"]["test"] = f"{13 * size:g} kg"
    return sections


def diagnosis(runs, sections=axis.MODEL):
    plant = parse_motion(sections, "axis.yaml")
    task = MotionTask(
        provenance=PROVENANCE,
        model="axis.yaml",
        plant_data=sections,
        plant=plant,
        runs=runs,
        material=0.002,
    )
    return diagnose_motion(task)


@cache
def hidden(effect, seed=1, friction=1.0, size=1.0, count=None):
    """The diagnosis of runs with an effect that is not in the first guess.

    Ten runs suffice; an asymmetry needs more, or it could be a constant force.
    """
    count = count or (15 if effect is axis.asymmetry else 10)
    return once(
        f"motion-{effect.__name__}-{seed}-{friction}-{size}-{count}",
        lambda: diagnosis(axis.axis_runs(effect, count, seed, scale=size), model(friction, size)),
    )


def errors_of(found):
    return {error.quantity: error for error in found.errors}


def names_of(found):
    return [effect.name for effect in found.effects]


@pytest.mark.parametrize(
    ("seed", "friction"),
    [(1, 1.0), *(pytest.param(*row, marks=SLOW) for row in ((2, 1.0), (3, 0.2), (4, 0.5)))],
)
def test_without_an_effect_the_verdict_is_none_and_both_errors_are_reported(seed, friction):
    found = hidden(axis.no_effect, seed, friction)
    assert found.verdict == "none" and not found.effects and not found.alternatives
    errors = errors_of(found)
    assert errors["force"].after == errors["force"].refitted < 0.3 * errors["force"].before
    assert errors["position"].after == errors["position"].refitted < errors["position"].before
    for text in (diagnosis_text(found), revised_yaml(found)):
        words = " ".join(text.replace("\n# ", " ").split())
        assert "force error is" in words and "position error is" in words
    lead = verdict_words(found)
    assert lead.startswith(
        "No missing effect is found. With refitted values, the force error falls"
    )
    assert "and the open-loop position error falls from" in lead
    page = diagnosis_page(found, ())
    assert "force along the motion (N)" in page and "open-loop position (mm)" in page


@pytest.mark.parametrize(
    ("effect", "name", "friction"),
    [
        (axis.asymmetry, "direction_asymmetry", 5.0),
        pytest.param(axis.asymmetry, "direction_asymmetry", 0.2, marks=SLOW),
        (axis.weight, "load_cell_offset", 1.0),
        (axis.tight_place, "position_friction", 1.0),
    ],
)
def test_a_hidden_effect_is_named_and_both_errors_fall(effect, name, friction):
    found = hidden(effect, friction=friction)
    assert found.verdict == "named" and names_of(found) == [name]
    errors = errors_of(found)
    assert errors["force"].after < 0.6 * errors["force"].refitted
    assert errors["position"].after < 0.9 * errors["position"].refitted
    assert "The effects improve" not in one_sided_words(found)


def test_a_tight_place_is_reported_with_its_position():
    (effect,) = hidden(axis.tight_place).effects
    words, _, place = effect.description.partition(", most at ")
    assert words and float(place.removesuffix(" mm")) == pytest.approx(300, abs=25)


def test_a_weight_is_an_offset_of_its_force():
    found = hidden(axis.weight)
    (effect,) = found.effects
    assert effect.parameters["force"].value == pytest.approx(-7.0, rel=0.05)
    assert effect.parameters["force"].unit == "N"
    written = found.revised["effects"]["load_cell_offset"]["force"]
    assert float(written.split()[0]) == pytest.approx(-7.0, rel=0.05)


def test_the_law_of_a_driven_mass_names_no_cylinders():
    page = diagnosis_page(hidden(axis.asymmetry, friction=5.0), ())
    assert "F (1 + k sign v), k that of the mass." in page and "test or load" not in page


def test_twice_the_mass_in_addition_is_named_with_its_size():
    found = hidden(axis.more_mass)
    (effect,) = found.effects
    assert effect.name == "added_mass"
    mass = 13 * found.refitted["moving_mass.test"].value + effect.parameters["test"].value
    assert mass == pytest.approx(3 * axis.MASS_KG, rel=0.1)


@SLOW
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_better_force_with_a_motion_that_is_no_better_is_reported(seed):
    """A constant force that differs from run to run decides how far the motion drifts."""
    found = diagnosis(axis.axis_runs(axis.shear, seed=seed, wander_n=4.0))
    (effect,) = found.effects
    assert effect.name == "presliding"
    assert effect.parameters["force"].value == pytest.approx(16.0, rel=0.1)
    errors = errors_of(found)
    assert errors["force"].after < 0.8 * errors["force"].refitted
    assert errors["position"].after > errors["position"].refitted
    for text in (diagnosis_text(found), diagnosis_page(found, ())):
        assert "The effects improve the force without the position" in " ".join(text.split())


@pytest.mark.parametrize(
    ("force", "position", "said"),
    [
        ((4, 2, 1), (9, 6, 3), []),
        ((4, 2, 1), (9, 6, 6), ["The effects improve the force without the position"]),
        ((4, 4, 4), (9, 9, 6), ["The effects improve the position without the force"]),
        ((4, 2, 1), (9, 20, 3), ["The refit improves the force without the position"]),
        (
            (4, 2, 1),
            (2, 9, 3),
            ["The refit improves the force without the position, also together"],
        ),
        ((4, 4, 2), (9, 7, 9), ["The refit improves the position", "Compared with the model as"]),
    ],
)
def test_each_step_that_improves_one_error_alone_is_in_the_words(force, position, said):
    errors = HeldOutError("force", "N", *force), HeldOutError("position", "mm", *position)
    found = replace(hidden(axis.asymmetry, friction=5.0), errors=errors)
    words = f"{errors_in_words(found)} {one_sided_words(found)}"
    assert [words.count(each) >= 1 for each in said] == [True] * len(said)
    assert words.count("without the") >= len(said) and (said or "without the" not in words)
    assert f"{force[2]:.2f} N with the effects" in words
    assert f"{position[0]:.2f} mm as given" in words
    force_alone = force[2] < force[0] and position[2] >= position[0]
    lead, change = verdict_words(found), position[2] - position[1]
    verb = "stays at" if change == 0 else "rises from" if change > 0 else "falls from"
    assert "With it, the force error " in lead and f"position error {verb}" in lead
    use = "Use the model for forces, not for positions."
    assert (use in verdict_words(found)) == force_alone


@pytest.mark.parametrize("size", [1e3, pytest.param(1e-3, marks=SLOW)])
def test_a_bench_of_another_size_has_the_same_verdict_and_forces_in_proportion(size):
    own, other = hidden(axis.tight_place), hidden(axis.tight_place, size=size)
    assert names_of(other) == names_of(own) == ["position_friction"]
    for key, parameter in own.effects[0].parameters.items():
        assert other.effects[0].parameters[key].value == pytest.approx(
            size * parameter.value, rel=1e-4
        )
    before, after = errors_of(own), errors_of(other)
    assert after["force"].after == pytest.approx(size * before["force"].after, rel=1e-4)
    assert after["position"].after == pytest.approx(before["position"].after, rel=1e-4)
    assert other.where[0].scatter == pytest.approx(size * own.where[0].scatter, rel=1e-4)


def test_an_unknown_law_has_the_parts_of_a_driven_mass_to_inspect():
    soft = deepcopy(axis.MODEL)
    soft["friction"]["test"]["law"] = "lugre"  # with bristles far softer than the axis
    found = diagnosis(axis.axis_runs(axis.no_effect, count=10), soft)
    assert found.verdict == "unknown" and not found.effects
    words = " ".join(diagnosis_text(found).split())
    assert "First inspect the guide and its seals" in words and "P_Tp" not in words
    assert "inspect the drive, the factor of its force and the moving mass." in words


def test_a_log_without_noise_and_one_without_motion():
    runs = axis.axis_runs(axis.weight, count=10, noise=0.0)
    assert names_of(diagnosis(runs)) == ["load_cell_offset"]
    still = tuple(
        replace(run, x_m=np.full_like(run.x_m, 0.2), f_drive_n=0 * run.f_drive_n) for run in runs
    )
    with pytest.raises(DataError, match="no friction is measured"):
        diagnosis(still)


def test_the_page_has_no_names_of_a_hydraulic_bench():
    effects = axis.no_effect, axis.weight, axis.more_mass, axis.tight_place
    for found in (hidden(axis.asymmetry, friction=5.0), *map(hidden, effects)):
        page = diagnosis_page(found, ())
        assert "force balance of the mass" in page and "no more than" not in page
        for name in ("test cylinder:", "of the test cylinder", "of test cylinder", "load cell 0"):
            assert name not in page
        for name in ("Metering edge", "valve's gain", "dead volumes", "oil columns", "chamber"):
            assert name not in page
        for name in ("bore", "barrel", "rod"):
            assert name not in page
    found = hidden(axis.weight)
    assert "a constant force acts, such as a weight" in diagnosis_page(found, ())
    assert "instruments have an error" not in diagnosis_page(found, ())


def test_few_runs_and_runs_without_a_drive_force_are_reported():
    runs = axis.axis_runs(axis.no_effect, count=8)
    found = diagnosis((replace(runs[0], f_drive_n=None), *runs[1:]))
    assert found.verdict == "unknown" and not found.errors
    assert "at least 8 runs" in found.why and "there are 7" in found.why
    assert found.left_out == ("run 0001: no drive force",)


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """A folder with a campaign that was imported from a voltage of 12 N/V, and a model."""
    folder = tmp_path_factory.mktemp("axis")
    (folder / "logs").mkdir()
    for run in axis.axis_runs(axis.asymmetry, count=10):
        rows = np.column_stack([run.t_s, 1e3 * run.x_m, run.f_drive_n / 12])
        path = folder / f"logs/axis_{int(run.plan.run)}.csv"
        np.savetxt(path, rows, delimiter=",", header="t,x,u", comments="", fmt="%.7g")
    rules = {
        "name": "axis",
        "kind": "triangle",
        "cut": "none",
        "columns": {
            "t_s": {"column": "t", "unit": "s"},
            "x_m": {"column": "x", "unit": "mm"},
            "f_drive_n": {"column": "u", "unit": "N", "scale": 12},
        },
        "series": [{"label": "axis", "files": "axis_{trial}.csv"}],
    }
    (folder / "map.yaml").write_text(yaml.safe_dump(rules))
    (folder / "model.yaml").write_text(yaml.safe_dump(axis.MODEL))
    arguments = ("import", folder / "logs", "-o", folder / "campaign", "--map", folder / "map.yaml")
    assert hbench(*arguments).returncode == 0
    return folder


def test_the_command_writes_both_errors_into_text_page_and_document(imported, undrawn):
    out = imported / "diagnosis"
    arguments = ("reconcile", imported / "campaign", "--model", imported / "model.yaml")
    done = hbench(*arguments, "-o", out)
    assert done.returncode == 0, done.stderr
    assert "verdict: named" in done.stdout and "irection asymmetry" in done.stdout
    assert "force along the motion (N)" in done.stdout and "open-loop position (mm)" in done.stdout
    page = (out / "report.html").read_text()
    assert "load cell 0" not in page  # nothing measured a load
    assert "open-loop position (mm)" in page and "law of the driven mass" in page
    document = json.loads((out / "diagnosis.json").read_text())
    assert [(each["quantity"], each["unit"]) for each in document["errors"]] == [
        ("force", "N"),
        ("position", "mm"),
    ]
    again = hbench(
        "reconcile", imported / "campaign", "--model", out / "model.yaml", "-o", imported / "again"
    )
    assert again.stdout.startswith("No missing effect found: ")


@pytest.mark.skipif(
    not DATA.is_dir(), reason="the TU Delft measurements are not beside the checkout"
)
@SLOW
@pytest.mark.parametrize(("seal", "offset_n_bar"), [("O-ring", 0.36), ("NAPN", 0.51)])
def test_the_strokes_of_real_cylinders_are_a_motion_with_drive_force_too(
    tmp_path, seal, offset_n_bar
):
    """The piston's pressure force drives, the load cell measures the load; the mass is a guess."""
    area_m2 = np.pi / 4 * 0.025**2
    rules = {
        "name": "pneumatic cylinder",
        "kind": "triangle",
        "format": {"separator": "whitespace", "header": False, "skip_rows": 15},
        "columns": {
            "t_s": {"column": 1, "unit": "ms"},
            "x_m": {"column": 5, "unit": "mm", "scale": -1},
            "f_drive_n": {"column": 6, "unit": "N", "scale": 1e5 * area_m2},  # of bar
            "f_applied_n": {"column": 7, "unit": "N"},
        },
        "series": [{"label": seal, "files": f"friction/{seal}_{{trial}}bar.csv"}],
        "cut": "reversals",
        "min_stroke": "20 mm",
        "resample": "100 Hz",
        "screening": {"max_gap": "0.1 s"},
    }
    friction = {"law": "tustin", "coulomb": "6 N", "stiction": "6 N"}
    model = {
        "moving_mass": {"test": "0.5 kg"},
        "friction": {"test": {**friction, "stribeck_velocity": "1 mm/s"}},
    }
    for name, content in (("map", rules), ("model", model)):
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(content))
    clock = lambda: axis.START  # noqa: E731
    workflow.import_runs(DATA, tmp_path / "campaign", tmp_path / "map.yaml", clock)
    found = workflow.reconcile(
        tmp_path / "campaign", tmp_path / "model.yaml", lambda done, of: None
    )
    effects = {effect.name: effect for effect in found.effects}
    assert set(effects) == {"load_friction", "load_cell_gain", "presliding"}
    # The mean offset per bar (the data's own README) as a share of the piston's force.
    share = 100 * offset_n_bar / (1e5 * area_m2)
    assert effects["load_cell_gain"].parameters["error"].value == pytest.approx(share, abs=0.35)
    errors = errors_of(found)
    assert errors["force"].after < 0.5 * errors["force"].refitted < 0.5 * errors["force"].before
    # Under a force that nothing balances exactly the motion is metres off with friction alone.
    assert errors["position"].after < 0.05 * errors["position"].refitted


@pytest.mark.slow
def test_over_many_runs_no_wrong_effect_is_named():
    """Seeds that no choice was made with; ``-s`` shows the verdicts."""
    counts = {}
    for effect, name in {
        axis.no_effect: "",
        axis.asymmetry: "direction_asymmetry",
        axis.tight_place: "position_friction",
        axis.weight: "load_cell_offset",
        axis.more_mass: "added_mass",
        axis.shear: "presliding",
        axis.late_friction: "friction_lag",
    }.items():
        seeds = range(11, 17 if name else 31)
        found = [hidden(effect, seed, count=15) for seed in seeds]
        verdicts = Counter((each.verdict, *names_of(each)) for each in found)
        print(effect.__name__, dict(verdicts))
        counts[effect.__name__] = verdicts
        assert {key[1:] for key in verdicts} <= ({(), (name,)} if name else {()})
    assert counts["no_effect"]["none",] >= 17
    clear = [c for name, c in counts.items() if name not in ("no_effect", "late_friction")]
    assert sum(n for c in clear for key, n in c.items() if key[0] == "named") >= 28
