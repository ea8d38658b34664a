"""Verdicts, what data lacks, runs that take no part, and the revised model's sections."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.config.bench import merge, parse_plant, plant_sections
from hbench.config.files.examples import example
from hbench.config.files.loading import parse_yaml
from hbench.config.schedule import parse_schedule
from hbench.errors import ConfigError
from hbench.experiment.plan import plan_runs
from hbench.model.effects.catalogue import EFFECTS, read_effects
from hbench.reconcile.diagnose import ReconcileTask, diagnose
from hbench.reconcile.diagnosis_fields import added_effect
from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.evidence.products import Products
from hbench.reconcile.gaps.log_map import unexplained_gaps
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.measured.comparable_runs import comparable_runs
from hbench.reconcile.nuisance import nuisances
from hbench.reconcile.revised_model import revised
from hbench.reconcile.search.candidates import EvaluatedCandidate
from hbench.reconcile.search_result import SearchResult, SearchStep
from hbench.reconcile.separation.missing_data import (
    FEWEST_POINTS,
    MISSING,
    data_shortfalls,
    missing_experiments,
    unmeasured_channels,
)
from hbench.reconcile.verdict import decide_verdict
from hbench.records import Candidate, FitParameter, Gap, Rival, Run, RunPlan, Specimen
from tests.support.reconcile.rounds import plant_of

LEAK = Candidate("internal_leakage", 80.0, 0.9, 1.0, {"test": 1e-12}, "full", 7.0)
OTHER = Candidate("external_leakage", 78.0, 0.9, 1.0, {"tp": 1e-12}, "full", 7.0)
LACKS = Gap("flow_tp", 9.0, 0.01, 1e-7, 100)


def found(*steps):
    """Steps are (taken, close); every one has tried both."""
    tried = EvaluatedCandidate(LEAK, None), EvaluatedCandidate(OTHER, None)
    return SearchResult(None, None, tuple(SearchStep(None, tried, *step) for step in steps), None)


# ---- verdicts


def test_an_effect_that_was_taken_is_named_and_the_rest_is_told():
    verdict, why = decide_verdict(found(("internal_leakage", ()), (None, ())), ())
    assert verdict == "named" and "internal_leakage" in why and "flow_tp" not in why
    verdict, why = decide_verdict(found(("internal_leakage", ()), (None, ())), (LACKS,))
    assert (
        verdict == "named"
        and "Gaps that remain (in multiples of the repeatability): flow_tp (9.0)" in why
    )
    assert "No effect" not in why  # it may be that of a correct model
    both = found(("internal_leakage", ()), ("supply_droop", ()), (None, ()))
    assert {"internal_leakage", "supply_droop"} <= set(decide_verdict(both, ())[1].split())


def test_a_set_beside_a_named_effect_is_told():
    verdict, why = decide_verdict(found(("supply_droop", ()), (None, (LEAK, OTHER))), (LACKS,))
    assert verdict == "named" and {"internal_leakage", "external_leakage"} <= set(why.split())


def test_one_unnamed_law_and_several_have_the_article_and_the_plural_that_they_need():
    tables = (
        SimpleNamespace(adds_to="flow_tp", knots={"opening": (), "piston_pressure": ()}),
        SimpleNamespace(adds_to="friction_test", knots={"position": ()}),
    )

    def why(count):
        final = SimpleNamespace(hypothesis=SimpleNamespace(tables=tables))
        laws = tuple(SimpleNamespace(table=i) for i in range(count))
        return decide_verdict(replace(found((None, ())), final=final, laws=laws), (LACKS,))[1]

    one, first = "contains an unnamed law: ", "flow_tp over opening and piston_pressure"
    assert why(1).endswith(f"{one}{first}.")
    assert why(2).endswith(f"contains unnamed laws: {first}; friction_test over position.")
    assert "unnamed" not in why(0)


def test_candidates_that_are_close_are_ambiguous():
    verdict, why = decide_verdict(found((None, (LEAK, OTHER))), (LACKS,))
    assert (
        verdict == "ambiguous" and "internal_leakage (80)" in why and "external_leakage (78)" in why
    )


def test_what_nothing_explains_is_unknown_and_no_gap_is_none():
    verdict, why = decide_verdict(found((None, ())), (LACKS,))
    assert verdict == "unknown" and "flow_tp (9.0)" in why and "7.0" in why
    assert "explains 90 % in cross-validation (25 % needed;" in why
    assert (
        decide_verdict(SearchResult(None, None, (SearchStep(None, (), None, ()),), None), (LACKS,))[
            0
        ]
        == "unknown"
    )
    assert decide_verdict(found((None, ())), ())[0] == "none"


def test_the_best_candidate_is_that_without_any_effect_also_if_too_little_of_it_remains():
    rest = EvaluatedCandidate(OTHER, None), EvaluatedCandidate(LEAK, None)
    steps = (*found(("internal_leakage", ())).steps, SearchStep(None, rest, None, ()))
    result = SearchResult(
        None, None, steps, None, ruled_out={"internal_leakage": "it is too small"}
    )
    verdict, why = decide_verdict(result, (LACKS,))
    assert verdict == "unknown" and "best candidate, internal_leakage, explains 90 %" in why
    assert "not named: refined, it is too small." in why and "external_leakage" not in why


def test_a_size_just_below_the_limit_is_written_apart_from_it():
    small = EvaluatedCandidate(replace(LEAK, size=0.2496), None)
    steps = (SearchStep(None, (small,), None, ()),)
    why = decide_verdict(SearchResult(None, None, steps, None), (LACKS,))[1]
    assert "0.2496 of a typical size, 0.2500 needed" in why


def test_a_balance_lacks_something_if_it_is_far_and_not_by_chance():
    ranked = [LACKS, replace(LACKS, p_value=0.3), replace(LACKS, gap=1.9), replace(LACKS, gap=2.1)]
    assert unexplained_gaps(ranked) == (LACKS, ranked[3])


# ---- what data lacks


def plans_of(bench, kinds=None, **changes):
    """Return the plans of some kinds of discriminate.yaml; ``changes`` are of the steady ones."""
    data = parse_yaml(example("discriminate.yaml").decode())
    data["experiments"] = [
        one | (changes if one["kind"] == "steady" else {})
        for one in data["experiments"]
        if kinds is None or one["kind"] in kinds
    ]
    return plan_runs(parse_schedule(data, "plan"), bench, "plan").runs


def test_the_plan_made_for_telling_effects_apart_lacks_nothing(bench):
    assert missing_experiments(repeated(plans_of(bench))) == {}


@pytest.mark.parametrize(
    "lacks, kinds, changes",
    [
        ("speeds", None, {"velocities": ["30 mm/s", "80 mm/s"]}),
        ("hold", ("steady", "triangle", "steps"), {}),
        ("reversals", ("steady", "steps", "hold"), {}),
    ],
)
def test_what_is_left_out_is_missing_and_nothing_else(bench, lacks, kinds, changes):
    assert list(missing_experiments(repeated(plans_of(bench, kinds, **changes)))) == [lacks]


def test_one_speed_at_one_load_in_one_direction_lacks_everything(bench):
    one = [plan for plan in plans_of(bench, ("steady",)) if plan.label == "extending, again"]
    every = ["speeds", "loads", "directions", "reversals", "steps", "hold", "pressures"]
    assert list(missing_experiments(repeated(one[:1]))) == list(missing_experiments([])) == every
    assert all(missing_experiments([])[code] == MISSING[code] for code in every)


def test_the_same_load_at_two_pressures_is_asked_for(bench):
    level = [plan for plan in plans_of(bench) if plan.label != "extending, high pressures"]
    assert list(missing_experiments(repeated(level))) == ["pressures"]


def test_pressures_that_no_plan_states_are_those_measured(bench):
    """An imported campaign has no reference of the rod-side pressure."""

    def imported(*levels_pa):
        return [
            replace(run, plan=replace(run.plan, p_lr_ref_pa=None), p_lr_pa=np.full(3, p))
            for run in repeated(plans_of(bench))
            for p in levels_pa
        ]

    assert "pressures" not in missing_experiments(imported(20e5, 55e5))
    assert "pressures" in missing_experiments(imported(20e5, 21e5))
    unknown = [replace(run, p_lr_pa=None) for run in imported(20e5)]
    assert "pressures" in missing_experiments(unknown)


def repeated(plans):
    """Return runs with all channels, two of each plan."""
    at = np.zeros(3)
    channels = ("v_m_s", "p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa", "f_applied_n")
    every = dict.fromkeys((*channels, "u_t_v", "u_l1_v", "u_l2_v"), at)
    return [Run(plan, at, at, **every) for plan in plans for _ in range(2)]


def test_many_points_of_one_speed_name_nothing_and_of_one_load_suffice(bench):
    """Twelve points each: at one speed effects look alike, at one load some of them do."""
    plans = plans_of(bench, ("steady",), trials=1)
    speed = [replace(plan, p_lr_ref_pa=p) for plan in plans for p in (1e6, 2e6)]
    speed = [plan for plan in speed if abs(plan.v_ref_m_s) == 0.08]
    assert list(data_shortfalls(repeated(speed))) == ["speeds"]
    load = [replace(plan, f_load_n=500.0, p_lr_ref_pa=1e5 * i) for i, plan in enumerate(plans)]
    assert data_shortfalls(repeated(load)) == {}
    assert "loads" in missing_experiments(repeated(load))
    assert data_shortfalls(repeated(plans)) == {}


def test_loads_that_no_plan_states_are_those_measured(bench):
    """Points of an imported campaign differ by a factor, such as the load cylinder's pressure."""
    runs = [
        replace(run, plan=replace(run.plan, f_load_n=None, label=label), f_applied_n=np.full(3, n))
        for run in repeated(plans_of(bench, ("steady",), trials=1))
        for label, n in (("20 bar", 1000.0), ("30 bar", 2900.0))
    ]
    assert "loads" not in missing_experiments(runs)
    friction = [replace(run, f_applied_n=0.3 * run.f_applied_n + 2500) for run in runs]
    assert "loads" in missing_experiments(friction)  # 2800 and 3370 N
    unknown = [replace(run, f_applied_n=None) for run in runs]
    assert "loads" in missing_experiments(unknown)


