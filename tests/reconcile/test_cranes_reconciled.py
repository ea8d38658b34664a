"""Cranes, whose cylinders have no force sensor: the load of the linkage gets no name."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.config.stroke_model import parse_strokes
from hbench.reconcile.strokes.stroke_diagnosis import StrokeTask, diagnose_strokes
from hbench.reconcile.strokes.stroke_words import NO_SENSOR_NOTE
from hbench.report.diagnosis.terminal import diagnosis_text
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.reconciliation import write_diagnosis
from hbench.workflow.results import calibrated_runs
from tests.support.linkage_strokes import half_bands, sections

CRANE = Path(__file__).parents[2].parent / "shared" / "data" / "crane"

pytestmark = pytest.mark.skipif(
    not CRANE.is_dir(), reason="the measurements of the cranes are not beside the checkout"
)

SIGNALS = {
    "x_m": ("PistonPosition", "m"),
    "p_tp_pa": ("Pa", "bar"),
    "p_tr_pa": ("Pb", "bar"),
    "p_s_pa": ("Ps", "bar"),
}
SIMULINK = {
    key: {"column": f"f{name}_G_OPCf{name}", "unit": unit} for key, (name, unit) in SIGNALS.items()
}
TWINCAT = {
    "x_m": {"column": "JibPistonPosition", "unit": "m"},
    "p_tp_pa": {"column": "JibPaCyl", "unit": "bar"},
    "p_tr_pa": {"column": "JibPbCyl", "unit": "bar"},
}
MAIN = {"piston_diameter": "65 mm", "rod_diameter": "35 mm"}
JIB = {"piston_diameter": "150 mm", "rod_diameter": "100 mm"}
FILES = {
    "DataForFriction_170125.mat": (SIMULINK, MAIN),
    "DynamicLoadTesting.mat": (SIMULINK, MAIN),
    "JibSineTest_230425.csv": (TWINCAT, JIB),
    "FixedXSensor_090525.csv": (TWINCAT, JIB),
    "RampDisturbanceTest_230425.csv": (TWINCAT, JIB),
    "JibValveResponseTime_010425.csv": (TWINCAT, JIB),
}
KILONEWTON = {"law": "tustin", "coulomb": "1 kN", "stiction": "1 kN", "stribeck_velocity": "1 mm/s"}


def model_of(cylinder):
    return {"test_cylinder": cylinder, "friction": {"test": KILONEWTON}}


def imported(folder, name, **changes):
    """The campaign of a file, with strokes whose load changes by any amount."""
    columns, cylinder = FILES[name]
    rules = {
        "name": "crane",
        "kind": "steady",
        "columns": columns,
        "constants": {"f_applied_n": "0 N"},
        "series": [{"label": "crane", "files": name, "cylinder": cylinder}],
        "cut": "reversals",
        "screening": {"friction_drift": "100 kN", "speed_ripple": "50 mm/s"},
    } | changes
    rules = {key: value for key, value in rules.items() if value is not None}
    (folder / "map.yaml").write_text(yaml.safe_dump(rules))
    (folder / "model.yaml").write_text(yaml.safe_dump(model_of(cylinder)))
    clock = lambda: datetime(2026, 1, 1, tzinfo=UTC)  # noqa: E731
    workflow.import_runs(CRANE, folder / "campaign", folder / "map.yaml", clock)
    return folder / "campaign"


def reconciled(folder):
    return workflow.reconcile(folder / "campaign", folder / "model.yaml", lambda done, of: None)


@pytest.mark.parametrize("name", FILES)
def test_a_file_has_a_single_load_which_is_too_few_for_a_name(tmp_path, name):
    imported(tmp_path, name)
    found = reconciled(tmp_path)
    assert found.verdict == "unknown"
    assert not found.effects and not found.alternatives and not found.rest
    assert "at least 4 loads or pressures" in found.missing[0]
    assert NO_SENSOR_NOTE in found.notes
    assert NO_SENSOR_NOTE in " ".join(diagnosis_text(found).split())


def test_a_map_without_the_applied_force_gets_the_way_out(tmp_path):
    imported(tmp_path, "DynamicLoadTesting.mat", constants=None)
    found = reconciled(tmp_path)
    assert found.verdict == "unknown"
    assert "f_applied_n to 0 N in the constants of the import map" in found.missing[0]
    assert all("f_applied_n" in reason for reason in found.left_out)


def test_a_load_that_changes_along_the_stroke_is_left_out_with_the_way_out(tmp_path):
    imported(tmp_path, "DynamicLoadTesting.mat", screening=None)
    found = reconciled(tmp_path)
    assert len(found.left_out) == 8 and all("drifts" in reason for reason in found.left_out)
    assert any("screening.friction_drift" in note for note in found.notes)


@pytest.fixture(scope="module")
def by_position(tmp_path_factory):
    """Passages of five sections of the stroke, four times in each direction, and the diagnosis."""
    folder = tmp_path_factory.mktemp("crane")
    reference = {"v_ref_m_s": {"column": "fXDotRef_G_OPCfXDotRef", "unit": "m/s"}}
    whole = {"cut": None, "kind": "verification", "columns": SIMULINK | reference}
    campaign = load_campaign(imported(folder, "DynamicLoadTesting.mat", **whole))
    (run,) = calibrated_runs(campaign)
    passages = sections(run, np.linspace(0.08, 0.25, 6), 0.03)
    model = model_of(MAIN)
    task = StrokeTask(
        provenance=campaign.provenance(),
        model="model.yaml",
        plant=parse_strokes(model, "model.yaml"),
        plant_data=model,
        series={"crane": passages},
    )
    return passages, diagnose_strokes(task)


def test_the_linkages_load_along_the_stroke_gets_no_name(by_position):
    """The load changes by 5 kN along the stroke, the half band by some 0.25 kN."""
    passages, found = by_position
    assert len(passages) == 40
    assert found.verdict in ("none", "unknown")
    assert not found.effects and not found.alternatives
    assert [gap.name for gap in found.where] == ["force_band"]


def test_the_refitted_friction_is_half_the_difference_of_the_directions(by_position):
    passages, found = by_position
    bands = half_bands(passages)
    refitted = 1e3 * found.refitted["friction.test.coulomb"].value
    assert bands.min() < refitted < bands.max()
    assert refitted == pytest.approx(bands.mean(), rel=0.15)


def test_the_page_of_a_crane_is_written(by_position, tmp_path, undrawn):
    _, found = by_position
    write_diagnosis(tmp_path, found)
    assert "No force sensor" in (tmp_path / "report.html").read_text()
