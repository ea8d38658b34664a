"""The paragraph for the engineer: every verdict, in the units of the bench."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from hbench.reconcile.diagnosis_fields import insufficient_data_diagnosis
from hbench.records import (
    AddedEffect,
    BeforeAfter,
    Candidate,
    Change,
    DetectableSize,
    EffectInPractice,
    FitParameter,
    Gap,
    GapTable,
    HeldOutLoad,
    Lookalike,
    Provenance,
    Region,
    Rival,
    Separability,
    UnnamedLaw,
    WorkingPoint,
)
from hbench.records.diagnosis import FITTED
from hbench.report.diagnosis.coefficient_words import coefficients_words
from hbench.report.diagnosis.figures.law_figures import law_figure
from hbench.report.diagnosis.law_words import law_title
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.revised_yaml import revised_yaml
from hbench.report.diagnosis.summary import answers, short_summary
from hbench.report.diagnosis.tables.change_tables import changes_tables
from hbench.report.diagnosis.tables.gap_tables import loads_table
from hbench.report.diagnosis.tables.separability_tables import lookalikes_tables
from hbench.report.diagnosis.text import diagnosis_text
from hbench.report.diagnosis.verdict import verdict_words
from tests.support.report.spaces import ordinary_spaces

NAN = float("nan")
POINT = WorkingPoint(
    "extend", 12, 0.08, 0.2, 2490.0, 63e5, 52.1e5, 40e5, 15e5, 150e5, 1.0, 0.5, -1.0,
    {"flow_tp": 1e-6, "force_test": 38.4},
)  # fmt: skip
LEAK = EffectInPractice(
    "internal_leakage",
    (
        Change("flow_tp", "l/min", -0.18, (-0.19, -0.17), 0.21, 0.35),
        Change("flow_tr", "l/min", 0.18, (0.17, 0.19), 0.21, 0.35),
        Change("speed", "mm/s", -2.4, (-2.5, -2.3), 2.8, 4.6),
        Change("force_load", "N", 1e-4, None, 5.0, 9.0),
    ),
    "the piston seal",
    "Replace it.",
    (Lookalike("external_leakage", "hold", "pressures meet, or each falls to zero"),),
)
CELL = EffectInPractice(
    "load_cell_gain",
    (
        Change("f_applied", "N", 49.8, None, 60.0, 100.0),
        Change("force_test", "N", -49.8, None, 60.0, 100.0),
    ),
    "known weights",
    "Calibrate it.",
    (),
)


def summary(diagnosis):
    """Return all answers as one text."""
    return " ".join(text for _, text in answers(diagnosis))


@pytest.fixture
def few():
    about = Provenance("made", "simulated", "bench", "sim", "2026-01-01T00:00:00", "")
    task = SimpleNamespace(provenance=about, model="model.yaml", plant_data={})
    return insufficient_data_diagnosis(task, ("a second load",), ())


@pytest.fixture
def compared(few):
    """A diagnosis with gaps, candidates and a working point, and nothing named."""
    gap = BeforeAfter(12.0, 9.5, 9.5, 1.2)
    table = GapTable(gap, {"flow_tp": gap}, {}, {})
    where = (
        Gap("force_test", 5.5, 5.4, 0.01, 7.3, 580, 40.0, 12.0, 113.0),
        Gap("flow_tp", 1.1, 0.5, 0.5, 1e-7, 580, 1e-7, 4e-7, 1e-6),
    )
    ranking = (
        Candidate("load_friction", 27.3, 0.8, 0.22, {}, "full", 5.0),
        Candidate("position_friction", 4.0, 0.1, 1.0, {}, "full", 5.0),
    )
    regions = tuple(
        Region("direction", label, NAN, NAN, 200, {"force_test": value})
        for label, value in (("extend", 2.0), ("retract", 9.0))
    ) + (
        Region("speed_m_s", "", 0.01, 0.05, 100, {"force_test": 5.0}),
        Region("speed_m_s", "", 0.05, 0.2, 100, {"force_test": 5.5}),
    )
    return replace(
        few, where=where, rest=where[:1], ranking=ranking, gap_heldout=table, regions=regions,
        working_point=POINT, missing=(), next_experiment=None, heldout_runs=("3", "8"),
    )  # fmt: skip


def added(name, margin, of_sensor=False):
    parameters = {"test": FitParameter(0.003, 1e-4, (0.0028, 0.0032), None, "l/min/bar")}
    rival = None if margin is None else Rival("external_leakage", margin)
    return AddedEffect(name, "oil leaks", parameters, of_sensor, 16.7, 1.6, 140.0, rival)


@pytest.fixture
def named(compared):
    return replace(
        compared, verdict="named", effects=(added("internal_leakage", 119.0),), rest=(),
        practice=(LEAK,),
    )  # fmt: skip


def test_a_named_effect_what_how_large_where_what_for_how_sure_and_what_to_do(named):
    text = summary(named)
    verdict = verdict_words(named)
    assert verdict.startswith(
        "The model does not contain internal leakage: oil leaks (test cylinder 0.00300 ± 0.00020 "
        "l/min/bar; 95 % intervals). It changes the flow"
    )
    assert "oil leaks" not in text  # once on the page is enough
    assert "deviation in the quantities that it touches falls from 16.7 to 1.60 times" in verdict
    assert text.startswith(
        "At the median working point (extending at 80 mm/s, load cell 2490 N, piston side "
        "P_Tp 63 bar, rod side P_Tr 52.1 bar, supply P_S 150 bar), 0.180 ± 0.010 l/min less oil "
        "enters the piston side of the test cylinder (Tp) and the piston is 2.40 ± 0.10 mm/s "
        "slower at the same commands. "
    )
    order = (
        "0.21 l/min (root mean square; up to 0.35 l/min)",
        "2.8 mm/s (root mean square; up to 4.6 mm/s)",
        "external leakage, by odds of more than 1000 to 1",
        "Inspect the piston seal. Replace it.",
    )
    places = [text.index(part) for part in order]
    assert places == sorted(places)
    assert "friction of the load cylinder" not in text.partition("Over all runs")[0]  # 1e-4 N


def test_odds_are_those_of_the_held_out_likelihood_and_not_overdone(named):
    for nats, says in ((0.7, "2.0 to 1"), (3.0, "20 to 1"), (8.0, "more than 1000 to 1")):
        text = summary(replace(named, effects=(added("internal_leakage", nats),)))
        assert f"by odds of {says}." in text
    alone = summary(replace(named, effects=(added("internal_leakage", None),)))
    assert "No other effect of the catalogue that is possible here explains these" in alone


def test_a_candidate_that_other_data_rule_out_has_the_reason_with_the_evidence(named):
    """Its bar in the figure of the candidates may be as long as that of the named effect."""
    ruled_out = replace(named, not_tried={"load_friction": "it differs between the series"})
    words = "Load friction would explain 80 % of the gap too, but is ruled out: it differs between"
    assert words in summary(ruled_out)
    assert "ruled out" not in summary(replace(named, not_tried={}))


def test_an_effect_that_does_not_reduce_the_gap_of_held_out_runs_is_reported_as_such(named):
    (effect,) = named.effects
    plain = "It does not reduce the gap of held-out runs in the balances that it touches: "
    worse = replace(named, effects=(replace(effect, gap_before=1.02, gap_after=1.04),))
    assert f"{plain}1.02 without it and 1.04 with it" in short_summary(worse)
    page = ordinary_spaces(diagnosis_page(worse, ()))
    assert f"{plain}1.02" in page[: page.index("<nav")]  # in the verdict
    assert "does not reduce" not in summary(named) + diagnosis_page(named, ())


def test_an_effect_that_held_out_runs_do_not_confirm_is_repeated_before_parts_are_replaced(named):
    """Its odds are those of the runs of the fit, and nothing states that it is present."""
    (effect,) = named.effects
    unconfirmed = replace(effect, gap_before=1.02, gap_after=1.04)
    worse = replace(named, effects=(unconfirmed,))
    verdict = ordinary_spaces(verdict_words(worse))
    assert "So model.yaml does not contain it." in verdict
    page = ordinary_spaces(diagnosis_page(worse, ()))
    assert "It does not contain internal leakage." in page and "with the effects" not in page
    assert "# Not in this model: internal_leakage (test" in revised_yaml(worse)
    assert "Not in this model" not in revised_yaml(named)
    order = (
        "Internal leakage may be missing in the model: oil leaks (test cylinder 0.00300 ± 0.00020",
        "It would change the flow",
        "The evidence is contradictory. In the runs of the fit, the cross-validation favours it",
        "by odds of more than 1000 to 1; held-out runs do not confirm it.",
        "1.02 without it and 1.04 with it",
        "To confirm internal leakage, repeat the runs and reconcile again; replace or adjust",
    )
    places = [verdict.index(part) for part in order]
    assert places == sorted(places) and "inspect" not in verdict
    assert "held-out runs do not confirm it." in short_summary(worse)
    for text in (summary(worse), short_summary(worse)):
        condition = "The sizes that follow apply only if internal leakage is present."
        assert text.index(condition) < text.index("0.180 ± 0.010 l/min less oil")
        first, _, then = text.partition("To confirm internal leakage, repeat the runs")
        assert "nspect" not in first and "Replace it" not in first
        assert "before that. If they confirm it: inspect the piston seal. Replace it." in then
    assert "not confirmed by held-out runs." in diagnosis_text(worse).splitlines()[0]
    proposed = replace(worse, next_schedule={"name": "next"})
    assert "To confirm internal leakage, measure next.yaml and" in verdict_words(proposed)
    cell = replace(unconfirmed, name="load_cell_gain", of_sensor=True)
    both = replace(named, effects=(effect, cell), practice=(LEAK, CELL))
    words = "Next, inspect the piston seal. To confirm load cell gain, repeat the runs"
    assert words in verdict_words(both) and "The instruments may have an error" in verdict_words(
        both
    )
    assert "confirm" not in verdict_words(named) + summary(named) + diagnosis_text(named)


def test_an_error_of_a_sensor_is_told_as_one_with_what_it_shows_too_much(named):
    effects = (added("load_cell_gain", 40.0, of_sensor=True),)
    text = summary(replace(named, effects=effects, practice=(CELL,)))
    assert "gain is an effect of the bench" not in text
    assert "the load cell shows 49.8 N too much" in text
    assert "the computed friction of the test cylinder is 49.8 N too low" in text


def test_an_effect_of_changes_alone_changes_nothing_in_steady_motion(named):
    only = replace(LEAK, changes=(Change("force_test", "N", 0.0, None, 20.0, 60.0),))
    text = summary(replace(named, practice=(only,)))
    assert "), it changes nothing: it acts only while speed or pressure changes" in text
    assert "the friction of the test cylinder by 20 N (root mean square; up to 60 N)" in text


def test_the_verdict_of_a_named_effect_has_its_largest_changes_and_what_is_left_with_its_cause(
    named, compared
):
    def verdict(diagnosis):
        return ordinary_spaces(verdict_words(diagnosis))

    text = verdict(named)
    order = (
        "The model does not contain internal leakage: oil leaks (",
        "It changes the flow to the piston side of the test cylinder (Tp) by up to 0.35 l/min, "
        "the speed by up to 4.6 mm/s and the friction of the load cylinder by up to 9.0 N (in 95 % "
        "of the motion).",
        "falls from 16.7 to 1.60 times the repeatability of the bench, in runs that were not used",
        "Next, inspect the piston seal.",
    )
    places = [text.index(part) for part in order]
    assert places == sorted(places) and "Not explained" not in text
    (rest,) = compared.rest
    fitted = "Without the effects it is"
    smaller = (replace(rest, deviation=10.0), *compared.where[1:])
    text = verdict(replace(named, rest=(rest,), where=smaller))
    assert "Not explained: the force of the test cylinder deviates by 40 N RMS" in text
    assert f"{fitted} 10 N: the values that are fitted together" in text
    assert fitted not in verdict(replace(named, rest=(rest,)))  # 40 N without them too
    sensor = replace(named, effects=(added("load_cell_gain", 40.0, of_sensor=True),))
    text = verdict(replace(sensor, practice=(CELL,)))
    assert text.startswith("The instruments have an error, load cell gain: oil leaks (test ")
    assert "the computed friction of the test cylinder by up to 100 N" in text


def test_the_verdict_of_an_ambiguous_set_says_what_each_effect_means_for_friction(compared):
    first = Candidate("load_cell_gain", 30.0, 0.9, 1.0, {}, "full", 5.0)
    changes = (
        Change("f_applied", "N", 20.0, None, 20.0, 20.0),
        Change("force_test", "N", -20.0, None, 20.0, 20.0),
    )
    alike = (Lookalike("load_cell_gain", "steady", "weights"),)
    other = EffectInPractice("load_cell_offset", changes, "the zero", "", alike)
    both = replace(
        compared, verdict="ambiguous", rest=(), practice=(CELL, other),
        alternatives=(first, replace(first, name="load_cell_offset", score=29.0)),
    )  # fmt: skip
    text = verdict_words(both)
    assert text.startswith("One of these errors of the instruments is present: load cell gain or")
    assert "The friction of the test cylinder differs by 30 N from case to case." in text
    each = "with load cell gain it is computed 49.8 N too low; with load cell offset it"
    assert each in summary(both) and each not in text  # once on the page
    assert text.endswith("inspect known weights or the zero.")
    swapped = replace(both, alternatives=both.alternatives[::-1])
    assert "Next, measure steady runs, which separate them, or inspect" in verdict_words(swapped)
    bench = replace(both, practice=(LEAK, other), alternatives=(
        replace(first, name="internal_leakage"), both.alternatives[1],
    ))  # fmt: skip
    assert verdict_words(bench).startswith("One of these effects is missing in the model: internal")


@pytest.fixture
def offsets(compared):
    """An offset of the load cell or of two transducers: zeros show which."""
    first = Candidate("load_cell_offset", 54.0, 0.7, 5.0, {}, "full", 5.0)
    cell = EffectInPractice(
        "load_cell_offset", (Change("f_applied", "N", -163.0, (-193.0, -133.0), 163.0, 163.0),),
        "the load cell's zero", "", (Lookalike("pressure_offset", "check", "zeros"),),
    )  # fmt: skip
    pressures = EffectInPractice(
        "pressure_offset",
        (
            Change("p_tp", "bar", 1.8, (0.8, 2.8), 1.8, 1.8),
            Change("p_tr", "bar", 2.0, (1.0, 3.0), 2.0, 2.0),
        ),
        "the zeros of the transducers", "", (),
    )  # fmt: skip
    return replace(
        compared, verdict="ambiguous", rest=(), practice=(cell, pressures),
        alternatives=(first, replace(first, name="pressure_offset", score=52.0)),
    )  # fmt: skip


def test_offsets_are_separated_by_a_zero_check_with_what_each_sensor_shows_then(offsets):
    check = (
        "Next step: a zero check with the supply off. Read the load cell's zero and the zeros of "
        "the transducers."
    )
    expected = (
        "Expected readings: with load cell offset, the load cell −163 ± 30 N; "
        "with pressure offset, P_Tp 1.8 ± 1.0 bar and P_Tr 2.0 ± 1.0 bar. The other sensors show "
        "zero within their tolerances"
    )
    for text in (summary(offsets), short_summary(offsets)):
        assert f"{check} {expected}." in ordinary_spaces(text)
    verdict = ordinary_spaces(verdict_words(offsets))
    assert check in verdict and expected not in verdict  # once on the page
    known = replace(offsets, zero_tolerances={"p_tp": 1.2, "p_s": 0.8, "f_applied": 69.3})
    limits = "(±1.2 bar for pressures and ±69 N for the load cell)."
    assert f"{expected} {limits}" in ordinary_spaces(summary(known))
    assert "There is no next.yaml, since a zero check is no run." in summary(offsets)
    planned = replace(offsets, next_schedule={"name": "next"}, next_experiment="Measure it.")
    assert "zero check" not in verdict_words(planned) + summary(planned)


def test_equal_errors_of_several_sensors_may_have_one_cause(offsets):
    assert "one effect with a value for each of the 2 sensors" in summary(offsets)
    assert "They are equal within their intervals, so a common cause" in summary(offsets)
    cell, pressures = offsets.practice
    p_tp, p_tr = pressures.changes
    apart = replace(pressures, changes=(p_tp, replace(p_tr, at_point=5.0, ci95=(4.0, 6.0))))
    text = summary(replace(offsets, practice=(cell, apart)))
    assert "a value for each of the 2 sensors" in text and "common cause" not in text


STROKES = tuple(
    Gap(name, gap, gap, 0.01, 0.2, 40) for name, gap in (("force_band", 3.6), ("force_middle", 9.0))
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
    assert "friction deviates by 3.6 trial scatters (0.72 N) over all runs" in text
    assert (
        "Friction, half the difference of both directions, differs by no more than 0.16 N" in text
    )
    assert "measured correctly" not in text
    assert "Each load in turn, predicted with values that were fitted to the other loads" in page
    assert (
        "Not used for the fit" not in page and "0.16 s" not in page and "oil that flows" not in page
    )
    assert "Tolerances allow" not in page
    verdict = verdict_words(found)
    assert (
        "These runs cannot distinguish the possible causes of a second deviation: direction "
        "asymmetry (mean force of both directions −3.50 N) or load cell gain (mean force of both "
        "directions −3.90 N)."
    ) in ordinary_spaces(verdict)
    assert "Not explained: friction deviates by 3.6 trial scatters (0.72 N)." in verdict
    assert "model as given" not in verdict
    assert verdict.endswith("Next, inspect the seal.")
    tests = "inspect part direction_asymmetry or part load_cell_gain"
    assert tests in text and "the sizes" not in verdict


def test_models_of_strokes_have_their_force_error_at_each_held_out_load(named):
    loads = (
        HeldOutLoad(50.0, 3.0, 4.52, 1.53, {"load_cell_gain": 1.12}),
        HeldOutLoad(149.0, 2.0, 3.60, 2.45, {"load_cell_gain": 0.75}),
    )
    strokes = replace(named, where=STROKES, regions=(), gap_runs=(), held_out_loads=loads)
    table = loads_table(strokes)
    assert table.head[-2:] == ("with the effects", "with the effects and load cell gain")
    assert table.rows[0] == ("50 N", "3.0 N", "4.5 N", "1.5 N", "1.1 N")
    assert "Root mean square force error at each held-out load" in diagnosis_page(strokes, ())
    assert "1.1 N" in diagnosis_text(strokes)
    assert not loads_table(named).rows
    # The root of the mean of 4.52² and 3.60² is 4.1, that of 1.53² and 2.45² is 2.0.
    verdict = ordinary_spaces(verdict_words(strokes))
    assert "outside the fit falls from 4.1 N (2.5 N as given) to 2.0 N RMS." in verdict
    better = tuple(replace(load, before=9.0) for load in loads)
    assert "as given" not in verdict_words(replace(strokes, held_out_loads=better))
    assert "for hbench reconcile." in diagnosis_page(strokes, ())
    assert "for hbench run --plant" in diagnosis_page(named, ())


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


def test_what_the_effects_do_not_explain_is_that_of_the_model_with_them(named, compared):
    part = replace(named, rest=compared.rest)
    text = summary(part)
    words = (
        "With the effects, the force of the test cylinder deviates by 40 N RMS (matters above 12 N)"
    )
    assert f"{words} over all runs." in text
    assert "Balances that the effects do not explain" in diagnosis_page(part, ())
    assert "Balances that the effects do not explain" not in diagnosis_page(named, ())


def test_a_deviation_that_a_correct_model_has_too_is_no_reason_to_distrust_the_model(
    named, compared
):
    """Its values are as uncertain; a part beyond that matters only above the balance's limit."""
    (rest,) = compared.rest  # 1 scatter is 7.3 N, and 12 N matter

    def found(after, floor, **changes):
        gaps = {"force_test": BeforeAfter(12.0, 9.0, after, floor)}
        table = replace(compared.gap_heldout, balances=gaps)
        return replace(named, rest=(replace(rest, **changes),), gap_heldout=table)

    close = found(2.73, 2.43)
    verdict, text = ordinary_spaces(verdict_words(close)), summary(close)
    words = "mostly due to the uncertainty of the model's values: the force of the test cylinder"
    assert f"The remaining deviation is {words} deviates by 40 N RMS" in verdict
    # 7.3 N times the root of 2.73² less 2.43²
    assert "In held-out runs 9.1 N of it is beyond that uncertainty, which is too small" in verdict
    assert "has a gap of 2.73, where a correct model whose values are as uncertain" in text
    assert "That is no evidence of a further cause." in text
    assert "mostly due to the uncertainty" in diagnosis_text(close).splitlines()[0]
    for distrusted in (
        found(4.06, 2.78),  # 22 N
        found(2.48, 1.67, material=99.0),  # most of it is beyond the uncertainty
    ):
        text = summary(distrusted)
        assert "mostly" not in verdict_words(distrusted) + diagnosis_text(distrusted)
        assert "Not explained: the force of the test" in verdict_words(distrusted)
        assert "Do not rely on model.yaml for the force of the test cylinder until" in text
    for text in (verdict, summary(close), diagnosis_text(close)):
        assert "Not explained" not in text and "Do not rely" not in text


