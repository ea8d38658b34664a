"""The verdict and the answers of steady strokes."""

import re
from dataclasses import replace

import pytest

from hbench.records import (
    BeforeAfter,
    Candidate,
    Change,
    EffectInPractice,
    Gap,
    GapTable,
    HeldOutLoad,
)
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.tables.effect_tables import effects_table
from hbench.report.diagnosis.tables.gap_tables import loads_table, where_table
from hbench.report.diagnosis.terminal import diagnosis_text
from hbench.report.diagnosis.text import gap_line
from hbench.report.diagnosis.verdict import verdict_words
from tests.support.report.spaces import ordinary_spaces
from tests.support.report.summarised import summary

STROKES = tuple(
    Gap(name, gap, 0.01, 0.2, 40) for name, gap in (("force_band", 3.6), ("force_middle", 9.0))
)


def test_strokes_have_words_of_their_own_and_gaps_of_loads_outside_the_fit(named):
    """Their balances are half the difference and the mean of both directions, in N by a scatter."""
    sizes = {"direction_asymmetry": (0.02, -3.5), "load_cell_gain": (0.18, -3.9)}
    practice = tuple(
        EffectInPractice(
            name,
            (
                Change("force_band", "N", band, None, band, band),
                Change("force_middle", "N", middle, None, abs(middle), abs(middle)),
            ),
            f"part {name}",
            "",
            (),
        )
        for name, (band, middle) in sizes.items()
    )
    seal = EffectInPractice(
        "internal_leakage", (Change("force_band", "N", 7.8, None, 7.1, 10.0),), "the seal", "", ()
    )
    alternatives = tuple(Candidate(name, 12.0, 0.9, 1.0, {}, "full", 4.3) for name in sizes)
    found = replace(
        named, where=STROKES, rest=STROKES[:1], alternatives=alternatives,
        practice=(seal, *practice), regions=(), gap_runs=(),
    )  # fmt: skip
    page = ordinary_spaces(diagnosis_page(found, ()))
    text = summary(found)
    assert "friction deviates by 0.72 N (repeated trials scatter by 0.20 N) over all runs" in text
    assert "Friction differs by no more than 0.16 N from case to case at the working" in text
    assert "measured correctly" not in text
    assert "Each load in turn, predicted with values that were fitted to the other loads" in page
    assert "Not used for the fit" not in page and "0.16 s" not in page and "continuity" not in page
    assert "Tolerances allow" not in page
    verdict = verdict_words(found)
    assert (
        "At the working point (extending at 80 mm/s), friction is 7.8 N higher in both directions. "
        "A second deviation may be due to direction asymmetry (mean force of both directions "
        "−3.5 N) or load cell gain (−3.9 N)."
    ) in ordinary_spaces(verdict)
    assert "scatter" not in verdict  # of trials: the answers have what is not explained
    assert verdict.endswith("Next, inspect the seal.")
    tests = "inspect part direction_asymmetry or part load_cell_gain"
    assert tests in text and "the sizes" not in verdict


@pytest.mark.usefixtures("wide_terminal")
def test_models_of_strokes_have_their_force_error_at_each_held_out_load(named):
    loads = (
        HeldOutLoad(50.0, 3.0, 4.52, 1.53, {"load_cell_gain": 1.12}, {"force_middle": 0.02}),
        HeldOutLoad(149.0, 2.0, 3.60, 2.45, {"load_cell_gain": 0.75}, {"force_middle": 0.0066}),
    )
    strokes = replace(named, where=STROKES, regions=(), gap_runs=(), held_out_loads=loads)
    table = loads_table(strokes)
    assert table.head[-2:] == ("with the effects", "with the effects and load cell gain")
    assert table.rows[0] == ("50 N", "3.0 N", "4.5 N", "1.5 N", "1.1 N")
    assert "Root mean square force error at each load outside the fit" in diagnosis_page(
        strokes, ()
    )
    assert "1.1 N" in diagnosis_text(strokes)
    assert not loads_table(named).rows
    # The root of the mean of 4.52² and 3.60² is 4.1, that of 1.53² and 2.45² is 2.0.
    verdict = ordinary_spaces(verdict_words(strokes))
    assert "at loads outside the fit is 2.0 N RMS, without it 2.5 N." in verdict
    line = (
        "Force error at loads outside the fit, root mean square: 2.5 N as given, 4.1 N refitted, "
        "2.0 N with the effects, 0.95 N with the effects and load cell gain."
    )
    assert gap_line(strokes) == line and "trial scatters" not in line
    page = ordinary_spaces(diagnosis_page(strokes, ()))
    assert line in page and '<h2 id="force-error-before-and-after">' in page
    assert "At 149 N the mean force of both directions repeats within 0.0066 N, so that" in page
    better = tuple(replace(load, before=9.0) for load in loads)
    lead = ordinary_spaces(verdict_words(replace(strokes, held_out_loads=better)))
    assert "is 2.0 N RMS, without it 4.1 N." in lead
    head = effects_table(strokes).head
    assert "gap without it" not in head and "gap without it" in effects_table(named).head
    assert "gap, all runs" not in where_table(strokes).head
    assert "gap, all runs" in where_table(named).head
    assert "for hbench reconcile." in diagnosis_page(strokes, ())
    assert "for hbench run --plant" in re.sub("<.*?>", "", diagnosis_page(named, ()))


def test_a_refit_to_strokes_that_is_worse_at_other_loads_is_reported_with_why_it_is_kept(named):
    band = BeforeAfter(35.9, 58.3, 14.0, 2.6)
    strokes = replace(named, where=STROKES, regions=(), gap_runs=())
    effect = replace(strokes.effects[0], gap_before=58.3, gap_after=14.0)
    strokes = replace(strokes, effects=(effect,))
    worse = replace(strokes, gap_heldout=GapTable(band, {"force_band": band}, {}, {}))
    better = replace(
        worse, gap_heldout=GapTable(band, {"force_band": replace(band, before=84.0)}, {}, {})
    )
    words = "in the gaps of friction (35.9 to 58.3). The refit is kept, since"
    assert f"The refitted model is worse than the model as given {words}" in summary(worse)
    assert "as given" not in verdict_words(better) + summary(better)
    loads = (HeldOutLoad(50.0, 4.8, 5.9, 3.1, {}, {}),)
    newtons = (
        "At loads outside the fit the force error is 4.8 N as given, 5.9 N refitted. The refit is"
    )
    assert newtons in summary(replace(worse, held_out_loads=loads))
