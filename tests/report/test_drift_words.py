"""The drift in words: its size, its test, and what the plan means for the numbers."""

import json
from dataclasses import replace

import pytest

from hbench.analysis.summary.drift import drift_checks
from hbench.records import Drift
from hbench.report.campaign.page import report_document
from hbench.report.campaign.results_document import results_json
from hbench.report.campaign.sections.drift import drift_sections
from hbench.report.drift import (
    drift_advice,
    drift_finding,
    drift_outside_u,
    drift_reserve,
    drift_table,
    drift_with_oil,
    drift_words,
)
from hbench.workflow.conformity.acceptance import decided

CHANGES = ("change", "change_ci95", "change_percent", "change_percent_ci95")
MEASURED = {
    "basis": "time",
    "scale": "relative",
    "change": -0.16,
    "change_ci95": 0.036,
    "change_percent": -16.0,
    "change_percent_ci95": 3.6,
    "per_hour": -3.7,
    "per_hour_ci95": 0.83,
    "span_s": 156.0,
    "p": 3e-9,
    "points": 12,
    "trials": 36,
    "dof": 23,
    "speed_vif": 1.04,
    "speed_share": -0.01,
    "separated": True,
}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "−16.0 ± 3.6 % from the first to the last steady run (significant, p < 0.0001), sep"),
        ({"p": 0.3}, "(not significant, p = 0.30), separated from speed by the order of the runs"),
        ({"separated": False}, "p < 0.0001), not separated from speed by the order of the runs"),
        ({"p": 0.3, "separated": False}, "not separated from speed by the order of the runs: up to "
         "20 % is possible"),
        ({"basis": "order"}, "by their order since no times are known (significant"),
        ({"basis": "order", "separated": False}, "an unknown amount: it drifts between the trials"),
    ],
)  # fmt: skip
def test_the_words_have_the_size_the_test_and_the_plan(changes, words):
    assert words in drift_words(Drift(**MEASURED | changes))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ""),
        ({"separated": False}, ""),
        ({"basis": "order"}, ""),
        ({"basis": "order", "separated": False}, "between the trials (p < 0.0001), whose size is"),
        ({"basis": "order", "separated": False, "p": 0.3}, "of up to 20 %, which cannot be ex"),
        ({"basis": "order", "separated": False, "p": 0.3, "change_percent": 1.0}, ""),
    ],
)
def test_a_decision_states_a_drift_that_its_probability_does_not_contain(changes, words):
    found = drift_outside_u(Drift(**MEASURED | changes))
    assert (words in found and found.startswith("U and the prob")) if words else found == ""


@pytest.mark.parametrize(("quantity", "noted"), [("friction", True), ("drift", False)])
def test_the_decision_on_friction_has_this_note(sample_results, tmp_path, quantity, noted):
    unit = "N" if quantity == "friction" else "%"
    limits = tmp_path / "limits.yaml"
    limit = f"{{quantity: {quantity}, max: 900 {unit}}}"
    limits.write_text(f"product: p\nrule: guard_band\nlimits: [{limit}]\n")
    unknown = Drift(**MEASURED | {"basis": "order", "separated": False})
    notes = decided(replace(sample_results, drift=unknown), limits).notes
    assert (drift_outside_u(unknown) in notes) is noted
    assert drift_outside_u(replace(unknown, separated=True)) == ""


def test_curves_of_a_single_speed_have_nothing_to_separate():
    one_speed = Drift(**MEASURED | {"p": 0.7, "several_speeds": False})
    assert "separated" not in drift_words(one_speed)
    table = drift_table(one_speed)
    (row,) = table.rows
    assert [cell.text for cell in row[-3:]] == ["–"] * 3


def test_a_change_that_is_extrapolated_from_the_order_of_files_has_no_number():
    """Files in the order of their names, −177 ± 65 %: friction cannot change by more than 100 %."""
    extrapolated = {"basis": "order", "separated": False, "per_hour": None, "per_hour_ci95": None}
    size = {"change_percent": -177.0, "change_percent_ci95": 65.0}
    drift = Drift(**MEASURED | extrapolated | size)
    (check,) = drift_checks(drift)
    assert check.grade == "with care"
    for words in (drift_words(drift), drift_finding(drift), drift_advice(drift)):
        assert "177" not in words
    assert "column of date-times" in drift_advice(drift)
    (row,) = drift_table(drift).rows
    assert row[0].text == "not known"
    (known,) = drift_checks(replace(drift, basis="time"))
    assert known.grade == "poor" and "177" in drift_finding(known.drift)


def test_results_have_no_number_of_a_change_that_is_not_known(small):
    """The p-value is that of the trials, and is kept."""

    def written(drift):
        quality = replace(small.quality, checks=drift_checks(drift))
        document = json.loads(results_json(replace(small, drift=drift, quality=quality)))
        (check,) = document["quality"]["checks"]
        return [document["drift"][name] for name in CHANGES], check["value"], document["drift"]["p"]

    drift = Drift(**MEASURED | {"basis": "order", "separated": False, "change_percent": -4.0})
    assert written(drift) == ([None] * 4, None, MEASURED["p"])
    values = [drift.change, drift.change_ci95, -4.0, drift.change_percent_ci95]
    assert written(replace(drift, basis="time")) == (values, 4.0, MEASURED["p"])
    assert written(replace(drift, p=0.3))[0] == values  # what is possible is stated


@pytest.mark.parametrize(("basis", "change_k"), [("order", None), ("time", 0.9)])
def test_results_have_no_change_of_the_oil_over_an_order_of_names(small, basis, change_k):
    drift = Drift(**MEASURED | {"basis": basis, "separated": False, "temp_change_k": 0.9})
    document = json.loads(results_json(replace(small, drift=drift)))
    assert document["drift"]["temp_change_k"] == change_k


