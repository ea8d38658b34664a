"""The verdict and the answers where no effect is named."""

import html
import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.records import (
    BeforeAfter,
    DetectableSize,
    FitParameter,
    GapTable,
    Overlay,
    Region,
    ResidualMap,
    Separability,
)
from hbench.records.reconcile.diagnosis import FITTED
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.summary import answers
from hbench.report.diagnosis.tables.effect_tables import ranking_table
from hbench.report.diagnosis.tables.gap_tables import where_table
from hbench.report.diagnosis.terminal import diagnosis_text
from hbench.report.diagnosis.verdict import verdict_words
from hbench.report.diagnosis.words.deviation import deviations
from tests.support.reconcile.made_diagnosis import named
from tests.support.report.spaces import ordinary_spaces
from tests.support.report.summarised import NAN, summary

CHANGED_MOST = (
    "Values of the model that the refit changes most for their assumed accuracy, with the factor: "
)


FACTOR = {"valve.gain": FitParameter(0.95, 0.01, (0.94, 0.96), None, "1")}


def test_an_unknown_effect_has_its_size_where_it_is_largest_and_how_far_the_best_explains(compared):
    text = summary(compared)
    verdict = (
        "The force of the test cylinder deviates from the model by 40 N RMS (0.67 % of its range); "
        "no known effect explains this. The deviation is largest while retracting (66 N RMS). "
        "First inspect the seals and guides of the test cylinder. To narrow the cause, measure"
    )
    assert "The flow to the test piston side agrees within the limits that matter." in text
    lead = ordinary_spaces(verdict_words(replace(compared, material=0.002)))
    assert lead.startswith(verdict)
    assert "(matters above 12 N, p = 0.010)" in text
    # The working point is extending, where the deviation is smallest.
    assert "off by 38 N" not in text and "off by 38 N" in summary(replace(compared, regions=()))
    # 9.0 scatters of 7.3 N; all speeds are about alike
    assert "The force of the test cylinder deviates most while retracting (about 66 N RMS)." in text
    assert (
        "Load friction is the closest of the 2 effects that were tried and would explain 80 %"
        in text
    )
    assert "It is not named: its size of 0.22 times a typical one is too small" in text
    assert "Take it as a hint" in text and "chance" not in text
    line = (
        "Gap of runs outside the fit (RMS of measurement less model, in multiples of the "
        "repeatability): 12.0 as given, 9.50 refitted. A correct model with equally"
    )
    assert line in ordinary_spaces(diagnosis_page(compared, ())) and "9.50" not in text
    assert "measure more steady runs while retracting and vary speed, load" in lead


def test_a_deviation_at_rest_is_narrowed_by_holds(compared):
    """A valve that leaks in its null: no speed is varied at rest."""
    regions = tuple(
        Region("direction", way, NAN, NAN, 9, {"force_test": gap})
        for way, gap in (("extend", 2.0), ("rest", 9.0))
    )
    lead = verdict_words(replace(compared, regions=regions))
    assert "The deviation is largest while at rest" in lead
    assert "measure longer holds at rest, at several loads and pressures." in lead
    assert "steady runs" not in lead


def test_the_cause_is_narrowed_where_the_deviation_is_largest_and_else_by_what_is_missing(compared):
    """Missing data may be of another balance."""
    missing = replace(compared, missing=("one load at two pressures",))
    assert "measure more steady runs while retracting" in verdict_words(missing)
    nowhere = replace(missing, regions=())
    assert "To narrow the cause, measure one load at two pressures." in verdict_words(nowhere)


def test_each_balance_that_no_effect_explains_has_its_parts_to_inspect(compared):
    first, second = (replace(gap, gap=9.0) for gap in compared.where)
    both = replace(compared, rest=(first, second))
    text = ordinary_spaces(verdict_words(both))
    assert text.count("First inspect") == 1
    assert "First inspect the seals and guides of the test cylinder" in text
    then = "test cylinder, inspect the load cell and the transducers of P_Tp and P_Tr."
    assert f"{then} For the flow to the test piston side, inspect the test valve" in summary(both)
    assert "For the" not in verdict_words(both) + summary(compared)