def test_loads_measured_at_nearly_one_speed_are_compared(bench):
    """A heavier load slows a position loop, so strokes with one reference differ in their speed."""
    runs = [
        replace(run, plan=replace(run.plan, f_load_n=None, label=label, v_ref_m_s=v), f_applied_n=n)
        for run in repeated(plans_of(bench, ("steady",), trials=1))[:1]
        for label, v, n in (
            ("10 bar", -0.0908, np.full(3, -3900.0)),
            ("80 bar", -0.0861, np.full(3, -13700.0)),
            ("40 bar", 0.3, np.full(3, 9000.0)),
        )
    ]
    assert "loads" not in missing_experiments(runs)
    assert "loads" in missing_experiments(runs[::2])  # another speed may have another friction


def test_reversals_have_many_speeds(bench):
    moving = plans_of(bench, ("triangle", "steps", "hold"), trials=1)
    plans = [replace(one, p_lr_ref_pa=p) for one in moving for p in (0, 1)]
    assert data_shortfalls(repeated(plans)) == {}


def test_triangles_have_both_directions_and_many_speeds(bench):
    triangles = repeated(plans_of(bench, ("triangle",), trials=1))
    assert not {"speeds", "directions", "reversals"} & set(missing_experiments(triangles))


def test_channels_that_no_run_has_are_named_with_what_is_not_compared(bench):
    runs = repeated(plans_of(bench))
    assert unmeasured_channels(runs) == {}
    text = unmeasured_channels([replace(run, p_s_pa=None) for run in runs])["channels"]
    assert text.startswith("p_s ") and text.endswith("flow_tp, flow_tr, flow_lp, flow_lr, supply")
    assert data_shortfalls([replace(run, p_s_pa=None) for run in runs]) == {}  # forces are compared
    some = [replace(runs[0], p_s_pa=None), *runs[1:]]
    assert unmeasured_channels(some) == {}