def test_the_verdict_states_a_drift_that_cannot_be_excluded_once(small):
    drift = Drift(**MEASURED | {"p": 0.3, "separated": False})
    quality = replace(small.quality, grade="with care", checks=drift_checks(drift))
    verdict = report_document(replace(small, drift=drift, quality=quality), ()).verdict
    assert verdict.count("20 %") == 1 and "U does not contain a possible drift of up to" in verdict
    assert "Next step: measure in random order, which separates drift from speed." in verdict
    shown = replace(drift, p=0.001)
    checks = drift_checks(shown)
    quality = replace(small.quality, grade=checks[0].grade, checks=checks)
    verdict = report_document(replace(small, drift=shown, quality=quality), ()).verdict
    assert "Next step: warm the bench up until friction no longer changes" in verdict


@pytest.mark.parametrize(
    ("stopped", "words"),
    [("08:24", "These runs span 2.6 min of the campaign's 24 min: a drift in"), ("08:03", "")],
)
def test_the_part_of_the_campaign_that_the_drift_is_of_is_stated(small, stopped, words):
    day = "2026-01-01T"
    times = {"started": f"{day}08:00:00+00:00", "stopped": f"{day}{stopped}:00+00:00"}
    results = replace(small, drift=Drift(**MEASURED), provenance=replace(small.provenance, **times))
    (section,) = drift_sections(results)
    text = " ".join(section.paragraphs)
    assert words in text and bool(words) == ("These runs span" in text)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"temp_change_k": 12.34}, "Meanwhile the oil temperature rose by 12.3 K."),
        ({"temp_change_k": 9.0, "temp_correlation": -0.93, "temp_p": 1e-9},
         "by 9.0 K; within the points, friction falls as it rises (correlation −0.93, p < 0.0001)"),
        ({"temp_change_k": -4.0, "temp_correlation": 0.05, "temp_p": 0.7},
         "fell by 4.0 K; within the points, friction does not correlate with it (correlation 0.05"),
        ({}, ""),
    ],
)  # fmt: skip
def test_the_oil_is_named_beside_the_drift(changes, words):
    assert words in drift_with_oil(Drift(**MEASURED | changes))


@pytest.mark.parametrize(
    ("correlation", "p", "words"),
    [
        (-0.72, 1e-9, "Within the points, friction falls as the oil temperature rises (corr"),
        (0.72, 1e-9, "Within the points, friction rises with the oil temperature (correl"),
        (0.05, 0.7, "Within the points, friction does not correlate with the oil temperature (c"),
        (None, None, ""),
    ],
)
def test_a_change_of_the_oil_over_an_order_of_names_is_not_stated(correlation, p, words):
    """Oil that warmed by 15 K in a random order rose by 0.9 K over the names of the files."""
    temp = {"temp_change_k": 0.9, "temp_correlation": correlation, "temp_p": p}
    drift = Drift(**MEASURED | temp | {"basis": "order", "separated": False})
    text = drift_with_oil(drift)
    assert text.startswith(words) and bool(words) == bool(text) and "0.9" not in text
    assert drift_with_oil(replace(drift, separated=True)).startswith("Meanwhile the oil temp")


def test_the_advice_is_a_random_order_where_the_plan_does_not_separate_drift_from_speed():
    assert "include the drift" in drift_advice(Drift(**MEASURED))
    assert drift_advice(Drift(**MEASURED | {"p": 0.3})) == ""
    for p in (0.001, 0.3):
        assert "order: random" in drift_advice(Drift(**MEASURED | {"separated": False, "p": p}))


def test_a_drift_that_u_does_not_contain_and_no_check_grades_is_a_reserve_of_the_verdict(small):
    """Only the order of imported runs is known: −5 ± 24 % leaves 29 % possible."""
    order = {"basis": "order", "separated": False, "p": 0.7}
    wide = Drift(**MEASURED | order | {"change_percent": -5.0, "change_percent_ci95": 24.0})
    words = "A drift of up to 29 % cannot be excluded, and U does not contain it."
    assert drift_reserve(wide) == words
    verdict = report_document(replace(small, drift=wide), ()).verdict
    assert verdict.count("29 %") == 1 and words not in verdict  # the first sentence states it
    none = replace(small, drift=wide, headline=replace(small.headline, series=()))
    verdict, step, _ = report_document(none, ()).verdict.partition(" Next step: ")
    assert verdict.endswith(words) and step
    assert drift_advice(wide).startswith("U does not contain it.")
    assert (
        drift_reserve(replace(wide, p=0.01)) == "U does not contain the drift between the trials."
    )
    for excluded in ({"change_percent_ci95": 9.0}, {"separated": True}, {"basis": "time"}):
        assert drift_reserve(replace(wide, **excluded)) == ""
    assert drift_reserve(None) == ""


def test_the_table_has_the_estimate_in_its_own_unit():
    def cells(changes):
        table = drift_table(Drift(**MEASURED | changes))
        return dict(zip(table.head, (cell.text for cell in table.rows[0]), strict=True))

    row = cells({})
    assert row["Change over the campaign"] == "−16.0 ± 3.6 %"
    assert row["Span"] == "2.6 min" and "Per hour" not in row  # no rate from a few minutes
    long = cells({"span_s": 7200.0})
    assert (long["Per hour"], long["Span"]) == ("−370 ± 83 %/h", "120.0 min")
    newtons = cells({"scale": "absolute", "change": -40.0, "change_ci95": 12.0, "span_s": None,
                     "basis": "order", "per_hour": None, "per_hour_ci95": None})  # fmt: skip
    assert newtons["Change over the campaign"] == "−40 ± 12 N"
    assert newtons["Span"] == "36 trials" and "Per hour" not in newtons