def test_each_deviation_that_is_not_explained_has_its_name_and_its_probability(compared):
    first = compared.where[0]
    others = [
        replace(first, name=name, deviation=20.0, p_value=p)
        for name, p in (("force_load", 0.09), ("kinematics", 0.00004), ("supply", 0.05))
    ]
    fifth = replace(first, name="flow_lr")
    found = replace(compared, rest=(first, *others, fifth))
    text = ordinary_spaces(summary(found))
    for p in ("p = 0.010)", "p = 0.090)", "p < 0.0001)", "p = 0.050)"):
        assert text.count(p) == 1
    assert "; also the flow to the load rod side." in text
    lead = ordinary_spaces(verdict_words(found))
    assert (
        "The force of the test cylinder deviates from the model by 40 N RMS and the force of the "
        "load cylinder by 20 N RMS, as do 3 more quantities; no known effect explains this."
    ) in lead
    assert "position against velocity" not in lead  # the row has all
    assert "p = " not in lead and "matters above" not in lead  # that is in the row on residuals


def test_a_deviation_that_the_refit_increases_does_not_say_where_to_look(compared):
    """The force is listed first, but its gap goes from 4.7 as given to 12 by the refit."""
    force, flow = (replace(gap, gap=9.0) for gap in compared.where)
    table = compared.gap_heldout
    worse = {**table.balances, force.name: replace(table.total, before=4.7, refitted=12.0)}
    worse[flow.name] = replace(table.total, before=26.0, refitted=4.0)
    found = replace(
        compared, rest=(force, flow), gap_heldout=replace(table, balances=worse), regions=()
    )
    lead = ordinary_spaces(verdict_words(found))
    assert lead.startswith("The flow to the test piston side deviates from the model by ")
    assert (
        "The refit itself increases the deviation of the force of the test cylinder, which "
        "therefore does not show where the cause is. First inspect the test valve."
    ) in lead
    steady = {**worse, force.name: worse[flow.name]}
    steady = replace(found, gap_heldout=replace(table, balances=steady))
    assert "First inspect the seals and guides" in verdict_words(steady)
    assert "The refit" not in verdict_words(steady)


def test_three_deviations_are_all_in_the_verdict_and_their_common_part_is_inspected(compared):
    names = ("flow_tr", "flow_tp", "supply")
    rest = tuple(replace(compared.where[0], name=name) for name in names)
    found = replace(compared, where=rest, rest=rest, regions=())
    lead = ordinary_spaces(verdict_words(found))
    for words in ("flow to the test rod side", "flow to the test piston side", "supply pressure"):
        assert words in lead
    flows = replace(found, rest=rest[:2])
    lead = ordinary_spaces(verdict_words(flows))
    shared = "The flows to the test rod side and the test piston side deviate from the model by "
    assert re.match(f"{shared}[0-9.]+ and [0-9.]+ l/min RMS; no known effect explains this.", lead)
    both = "The flows to the test rod side and the test piston side deviate, and the test valve is"
    assert both in ordinary_spaces(summary(found))


@pytest.mark.parametrize(
    ("score", "explained", "size", "is_hint"),
    [
        (40.0, 0.6, 0.11, True),  # a tenth of a typical size
        (4.0, 0.6, 0.11, False),  # by chance
        (40.0, 0.1, 0.11, False),  # explains little
        (40.0, 0.6, 0.0, False),  # within the tolerances
    ],
)
def test_an_effect_that_is_too_small_to_be_named_is_a_hint_beside_what_to_inspect(
    compared, score, explained, size, is_hint
):
    air = replace(
        compared.ranking[0], name="entrained_air", score=score, threshold=5.0,
        explained=explained, size=size,
    )  # fmt: skip
    text = summary(replace(compared, ranking=(air,)))
    words = (
        "Too small to be named, entrained air would explain 60 % of the deviation of the "
        "quantities that it changes."
    )
    assert (words in text) is is_hint and ("Too small to be" in text) is is_hint


