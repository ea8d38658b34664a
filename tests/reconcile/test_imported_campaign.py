"""Logs of a whole bench, imported from CSV without a bench file, take part with the catalogue."""

import json
from datetime import UTC, datetime

import pytest

from hbench import workflow
from tests.support import ROOT

LEAKING = ROOT / "data_samples" / "blind" / "internal_leakage-clear-1"
MODEL = ROOT / "configs" / "bench-aau.yaml"
AT = datetime(2026, 1, 1, tzinfo=UTC)


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """The campaign as somebody else's logs: no bench, no settings, no motion, no journal."""
    folder = tmp_path_factory.mktemp("foreign")
    workflow.export(LEAKING, folder / "logs", "csv")
    for name in ("bench.yaml", "settings.yaml"):
        (folder / "logs" / name).unlink()
    workflow.import_runs(folder / "logs", folder / "campaign", None, lambda: AT)
    return folder / "campaign"


def test_a_leak_is_named_in_imported_logs_with_the_coefficients_of_the_original(imported):
    """The truth follows another law, so only the two diagnoses are compared."""
    own, foreign = (
        workflow.reconcile(folder, MODEL, lambda done, of: None) for folder in (LEAKING, imported)
    )
    assert [effect.name for effect in foreign.effects] == ["internal_leakage"]
    for key in ("test", "load"):
        measured, again = (one.effects[0].parameters[key] for one in (own, foreign))
        assert again.value == pytest.approx(measured.value, rel=0.15), key
    gap = foreign.gap_heldout.total
    assert gap.refitted > 3 * gap.after
    assert not foreign.gap_heldout.signals and any("imported" in note for note in foreign.notes)
    assert any("instruments" in note for note in foreign.notes)


def test_the_series_of_strokes_is_not_asked_for(imported):
    from hbench.errors import ConfigError

    with pytest.raises(ConfigError, match="--series"):
        workflow.reconcile(imported, MODEL, lambda done, of: None, series="a")


def test_gaps_have_units_and_limits(imported, tmp_path):
    found = workflow.reconcile(imported, MODEL, lambda done, of: None)
    workflow.write_diagnosis(tmp_path, found)
    rows = json.loads((tmp_path / "diagnosis.json").read_text())["where"]
    flows = {row["name"]: row for row in rows if row["name"].startswith("flow")}
    for row in flows.values():
        assert 0 < row["material"] < row["deviation"] < 1e-4  # m^3/s
        assert row["allowed"] > 0