def test_a_gap_that_remains_with_the_effects_is_compared_with_that_of_a_correct_model(named):
    def text(after, **changes):
        total = BeforeAfter(12.0, 9.0, after, 1.17)
        table = replace(named.gap_heldout, total=total)
        return summary(replace(named, gap_heldout=table, **changes))

    words = "With the effects, a gap of 2.06 remains in held-out runs, where a correct model would"
    assert words in text(2.06) and "have 1.17 on average. No single balance" in text(2.06)
    assert "remains" not in text(1.2)
    assert "remains" not in text(2.06, rest=named.where[:1])  # it is listed as not explained


def test_an_ambiguous_set_has_a_size_for_each_and_the_run_that_decides(compared):
    first = Candidate("internal_leakage", 30.0, 0.9, 1.0, {}, "full", 5.0)
    second = replace(first, name="external_leakage", score=29.0)
    other = replace(LEAK, name="external_leakage", inspect="the rod seal", lookalikes=())
    both = replace(
        compared, verdict="ambiguous", rest=(), alternatives=(first, second), practice=(LEAK, other)
    )
    text = summary(both)
    page = diagnosis_page(both, ())
    assert (
        'class="verdict">One of these effects is missing in the model: internal leakage or' in page
    )
    assert text.count("would mean that 0.180 ± 0.010 l/min less oil enters the piston side") == 2
    assert "internal leakage 90 %, external leakage 90 %" in text
    assert "(internal leakage 30, external leakage 29 nats) are too close to decide" in text
    assert "Hold runs separate internal leakage and external leakage (pressures meet" in text
    cell = replace(CELL, name="external_leakage", lookalikes=())
    errors = summary(replace(both, practice=(LEAK, cell)))
    assert "external leakage it is computed 49.8 N too low. " in errors
    cases = replace(both, practice=(LEAK, cell))
    assert "friction of the test cylinder differs by 50 N from case to case" in verdict_words(cases)
    assert "The measured friction of the test cylinder is right in each" in verdict_words(both)
    assert "Not explained" not in summary(replace(both, rest=compared.rest))  # the set would do so
    assert "inspect the piston seal or the rod seal." in text
    alike = replace(both, practice=(replace(LEAK, lookalikes=()), other))
    assert "The catalogue contains no run that separates them." in summary(alike)
    planned = replace(both, next_experiment="Measure the hold runs of next.yaml.")
    assert "Measure the hold runs of next.yaml." in summary(planned)


