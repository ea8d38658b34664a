"""Benches that are not built like hbench's: a motor, a rotary actuator, several speeds in a log."""

import json
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from hbench import workflow
from hbench.analysis.comparison.difference_tests import InstrumentPair
from hbench.analysis.comparison.differences import campaign_differences
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign

CERTIFICATE = Path(__file__).parents[1] / "configs" / "certificate.yaml"
RATE_HZ = 200
COULOMB_N, VISCOUS_N_S_M, OFFSET_N, MASS_KG = 18.0, 70.0, 3.0, 6.0


def clock():
    return datetime(2026, 1, 1, tzinfo=UTC)


def friction(v):
    return np.tanh(v / 2e-4) * COULOMB_N + VISCOUS_N_S_M * v + OFFSET_N


def speeds_in_turn(speeds, travel_m=0.1):
    """Return t, x, v, a: out and back at each speed, with rests of 0.3 s."""
    v = [np.zeros(RATE_HZ)]
    for speed in speeds:
        ramp, hold = int(speed / 1.0 * RATE_HZ) + 2, int(travel_m / speed * RATE_HZ)
        one = np.concatenate([np.linspace(0, 1, ramp), np.ones(hold), np.linspace(1, 0, ramp)])
        rest = np.zeros(int(0.3 * RATE_HZ))
        v += [speed * one, rest, -speed * one, rest]
    v = np.concatenate(v)
    t = np.arange(len(v)) / RATE_HZ
    return t, 0.05 + np.cumsum(v) / RATE_HZ, v, np.gradient(v, t)


def write(path, columns, seed=1):
    """Write columns as a German logger does."""
    path.parent.mkdir(exist_ok=True, parents=True)
    rng = np.random.default_rng(seed)
    noisy = [y + noise * rng.standard_normal(len(y)) for y, noise in columns.values()]
    rows = (";".join(f"{value:.6f}" for value in row) for row in zip(*noisy, strict=True))
    path.write_text("\n".join([";".join(columns), *rows]).replace(".", ",") + "\n")


@pytest.fixture
def rules():
    """The map of a linear axis with a motor of 12 N/V and no load cell."""
    return {
        "name": "axis",
        "format": {"separator": "semicolon", "decimal": ","},
        "columns": {
            "t_s": {"column": "t", "unit": "s"},
            "x_m": {"column": "x", "unit": "mm"},
            "f_drive_n": {"column": "u", "unit": "N", "scale": 12},
        },
        "moving_mass": f"{MASS_KG} kg",
        "cut": "plateaus",
        "screening": {"settle_travel": "5 mm", "friction_drift": "5 N"},
        "series": [
            {"label": "axis", "files": "axis_{warmth}C_{trial}.csv", "factors": {"warmth": "°C"}}
        ],
    }


@pytest.fixture
def imported(tmp_path, rules):
    """Return a function that imports ``tmp_path / "logs"`` by ``rules``."""

    def bring_in():
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        summary = workflow.import_runs(
            tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", clock
        )
        return summary, workflow.analyze(tmp_path / "out")

    return bring_in


def axis_log(path, speeds, seed):
    t, x, v, a = speeds_in_turn(speeds)
    drive = (friction(v) + MASS_KG * a) / 12
    write(path, {"t": (t, 0), "x": (1e3 * x, 3e-3), "u": (drive, 0.02)}, seed)


def test_a_log_of_several_speeds_becomes_a_run_a_speed_without_hydraulics(tmp_path, imported):
    for trial in (1, 2):
        axis_log(tmp_path / f"logs/axis_20C_{trial}.csv", (0.02, 0.06, 0.15), trial)
    axis_log(tmp_path / "logs/axis_40C_1.csv", (0.02, 0.06, 0.15), 3)
    summary, results = imported()
    assert summary.runs == 18 and all(run.accepted for run in results.runs)
    assert {curve.label for curve in results.curves} == {"axis, warmth 20 °C", "axis, warmth 40 °C"}
    warm = [curve for curve in results.curves if "20" in curve.label]
    for curve in warm:
        sign = 1 if curve.direction == "extend" else -1
        assert [round(1e3 * abs(point.v_m_s)) for point in curve.points] == [20, 60, 150]
        for point in curve.points:
            assert point.friction_n == pytest.approx(friction(point.v_m_s), abs=0.6)
            assert sign * point.friction_n > 0 and point.n == 2 and point.p_tp_pa is None
    balance = next(b for b in results.motion_balances if "20" in b.label)
    for name, truth in (
        ("coulomb_n", COULOMB_N),
        ("viscous_n_s_m", VISCOUS_N_S_M),
        ("offset_n", OFFSET_N),
        ("asymmetry_n_s_m", 0.0),
    ):
        stem, unit = name.split("_n", 1)
        half_width = getattr(balance, f"{stem}_ci95_n{unit}")
        assert abs(getattr(balance, name) - truth) < half_width < 0.2 * COULOMB_N, name


