"""Figure of decisions: shares of the limits, guard bands, and what cannot be drawn."""

import csv
import io
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from hbench.analysis.conformity.decision import decide
from hbench.records.conformity.acceptance import ConformityCheck, Measurement, Requirement
from hbench.report.conformity.decision_section import decision_drawings
from hbench.report.conformity.text import acceptance_text, series_words

SHARE = "Share of the limit (%)"


def check(value, u95, low, high, quantity="friction", unit="N", rule="guard_band", name="", **of):
    requirement = Requirement(quantity, unit, low, high, name)
    measured = Measurement(value, u95, **of)
    decided = decide(requirement, measured, rule)
    return ConformityCheck(requirement, measured, decided.probability, decided.decision)


def rows(*drawings):
    return [row for each in drawings for row in csv.DictReader(io.StringIO(each.csv.decode()))]


@pytest.mark.parametrize(
    ("made", "share", "half"),
    [
        (check(40.0, 4.0, None, 80.0), 50, 5),
        (check(100.0, 4.0, None, 80.0), 125, 5),
        (check(443.0, 9.0, 300.0, 480.0), 100 * 53 / 90, 10),  # 53 from their middle, 390
        (check(310.0, 9.0, 300.0, 480.0), 100 * 80 / 90, 10),
        (check(0.9, 0.02, 0.75, None, "efficiency", "%"), 40, 8),  # loses 10 of 25 %
        (check(3.5, 0.7, 3.5, None), 100, 20),
        (check(2.8, 0.7, 3.5, None), 120, 20),
    ],
)
def test_a_value_is_a_share_of_its_limit_and_conforms_below_100_percent(made, share, half):
    (drawing,) = decision_drawings([made], "guard_band", simulated=False)
    (row,) = rows(drawing)
    assert float(row[SHARE]) == pytest.approx(share, rel=1e-4)
    assert float(row[f"± {SHARE}"]) == pytest.approx(half, rel=1e-4)
    assert (share > 100) == (made.decision == "FAIL")


def test_the_measured_value_is_behind_each_point_in_the_unit_of_its_limit():
    made = check(4e5, 5e4, None, 8e5, unit="bar", name="seal", direction="extend")
    (row,) = rows(*decision_drawings([made], "guard_band", simulated=False))
    assert (row["measured"], row["± measured"], row["unit"]) == ("4", "0.5", "bar")
    assert row["quantity"] == "Seal: friction, at most 8 bar"


def hatches(drawing):
    root = ElementTree.fromstring(drawing.svg)
    return len(list(root.iter("{http://www.w3.org/2000/svg}pattern")))


def test_the_guard_band_is_drawn_only_where_the_rule_has_one():
    for rule, count in (("guard_band", 1), ("simple", 0), (None, 0)):
        made = check(40.0, 4.0, None, 80.0, rule=rule or "simple")
        (drawing,) = decision_drawings([made], rule, simulated=False)
        assert hatches(drawing) == count
        assert ("guard band" in drawing.read) == bool(count)


def test_a_limit_that_was_not_tested_has_a_hatched_strip_and_no_value():
    requirement = Requirement("friction", "N", None, 80.0)
    made = ConformityCheck(requirement, None, None, "NOT TESTED", "no runs")
    (drawing,) = decision_drawings([made], "simple", simulated=False)
    (row,) = rows(drawing)
    assert (row["series"], row[SHARE], row["measured"]) == ("NOT TESTED", "", "")
    assert hatches(drawing) == 1


def test_a_limit_of_zero_has_no_share():
    made = check(-3.0, 11.0, None, 0.0, "drift", "%", "simple")
    (row,) = rows(*decision_drawings([made], "simple", simulated=False))
    assert (row[SHARE], row["measured"]) == ("", "-300")


def test_many_decisions_are_drawn_in_figures_of_about_the_same_length_and_on_one_scale():
    made = [
        check(30.0 + number, 4.0, None, 80.0, name=f"clause {number}", direction=way)
        for number in range(20)
        for way in ("extend", "retract")
    ]
    drawings = decision_drawings(made, "guard_band", simulated=True)
    assert [len(rows(each)) for each in drawings] == [10, 10, 10, 10]
    assert len({row["quantity"] for row in rows(*drawings)}) == 20
    assert len({each.caption for each in drawings}) == 1
    assert [each.title[-5:] for each in drawings] == ["(1/4)", "(2/4)", "(3/4)", "(4/4)"]


def test_there_is_no_figure_without_decisions():
    assert decision_drawings([], "simple", simulated=False) == ()


def test_a_decision_of_poor_data_says_so_beside_it_and_what_to_do(certificate):
    acceptance = certificate().acceptance
    good, poor = (
        " ".join(acceptance_text(replace(acceptance, data=grade)).split())
        for grade in ("good", "poor")
    )
    assert poor.startswith(f"{acceptance.decision}, data poor: ")
    assert "next, as the data is poor: complete the campaign with --resume" in poor
    assert "data poor" not in good and "data is poor" not in good


def test_a_series_of_no_load_does_not_state_its_load_twice():
    requirement = Requirement("friction", "N", None, 80.0)
    no_load = Measurement(1.0, 0.1, label="no load", direction="extend", f_load_n=0.0)
    assert series_words(requirement, no_load) == "no load, extending"
    crawl = replace(no_load, label="crawl")
    assert series_words(requirement, crawl) == "crawl, extending, load 0 N"