def test_an_unknown_effect_has_its_size_where_it_is_largest_and_how_far_the_best_explains(compared):
    text = summary(compared)
    verdict = "the force of the test cylinder deviates by 40 N RMS (matters above 12 N)."
    assert verdict in ordinary_spaces(diagnosis_page(compared, ()))
    assert "with a correct model, after Holm: 0.010 (force of test cylinder)." in text
    assert "), the refitted model is off by 38 N (force of test cylinder)." in text
    largest = (
        "Over all runs, the force of the test cylinder deviates most while "
        "retracting (9.0 trial scatters there, 2.0 where it is smallest). Next, inspect the seals "
        "and guides of the test cylinder, the load cell and"
    )
    assert largest in ordinary_spaces(verdict_words(compared))  # all speeds are about alike
    assert (
        "Load friction is the closest of the 2 effects that were tried and would explain 80 %"
        in text
    )
    assert "It is not named: its size of 0.22 times a typical one is too small" in text
    assert "Take it as a hint" in text and "chance" not in text
    assert "The gap of 2 held-out runs is 9.50 with the refitted model" in text
    assert "more steady runs where its gap is largest, while retracting, and" in text


def test_each_balance_that_no_effect_explains_has_its_parts_to_inspect(compared):
    first, second = (replace(gap, gap=9.0) for gap in compared.where)
    text = ordinary_spaces(verdict_words(replace(compared, rest=(first, second))))
    assert "Next, inspect the seals and guides of the test cylinder, the load cell and" in text
    assert "For the flow to the test piston side, inspect the test valve" in text
    assert "For the" not in verdict_words(compared)