def test_deviations_barely_above_their_limits_and_their_common_place_are_in_the_verdict(compared):
    first = replace(compared.where[0], deviation=13.0, material=12.0)
    second = replace(first, name="force_load", deviation=14.0)
    places = tuple(
        Region("direction", way, NAN, NAN, 9, {"force_test": gap, "force_load": gap})
        for way, gap in (("extend", 2.0), ("retract", 9.0))
    )
    gaps = (first, second)
    lead = verdict_words(replace(compared, where=gaps, rest=gaps, regions=places))
    assert "That is only about 8 and 20 % above the limits that matter." in lead
    assert "While retracting they deviate by 66 and 66 N RMS." in lead
    barely = (replace(first, deviation=12.06), second)
    lead = verdict_words(replace(compared, where=barely, rest=barely))
    assert "That is at most about 20 % above the limits that matter." in lead
    barely = (barely[0], replace(second, deviation=12.1))
    lead = verdict_words(replace(compared, where=barely, rest=barely))
    assert "That is less than 1 % above the limits that matter." in lead
    far = (first, replace(second, deviation=24.0))
    assert "above the limits" not in verdict_words(replace(compared, where=far, rest=far))


def test_a_significant_deviation_below_its_limit_and_one_within_the_noise_do_not_agree(compared):
    near = replace(
        compared.where[1], name="flow_lp", deviation=0.95e-6, material=1e-6, p_value=0.028
    )
    noise = replace(near, name="kinematics", deviation=0.0, p_value=0.4)
    gap = BeforeAfter(3.0, 5.01, 5.01, 3.5)
    table = replace(compared.gap_heldout, balances={"flow_lp": gap})
    where = (compared.where[0], near, noise)
    text = summary(replace(compared, where=where, gap_heldout=table))
    assert "The flow to the load piston side deviates significantly, but just below its" in text
    assert "In runs outside the fit its gap is 5.01;" in text
    assert "No deviation of position against velocity is distinguishable from noise." in text
    assert "agree" not in text
    assert "but just below its limit" in summary(replace(compared, where=where))
    sure = replace(near, p_value=0.3)
    text = summary(replace(compared, where=(*where[:1], sure), gap_heldout=table))
    assert "The flow to the load piston side agrees within the limits that matter." in text


def test_a_size_far_below_a_typical_one_is_not_written_as_zero(compared):
    small = replace(compared.ranking[0], score=1.1, explained=1.0, size=0.0004)
    (row,) = ranking_table(replace(compared, ranking=(small,))).rows
    assert "< 0.01 × typical" in row


def test_a_candidate_that_could_be_named_but_for_a_better_one_has_the_lower_score():
    found = named()
    best = replace(found.ranking[0], name=found.effects[0].name, score=184.2, threshold=5.0)
    best = replace(best, explained=1.0, size=0.95)
    second = replace(best, name="valve lag", score=13.8, explained=0.27, size=1.38)
    table = ranking_table(replace(found, ranking=(best, second)))
    why = table.head.index("why not named")
    assert [row[why] for row in table.rows] == ["–", "lower score"]


def test_a_deviation_above_its_limit_that_may_be_chance_is_not_left_out(compared):
    """The row on the residuals names every quantity."""
    chance = replace(compared.where[0], name="force_load", deviation=15.0, p_value=0.133)
    text = summary(replace(compared, where=(compared.where[0], chance)))
    words = "The force of the load cylinder deviates by 15 N RMS (matters above 12 N, p = 0.13)"
    assert f"{words}; this may be chance." in ordinary_spaces(text)
    sure = replace(chance, p_value=0.01)
    assert "chance" not in summary(replace(compared, where=(compared.where[0], sure)))


def test_a_share_that_suffices_and_a_score_that_does_not_are_explained_once(compared):
    weak = replace(compared.ranking[0], score=9.5, threshold=11.3, explained=0.35, size=1.0)
    why = "No effect explains the gaps. The best candidate, load_friction, explains 35 % (25 %)."
    text = summary(replace(compared, ranking=(weak,), why=why))
    page = diagnosis_page(replace(compared, ranking=(weak,), why=why), ())
    assert "The best candidate" not in page + text and "No effect explains the gaps." in page
    assert "35 % of the gap in the quantities that it changes; that share is large enough" in text
    assert "that chance is ruled out (score 9.5 nats, 11.3 needed)" in text
    refined = replace(weak, score=20.0)  # it meets each criterion of the search
    reason = {"load_friction": "it leaves most of the gap of runs outside the fit"}
    text = summary(replace(compared, ranking=(refined,), ruled_out=reason))
    assert f"It is not named: refined with the model's values, {reason['load_friction']}." in text
    for verdict in ("unknown", "none"):
        found = replace(compared, verdict=verdict, ranking=(refined,), ruled_out=reason)
        text = " ".join(ordinary_spaces(diagnosis_text(found)).split())
        assert "Load friction would explain 35 % of the gap, but is ruled out: it leaves" in text


