"""Steady strokes of a made-up foreign bench, whose friction follows laws of its own."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.config.stroke_model import parse_strokes
from hbench.errors import ConfigError
from hbench.reconcile.separation.missing_data import MISSING
from hbench.reconcile.strokes import stroke_search
from hbench.reconcile.strokes.pairs import stroke_pairs
from hbench.reconcile.strokes.stroke_diagnosis import StrokeTask, diagnose_strokes
from hbench.reconcile.strokes.stroke_search import StrokeSearchStep
from hbench.reconcile.strokes.stroke_words import GAIN_NOTE
from hbench.records import Candidate, Provenance, Run, RunPlan, ScreenedRun, Specimen, SteadyMeans
from hbench.report.diagnosis.heading import title_words
from hbench.report.diagnosis.summary import answers
from hbench.report.diagnosis.tables.change_tables import candidates_table
from hbench.report.diagnosis.tables.effect_tables import alternatives_table
from hbench.report.diagnosis.tables.gap_tables import loads_table
from hbench.report.diagnosis.verdict import verdict_words
from hbench.units import to_si

BORE_M = 0.040
AREA = np.pi / 4 * BORE_M**2
SPECIMEN = Specimen(AREA, AREA)
MODEL = {
    "test_cylinder": {"piston_diameter": "40 mm"},
    "friction": {
        "test": {
            "law": "tustin",
            "coulomb": "40 N",
            "stiction": "40 N",
            "stribeck_velocity": "1 mm/s",
        }
    },
}
BARS = (10, 20, 30, 45, 60)


def strokes(friction, bars=BARS, trials=3, seed=0, gain=1.0, ways=(1, -1), tilt=0.0):
    """Runs at constant pressures; ``friction(bar)`` [N], the same both ways, and 1 % scatter.

    ``tilt`` is the change of the load cell's force over a stroke, as a share of it.
    """
    rng, screened = np.random.default_rng(seed), []
    for trial in range(1, trials + 1):
        for bar in bars:
            for way in ways:
                speed = way * 0.05
                own = way * friction(bar) * (1 + 0.01 * rng.standard_normal())
                applied = gain * (bar * 1e5 * AREA - own)
                plan = RunPlan(
                    f"{len(screened)}", "steady", trial, speed, SPECIMEN, f_load_n=bar * 1e5 * AREA
                )
                f_test = bar * 1e5 * AREA
                means = SteadyMeans(
                    0.0, 1.0, 100, speed, f_test - applied, f_test, applied, bar * 1e5, 0.0
                )
                t = np.linspace(0.0, 1.0, 101)
                along = way * (t - 0.5)  # of the stroke
                run = Run(
                    plan,
                    t,
                    0.05 * along,
                    p_tp_pa=np.full(len(t), bar * 1e5),
                    f_applied_n=applied + tilt * f_test * along,
                )
                screened.append(ScreenedRun(run, (), means))
    return tuple(screened)


def diagnosed(model=MODEL, **series):
    plant = parse_strokes(model, "model")
    made = Provenance("made", "imported", "", "", "2026-01-01", "2026-01-01")
    task = StrokeTask(
        provenance=made, model="model.yaml", plant_data=model, plant=plant, series=series
    )
    return diagnose_strokes(task)


def saturating(most, half):
    """Seals that are pressed home: the catalogue's law is a straight line."""
    return lambda bar: 30 + most * bar / (bar + half)


def two_seals(model=MODEL):
    """Two seals that differ."""
    soft, hard = strokes(saturating(120, 120)), strokes(saturating(40, 120), seed=1)
    return diagnosed(model, soft=soft, hard=hard)


def test_trials_of_files_with_other_positions_are_repeats():
    """An import averages each file at the positions that its own strokes cover."""
    as_imported = [
        replace(
            run,
            run=replace(
                run.run,
                plan=replace(
                    run.run.plan, x_low_m=0.01 + 1e-5 * n, x_high_m=0.1, speed_is_measured=True
                ),
            ),
        )
        for n, run in enumerate(strokes(saturating(120, 120)))
    ]
    assert len({pair.plan for pair in stroke_pairs(as_imported)}) == len(BARS)
    found = diagnosed(only=tuple(as_imported))
    assert {each.name for each in found.alternatives} >= {"load_friction"}