def test_a_place_is_a_stretch_of_its_axis(compared):
    regions = tuple(
        Region("position_m", "", low, low + 0.1, 99, {"force_test": gap})
        for low, gap in ((0.05, 2.0), (0.2, 8.0))
    )
    text = ordinary_spaces(verdict_words(replace(compared, regions=regions)))
    assert "deviates most at a position of 200 to 300 mm (8.0 trial scatters there" in text


def test_an_effect_that_is_present_but_too_small_to_matter_is_reported_as_such(named):

    def verdict(largest):
        changes = (Change("force_test", "N", 0.0, None, largest, largest),)
        effect = replace(LEAK, changes=changes)
        return ordinary_spaces(verdict_words(replace(named, practice=(effect,))))

    words = "too small to matter (limit for the force of the test cylinder: 12 N)."
    assert f"by up to 4.0 N (in 95 % of the motion). That is {words}" in verdict(4.0)
    nothing = "Nothing needs to be inspected or repaired for an effect of this size"
    assert nothing in verdict(4.0) and "Next, inspect" not in verdict(4.0)
    assert "too small" not in verdict(12.5) and nothing not in verdict(12.5)
    changes = (Change("force_test", "N", 0.0, None, 4.0, 4.0),)
    text = summary(replace(named, practice=(replace(LEAK, changes=changes),)))
    assert nothing in text and "To see its cause, inspect the piston seal." in text