def test_what_several_deviations_have_in_common_is_inspected_first(compared):
    first = compared.where[0]

    def start(*names, residuals=None):
        rest = tuple(replace(first, name=name) for name in names)
        found = replace(
            compared, where=rest, rest=rest, residuals_after=residuals or ResidualMap.empty()
        )
        return ordinary_spaces(f"{verdict_words(found)} {summary(found)}")

    flows = ("flow_tr", "flow_tp", "flow_lp", "flow_lr")
    assert "First inspect the position transducer. To narrow" in start(*flows)
    assert "First inspect the test valve" in start(*flows[:3])
    cell = start("force_load", "force_test", "supply")
    assert "First inspect the load cell." in cell
    assert "The force of the test cylinder and the force of the load cylinder depend on it." in cell
    assert "First inspect the bore and the piston seal of the load" in start("flow_lr", "flow_lp")
    forces = "force_load", "force_test"
    opposite = replace(
        ResidualMap.empty(), names=forces, value=np.array([[-9.0, 9.0], [8.0, -7.0]])
    )
    assert "First inspect the load cell." in start(*forces, residuals=opposite)
    alike = replace(opposite, value=np.abs(opposite.value))  # which no error of a load cell causes
    assert "the load cell." not in start(*forces, residuals=alike)


def test_a_limit_that_two_deviations_share_is_written_once(compared):
    first = compared.where[0]
    second = replace(first, name="force_load", deviation=20.0)
    shared = "40 N RMS and the force of the load cylinder by 20 N RMS (each matters above 12 N)"
    assert deviations([first, second]) == f"the force of the test cylinder deviates by {shared}"
    own = deviations([first, replace(second, material=9.0)])
    assert "40 N RMS (matters above 12 N) and the force" in own and "(matters above 9" in own


def test_a_place_is_a_stretch_of_its_axis(compared):
    regions = tuple(
        Region("position_m", "", low, low + 0.1, 99, {"force_test": gap})
        for low, gap in ((0.05, 2.0), (0.2, 8.0))
    )
    text = ordinary_spaces(summary(replace(compared, regions=regions)))
    assert "deviates most at a position of 200 to 300 mm (about 58 N RMS)." in text
    loads = tuple(replace(each, axis="load_n", gaps={"force_test": 4.0}) for each in regions)
    loads = (loads[0], replace(loads[1], gaps={"force_test": 7.0}))
    both = ordinary_spaces(summary(replace(compared, regions=(*regions, *loads))))
    assert both == text  # the largest alone: the figure has the other


def test_an_unknown_effect_has_the_values_that_the_refit_changes_most(compared):
    """They may be a hint: a value takes up what no effect of the catalogue explains."""
    path = "load_cylinder.dead_volume_rod"
    factor = FitParameter(1.47, 0.1, (1.28, 1.67), None, "1")
    text = summary(replace(compared, refitted={path: factor}, refit_priors={path: 0.3}))
    assert f"{CHANGED_MOST}dead volume, rod side, load" in text
    assert "An implausible one may be a trace of the missing effect." in text
    assert CHANGED_MOST not in summary(compared)


def test_a_dead_volume_far_from_the_models_is_a_hint_where_the_flow_to_its_chamber_deviates(
    compared,
):
    def verdict(value, name="flow_lr", prior=0.3, words=summary, **changes):
        (rest,) = compared.rest
        path = "load_cylinder.dead_volume_rod"
        factors = {path: FitParameter(value, 0.1, None, None, "1")}
        found = replace(
            compared, rest=(replace(rest, name=name),), refitted=factors,
            refit_priors={path: prior}, **changes,
        )  # fmt: skip
        return words(found)

    hint = (
        "A hint: the refit gives a dead volume at the rod side of the load cylinder (Lr) 1.47 times"
    )
    assert f"{hint} that of the model file; compare it with the hoses" in verdict(1.47)
    assert "(Lr) 0.60 times" in verdict(0.6)
    assert hint in ordinary_spaces(verdict(1.47, words=summary))
    for other in (verdict(1.2), verdict(1.47, "flow_lp"), verdict(1.47, refit_refused="No.")):
        assert "A hint" not in other
    # ln 1.2 = 0.18 and ln 1.47 = 0.39: the accuracy is that of the diagnosis.
    assert "A hint" in verdict(1.2, prior=0.1) and "A hint" not in verdict(1.47, prior=0.4)