# ---- runs that take no part


def test_runs_that_are_not_whole_take_no_part_and_it_is_told_why(bench):
    plan = plans_of(bench)[0]
    at = np.zeros(3)
    whole = Run(plan, at, at)
    imported = Run(RunPlan("0009", "steady", 1, 0.1, Specimen(1e-3, 8e-4)), at, at)
    runs = [
        whole,
        replace(whole, aborted="emergency stop"),
        replace(whole, truncated="the link broke"),
        replace(whole, missing_records=7),
        replace(whole, t_s=np.append(0.01 * np.arange(50), 2.0), x_m=np.zeros(51)),
        imported,
    ]
    usable, left_out = comparable_runs(runs)
    assert usable == (whole, imported)
    reasons = ("emergency stop", "the link broke", "7 records", "gaps of up to 1.51 s")
    assert len(left_out) == len(reasons)
    for said, reason in zip(left_out, reasons, strict=True):
        assert reason in said and said.startswith("run 0") and said.count("run ") == 1


def test_too_few_operating_points_name_nothing_and_simulate_nothing(bench):
    """Seven points of eight that it needs: no guess is made."""
    plans = [plan for plan in plans_of(bench) if plan.label == "extending"][:7]
    at = np.zeros(3)
    runs = tuple(Run(plan, at, at) for plan in plans) + (
        Run(plans_of(bench)[-1], at, at, aborted="emergency stop"),
    )

    def simulate(hypotheses, trials):
        raise AssertionError("nothing is simulated")

    task = ReconcileTask(
        provenance=None,
        model="model.yaml",
        plant_data={"oil": {}},
        bench=bench,
        plant=plant_of(bench),
        runs=runs,
        instruments=None,
        simulate=simulate,
    )
    found = diagnose(task)
    assert found.verdict == "unknown" and not found.effects
    assert found.missing[0] == data_shortfalls(runs[:-1])["points"]
    assert found.missing[0].endswith(" 7") and f" {FEWEST_POINTS} " in found.missing[0]
    assert MISSING["hold"] in found.missing
    assert "discriminate.yaml" in found.next_experiment
    elsewhere = diagnose(replace(task, bench=None))  # its runs cannot be made there
    assert "discriminate.yaml" not in elsewhere.next_experiment
    assert found.revised == {"oil": {}} and set(found.not_tried) == set(EFFECTS)
    assert len(found.left_out) == 1