def test_the_law_of_an_effect_is_printed_with_raised_exponents(named):
    law = "dp/dt = R Q_0^2 (Q / Q_0)^n - p"
    lawful = replace(named, effects=(replace(named.effects[0], law=law),))
    page = ordinary_spaces(diagnosis_page(lawful, ()))
    assert "Q<sub>0</sub>² (Q / Q<sub>0</sub>)ⁿ − p." in page


def test_two_effects_that_are_both_present_are_both_inspected(named):
    other = added("tank_back_pressure", 50.0)
    line = replace(LEAK, name="tank_back_pressure", inspect="the return line", lookalikes=())
    both = replace(named, effects=(*named.effects, other), practice=(LEAK, line))
    assert "Next, inspect the piston seal and the return line." in verdict_words(both)


def test_an_unknown_effect_has_the_values_that_the_refit_changes_most(compared):
    """They may be a hint: a value takes up what no effect of the catalogue explains."""
    path = "cylinders.load.dead_volume_rod"
    factor = FitParameter(1.47, 0.1, (1.28, 1.67), None, "1")
    text = summary(replace(compared, refitted={path: factor}))
    assert "Largest factors on values of the model: dead volume, rod side, load" in text
    assert "An implausible one may be a trace of the missing effect." in text
    assert "Largest factors" not in summary(compared)