def test_a_value_that_the_refit_can_not_reach_is_checked_before_anything_is_inspected(compared):
    """A guess of the valves' bandwidth that is five times too small leaves gaps in all flows."""
    path = "valve.bandwidth"
    factor = FitParameter(1.57, 0.3, (0.9, 1.57), "upper", "1")
    far = replace(compared, refitted={path: factor}, refit_priors={path: 0.15})
    assert "First check in the model file: valve bandwidth." in verdict_words(far)
    assert "The refit ends at its bound for valve bandwidth." in summary(far)
    inside = replace(far, refitted={path: replace(factor, at_bound=None)})
    late = replace(far, delays={"commands": FitParameter(5.0, 1.0, (3.0, 7.0), None, "ms")})
    for other in (inside, late, replace(far, refit_refused="No.")):
        assert "First check in the model file" not in verdict_words(other)
        assert "ends at its bound" not in summary(other)


def test_friction_that_the_refit_can_not_reach_is_checked_where_a_force_is_unexplained(compared):
    """A file without the stiffness of the bristles has the default: soft for large seals."""
    path = "friction.test.bristle_stiffness"
    factor = FitParameter(11.0, 3.0, (3.3, 11.0), "upper", "1")
    far = replace(
        compared,
        refitted={path: factor},
        refit_priors={path: 0.8},
        rest=(replace(compared.rest[0], name="force_test"),),
    )
    value = "bristle stiffness, test cylinder"
    assert f"First check in the model file: {value}." in verdict_words(far)
    assert f"may be further off: {value} 11.0" in ordinary_spaces(summary(far))
    assert "with the refitted model.yaml as the model" in ordinary_spaces(summary(far))
    inside = replace(far, refitted={path: replace(factor, at_bound=None)})
    of_flow = replace(far, rest=(replace(compared.rest[0], name="flow_tp"),))
    for other in (inside, of_flow, replace(far, refit_refused="No.")):
        assert "First check in the model file" not in verdict_words(other)
        assert "may be further off" not in summary(other)