# ---- the revised model


def test_the_revised_sections_read_as_the_plant_with_its_factors_and_effects(bench, bench_data):
    """Every nuisance of the shipped model, each with a factor of its own."""
    model = parse_yaml(example("model-aau.yaml").decode())
    sections = plant_sections(bench_data, model, "model")
    given = parse_plant(bench_data, model, "model")
    factors = {path: 1 + 0.01 * (i + 1) for i, path in enumerate(nuisances(given))}
    fitted = {path: FitParameter(value, 0.0, None, None, "1") for path, value in factors.items()}
    hypothesis = Hypothesis(factors).with_coefficients({("internal_leakage", "test"): 1e-12})
    made = revised(sections, fitted, hypothesis)
    plant = parse_plant(bench_data, made, "revised")
    assert len(factors) > 15
    for path, factor in factors.items():
        assert at(plant, path) == pytest.approx(factor * at(given, path), rel=1e-5), path
    assert read_effects(plant.effects)["internal_leakage"]["test"] == pytest.approx(1e-12)
    assert plant.valve.damping == given.valve.damping
    assert sections == plant_sections(bench_data, model, "model")  # untouched


def test_effects_that_a_model_has_already_stay_in_the_revised_one(bench_data):
    sections = merge(bench_data, {"effects": {"load_cell_gain": {"error": "1 %"}}})
    hypothesis = Hypothesis().with_coefficients({("supply_droop", "slope"): 2e9})
    assert set(revised(sections, {}, hypothesis)["effects"]) == {"load_cell_gain", "supply_droop"}
    assert "effects" not in revised({"oil": {}}, {}, Hypothesis())