def test_parameters_that_one_speed_does_not_separate_are_no_excuse_for_a_gap():
    """Only their sum is determined; a correct model with it fits at every load."""
    friction = {"coulomb": "60 N", "stiction": "190 N", "stribeck_velocity": "30 mm/s",
                "viscous": "700 N s/m"}  # fmt: skip
    model = MODEL | {"friction": {"test": MODEL["friction"]["test"] | friction}}
    found = diagnosed(model, one_speed=strokes(lambda bar: 150.0, bars=(20, 40, 60, 80)))
    assert found.verdict == "none"
    total = found.gap_heldout.total
    assert 1.0 <= total.floor < 1.5 < 10 < total.before
    assert dict(answers(found))["What to do"].startswith("Use model.yaml")


def test_of_two_balances_one_effect_each_is_missing():
    """Friction that rises with pressure, and an offset: no single effect explains both."""
    both = tuple(
        replace(
            run,
            run=replace(run.run, f_applied_n=run.run.f_applied_n - 25),
            means=replace(
                run.means,
                f_applied_n=run.means.f_applied_n - 25,
                friction_n=run.means.friction_n + 25,
            ),
        )  # fmt: skip
        for run in strokes(lambda bar: 30.0 + 2.0 * bar)
    )
    found = diagnosed(both=both)
    sets = [[each.name for each in some] for some in found.alternative_sets]
    assert [set(names) for names in sets] == [
        {"load_friction", "seal_pressure_friction"},
        {"load_cell_offset", "pressure_offset"},
    ]
    assert "ne of 2 effects, and one of 2 others, not distinguishable" in title_words(found)
    words = verdict_words(found)
    assert words.count("ne of these effects is missing in the model") == 2
    assert "these data cannot distinguish the effects of a set." in words
    assert "from case to case" not in words
    table = loads_table(found)
    assert "with load friction and load cell offset" in table.head
    for load in found.held_out_loads:
        assert max(load.also.values()) < 1.5 < 10 < load.refitted
    assert found.next_experiment.count("Tests that distinguish ") == 2
    assert "load cell offset and pressure offset: " in found.next_experiment
    assert "they differ by" not in candidates_table(found).head
    candidates = alternatives_table(found)
    why = candidates.head.index("why not named")
    assert {row[why] for row in candidates.rows} == {"not distinguished"}
    assert not [text for text in found.missing if "steps" in text or "hold" in text]


@pytest.mark.parametrize("alone", [False, True])
def test_an_effect_of_the_band_is_decided_beside_those_of_the_middle(monkeypatch, alone):
    """Without them one of two equal laws looked better: a search with scripted steps."""

    def step(searches, models, added, balance):
        beside = "load_cell_offset" in added
        if balance == "force_middle":
            names = () if beside else ("load_cell_offset", "pressure_offset")
        elif "load_friction" in added:
            names = ()
        else:
            names = ("load_friction",) if alone or not beside else ("seals", "load_friction")
        rivals = tuple(Candidate(name, 9.0, 1.0, 1.0, {}, "full", 3.0) for name in names)
        one = names[0] if len(names) == 1 else None
        return StrokeSearchStep(balance, None, rivals, one, () if one else rivals, {}), models

    monkeypatch.setattr(stroke_search, "_step", step)
    measured = SimpleNamespace(balances=("force_band", "force_middle"))
    search = SimpleNamespace(measured=measured, refit=lambda model, names: (*model, *names))
    found = stroke_search.search_series([(search, ())])
    assert found.names == (("load_friction",) if alone else ())
    sets = [[each.name for each in one.ambiguous] for one in found.steps if one.ambiguous]
    band = [] if alone else [["seals", "load_friction"]]
    assert sets == [*band, ["load_cell_offset", "pressure_offset"]]


@pytest.fixture(scope="module")
def of_two_seals():
    return two_seals()