def test_an_agreement_has_its_bounds_and_nothing_to_repair(compared):
    sizes = tuple(
        DetectableSize(name, "test", smallest, 2.0, "N", "evidence")
        for name, smallest in (("load_friction", 1.0), ("added_mass", 3.0))
    )
    none = replace(compared, verdict="none", rest=(), separability=Separability(sizes, ()),
                   not_tried={"rest_time": "no breakaway"})  # fmt: skip
    text = summary(none)
    assert "Not simulated" not in text
    proposed = summary(replace(none, next_experiment="next.yaml adds steps runs."))
    assert "next.yaml adds steps runs. Not simulated: rest time (no breakaway)." in proposed
    runs = "hbench run next.yaml --bench my_bench.yaml shows added_mass."
    terminal = diagnosis_text(replace(none, next_experiment=runs))
    assert (
        " ".join(terminal.split()).count("my_bench.yaml shows added mass.") == 1
    )  # the file keeps its name
    assert "9.50" not in text  # the verdict and the section on the gap have it
    assert "would show 1 of 3 known effects (2 tried, and rest time) at a typical" in text
    assert "They would not show added mass and rest time (not tried): these can be present." in text
    assert "38 N (force of test cylinder) and 0.060 l/min (flow to test piston side)" in text
    lead = (
        "repair anything. However, 2 of 3 known effects at a typical size could be present "
        "without showing in these runs."
    )
    assert f"no reason to inspect or to {lead}" in verdict_words(none)
    many = replace(none, not_tried={f"effect_{i}": "no breakaway" for i in range(6)})
    assert "However, 7 of 8 known effects at a typical size could be present" in verdict_words(many)
    assert next(iter(answers(compared)))[0] == "What to inspect"  # before the evidence
    assert "no reason to inspect" not in text  # once on the page
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
    assert "by 1.70 times the repeatability, a correct one by 1.20 on average; no" in text
    largest = "The largest deviation, 19 N RMS in the force of the test cylinder (matters above"
    small = (
        "is significant, but, at 1.9 times the repeatability, below the limit for an unknown "
        "effect (2 times): a small one is possible. It is largest while retracting."
    )
    assert f"{largest} 12 N), {small}" in text and "trial scatters" not in text
    assert "and is more than 2 times the repeatability." in diagnosis_page(compared, ())
    assert "agrees" not in verdict(close, gap=1.9, deviation=19.0, p_value=0.008)
    better = verdict(BeforeAfter(0.8, 0.73, 0.73, 1.37), deviation=19.0, p_value=0.008)
    assert "by 0.73 times the repeatability, no more than a correct one (1.37 on" in better
    immaterial = verdict(off, gap=1.9, deviation=9.0, p_value=0.008)
    assert "agrees with the measurement as far as it matters (it deviates from" in immaterial
    text = verdict(close, gap=1.9, deviation=19.0, p_value=0.3)
    assert "agrees" in text and "is not significant (p = 0.30)." in text
    assert "times the repeatability, a correct model by 1.20 on average" in text
    text = verdict(close, gap=1.1, deviation=9.0, p_value=0.3)
    assert "agrees" in text and "No deviation is large enough to matter; nearest to its" in text


def test_an_effect_too_small_to_be_named_that_explains_all_has_its_value_in_the_verdict(compared):
    """What exceeds its limit is no missing effect then, and no unknown one is possible."""
    leak = named().effects[0]
    small = replace(compared, verdict="none", rest=(), effects=(), small_effects=(leak,))
    text = ordinary_spaces(verdict_words(small))
    assert text.startswith("No missing effect is found that is large enough to be named. The ")
    assert "(matters above 12 N)" in text
    assert "Internal leakage (test cylinder 0.00580 (0.00560 to 0.00610) l/min/bar)" in text
    assert (
        "explains this; it is too small to be named (25 % of the typical size needed), and" in text
    )
    assert "a small one is possible" not in text and "no known effect" not in text
    line = "'internal_leakage: {test: 0.0058 l/min/bar}'"  # the keys that a file has
    for text in (diagnosis_text(small), diagnosis_page(small, ())):
        text = ordinary_spaces(" ".join(html.unescape(text).split()))
        assert f"To include that effect too, add {line} to its section 'effects'." in text
    assert "To include" not in summary(replace(small, small_effects=()))


@pytest.mark.parametrize(("given", "kept"), [(0.8, True), (3.0, False)])
def test_a_model_that_agrees_as_given_is_kept(compared, given, kept):
    """Its refit is as close outside the fit, but not in what the fit does not compare."""
    total = BeforeAfter(given, 0.73, 0.73, 1.37)
    table = GapTable(total, {"force_test": total}, {}, {})
    refit = {"refitted": FACTOR, "refit_priors": dict.fromkeys(FACTOR, 0.2)}
    none = replace(compared, verdict="none", rest=(), gap_heldout=table, **refit)
    told = dict(answers(none))["What to do"]
    assert told.startswith("Keep the model as given" if kept else "Use model.yaml")


@pytest.mark.parametrize(
    "path, value, ci95, bound, told",
    [
        ("moving_mass.test", 1.47, (1.2, 1.82), None, "1.47 (1.20 to 1.82)"),
        ("test_cylinder.dead_volume_piston", 2.19, (1.65, 2.91), None, "2.19 (1.65 to 2.91)"),
        ("moving_mass.test", 1.15, (1.05, 1.26), None, ""),  # within its assumed accuracy
        ("moving_mass.test", 1.47, (0.9, 2.4), None, ""),  # hardly determined
        ("friction.test.coulomb", 8.0, (7.0, 9.0), None, ""),  # no drawing tells it
        (
            "valve.bandwidth",
            0.64,
            (0.64, 0.67),
            "lower",
            "(at its lower bound)",
        ),
        ("valve.bandwidth", 0.64, (0.61, 0.67), None, ""),  # fitted: not known from a drawing
    ],
)
def test_an_agreement_by_a_value_that_is_far_off_asks_to_check_it(
    compared, path, value, ci95, bound, told
):
    factor = FitParameter(value, None, ci95, bound, "1")
    none = replace(
        compared, verdict="none", rest=(), refitted={path: factor}, refit_priors={path: 0.2}
    )
    text = ordinary_spaces(verdict_words(none))
    asked = "Check these values of the model file"
    assert ("no reason to inspect" in text) is not bool(told)
    assert (asked in text) is bool(told) and told in text


