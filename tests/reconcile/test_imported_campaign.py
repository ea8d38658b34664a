"""Logs of a whole bench, imported from CSV without a bench file, take part with the catalogue."""

from datetime import UTC, datetime

import pytest
import yaml

from hbench import workflow
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.model.effects.catalogue import EFFECTS
from hbench.store.campaign.folder import StoredCampaign, load_campaign
from hbench.workflow import campaign_diagnosis
from hbench.workflow.results import calibrated_runs
from tests.support import ROOT
from tests.support.reconcile.blind import stored_outcome
from tests.support.reconcile.made_diagnosis import named

LEAKING = ROOT / "data_samples" / "blind" / "internal_leakage-clear-1"
MODEL = ROOT / "configs" / "bench-aau.yaml"
AT = datetime(2026, 1, 1, tzinfo=UTC)


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """The campaign as somebody else's logs: no bench, no instruments, no motion."""
    folder = tmp_path_factory.mktemp("foreign")
    workflow.export(LEAKING, folder / "logs", "csv")
    (folder / "logs" / "bench.yaml").unlink()
    workflow.import_runs(folder / "logs", folder / "campaign", None, lambda: AT)
    return folder / "campaign"


@pytest.fixture(scope="module")
def foreign(imported):
    return workflow.reconcile(imported, MODEL, lambda done, of: None)


@pytest.mark.slow
def test_a_leak_is_named_in_imported_logs_with_the_coefficients_of_the_original(foreign):
    """The truth follows another law, so only the two diagnoses are compared."""
    own = stored_outcome(LEAKING)
    (effect,) = foreign.effects
    assert (effect.name,) == own.named == ("internal_leakage",)
    for key, row in EFFECTS[effect.name].coefficients.items():
        again = row.to_si(effect.parameters[key].value)
        assert again == pytest.approx(own.coefficients[key], rel=0.15), key
    gap = foreign.gap_heldout.total
    assert gap.refitted > 3 * gap.after
    assert not foreign.gap_heldout.signals and any("imported" in note for note in foreign.notes)
    assert any("instruments" in note for note in foreign.notes)
    assert any("no start times" in note and "date-time" in note for note in foreign.notes)


@pytest.mark.parametrize("known", [True, False])
def test_runs_are_diagnosed_in_the_order_of_their_starts(imported, monkeypatch, known):
    """A drift or oil that warms follows the time, not the names of files."""
    campaign = load_campaign(imported)
    runs = tuple(calibrated_runs(campaign))
    starts = {run.plan.run: -60.0 * i for i, run in enumerate(runs)}
    if not known:
        del starts[runs[0].plan.run]
    monkeypatch.setattr(StoredCampaign, "start_times_s", lambda self: starts)
    taken = []
    monkeypatch.setattr(campaign_diagnosis, "diagnose", lambda task: taken.append(task) or named())
    found = campaign_diagnosis.diagnosed(campaign, runs, MODEL, 0.002, print, print)
    assert taken[0].runs == (runs[::-1] if known else runs)
    assert any("no start times" in note for note in found.notes) is not known


def test_sections_that_no_bench_file_supplies_are_asked_for(imported, tmp_path):
    model = read_yaml(ROOT / "configs" / "model-aau.yaml")
    del model["end_stop"]
    (tmp_path / "model.yaml").write_text(yaml.safe_dump(model))
    with pytest.raises(ConfigError, match="'end_stop' is missing") as caught:
        workflow.reconcile(imported, tmp_path / "model.yaml", lambda done, of: None)
    assert "no bench file" in caught.value.hint and "model-aau.yaml" in caught.value.hint


def test_the_series_of_strokes_is_not_asked_for(imported):
    with pytest.raises(ConfigError, match="--series"):
        workflow.reconcile(imported, MODEL, lambda done, of: None, series="a")


@pytest.mark.slow
def test_gaps_have_units_and_limits(foreign):
    flows = [gap for gap in foreign.where if gap.name.startswith("flow")]
    assert len(flows) == 4
    for gap in flows:
        assert 0 < gap.material < gap.deviation < 1e-4  # m^3/s
        assert gap.allowed > 0