def test_an_unknown_effect_with_a_learned_law_has_its_size_and_that_it_is_unnamed(compared):
    law = UnnamedLaw(
        "friction_test", ("force_test",), "N", ("position",), ("mm",), ((0.0, 100.0, 200.0),),
        (-2.0, 31.4, 5.0), (-3.0, 30.0, 4.0), (-1.0, 33.0, 6.0), 9.5, 2.1, 40.0, 12.0, 0.001,
    )  # fmt: skip
    says = (
        "The revised model contains an unnamed law, fitted as a table: dry friction of −2.0 to "
        "31 N over position (force of test cylinder; gap of held-out runs 9.5 before, 2.1 after). "
        "A table reproduces a deviation but does not show its cause."
    )
    text = summary(replace(compared, verdict="unknown", unnamed=(law,)))
    assert says in text
    assert "model.yaml reproduces a part of this deviation by its unnamed law" in text
    assert says in short_summary(replace(compared, verdict="unknown", unnamed=(law,)))


def test_a_flow_that_is_wrong_at_one_metering_edge_has_that_edge_inspected_first(compared):
    def of_flow(extending, retracting):
        gaps = {"extend": extending, "retract": retracting}
        regions = tuple(
            Region("direction", way, NAN, NAN, 9, {"flow_tr": gap}) for way, gap in gaps.items()
        )
        gap = replace(compared.where[0], name="flow_tr")
        return verdict_words(replace(compared, where=(gap,), rest=(gap,), regions=regions))

    begin = (
        "Begin with the valve's edge to tank: over all runs the gap is 17.8 there and 8.6 at that"
    )
    assert f"{begin} to supply." in of_flow(
        17.8, 8.6
    )  # while the piston extends, oil leaves the rod side
    assert "Begin with" not in of_flow(8.6, 8.0)


def test_quantities_of_a_learned_law_have_the_symbols_of_its_chamber(compared):
    values = (0.0, 0.1, 0.2, 0.4)
    law = UnnamedLaw(
        "flow_lp", ("flow_lp",), "l/min", ("rod_pressure", "opening"), ("bar", "V"),
        ((40.0, 140.0), (-2.0, 2.0)), values, values, values, 3.0, 1.1, 40.0, 12.0, 0.001,
    )  # fmt: skip
    assert " over rod pressure P_Lr and opening u_L2" in law_title(law)
    (axes,) = law_figure(compared, law).axes
    assert axes.get_xlabel() == "Rod pressure $P_{Lr}$ (bar)"
    assert [text.get_text() for text in axes.get_legend().texts] == [
        "opening $u_{L2}$ = −2 V",
        "opening $u_{L2}$ = 2 V",
    ]


def test_the_curves_of_a_learned_law_all_differ_in_colour_or_marker(compared):
    knots = (-2.0, 2.0), tuple(float(position) for position in range(40, 360, 40))
    values = (0.1,) * 16
    law = UnnamedLaw(
        "flow_tr", ("flow_tr",), "l/min", ("velocity", "position"), ("mm/s", "mm"), knots, values,
        values, values, 3.0, 1.1, 40.0, 12.0, 0.001,
    )  # fmt: skip
    (axes,) = law_figure(compared, law).axes
    looks = {(line.get_color(), line.get_marker()) for line in axes.get_legend().get_lines()}
    assert len(looks) == len(knots[1]) == 8


def test_an_agreement_has_its_bounds_and_nothing_to_repair(compared):
    sizes = tuple(
        DetectableSize(name, "test", smallest, 2.0, "N", "evidence")
        for name, smallest in (("load_friction", 1.0), ("added_mass", 3.0))
    )
    text = summary(
        replace(compared, verdict="none", rest=(), separability=Separability(sizes, ()),
                not_tried={"rest_time": "no breakaway"})
    )  # fmt: skip
    assert "The gap of 2 held-out runs is 9.50 with the refitted model" in text
    assert "A correct model whose values are as uncertain would have 1.20 on average." in text
    assert "would show 1 of 3 known effects at a typical size. They would not show added" in text
    assert "mass and rest time (not tried): these can be present." in text
    assert "38 N (force of test cylinder) and 0.060 l/min (flow to test piston side)" in text
    assert "These runs give no reason to inspect or to repair anything." in text
    assert "too small to matter" not in text  # 40 N matter
    close = replace(compared.where[0], deviation=11.64, material=12.04)
    text = summary(replace(compared, verdict="none", rest=(), where=(close,)))
    assert "the force of the test cylinder by 11.6 N RMS (p = 0.010, matters above 12.0 N)" in text