@pytest.mark.parametrize(
    "given, expected",
    [
        ("700 bar", "770 bar"),
        ("3e5 N/m", "330000 N/m"),
        ("-1.5e-3 m^2/V", "-0.00165 m^2/V"),
        (2, 2.2),
    ],
)
def test_quantities_keep_their_units(given, expected):
    factor = FitParameter(1.1, None, None, None, "1")
    found = revised({"a": {"b": given}}, {"a.b": factor}, Hypothesis())
    assert found["a"]["b"] == expected


def test_what_a_file_leaves_to_its_default_is_written_with_its_factor(bench_data):
    """Of all nuisances: each key that a file can do without."""
    model = parse_yaml(example("model-aau.yaml").decode())
    for path in nuisances(parse_plant(bench_data, model, "model")):
        sections = plant_sections(bench_data, model, "model")
        section, (*above, last) = sections, path.split(".")
        for name in above:
            section = section[name]
        del section[last]
        try:
            before = parse_plant({}, sections, "model")
        except ConfigError:
            continue  # it must have one
        factor = FitParameter(1.1, None, None, None, "1")
        if path in nuisances(before):
            after = parse_plant({}, revised(sections, {path: factor}, Hypothesis()), "model")
            assert at(after, path) == pytest.approx(1.1 * at(before, path))


def at(plant, path):
    for name in path.split("."):
        plant = getattr(plant, name)
    return plant


def test_an_effect_that_was_taken_keeps_its_own_score_though_another_scored_more(bench):
    """The other explained too little; the rival is the next below."""
    tried = [
        Candidate("pressure_offset", 33.0, 0.45, 0.1, {}, "full"),
        Candidate("load_friction", 12.0, 0.9, 1.0, {}, "full"),
        Candidate("load_cell_gain", 4.0, 0.1, 0.1, {}, "linear"),
    ]
    data = Products((), *[np.zeros(0)] * 5, ())
    empty = LinearisedModel(Hypothesis(), None, {}, data, None, None)
    nothing = ParameterEstimates(bench, empty, (), *[np.zeros(0)] * 6)
    found = added_effect("load_friction", tried, nothing, 3.0, 1.0)
    assert (found.name, found.score, found.gap_before, found.gap_after) == (
        "load_friction", 12.0, 3.0, 1.0,
    )  # fmt: skip
    assert found.runner_up == Rival("load_cell_gain", 8.0)


def test_a_candidate_within_its_tolerances_is_no_rival(bench):
    """A gain of all transducers is within tolerances for each alone, and scores the same."""
    tried = [
        Candidate("load_cell_gain", 109.2, 1.0, 1.5, {}, "full"),
        Candidate("pressure_gain", 109.2, 1.0, 0.0, {}, "full"),
        Candidate("load_friction", 33.7, 0.99, 1.5, {}, "full"),
    ]
    data = Products((), *[np.zeros(0)] * 5, ())
    empty = LinearisedModel(Hypothesis(), None, {}, data, None, None)
    nothing = ParameterEstimates(bench, empty, (), *[np.zeros(0)] * 6)
    found = added_effect("load_cell_gain", tried, nothing, 3.0, 1.0)
    assert found.runner_up == Rival("load_friction", 75.5)