def test_factors_have_columns_of_their_own_and_match_series_of_other_labels(
    tmp_path, rules, imported
):
    for warmth in (20, 40):
        axis_log(tmp_path / f"logs/axis_{warmth}C_1.csv", (0.02, 0.06, 0.15), warmth)
    rules["series"][0]["factors"]["grease"] = "PTFE"
    _, own = imported()
    tables = {
        name: pd.read_csv(tmp_path / f"out/results/{name}.csv") for name in ("curves", "runs")
    }
    for table in tables.values():
        after = list(table.columns).index("label") + 1
        assert list(table.columns[after : after + 2]) == ["factor_grease", "factor_warmth"]
        assert set(table["factor_warmth"]) == {"20 °C", "40 °C"}
        assert (table["label"] == "axis, grease PTFE, warmth " + table["factor_warmth"]).all()
    document = json.loads((tmp_path / "out/results/results.json").read_text())
    assert document["curves"][0]["factors"] == {"warmth": "20 °C", "grease": "PTFE"}
    assert document["runs"][-1]["factors"]["warmth"] == "40 °C"

    rules["series"][0] |= {"label": "other axis", "factors": {"warmth": "°C", "grease": "none"}}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(tmp_path / "logs", tmp_path / "b", tmp_path / "map.yaml", clock)
    other = workflow.analyze(tmp_path / "b")
    compared, notes = campaign_differences(own, other, InstrumentPair(None, None, False))
    assert len(compared) == 4 and not notes
    for pair in compared:
        assert pair.a.factor_values["warmth"] == pair.b.factor_values["warmth"]
        assert pair.b.label.startswith("other axis, ")


def test_laws_of_a_bench_without_hydraulics_are_tried_on_files_left_out(tmp_path, rules):
    t = np.arange(0, 6, 1 / 100)
    for trial in range(1, 7):
        x = 0.1 + 0.03 * np.sin(2 * np.pi * (0.2 + 0.05 * trial) * t) * np.minimum(t, 1)
        v, a = np.gradient(x, t), np.gradient(np.gradient(x, t), t)
        drive = (friction(v) - OFFSET_N + MASS_KG * a) / 12
        columns = {"t": (t, 0), "x": (1e3 * x, 1e-4), "u": (drive, 0.01)}
        write(tmp_path / f"logs/axis_20C_{trial}.csv", columns, trial)
    rules |= {"kind": "triangle", "cut": "none"}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", clock)
    found = workflow.identify(tmp_path / "out", lambda progress: None)
    assert not any("bench file" in note for note in found.notes)  # there is none
    lugre = next(law for law in found.laws if law.law == "lugre")
    assert lugre.held_out_runs == ("0003", "0006")
    assert lugre.held_out_n < 0.1 * (COULOMB_N + VISCOUS_N_S_M * 0.1)
    parameters = {name: p.value for name, p in lugre.fit.parameters.items()}
    assert parameters["b_viscous_n_s_m"] == pytest.approx(VISCOUS_N_S_M, rel=0.1)
    assert not {"k_piston_n_pa", "k_rod_n_pa"} & set(parameters)


def cylinder_log(
    path, load_n=1500.0, seed=1, zero_n=0.0, late_load=False, sign=1.0, velocity_sign=1.0
):
    t, x, v, a = speeds_in_turn((0.1,), 0.2)
    rest = np.zeros(2 * RATE_HZ)
    t = np.arange(len(t) + len(rest)) / RATE_HZ
    x, v = np.concatenate([rest + x[0], x]), np.concatenate([rest, v])
    force = np.where(np.abs(v) > 0, load_n, 0.0)
    if late_load:
        force = np.where(t > 2.6, load_n, 0.0)
    p_a = (force + 300 * np.tanh(v / 1e-3) + 10e5 * 7.6576e-4) / 1.256637e-3
    columns = {
        "t": (t, 0),
        "x": (1e3 * x, 3e-3),
        "v": (velocity_sign * 1e3 * v, 0.1),
        "p": (p_a / 1e5, 0.02),
        "f": (sign * force + zero_n, 2.0),
    }
    write(path, columns, seed)