def test_a_model_that_deviates_from_held_out_runs_is_not_called_an_agreement(compared):
    """Without a missing effect the verdict states the gap, the limits and the scatter beside."""

    def verdict(total, **changes):
        table = GapTable(total, {"force_test": total}, {}, {})
        where = (replace(compared.where[0], **changes),)
        found = replace(compared, verdict="none", rest=(), where=where, gap_heldout=table)
        return ordinary_spaces(verdict_words(found))

    close, off = BeforeAfter(12.0, 1.25, 1.25, 1.2), BeforeAfter(12.0, 1.7, 1.7, 1.2)
    text = verdict(off, gap=1.9, deviation=19.0, p_value=0.008)
    assert "agrees" not in text
    assert "by 1.70 times the repeatability of the bench, a correct one by 1.20 on average" in text
    assert "The force of the test cylinder deviates by 19 N RMS (matters above 12 N; p =" in text
    assert "p = 0.008, 1.90 trial scatters). That is significant and large enough to" in text
    assert "but only more than 2 trial scatters are reported as unexplained: a small" in text
    assert "agrees" not in verdict(close, gap=1.9, deviation=19.0, p_value=0.008)
    text = verdict(close, gap=1.9, deviation=19.0, p_value=0.3)
    assert "agrees" in text and "is not distinguishable from the scatter of the trials" in text
    text = verdict(close, gap=1.1, deviation=9.0, p_value=0.3)
    assert "agrees" in text and "No deviation is large enough to matter; nearest to its" in text


def test_signals_that_the_simulation_does_not_reproduce_are_reported(compared):
    gaps = {"v": 11.6, "u_t": 6.4, "x": 1.9}
    signals = {name: BeforeAfter(9.0, gap, gap, NAN) for name, gap in gaps.items()}
    table = replace(compared.gap_heldout, signals=signals)
    text = summary(replace(compared, verdict="none", rest=(), gap_heldout=table))
    assert "deviate in the velocity by 11.6 and the command of valve T by 6.40 trial" in text
    assert "position by" not in text
    assert "Simulated in closed loop" not in summary(compared)


def test_a_signal_that_deviates_far_more_than_the_balances_is_in_the_verdict(compared):
    def verdict(verdict, gap):
        signals = {"v": BeforeAfter(9.0, gap, gap, NAN), "x": BeforeAfter(9.0, 1.5, 1.5, NAN)}
        balances = {"force_test": BeforeAfter(9.0, 2.1, 2.1, 1.6)}
        table = replace(compared.gap_heldout, signals=signals, balances=balances)
        return verdict_words(replace(compared, verdict=verdict, gap_heldout=table))

    words = "the velocity deviates by 11.7 trial scatters, the balances by no more than 2.10."
    assert words in verdict("unknown", 11.7) and words in verdict("none", 11.7)
    assert "simulation shows more" not in verdict("unknown", 4.0)
    assert "simulation shows more" not in verdict_words(compared)  # nothing was simulated


def test_a_coefficient_of_a_power_law_has_the_value_where_its_unit_holds(named):
    """A leak is a flow there; of other laws the coefficient's unit applies there alone."""
    (effect,) = named.effects
    law = "Q = G p_0 (|P| / p_0)^n, n = exponent, p_0 = 50 bar"
    power = {**effect.parameters, "exponent": FitParameter(0.7, 0.07, (0.56, 0.84), None, "1")}
    curved = replace(effect, law=law, parameters=power)
    assert coefficients_words(curved) == (
        "test cylinder 0.150 ± 0.010 l/min at 50 bar, i.e. 0.00300 l/min/bar; exponent 0.70 ± 0.14"
    )
    share = {"test": FitParameter(0.5, 0.1, (0.3, 0.7), None, "N/bar")}
    seal = replace(effect, law="k P_0 (P / P_0)^n, P_0 = 50 bar", parameters=share)
    assert coefficients_words(seal) == "test cylinder 0.50 ± 0.20 N/bar"
    curved = replace(seal, parameters=share | {"exponent": power["exponent"]})
    assert coefficients_words(curved).startswith("test cylinder 0.50 ± 0.20 N/bar at 50 bar")


def test_the_resistance_of_a_line_is_a_pressure_at_the_flow_of_its_law(named):
    """0.014 bar min²/l² times the square of 10 l/min are 1.4 bar."""
    parameters = {"resistance": FitParameter(0.014, 0.001, (0.012, 0.016), None, "bar min^2/l^2")}
    law = "lag dp/dt = resistance Q_0^2 (Q / Q_0)^n - p, Q_0 = 10 l/min"
    line = replace(named.effects[0], law=law, parameters=parameters)
    words = "resistance 1.40 ± 0.20 bar at 10 l/min, i.e. 0.0140 bar min²/l²"
    assert coefficients_words(line) == words
    found = replace(named, effects=(line,))
    assert words in ordinary_spaces(diagnosis_page(found, ()))
    assert diagnosis_text(found).isascii()


def test_coefficients_that_may_be_0_are_marked(named):
    masses = {
        "test": FitParameter(2.0, 2.5, (-2.9, 6.9), None, "kg"),
        "load": FitParameter(16.2, 2.6, (11.0, 21.4), None, "kg"),
    }
    heavy = replace(named.effects[0], name="added_mass", parameters=masses)
    assert coefficients_words(heavy) == (
        "load cylinder 16.2 ± 5.2 kg; not distinguishable from 0: test cylinder 2.0 ± 4.9 kg"
    )
    page = ordinary_spaces(diagnosis_page(replace(named, effects=(heavy,)), ()))
    assert "2.0 ± 4.9 kg (not distinguishable from 0)" in page
    assert "5.2 kg (not" not in page


