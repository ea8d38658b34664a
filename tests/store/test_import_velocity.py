"""A column of the velocity whose sign or scale contradicts the motion is named by the import."""

import numpy as np
import pytest
import yaml

from hbench import workflow
from tests.support.strokes import there_and_back


@pytest.fixture
def notes_of(tmp_path, clock):
    """Return a function that imports a log with a velocity and returns the notes on it."""

    def notes_of(velocity, unit="m/s"):
        run = there_and_back(0.02, 500.0, rate_hz=200.0)
        v = np.gradient(run["x_m"], run["t_s"])
        smooth = np.convolve(v, np.ones(20) / 20, "same")
        run["v"] = velocity(smooth)
        (tmp_path / "logs").mkdir()
        rows = np.stack(list(run.values()), axis=1)
        np.savetxt(tmp_path / "logs/1.csv", rows, "%.8g", ",", header=",".join(run), comments="")
        columns = {name: {"column": name} for name in run if name != "v"}
        columns["v_m_s"] = {"column": "v", "unit": unit}
        cylinder = {"piston_diameter": "40 mm", "rod_diameter": "25 mm"}
        rules = {
            "name": "velocity",
            "cut": "reversals",
            "columns": columns,
            "series": [{"label": "A", "files": "{trial}.csv", "cylinder": cylinder}],
        }
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        found = workflow.import_runs(
            tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", clock
        )
        return [note for note in found.notes if "v_m_s" in note]

    return notes_of


@pytest.mark.parametrize("noise", [0.0, 5e-3])
def test_the_velocity_of_the_motion_has_no_note(notes_of, noise):
    rng = np.random.default_rng(1)
    assert notes_of(lambda v: v + noise * rng.standard_normal(len(v))) == []


def test_a_velocity_in_another_unit_is_named_with_its_ratio(notes_of):
    (note,) = notes_of(lambda v: 1e3 * v)
    assert note.startswith("1.csv: v_m_s is ") and "times the speed of x_m: check its" in note
    low = float(note.split("v_m_s is ")[1].split()[0])
    assert low == pytest.approx(1000, rel=0.05)


def test_a_velocity_of_the_wrong_sign_is_named(notes_of):
    (note,) = notes_of(lambda v: -v)
    assert "v_m_s has the sign opposite to that of the motion of x_m" in note


@pytest.mark.parametrize(
    ("x_unit", "t_unit", "ratio"),
    [("mm", "s", None), ("m", "s", 1000), ("in", "s", 25.4), ("mm", "ms", 1000)],
)
def test_a_motion_of_another_scale_than_the_speed_in_the_name_is_named(
    rules, import_by, tmp_path, x_unit, t_unit, ratio
):
    run = there_and_back(0.02, 500.0, rate_hz=200.0)
    rows = np.stack([run["t_s"], 1e3 * run["x_m"]], axis=1)
    np.savetxt(tmp_path / "20mm_s_1.csv", rows, "%.8g", ",", header="t,x", comments="")
    rules["columns"] = {
        "t_s": {"column": "t", "unit": t_unit},
        "x_m": {"column": "x", "unit": x_unit},
    }
    rules["cut"] = "reversals"
    del rules["constants"]
    rules["series"][0]["files"] = "{speed}mm_s_{trial}.csv"
    _, notes = import_by(rules)
    found = [note for note in notes if "times the nominal speed" in note]
    assert len(found) == (ratio is not None)
    for note in found:
        assert float(note.split("speed of x_m is ")[1].split()[0]) == pytest.approx(ratio, rel=0.1)