@pytest.mark.parametrize(
    ("value", "bound", "soft"), [(0.223, "lower", True), (4.48, "upper", False), (0.3, None, False)]
)
def test_an_agreement_by_a_friction_value_at_its_bound_asks_to_go_on_from_it(
    compared, value, bound, soft
):
    """A seal ten times as soft as the guess: its stiffness may be further off than the bound."""
    path = "friction.test.bristle_stiffness"
    factor = FitParameter(value, None, (0.9 * value, 1.1 * value), bound, "1")
    none = replace(
        compared, verdict="none", rest=(), refitted={path: factor}, refit_priors={path: 0.5}
    )
    text = ordinary_spaces(verdict_words(none))
    assert ("no reason to inspect" in text) is (bound is None)
    assert ("bristle stiffness, test cylinder" in text) is (bound is not None)
    assert ("Reconcile again with the refitted model.yaml" in text) is (bound is not None)
    assert ("over a longer distance than in the model" in text) is soft


def test_late_commands_say_what_a_bandwidth_at_its_bound_says(compared):
    factor = FitParameter(1.57, None, (1.01, 1.57), "upper", "1")
    none = replace(
        compared,
        verdict="none",
        rest=(),
        refitted={"valve.bandwidth": factor},
        refit_priors={"valve.bandwidth": 0.15},
    )
    late = {"commands": FitParameter(18.5, 0.7, (17.1, 19.9), None, "ms")}
    asked = "Check these values of the model file"
    assert asked in verdict_words(none)
    words = ordinary_spaces(verdict_words(replace(none, delays=late)))
    assert asked not in words and "the valves' commands by 18.5" in words


def test_an_agreement_states_the_largest_gap_beside_that_of_a_correct_model(compared):
    gaps = {
        "flow_lp": BeforeAfter(4.0, 2.79, 2.79, 4.48),
        "supply": BeforeAfter(1.6, 1.45, 1.45, 2),
    }
    total = BeforeAfter(5.4, 1.46, 1.46, 2.18)
    weak = replace(compared.ranking[0], score=1.1, explained=0.0)
    none = replace(
        compared, verdict="none", rest=(), where=(replace(compared.where[1], deviation=1e-8),),
        gap_heldout=GapTable(total, gaps, {}, {}), ranking=(weak,),
    )  # fmt: skip
    text = ordinary_spaces(verdict_words(none))
    assert "the model agrees with the measurement. These runs give no reason to inspect" in text
    assert (
        "In runs outside the fit the model deviates by 1.46 times the repeatability, a correct "
        "model by 2.18 on average: its fitted values are uncertain, and trials differ by more at "
        "some operating points than at others."
    ) in text
    largest = (
        "The largest gap of a quantity in runs outside the fit is 2.79 in the flow to the load"
    )
    assert f"{largest} piston side (4.48 expected of a correct model)." in ordinary_spaces(
        summary(none)
    )
    assert "closest" not in summary(none) + diagnosis_text(none)  # it would explain 0 %
    assert "Load friction is the closest" in summary(replace(none, ranking=compared.ranking))
    small = {name: replace(gap, refitted=0.9) for name, gap in gaps.items()}
    less = replace(none, gap_heldout=GapTable(total, small, {}, {}))
    assert "largest gap of a quantity" not in summary(less)