@pytest.fixture
def hydraulic(rules):
    """The map of a cylinder with a load cell; loads are in the files' names."""
    del rules["columns"]["f_drive_n"], rules["moving_mass"], rules["screening"]
    rules["columns"] |= {
        "p_tp_pa": {"column": "p", "unit": "bar"},
        "f_applied_n": {"column": "f", "unit": "N"},
    }
    rules["constants"] = {"p_tr_pa": "10 bar"}
    cylinder = {"piston_diameter": "40 mm", "rod_diameter": "25 mm"}
    rules["series"] = [{"label": "", "files": "*_{load}N_{trial}.csv", "cylinder": cylinder}]
    return rules


def test_instruments_of_a_map_give_the_expanded_uncertainty(tmp_path, hydraulic, imported):
    for trial in (1, 2, 3):
        cylinder_log(tmp_path / f"logs/any_+1500,0N_{trial}.csv", seed=trial)
    hydraulic["instruments"] = {
        "force": {"tolerance": "0.5 %", "of": "full_scale", "full_scale": "5 kN"},
        "pressure": {"tolerance": "0.5 %", "of": "full_scale", "full_scale": "100 bar"},
    }
    hydraulic["details"] = {"specimen": "serial 17", "oil": "HLP 46"}
    _, results = imported()
    point = next(c for c in results.curves if c.direction == "extend").points[0]
    limit = np.hypot(25.0, 0.5e5 * np.hypot(1.256637e-3, 7.6576e-4))  # 0.5 % of full scale
    assert point.sigma_instruments_n == pytest.approx(limit / np.sqrt(3), rel=1e-3)
    assert point.u95_n > 1.1 * limit and point.friction_n == pytest.approx(300, abs=5)
    assert results.provenance.details["specimen"] == "serial 17"


def test_a_load_before_the_motion_is_no_zero_offset(tmp_path, hydraulic, imported):
    hydraulic["columns"]["f_applied_n"]["zero"] = "rest"
    cylinder_log(tmp_path / "logs/a_1500N_1.csv", late_load=True, zero_n=12.0)
    with pytest.raises(DataError, match=r"a_1500N_1\.csv: f_applied_n: .*1\d\d\d.* N at 2\.6") as e:
        imported()
    assert "zero: none" in e.value.hint
    cylinder_log(tmp_path / "logs/a_1500N_1.csv", zero_n=12.0)
    _, results = imported()
    assert results.runs[0].means.f_applied_n == pytest.approx(1500, abs=2)


def test_a_load_of_the_other_sign_than_its_name_is_reported(tmp_path, hydraulic, imported):
    for trial in (1, 2):
        cylinder_log(tmp_path / f"logs/a_1500N_{trial}.csv", sign=-1.0, seed=trial)
    summary, _ = imported()
    notes = [note for note in summary.notes if "sign" in note]
    assert len(notes) == 1 and "1500" in notes[0] and "2 files" in notes[0]


def test_a_velocity_against_the_motion_is_reported(tmp_path, hydraulic, imported):
    hydraulic["columns"]["v_m_s"] = {"column": "v", "unit": "mm/s"}
    for trial, sign in ((1, 1.0), (2, -1.0)):
        cylinder_log(tmp_path / f"logs/a_1500N_{trial}.csv", seed=trial, velocity_sign=sign)
    summary, _ = imported()
    (note,) = [note for note in summary.notes if "v_m_s has the sign" in note]
    assert note.startswith("a_1500N_2.csv: ")


