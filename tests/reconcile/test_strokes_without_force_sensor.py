"""Strokes without a force sensor: only what turns with the direction is compared."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.config.stroke_model import parse_strokes
from hbench.reconcile.strokes.stroke_diagnosis import StrokeTask, diagnose_strokes
from hbench.reconcile.strokes.stroke_words import NO_SENSOR_NOTE
from hbench.records import Provenance
from tests.support.linkage_strokes import AREAS, LOADS_N, half_bands, linkage_strokes

MODEL = {
    "test_cylinder": {"piston_diameter": "65 mm", "rod_diameter": "35 mm"},
    "friction": {
        "test": {
            "law": "tustin",
            "coulomb": "300 N",
            "stiction": "300 N",
            "stribeck_velocity": "1 mm/s",
        }
    },
}


def constant(p_tp, p_tr):
    return 700.0


def saturating(p_tp, p_tr):
    """Seals that are pressed home: the catalogue's law is a straight line."""
    return 400 + 900 * p_tp / (p_tp + 100e5)


def diagnosed(**series):
    plant = parse_strokes(MODEL, "model")
    made = Provenance("made", "imported", "", "", "2026-01-01", "2026-01-01")
    task = StrokeTask(
        provenance=made, model="model.yaml", plant_data=MODEL, plant=plant, series=series
    )
    return diagnose_strokes(task)


def test_the_unknown_load_of_a_linkage_is_neither_friction_nor_an_error_of_a_sensor():
    found = diagnosed(one=linkage_strokes(constant))
    assert found.verdict == "none"
    assert not found.effects and not found.alternatives
    assert found.refitted["friction.test.coulomb"].value == pytest.approx(700 / 300, rel=0.02)


def test_the_mean_of_both_directions_is_not_compared_and_the_page_states_it():
    found = diagnosed(one=linkage_strokes(constant))
    assert [gap.name for gap in found.where] == ["force_band"]
    assert list(found.gap_heldout.balances) == ["force_band"]
    assert NO_SENSOR_NOTE in found.notes
    for name in ("load_cell_gain", "load_cell_offset", "pressure_offset", "direction_asymmetry"):
        assert "force sensor" in found.not_tried[name]


@pytest.mark.parametrize("hidden", [{"gain": 1.03}, {"shares": (1.25, 0.75)}])
@pytest.mark.parametrize("seed", range(3))
def test_a_gain_or_an_asymmetry_gets_no_name(hidden, seed):
    found = diagnosed(one=linkage_strokes(constant, seed=seed, **hidden))
    assert not found.effects and not found.alternatives


@pytest.mark.parametrize("scatter", [0.01, 0.003])
@pytest.mark.parametrize("seed", range(3))
def test_seals_and_guides_are_ambiguous_where_the_load_is_nearly_the_pressure(seed, scatter):
    """Either law explains the friction but for its curvature, whichever has the better score."""
    found = diagnosed(one=linkage_strokes(saturating, seed=seed, scatter=scatter))
    assert found.verdict == "ambiguous" and not found.effects
    names = {each.name for each in found.alternatives}
    assert names == {"seal_pressure_friction", "load_friction"}


def test_a_second_seal_decides_and_held_out_loads_confirm_the_name():
    soft = linkage_strokes(saturating)
    hard = linkage_strokes(lambda p_tp, p_tr: 0.4 * saturating(p_tp, p_tr), seed=1)
    found = diagnosed(one=soft, other=hard)
    assert found.verdict == "named"
    (effect,) = found.effects
    assert effect.name == "seal_pressure_friction"
    assert "standard errors" in found.ruled_out["load_friction"]
    slope = np.polyfit(LOADS_N, half_bands(soft), 1)[0] * 1e5 * AREAS.area_piston_m2  # N/bar
    assert effect.parameters["test_piston"].value == pytest.approx(slope, rel=0.1)
    (band,) = found.gap_heldout.balances.values()
    assert band.after < 0.3 * band.refitted
    assert not found.rest


def test_friction_of_a_single_load_gets_no_name_although_a_line_would_fit():
    """The other loads do not predict the last one, nor it them."""
    loads = (9e3, 10e3, 11e3, 12e3, 25e3)
    screened = linkage_strokes(lambda p_tp, _: np.where(p_tp < 75e5, 700.0, 1100.0), loads_n=loads)
    bands = half_bands(screened)
    assert np.corrcoef(loads, bands)[0, 1] > 0.98
    found = diagnosed(one=screened)
    assert found.verdict == "unknown" and not found.effects and not found.alternatives
    assert [gap.name for gap in found.rest] == ["force_band"]


def test_strokes_with_a_load_cell_are_no_evidence_for_strokes_without():
    unknown = linkage_strokes(saturating)
    rng = np.random.default_rng(0)
    measured = tuple(
        replace(each, run=replace(each.run, f_applied_n=rng.normal(1e4, 5.0, len(each.run.t_s))))
        for each in unknown
    )
    found = diagnosed(one=unknown, other=measured)
    assert not any("Other series" in note for note in found.notes)


def test_logs_without_any_applied_force_get_the_way_out():
    screened = [
        replace(each, run=replace(each.run, f_applied_n=None), reasons=("missing_channel",))
        for each in linkage_strokes(constant)
    ]
    found = diagnosed(one=screened)
    assert found.verdict == "unknown" and not found.effects
    assert "f_applied_n to 0 N in the constants of the import map" in found.missing[0]


def test_two_loads_without_a_force_sensor_are_too_few():
    two = [each for each in linkage_strokes(constant) if each.run.plan.f_load_n < 150]
    found = diagnosed(one=two)
    assert found.verdict == "unknown" and "at least 4 loads" in found.missing[0]
    assert NO_SENSOR_NOTE in found.notes


def test_a_load_that_changes_along_the_stroke_cancels_at_the_same_positions():
    found = diagnosed(one=linkage_strokes(constant, slope_n_m=5e3))
    assert found.verdict == "none"
    assert found.refitted["friction.test.coulomb"].value == pytest.approx(700 / 300, rel=0.02)


def test_strokes_at_other_positions_under_such_a_load_are_not_compared():
    """The load would count as a friction that grows by 125 N, of 700, from load to load."""
    apart = linkage_strokes(constant, slope_n_m=5e3, apart_m=0.05)
    assert np.ptp(half_bands(apart)) > 400
    found = diagnosed(one=apart)
    assert found.verdict == "unknown" and not found.effects and not found.alternatives
    assert "at the same positions; these runs have 1" in found.missing[0]
    level = diagnosed(one=linkage_strokes(constant, apart_m=0.05))
    assert level.verdict == "none"
