"""Real cylinders whose model has constant friction: what the measurement says is missing."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from hbench import workflow
from hbench.config.files.loading import read_yaml
from hbench.config.stroke_model import parse_strokes, stroke_sections
from hbench.errors import ConfigError
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.strokes.stroke_words import GAIN_NOTE
from hbench.report.diagnosis.terminal import diagnosis_text
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.reconciliation import write_diagnosis
from hbench.workflow.stroke_diagnosis import diagnosed_strokes

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data" / "tudelft-cylinder"

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason="the TU Delft measurements are not beside the checkout"
)

BARS = np.array([1.0, 3.0, 5.0, 7.0])
# Half of the friction band [N] at these, computed independently (the data's own README).
HALF_BANDS = {"O-ring": (4.0, 5.6, 7.2, 8.0), "NAPN": (3.3, 6.9, 9.8, 11.9)}
MODEL = ROOT / "configs" / "model-tudelft.yaml"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tudelft") / "campaign"
    clock = lambda: datetime(2026, 1, 1, tzinfo=UTC)  # noqa: E731
    workflow.import_runs(DATA, folder, ROOT / "configs" / "tudelft.yaml", clock)
    return load_campaign(folder)


@pytest.fixture(scope="module", params=HALF_BANDS)
def seal(request, campaign):
    return request.param, diagnosed_strokes(campaign, MODEL, request.param, ["u_t_v"])


def test_friction_of_the_seal_that_grows_with_pressure_is_named_for_both_seals(seal):
    label, found = seal
    assert found.verdict == "named"
    (effect,) = found.effects
    assert effect.name == "seal_pressure_friction"
    slope = np.polyfit(BARS, HALF_BANDS[label], 1)[0]  # N/bar
    # The O-ring's friction bends over pressure, and the strokes at 7 bar, which scatter most, weigh
    # least: so the coefficient is above the slope of the four half bands.
    assert effect.parameters["test_piston"].value == pytest.approx(slope, rel=0.2)
    assert effect.gap_after < 0.3 * effect.gap_before


def test_guides_are_ruled_out_as_they_would_rub_alike_with_either_seal(seal):
    assert "standard errors" in seal[1].ruled_out["load_friction"]


def test_the_error_shrinks_at_pressures_left_out_of_the_fit(seal):
    band = seal[1].gap_heldout.balances["force_band"]
    assert band.after < 0.3 * band.refitted
    (effect,) = seal[1].effects
    assert (effect.gap_before, effect.gap_after) == (band.refitted, band.after)


def test_the_mean_offset_is_ambiguous_between_a_gain_an_area_and_an_asymmetry(seal):
    _, found = seal
    assert {one.name for one in found.alternatives} == {"direction_asymmetry", "load_cell_gain"}
    assert GAIN_NOTE in found.notes
    middle = found.gap_heldout.balances["force_middle"]
    assert middle.after > 0.9 * middle.refitted  # nothing was added for it
    assert EFFECTS["load_cell_gain"].inspect in found.next_experiment


def test_the_diagnosis_is_written_as_for_any_campaign(seal, tmp_path, undrawn):
    _, found = seal
    write_diagnosis(tmp_path, found)
    assert "seal pressure friction" in (tmp_path / "report.html").read_text()
    written = stroke_sections(read_yaml(tmp_path / "model.yaml"))
    coefficient = parse_strokes(written, "model").effects["seal_pressure_friction"]["test_piston"]
    value = found.effects[0].parameters["test_piston"].value
    assert float(coefficient.split()[0]) == pytest.approx(value, rel=1e-6)
    text = " ".join(diagnosis_text(found).split())
    assert all(note in text for note in found.notes)


def test_one_seal_alone_does_not_tell_guides_from_seal(campaign, tmp_path):
    """The reruns' cylinder has another bore, so no other series of it tells."""
    model = tmp_path / "model.yaml"
    model.write_text(MODEL.read_text().replace("piston_diameter: 25.0", "piston_diameter: 25.7"))
    found = diagnosed_strokes(campaign, model, "O-ring 25.7 mm", ["u_t_v"])
    assert found.verdict == "ambiguous" and not found.effects
    assert {each.name for each in found.ranking} == {"seal_pressure_friction", "load_friction"}
    one, other = found.ranking
    assert one.score == pytest.approx(other.score, abs=0.01)
    assert min(one.explained, other.explained) > 0.9


def test_a_series_must_be_told_and_its_cylinder_be_the_models(campaign):
    with pytest.raises(ConfigError, match="'O-ring', 'NAPN'") as caught:
        diagnosed_strokes(campaign, MODEL, None, ["u_t_v"])
    assert caught.value.hint.startswith("Without u_t_v flows are not known")
    with pytest.raises(ConfigError, match=r"4\.909 cm\^2.*5\.187 cm\^2"):
        diagnosed_strokes(campaign, MODEL, "O-ring 25.7 mm", ["u_t_v"])
    with pytest.raises(ConfigError, match="'PTFE'"):
        diagnosed_strokes(campaign, MODEL, "PTFE", ["u_t_v"])