def test_friction_that_saturates_with_pressure_is_named_with_the_seals_law(of_two_seals):
    """Guides are ruled out."""
    found = of_two_seals
    assert found.verdict == "named"
    (effect,) = found.effects
    assert effect.name == "seal_pressure_friction"
    secant = (saturating(120, 120)(60) - saturating(120, 120)(10)) / 50
    assert effect.parameters["test_piston"].value == pytest.approx(secant, rel=0.2)
    assert "load_friction" in found.ruled_out
    band = found.gap_heldout.balances["force_band"]
    assert band.after < 0.5 * band.refitted
    assert not found.alternatives


def test_the_gaps_of_an_effect_are_those_of_loads_outside_the_fit(of_two_seals):
    """Constant and straight friction through the mean half bands of the other loads, fitted here.

    Of the code's numbers only the unit is used, the scatter of the trials.
    """
    runs, bars = strokes(saturating(120, 120)), np.array(BARS)
    lost = [abs(run.means.p_tp_pa * AREA - run.means.f_applied_n) for run in runs]
    half_bands = np.reshape(lost, (3, len(BARS), 2)).mean(axis=(0, 2))
    scatter = next(gap.scatter for gap in of_two_seals.where if gap.name == "force_band")
    (effect,), band = of_two_seals.effects, of_two_seals.gap_heldout.balances["force_band"]
    for gap, degree in ((effect.gap_before, 0), (effect.gap_after, 1)):
        errors = []
        for i, bar in enumerate(bars):
            line = np.polyfit(np.delete(bars, i), np.delete(half_bands, i), degree)
            errors.append((np.polyval(line, bar) - half_bands[i]) / scatter)
        assert gap == pytest.approx(np.sqrt(1 - 1 / 3 + np.mean(np.square(errors))), rel=0.05)
    assert (effect.gap_before, effect.gap_after) == (band.refitted, band.after)


def test_the_force_error_at_each_load_is_that_of_a_line_through_the_other_loads(of_two_seals):
    runs, bars = strokes(saturating(120, 120)), np.array(BARS)
    lost = [abs(run.means.p_tp_pa * AREA - run.means.f_applied_n) for run in runs]
    half_bands = np.reshape(lost, (3, len(BARS), 2)).mean(axis=(0, 2))
    assert [load.load_n for load in of_two_seals.held_out_loads] == pytest.approx(
        bars * 1e5 * AREA, rel=0.01
    )
    for i, load in enumerate(of_two_seals.held_out_loads):
        for error, degree in ((load.refitted, 0), (load.after, 1)):
            line = np.polyfit(np.delete(bars, i), np.delete(half_bands, i), degree)
            # The mean of both directions has the scatter of the trials in addition, below 0.5 N.
            assert error == pytest.approx(abs(np.polyval(line, bars[i]) - half_bands[i]), abs=0.5)
        assert load.also == {}


def test_the_friction_of_seals_at_the_load_in_the_middle_is_its_coefficient_times_the_pressure(
    of_two_seals,
):
    """30 bar of 10 to 60: k P, about the hidden seals' own 120 P / (P + 120)."""
    point, (effect,) = of_two_seals.working_point, of_two_seals.practice
    assert point.p_tp_pa == pytest.approx(30e5)
    changes = {one.quantity: one for one in effect.changes}
    k = of_two_seals.effects[0].parameters["test_piston"]
    band = changes["force_band"]
    assert band.at_point == pytest.approx(30 * k.value, rel=0.02)
    assert band.at_point == pytest.approx(120 * 30 / 150, rel=0.25)
    assert band.ci95[0] < band.at_point < band.ci95[1]
    assert band.largest <= 60 * k.value * 1.02


def test_constant_friction_of_another_size_is_no_effect():
    found = diagnosed(one=strokes(lambda bar: 55.0))
    assert found.verdict == "none"
    assert not found.effects and not found.alternatives
    assert found.refitted["friction.test.coulomb"].value == pytest.approx(55 / 40, rel=0.02)