def test_a_rotary_actuator_has_angles_and_torques(tmp_path, hydraulic, imported):
    t, x, v, _ = speeds_in_turn((0.4,), 0.8)  # rad
    p_a = (50 + 8 * np.sign(v) + 10e5 * 30e-6) / 30e-6
    columns = {"t": (t, 0), "x": (np.degrees(x), 1e-3), "p": (p_a / 1e5, 1e-3)}
    write(tmp_path / "logs/a_50N_1.csv", columns | {"f": (np.full(len(t), 50.0), 1e-3)})
    hydraulic["columns"]["x_m"]["unit"] = "deg"
    hydraulic["columns"]["f_applied_n"]["unit"] = "N m"
    hydraulic["min_stroke"] = "100 mm"
    hydraulic["series"] = [
        {
            "label": "",
            "files": "a_{load}N_{trial}.csv",
            "load_unit": "N m",
            "cylinder": {"displacement": "30 cm^3"},
        }
    ]
    summary, results = imported()
    assert [run.means.friction_n for run in results.runs] == pytest.approx([8, -8], abs=0.05)
    assert [run.means.v_m_s for run in results.runs] == pytest.approx([0.4, -0.4], rel=1e-3)
    assert any("rad" in note for note in summary.notes)
    with pytest.raises(DataError, match="gets no certificate: its actuator is rotary"):
        workflow.certify(tmp_path / "out", CERTIFICATE, tmp_path / "c.html")


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat"])
def test_a_rotary_campaign_stays_rotary_when_it_is_exported(
    tmp_path, hydraulic, imported, clock, kind
):
    test_a_rotary_actuator_has_angles_and_torques(tmp_path, hydraulic, imported)
    workflow.export(tmp_path / "out", tmp_path / "exported", kind)
    summary = workflow.import_runs(tmp_path / "exported", tmp_path / "again", None, clock)
    assert any(note.startswith("rotary actuator: in all results") for note in summary.notes)
    with pytest.raises(DataError, match="gets no certificate: its actuator is rotary"):
        workflow.certify(tmp_path / "again", CERTIFICATE, tmp_path / "c.html")


@pytest.mark.parametrize(
    ("cylinder", "key"),
    [
        ({"piston_diameter": "40 mm", "piston_area": "10 cm^2"}, "piston_area"),
        ({"rod_area": "5 cm^2"}, "piston_diameter"),
        ({"piston_area": "5 cm^2", "rod_area": "6 cm^2"}, "rod_area"),
        ({}, "displacement"),
    ],
)
def test_a_cylinder_has_one_size(tmp_path, hydraulic, imported, cylinder, key):
    (tmp_path / "logs").mkdir()
    hydraulic["series"][0]["cylinder"] = cylinder
    with pytest.raises(ConfigError, match=rf"cylinder.*{key}"):
        imported()


def test_without_pressures_and_without_a_drive_there_is_no_friction(tmp_path, hydraulic, imported):
    (tmp_path / "logs").mkdir()
    del hydraulic["series"][0]["cylinder"]
    with pytest.raises(ConfigError, match=r"cylinder.*f_drive_n"):
        imported()


def test_a_campaign_of_a_foreign_bench_can_be_loaded_again(tmp_path, hydraulic, imported):
    cylinder_log(tmp_path / "logs/a_-1500N_1.csv")
    imported()
    plans = load_campaign(tmp_path / "out").plans
    assert {plan.f_load_n for plan in plans} == {-1500.0}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"x_m": {"column": "Weg [mm]", "unit": "m"}}, ["x_m", "Weg", "mm"]),
        ({"f_applied_n": {"column": "F (kN)", "unit": "N"}}, ["F (kN)", "kN"]),
        ({"f_applied_n": {"column": "F (Newton)", "unit": "kN"}}, ["F (Newton)", "'kN'"]),
        ({"x_m": {"column": "Weg [%]", "unit": "mm"}}, ["x_m", "Weg", "%"]),
    ],
)
def test_a_unit_that_the_columns_name_contradicts_is_refused(
    tmp_path, hydraulic, imported, change, words
):
    cylinder_log(tmp_path / "logs/a_1500N_1.csv")
    path = tmp_path / "logs/a_1500N_1.csv"
    for key, column in change.items():
        old = hydraulic["columns"][key]["column"]
        head, _, rest = path.read_text().partition("\n")
        path.write_text(head.replace(old, column["column"]) + "\n" + rest)
        hydraulic["columns"][key] = column
    with pytest.raises(DataError) as caught:
        imported()
    assert all(word in caught.value.message for word in words[1:])


def test_a_unit_that_the_files_name_contradicts_is_refused(tmp_path, hydraulic, imported):
    (tmp_path / "logs").mkdir()
    hydraulic["series"][0]["files"] = "a_{load}kN_{trial}.csv"
    with pytest.raises(ConfigError, match=r"\{load\} .*kN.*load_unit"):
        imported()


def test_what_is_no_cylinder_gets_no_certificate_of_one(tmp_path, imported):
    """Its areas, forces and efficiency would be those of a hydraulic cylinder."""
    axis_log(tmp_path / "logs/axis_20C_1.csv", (0.02, 0.06, 0.15), 1)
    imported()
    with pytest.raises(DataError, match="gets no certificate: a drive without hydraulics"):
        workflow.certify(tmp_path / "out", CERTIFICATE, tmp_path / "c.html")