def test_a_deviation_within_the_noise_and_a_tolerance_that_changes_nothing_are_dashes(compared):
    noise = replace(compared.where[1], name="kinematics", deviation=0.0, allowed=0.0)
    table = where_table(replace(compared, where=(compared.where[0], noise)))
    first, second = (dict(zip(table.head, row, strict=True)) for row in table.rows)
    allowed = "tolerances allow without refit"
    assert (first["deviation"], first[allowed]) == ("40 N", "113 N")
    assert (second["deviation"], second[allowed]) == ("–", "–")


def test_signals_that_the_simulation_does_not_reproduce_are_reported(compared):
    gaps = {"v": 11.6, "u_t": 6.4, "x": 1.9}
    signals = {name: BeforeAfter(9.0, gap, gap, NAN) for name, gap in gaps.items()}
    table = replace(compared.gap_heldout, signals=signals)
    text = summary(replace(compared, verdict="none", rest=(), gap_heldout=table))
    assert "deviate in the velocity by 11.6 and the command of valve T by 6.40 times" in text
    assert "position by" not in text
    assert "Simulated in closed loop" not in summary(compared)


def test_a_signal_that_deviates_far_more_than_the_balances_is_in_the_verdict(compared):
    def found(gap, **changes):
        signals = {"v": BeforeAfter(9.0, gap, gap, NAN), "x": BeforeAfter(9.0, 1.5, 1.5, NAN)}
        balances = {"force_test": BeforeAfter(9.0, 2.1, 2.1, 1.6)}
        table = replace(compared.gap_heldout, signals=signals, balances=balances)
        return replace(compared, gap_heldout=table, **changes)

    def verdict(verdict, gap):
        return verdict_words(found(gap, verdict=verdict))

    def of_simulation(gap):
        return dict(answers(found(gap)))["Simulation"]

    words = (
        "the velocity deviates by 11.7 times its repeatability: look there for fast motion, such "
        "as chatter."
    )
    assert words in verdict("unknown", 11.7) and words in verdict("none", 11.7)
    # The row on the simulation does not call the same signal of no consequence.
    assert "either the bench moves in a way" in of_simulation(11.7)
    assert "do not expect" not in of_simulation(11.7)
    assert "do not expect" in of_simulation(4.0)
    assert "simulation shows more" not in verdict("unknown", 4.0)
    assert "velocity" not in verdict("none", 4.0)  # the row on the simulation has it
    measured, simulated = np.array([0.01, 0.02]), np.array([0.013, 0.024])  # 3 and 4 mm/s off
    run = Overlay("0042", "v", "m/s", np.arange(2), measured, measured, simulated)
    text = ordinary_spaces(verdict_words(found(11.7, overlays=(run,))))
    assert "the velocity deviates by 3.5 mm/s RMS in run 0042: look there for fast motion" in text
    assert "trial scatters" not in text
    assert "deviates most" not in text  # run 0042 is where to look first
    assert "simulation shows more" not in verdict_words(compared)  # nothing was simulated


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
    priors = dict.fromkeys(refitted, 0.1) | {"friction.test.coulomb": 0.8, "supply.tank": 0.3}
    sizes = (DetectableSize("load_friction", "test", 1.0, 2.0, "N", "evidence"),)
    agreed = replace(compared, verdict="none", rest=(), refitted=refitted, refit_priors=priors)
    text = summary(
        replace(agreed, separability=Separability(sizes, ()), not_tried={"valve_trim": FITTED})
    )
    # Logarithms by accuracies: ln 1.7 / 0.3 = 1.8, ln 2 / 0.8 = 0.87, ln 1.05 / 0.1 = 0.5.
    assert (
        f"{CHANGED_MOST}tank pressure 1.70 ± 0.30; Coulomb friction, test cylinder 0.50 ± 0.10; "
        "valve gain 0.950 ± 0.010." in text
    )
    assert "would show 1 of 1 known effects at a typical size. Valve trim is fitted with" in text
    refused = replace(agreed, refit_refused="No.")
    assert CHANGED_MOST not in summary(refused)


def test_too_few_data_say_what_is_missing_and_that_the_size_is_not_known(few):
    text = summary(few)
    assert "do not suffice to find a missing effect. Missing: a second load." in diagnosis_page(
        few, ()
    )
    assert few.next_experiment in text
    terminal = " ".join(diagnosis_text(few).split())
    assert all(f"{name}: {words}" in terminal for name, words in answers(few))
