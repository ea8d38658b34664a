"""Texts of a diagnosis that are true of a bench or a simulator that hbench did not run."""

import re
from dataclasses import replace

from hbench.records import Candidate, DetectableSize, RunPlan, Separability, Specimen
from hbench.records.reconcile.diagnosis import HeldOutError
from hbench.report.diagnosis.definitions import of_effects_gaps, of_gaps
from hbench.report.diagnosis.page import diagnosis_page
from hbench.report.diagnosis.revised_yaml import revised_yaml
from hbench.report.diagnosis.tables.effect_tables import ranking_table
from hbench.report.diagnosis.tables.run_gaps import plan_words
from hbench.report.diagnosis.terminal import diagnosis_text
from tests.support.report.summarised import summary

SEEN = Candidate("direction_asymmetry", 7.1, 0.0, 0.9, {"test": 0.2}, "full", 5.0)
REFINED = Candidate("internal_leakage", 47.6, 0.77, 3.2, {"test": 1e-12}, "full", 5.0)


def on_one_line(text):
    return re.sub(r"\s+", " ", text)


def test_simulated_numbers_are_not_said_to_be_of_the_virtual_rig(named):
    assert named.provenance.source == "simulated"
    page, model = diagnosis_page(named, ()), revised_yaml(named)
    assert "Simulated. A simulation made these numbers" in page and "SIMULATED: not valid" in model
    assert "virtual rig" not in page + model


def test_the_model_of_a_bench_without_hbenchs_board_is_not_for_hbench_run(named):
    elsewhere = replace(named, provenance=replace(named.provenance, firmware=""))
    assert "hbench run --plant" in revised_yaml(named) and "--plant" in diagnosis_page(named, ())
    assert "--plant" not in revised_yaml(elsewhere) + diagnosis_page(elsewhere, ())
    assert "Give it to `hbench reconcile` as --model." in revised_yaml(elsewhere)


def test_levels_of_friction_count_in_the_gaps_of_a_driven_mass(named):
    """Its runs have no levels of their own, so its page does not say that they are left out."""
    (fact,) = of_effects_gaps(named)
    assert "from run to run" in fact[1] and fact[1] in on_one_line(diagnosis_page(named, ()))
    driven = replace(named, errors=(HeldOutError("force", "N", 4.0, 2.0, 1.0),))
    assert of_effects_gaps(driven) == () == of_effects_gaps(replace(named, effects=()))


def test_the_terminals_table_of_effects_is_not_announced_with_gaps(named):
    lines = diagnosis_text(named).splitlines()
    title = lines.index("Effects")
    assert "gap" not in lines[title + 1].lower()


def test_terms_of_a_bench_with_one_cylinder_are_of_one_cylinder(named):
    def words(diagnosis):
        return dict(of_gaps(diagnosis))["Flows and forces"]

    gap = named.where[0]
    both = words(replace(named, where=(gap, replace(gap, name="flow_lp"))))
    assert "each of the four chambers" in both and "balance of either cylinder" in both
    alone = words(replace(named, where=(replace(gap, name="flow_tr"),)))
    assert "each chamber of the cylinder" in alone and "either" not in alone


def test_an_imported_run_at_several_speeds_has_its_largest_speed_and_no_sign():
    plan = RunPlan("0001", "verification", 1, -0.152, Specimen(20e-4, 12e-4))
    assert plan_words(plan) == "verification up to 152 mm/s, trial 1"
    assert plan_words(replace(plan, kind="steady")).startswith("steady −152 mm/s")


def test_the_terminal_lists_the_effects_that_could_be_present_unseen(compared):
    sizes = tuple(
        DetectableSize(name, "test", smallest, 2.0, "N", "evidence")
        for name, smallest in (("direction_asymmetry", 3.0), ("presliding", 1.0))
    )
    known = replace(compared, verdict="none", separability=Separability(sizes, ()))
    found = replace(known, not_tried={"rest_time": "runs of the kind breakaway measure it"})
    line = "Could be present at a typical size: direction asymmetry; not tried: rest time"
    assert line in diagnosis_text(found).splitlines()
    assert "Could be present" not in diagnosis_text(replace(found, verdict="unknown"))


def test_an_effect_that_the_refitted_model_makes_superfluous_is_listed_with_none(compared):
    none = replace(compared, verdict="none", ranking=(SEEN, REFINED))
    words = (
        "Not excluded: direction asymmetry (score 7.1 nats, 5.0 needed; explains 0 %). The "
        "refitted model without it, with errors of the sensors within their tolerances, comes "
        "about as close."
    )
    assert words in on_one_line(diagnosis_text(none)) and words in summary(none)
    below = replace(SEEN, score=4.9)
    assert "Not excluded" not in diagnosis_text(replace(none, ranking=(below, REFINED)))
    assert "Not excluded" not in diagnosis_text(replace(none, verdict="unknown"))


def test_the_terminal_gives_the_reason_why_a_candidate_with_a_sufficient_score_is_not_named(
    compared,
):
    reason = "it leaves most of the gap of runs outside the fit"
    found = replace(compared, ranking=(REFINED, SEEN), ruled_out={"internal_leakage": reason})
    assert found.verdict == "unknown"
    column = ranking_table(found).head.index("why not named")
    assert [row[column] for row in ranking_table(found).rows] == ["ruled out", "share"]
    words = f"Internal leakage would explain 77 % of the gap, but is ruled out: {reason}."
    assert words in on_one_line(diagnosis_text(found))