def test_the_cylinder_that_leaks_is_the_one_that_is_inspected(named):
    """The catalogue has one text for both; the coefficients state which."""
    leak = FitParameter(0.006, 1e-4, (0.0058, 0.0062), None, "l/min/bar")
    none = FitParameter(0.0, 1e-6, (0.0, 1e-5), "lower", "l/min/bar")
    seal = replace(LEAK, inspect="the piston seal of each leaking cylinder")

    def advice(**parameters):
        effect = replace(named.effects[0], parameters=parameters)
        found = replace(named, effects=(effect,), practice=(seal,))
        words = verdict_words(found).rpartition("Next, inspect ")[2]
        assert words in summary(found).replace("Inspect ", "")
        return words

    assert advice(test=none, load=leak) == "the piston seal of the load cylinder."
    assert advice(test=leak, load=none) == "the piston seal of the test cylinder."
    assert advice(test=leak, load=leak) == "the piston seal of each cylinder."
    assert advice(exponent=replace(leak, unit="1")) == "the piston seal of each leaking cylinder."
    other = replace(LEAK, name="tank_back_pressure", lookalikes=())
    effects = (replace(named.effects[0], parameters={"test": none, "load": leak}),
               added("tank_back_pressure", 50.0))  # fmt: skip
    both = replace(named, effects=effects, practice=(seal, other))
    assert "internal leakage: oil leaks (load cylinder). It changes" in verdict_words(both)


def test_a_change_of_exactly_0_has_no_interval(named):
    still = Change("flow_lr", "l/min", 0.0, (0.0, 0.0), 0.1, 0.2)
    (table,) = changes_tables(replace(named, practice=(replace(LEAK, changes=(still,)),)))
    assert table.rows[0][1] == "0 l/min"


def test_an_agreement_states_what_the_refit_changes_and_what_is_fitted_with_the_model(compared):
    def factor(value, low, high):
        return FitParameter(value, 0.01, (low, high), None, "1")

    refitted = {
        "valve.gain": factor(0.95, 0.94, 0.96),
        "supply.tank": factor(1.7, 1.4, 2.0),
        "moving_mass.test": factor(1.2, 0.8, 1.6),  # not known to differ from 1
        "oil.bulk_modulus": factor(1.04, 1.03, 1.05),
        "friction.test.coulomb": factor(0.5, 0.4, 0.6),
    }
    sizes = (DetectableSize("load_friction", "test", 1.0, 2.0, "N", "evidence"),)
    text = summary(
        replace(compared, verdict="none", rest=(), refitted=refitted,
                separability=Separability(sizes, ()), not_tried={"valve_trim": FITTED})
    )  # fmt: skip
    assert (
        "Largest factors on values of the model: Coulomb friction, test cylinder 0.50 ± 0.10; "
        "tank pressure 1.70 ± 0.30; valve gain 0.950 ± 0.010." in text
    )
    assert "would show 1 of 1 known effects at a typical size. Valve trim is fitted with" in text
    refused = replace(compared, verdict="none", rest=(), refitted=refitted, refit_refused="No.")
    assert "Largest factors" not in summary(refused)


def test_too_few_data_say_what_is_missing_and_that_the_size_is_not_known(few):
    text = summary(few)
    assert "do not suffice to find a missing effect. Missing: a second load." in diagnosis_page(
        few, ()
    )
    assert few.next_experiment in text
    assert short_summary(few) in diagnosis_text(few)


def test_two_effects_share_one_description_of_the_working_point(named):
    second = added("load_cell_gain", 9.0, of_sensor=True)
    text = summary(replace(named, effects=(*named.effects, second), practice=(LEAK, CELL)))
    assert text.count("extending at 80 mm/s") == 1
    assert "Coefficients with 95 % intervals: test cylinder 0.00300" in text
    assert "There the load cell shows 49.8 N too much" in text
    both = replace(named, effects=(*named.effects, second), practice=(LEAK, CELL))
    verdict = ordinary_spaces(verdict_words(both))
    assert "0.00300" not in verdict  # brief: the coefficients are below
    assert verdict.count("in runs that were not used for the fit") == 1
    assert (
        "With both effects, the model's deviation in all quantities falls from 9.50 to" in verdict
    )


def test_the_terminal_begins_with_the_verdict_and_the_paragraph_in_short(named):
    first, second, *_ = diagnosis_text(named).splitlines()
    assert first.startswith("named: internal_leakage (test cylinder ")
    assert second.startswith("At the median working point (extending at 80 mm/s, load cell ")
    assert "0.180 +- 0.010 l/min less oil" in second and "Inspect the piston seal." in second
    assert "root mean square" not in second and len(second) < len(summary(named))


def test_the_page_has_the_paragraph_before_the_gap_and_the_method_last(named):
    page = diagnosis_page(named, ())
    places = [
        page.index(part)
        for part in (
            "The model does not contain internal leakage",
            "At the median working point",
            '<h2 id="the-gap-before-and-after">',
            '<h2 id="the-effects">',
            "What internal leakage changes",
            "What looks like internal leakage",
            '<h2 id="where-the-model-disagrees">',
            '<h2 id="which-effect">',
        )
    ]
    assert places == sorted(places)


def test_the_page_of_every_verdict_has_the_reason(compared, named):
    for each in (compared, named, replace(compared, verdict="none", rest=())):
        assert "Made up." in diagnosis_page(replace(each, why="Made up."), ())


def test_tables_have_every_change_with_its_unit_and_every_look_alike(named):
    (changes,), (alike,) = changes_tables(named), lookalikes_tables(named)
    assert changes.title == "What internal leakage changes" and len(changes.rows) == 4
    assert changes.rows[0] == (
        "flow to test piston side", "−0.180 ± 0.010 l/min", "0.21 l/min", "0.35 l/min",
    )  # fmt: skip
    assert alike.rows == (("external_leakage", "hold", LEAK.lookalikes[0].why),)
