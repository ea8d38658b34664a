"""Breakaway in a comparison: verdict, table and JSON, alone and beside curves."""

import csv
import json
from dataclasses import replace
from io import StringIO

import pytest

from hbench.analysis.curves.breakaway import breakaways
from hbench.records import BreakawayDifference, CampaignDifferences, Difference
from hbench.report.comparison.breakaways import breakaway_names
from hbench.report.comparison.figures import draw_differences
from hbench.report.comparison.text import differences_json, differences_page, differences_text
from tests.support.analysis.pushes import accepted, push
from tests.support.report.spaces import ordinary_spaces

NAMES = "before", "<after>"


def difference(value, u95=15.0, p=1e-3):
    return Difference(600.0, 600.0 + value, 4.0, 12.0, u95, p, p, u95_a=40.0, u95_b=40.0)


def rows(*values, p=1e-3):
    found = []
    for dwell, value in zip((1.0, 10.0, 60.0), values, strict=False):
        (one,) = breakaways(accepted(push(600.0, dwell_s=dwell)), None)
        found.append(BreakawayDifference(one, one, difference(value, p=p)))
    return tuple(found)


@pytest.fixture
def made(small):
    qualities = (small.quality, small.quality)
    provenance = small.provenance
    nothing = CampaignDifferences(NAMES, provenance, provenance, qualities, True, (), ())
    return lambda *values, p=1e-3: replace(nothing, breakaways=rows(*values, p=p))


def verdict_of(differences):
    page = ordinary_spaces(differences_page(differences, ()))
    return page[page.index('<p class="verdict"') : page.index("<dl")]


def test_the_verdict_states_direction_and_size_of_what_is_significant(made):
    assert "In 2 of 3 cases, breakaway of &lt;after&gt; is lower than that of before by" in (
        verdict_of(made(-40.0, -60.0, -8.0))
    )
    assert "40–60 N, or 6.7–10 % (U up to 15 N)" in verdict_of(made(-40.0, -60.0, -8.0))
    both = verdict_of(made(-40.0, 60.0))
    assert "is higher than that of before by 60 N" in both
    assert "and in the others lower than that of before by 40 N" in both


def test_without_a_significant_difference_the_largest_is_stated(made):
    words = verdict_of(made(5.0, -9.0, p=0.4))
    assert "No difference of breakaway is significant in any of 2 cases" in words
    assert "the largest is −9 N (U 15 N)." in words
    assert "in the only case" in verdict_of(made(5.0, p=0.4))


def test_a_significant_difference_may_be_that_of_a_mounting(made):
    assert "U does not contain a new mounting: before acting" in verdict_of(made(-40.0, -60.0))
    assert "mounting" not in verdict_of(made(5.0, p=0.4))
    (row,) = made(-40.0).breakaways
    by_trials = replace(row, breakaway_n=replace(row.breakaway_n, u95=None))
    words = verdict_of(replace(made(-40.0), breakaways=(by_trials,)))
    assert "The interval does not contain a new mounting" in words


def test_page_terminal_and_json_have_a_row_for_each_case(made):
    differences = made(-40.0, -60.0)
    page = ordinary_spaces(differences_page(differences, ()))
    assert "Breakaway of two campaigns" in page and "efficiency" not in page.partition("<h2")[0]
    assert "−60 ± 15" in page and "same time at rest" in page
    assert "Speeds within 2 %" not in page, "no curve is compared"
    noted = replace(differences, notes=("breakaway retracting -500 N after 1 s: only in A",))
    assert "retracting −500 N after 1 s: only in A" in ordinary_spaces(differences_page(noted, ()))
    text = differences_text(differences)
    assert "In 2 of 2 cases" in text and "Breakaway (N)" in text
    (first, second) = json.loads(differences_json(differences))["breakaways"]
    assert first["dwell_s"] == 1.0 and second["dwell_s"] == 10.0
    assert second["breakaway_n"]["difference"] == -60.0 and second["breakaway_n"]["real"]
    assert second["direction"] == "extend" and second["rate_n_s"] == 500.0


def test_columns_that_no_row_knows_are_left_out(made):
    differences = made(-40.0)
    (row,) = differences.breakaways
    unknown = replace(row.a, dwell_s=None, rate_n_s=None)
    page = differences_page(replace(differences, breakaways=(replace(row, a=unknown),)), ())
    assert "At rest" not in page and "Rate" not in page


def test_the_figure_has_both_campaigns_and_their_difference_in_a_row_for_each_case(made):
    differences = made(-40.0, 20.0, -8.0, p=1e-3)
    (drawing,) = draw_differences(differences)
    page = ordinary_spaces(differences_page(differences, (drawing,)))
    section = page[page.index('<h2 id="breakaway"') : page.index("<h2", page.index("Table 1."))]
    assert "Figure 1. Breakaway." in section and "largest friction while a rising force" in section
    assert "U of A and of B also contains" in section
    rows = list(csv.DictReader(StringIO(drawing.csv.decode())))
    cases = ["extending, 1 s", "extending, 10 s", "extending, 60 s"]
    for series, name in (("A: before", "Breakaway (N)"), ("B: <after>", "Breakaway (N)")):
        own = [row for row in rows if row["series"] == series]
        assert [row["item"] for row in own] == cases
        assert [float(row[name]) for row in own] == pytest.approx([600.0] * 3, rel=0.02)
    found = {row["item"]: row for row in rows if row["series"].startswith("B − A")}
    assert [float(found[case]["B − A (N)"]) for case in cases] == [-40.0, 20.0, -8.0]
    assert all(float(row["U95 (N)"]) == 15.0 for row in found.values())
    filled = {row["item"] for row in rows if row["series"] == "B − A, real"}
    assert filled == {"extending, 1 s", "extending, 10 s"}, "8 N is within U"


def test_the_name_of_a_case_has_what_distinguishes_it_and_no_more(made):
    three = made(-40.0, -60.0, -8.0).breakaways
    assert breakaway_names(three[:1]) == ["extending"]
    other = replace(three[1], a=replace(three[1].a, direction="retract", dwell_s=1.0))
    assert breakaway_names((three[0], other)) == ["extending", "retracting"]
    loaded = replace(three[0].a, series=replace(three[0].a.series, f_load_n=5000.0))
    cases = (three[0], replace(three[0], a=loaded))
    assert breakaway_names(cases) == ["extending, 2000 N", "extending, 5000 N"]