def test_a_load_cell_that_shows_too_much_is_not_taken_for_friction():
    found = diagnosed(one=strokes(lambda bar: 42.0, gain=1.02))
    (effect,) = found.effects
    assert effect.name == "load_cell_gain"
    assert effect.parameters["error"].value == pytest.approx(2.0, rel=0.05)
    assert GAIN_NOTE in found.notes


@pytest.mark.parametrize("gain", [1.02, 1.06])
def test_a_middle_that_changes_within_the_stroke_is_no_gain(gain):
    """A gain is the same along a stroke at constant pressure, so its mean proves nothing."""
    tilted = diagnosed(one=strokes(lambda bar: 42.0, gain=gain, tilt=0.8 * (gain - 1)))
    assert not tilted.effects and not tilted.alternatives
    assert tilted.verdict == "unknown" and [gap.name for gap in tilted.rest] == ["force_middle"]
    assert "within a stroke" in tilted.ruled_out["load_cell_gain"]
    level = diagnosed(one=strokes(lambda bar: 42.0, gain=gain, tilt=0.2 * (gain - 1)))
    assert [effect.name for effect in level.effects] == ["load_cell_gain"]


@pytest.mark.parametrize("guess", ["0.2 N", "1 N", "2 kN"])
def test_the_first_guess_of_friction_has_no_influence(of_two_seals, guess):
    """The reference's is 40 N."""
    friction = {**MODEL["friction"]["test"], "coulomb": guess, "stiction": guess}
    of_guess, reference = two_seals({**MODEL, "friction": {"test": friction}}), of_two_seals
    assert of_guess.verdict == "named"
    (effect,), (expected,) = of_guess.effects, reference.effects
    assert effect.name == "seal_pressure_friction"
    for key, parameter in effect.parameters.items():
        assert parameter.value == pytest.approx(expected.parameters[key].value, rel=1e-4, abs=1e-12)
    revised, before = (d.revised["friction"]["test"]["coulomb"] for d in (of_guess, reference))
    assert to_si(revised, "N") == pytest.approx(to_si(before, "N"), rel=1e-4)


@pytest.mark.parametrize(
    ("lacking", "pattern"),
    [
        ({"bars": (10,)}, r"at least 4 loads.* have 1$"),
        ({"trials": 1}, r"at least 4 loads.* have 0$"),
        ({"ways": (1,)}, re.escape(MISSING["directions"])),
    ],
)
def test_too_few_strokes_get_what_is_missing(lacking, pattern):
    found = diagnosed(one=strokes(saturating(120, 120), **lacking))
    assert found.verdict == "unknown" and not found.effects
    assert any(re.match(pattern, text) for text in found.missing)


def test_areas_on_which_a_pressure_acts_are_those_of_the_campaign():
    thicker = {**MODEL, "test_cylinder": {"piston_diameter": "40 mm", "rod_diameter": "20 mm"}}
    assert diagnosed(thicker, one=strokes(saturating(120, 120))).verdict != "unknown"  # 0 bar
    under_pressure = [
        replace(each, means=replace(each.means, p_tr_pa=1e5))
        for each in strokes(saturating(120, 120))
    ]
    with pytest.raises(ConfigError, match=r"rod-side area of 9\.425 cm\^2, .* 12\.57") as caught:
        diagnosed(thicker, one=under_pressure)
    assert "test_cylinder.rod_diameter" in caught.value.hint
    other = {**MODEL, "test_cylinder": {"piston_diameter": "50 mm"}}
    with pytest.raises(ConfigError, match=r"piston area of 19\.63 cm\^2, .* 12\.57"):
        diagnosed(other, one=strokes(saturating(120, 120)))


def test_strokes_of_one_trial_are_its_repeats_until_a_second_trial_is_there():
    """Five strokes each way in one file are five pairs; with a second file each file is one."""
    one = [stroke for seed in range(5) for stroke in strokes(lambda bar: 50, trials=1, seed=seed)]
    assert len(stroke_pairs(one)) == 5 * len(BARS)
    assert len(stroke_pairs([*one, *strokes(lambda bar: 50, trials=2)])) == 2 * len(BARS)
