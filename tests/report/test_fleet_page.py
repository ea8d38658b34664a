"""The page of a fleet, of tables whose truth is known."""

import csv
import json
import re
import warnings
from dataclasses import replace
from datetime import timedelta
from itertools import pairwise

import numpy as np
import pytest
from markupsafe import escape
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hbench.records import QUANTITIES, Trend
from hbench.records.conformity.acceptance import Requirement
from hbench.records.fleet.campaign_names import distinct_names
from hbench.records.fleet.campaigns import FleetNumber
from hbench.report.fleet.charts import chart_table, step_table
from hbench.report.fleet.dates import set_dates
from hbench.report.fleet.figures import draw_fleet
from hbench.report.fleet.names import range_words
from hbench.report.fleet.overview import fleet_tiles, overview_table
from hbench.report.fleet.page import fleet_document, fleet_page
from hbench.report.fleet.terminal import fleet_text
from hbench.report.fleet.text import (
    campaign_table,
    fleet_json,
    spread_table,
    trend_table,
    worst_table,
)
from hbench.report.fleet.verdict import fleet_verdict, further_sentences, stepped_numbers
from hbench.report.render import style
from hbench.sentences import uncapital
from hbench.store.campaign.stored_acceptance import stored_decision
from hbench.store.fleet.table import TABLE, cells_of, write_table
from tests.support.report.made_fleet import FAILURE, made_row, made_table, summary_of
from tests.support.report.spaces import ordinary_spaces

OFF = {17: 120.0, 60: -140.0, 150: 100.0}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fleet") / "out"
    name = "<b>=1+1\"'&amp;"
    made_table(folder, 200, drift_n=60.0, off=OFF, failed=(3, 8), noisy=(25,), name=name)
    report = folder / "line" / f"{name}0000017" / "results" / "report.html"
    report.parent.mkdir(parents=True)
    report.write_text("")
    return summary_of(folder)


@pytest.fixture(scope="module")
def drawings(found):
    return draw_fleet(found)


@pytest.fixture(scope="module")
def page(found, drawings):
    return fleet_page(found, drawings)


def spread(found, name, direction="extend"):
    return next(
        one for one in found.spreads if (one.quantity.name, one.direction) == (name, direction)
    )


def test_the_campaigns_that_are_off_are_the_outliers_worst_first(found):
    assert found.outliers == 3
    worst = [suspect.path[-3:] for suspect in found.worst[:3]]
    assert worst == ["060", "017", "150"]
    assert all(one.deviations[0].quantity.name == "friction_n" for one in found.worst[:3])
    assert "3 of 198" in fleet_verdict(found)


def test_a_drift_is_told_with_its_change_and_the_others_are_not(found):
    trend = spread(found, "friction_n").trend
    assert trend.real and trend.low < 60.0 * 197 / 200 < trend.high
    assert sum(one.trend.real for one in found.spreads) == 1
    (row,) = (row for row in overview_table(found).rows if row[0] == "Friction, extending (N)")
    assert "step at" in " ".join(row) or "drift: +" in " ".join(row)


def test_the_spread_between_cylinders_is_that_of_the_truth(found):
    assert spread(found, "friction_n", "retract").between == pytest.approx(9.0, rel=0.2)
    assert spread(found, "friction_n", "retract").se_trials == pytest.approx(4.0, rel=1e-6)
    assert spread(found, "efficiency").between == pytest.approx(0.002, rel=0.2)


def test_failed_campaigns_are_counted_with_their_reason_and_named(found, page):
    assert (found.campaigns, found.failed, found.compared) == (200, 2, 198)
    assert found.reasons == ((FAILURE, 2),)
    assert "2 of 200 campaigns" in page
    assert str(escape(FAILURE)) in page


def test_a_campaigns_name_stays_words_and_its_link_leads_to_its_report(found, page):
    links = re.findall(r'<a href="([^"#]*report\.html)">([^<]*)', page)
    assert set(links) == {
        ("line/%3Cb%3E%3D1%2B1%22%27%26amp%3B0000017/results/report.html",
         "&lt;b&gt;=1+1&#34;&#39;&amp;amp;0000017")
    }  # fmt: skip
    assert "<b>=1" not in page
    assert [bool(suspect.report) for suspect in found.worst[:3]] == [False, True, False]


def test_figures_have_words_and_data_and_name_the_unit(found, drawings):
    assert len({drawing.name for drawing in drawings}) == len(drawings) == 12
    for drawing in drawings:
        assert drawing.csv.count(b"\n") > 8 and len(drawing.seen) > 40
        assert re.search(rb"\((N|%|mm/s|N s/m)\)", drawing.csv)


@pytest.mark.slow
def test_every_figure_is_the_same_twice(found, drawings):
    again = draw_fleet(found)
    assert [one.svg for one in again] == [one.svg for one in drawings]


def test_the_page_of_many_campaigns_is_no_larger_and_holds_no_row_each(tmp_path, page):
    many = summary_of(made_table(tmp_path, 600, drift_n=60.0, off=OFF))
    text = fleet_page(many, draw_fleet(many))
    assert len(text) < 1.3 * len(page)
    assert many.outliers == 3 and len(fleet_json(many)) < 300_000
    assert sum(spread(many, "friction_n").counts) > 588


def test_a_few_campaigns_are_shown_and_not_compared(tmp_path, undrawn):
    few = summary_of(made_table(tmp_path, 4, off={2: 500.0}))
    assert few.outliers == 0 and few.worst == () and few.compared == 4
    assert "outlier" not in fleet_verdict(few)
    friction = next(one for one in few.spreads if one.quantity.name == "friction_n")
    values = [row.numbers[friction.quantity.column(friction.direction)].value for row in few.rows]
    assert (friction.low, friction.high) == (min(values), max(values))
    assert "(smallest to largest of 4 campaigns; 95 % intervals up to ±" in fleet_verdict(few)
    assert all(one.trend is None and len(one.blocks) == 4 for one in few.spreads)
    assert re.search(r"<h1>[^<]* 4 ", fleet_page(few, draw_fleet(few)))
    assert "Next step" not in fleet_verdict(few)  # without limits
    passed = fleet_verdict(replace(few, decisions=(("PASS", 4),)))
    assert passed.endswith("Next step: none; changes over time are tested from 10 campaigns on.")
    failed = fleet_verdict(replace(few, decisions=(("FAIL", 1), ("PASS", 3))))
    assert "Next step: none" not in failed


def test_incomplete_campaigns_and_poor_data_are_named_before_the_comparison(tmp_path):
    rng = np.random.default_rng(4)
    rows = [made_row(i, rng, f"/line/{i}", i) for i in range(4)]
    rows[1] = replace(rows[1], quality="poor", missing="9 of 96 planned runs were not completed")
    write_table(tmp_path / TABLE, map(cells_of, rows))
    found = summary_of(tmp_path)
    assert fleet_verdict(found).startswith(
        "1 of 4 analysed campaigns is incomplete. 1 of 4 analysed campaigns has poor data."
    )
    text = fleet_text(found)
    assert "data: poor; incomplete: 9 of 96 planned runs" in text
    assert text.count("incomplete:") == 1 and "9 of 96" in fleet_page(found, ())


def test_the_tile_names_the_checks_by_which_the_data_is_not_good(tmp_path):
    rng = np.random.default_rng(4)
    rows = [made_row(i, rng, f"/line/{i}", i) for i in range(4)]
    rows[1] = replace(rows[1], quality="with care", weak="instruments, drift")
    rows[2] = replace(rows[2], quality="with care", weak="instruments")
    write_table(tmp_path / TABLE, map(cells_of, rows))
    found = summary_of(tmp_path)
    all_rows = replace(found, qualities=(("with care", 4),), weak_checks=(("instruments", 4),))
    assert "data: 4 with care (because of instruments)" in fleet_page(all_rows, ())
    page = fleet_page(found, ())
    assert "data: 2 good, 2 with care (because of instruments in 2, drift in 1)" in page


def test_where_all_have_failed_the_page_says_why(tmp_path):
    none = summary_of(made_table(tmp_path, 3, failed=(0, 1, 2)))
    assert none.spreads == () and draw_fleet(none) == ()
    assert fleet_verdict(none) in fleet_page(none, ())
    assert "3 failed" in fleet_text(none)


def test_the_terminal_gets_ascii_and_json_the_verdicts(found):
    text = fleet_text(found)
    assert text.isascii() and "outlier" in text and "drift or step" not in text
    assert "Significant drift from the first to the last" in fleet_text(replace(found, charts=()))
    document = json.loads(fleet_json(found))
    assert document["schema"] == "hbench.fleet/1"
    assert [one["outlier"] for one in document["worst"]].count(True) == 3
    assert sum(one["trend"]["real"] for one in document["spreads"]) == 1
    assert document["first"].startswith("2026-03-02")


def test_decisions_are_counted_and_ppk_stands_on_page_in_text_and_json(tmp_path, undrawn):
    made_table(tmp_path, 12)
    requirement = Requirement("friction", "N", low=None, high=900.0, name="ISO <b>")
    of_a_load = replace(requirement, f_load_n=500.0, name="loaded <b>")
    decisions = {f"{i:07}": "PASS" if i else "FAIL" for i in range(12)}
    limits = [requirement, of_a_load]
    fleet = summary_of(tmp_path, requirements=limits, decision=lambda p: decisions[p[-7:]])
    assert fleet.decisions == (("FAIL", 1), ("PASS", 11))
    assert {each.decision for each in fleet.rows} == {"FAIL", "PASS"}
    page, text = fleet_page(fleet, draw_fleet(fleet)), fleet_text(fleet)
    assert "Ppk" in text and "Cpk" in text and "1 FAIL, 11 PASS" in text
    assert "Capability" in page and "at most 900" in page
    assert any("limits: ISO <b>: friction" in tile.more for tile in fleet_tiles(fleet))
    without = "No Ppk for loaded <b>: friction, load 500 N (at most 900 N): it applies to one load"
    assert escape(without) in ordinary_spaces(page) and without[:60] in ordinary_spaces(text)
    assert json.loads(fleet_json(fleet))["capabilities"][0]["ppk"]["value"] == pytest.approx(
        fleet.capabilities[0].ppk.value
    )


def test_a_decision_is_read_from_the_campaign_alone(tmp_path):
    results = tmp_path / "a" / "results"
    results.mkdir(parents=True)
    assert stored_decision(tmp_path / "a") == ""
    for text, decision in (
        ('{"schema": "hbench.acceptance/1", "decision": "FAIL"}', "FAIL"),
        ('{"schema": "hbench.acceptance/1", "decision": "<b>"}', ""),
        ('{"schema": "another", "decision": "FAIL"}', ""),
        ("[", ""),
    ):
        (results / "acceptance.json").write_text(text)
        assert stored_decision(tmp_path / "a") == decision
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "results").symlink_to(results)
    (results / "acceptance.json").write_text(
        '{"schema": "hbench.acceptance/1", "decision": "FAIL"}'
    )
    assert stored_decision(tmp_path / "b") == ""


@pytest.fixture(scope="module")
def shifted(tmp_path_factory):
    """30 campaigns: friction extending rises by 35 N at number 18; four are of other kinds."""
    folder = tmp_path_factory.mktemp("shifted")
    rng = np.random.default_rng(3)
    other = {4: ("1257/766", "2000/1200"), 7: ("2000 N", "4000 N"), 11: ("35 mm/s", "80 mm/s")}
    rows = []
    for i in range(30):
        row = made_row(i, rng, str(folder / f"c{i:02d}"), float(i), off_n=35.0 * (i >= 18))
        kind = f"real, bench; {row.protocol}".replace(*other.get(i, ("", "")))
        kind = kind.replace("real, bench", "simulated, bench") if i == 13 else kind
        rows.append(cells_of(replace(row, specimen=f"S{i:02d}", protocol=kind)))
    write_table(folder / TABLE, rows)
    return summary_of(folder)


@pytest.mark.usefixtures("wide_terminal")
def test_charts_show_a_shift_by_ewma_rules_and_a_step(shifted):
    chart = next(
        c for c in shifted.charts if (c.quantity.name, c.direction) == ("friction_n", "extend")
    )
    assert chart.step.name == "c18" and chart.step.real
    assert chart.step.after - chart.step.before == pytest.approx(35.0, abs=12.0)  # 3 s.e.
    rules = " ".join(signal.rule for signal in chart.signals)
    assert "EWMA, λ = 0.1, L = 2.7" in rules and "Western Electric 4: eight on one side" in rules
    others = [c.step.real for c in shifted.charts if c.quantity.name != "friction_n"]
    assert not any(others)
    text = fleet_text(shifted)
    assert text.isascii() and "friction changed from c18 on." in text.lower()
    assert re.search(r"Friction, extending \(N\) .* step at c18: \+", text)
    assert "Western Electric" not in text  # the page has the charts
    document = json.loads(fleet_json(shifted))
    assert (
        document["charts"][0]["step"]["real"] is True and len(document["charts"][0]["ewma"]) == 26
    )


def test_charts_are_over_the_dates_of_the_campaigns_however_long_their_names_are(tmp_path):
    fleet = summary_of(made_table(tmp_path, 30, drift_n=90, off={7: 300.0}, name="W" * 200))
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of a layout without room
        drawings = draw_fleet(fleet)
    charts = [drawing for drawing in drawings if drawing.section in ("charts", "drifts")]
    assert charts
    for drawing in charts:
        head, first, *_ = csv.reader(drawing.csv.decode().splitlines())
        assert first[head.index("Start of the campaign (UTC)")] == f"{fleet.first:%Y-%m-%d %H:%M}"


@pytest.mark.parametrize("days", [0.06, 1.3, 14.0, 700.0])
def test_dates_below_a_figure_have_letters_of_full_size_and_do_not_overlap(shifted, days):
    fleet = replace(shifted, last=shifted.first + timedelta(days=days))
    figure = Figure(figsize=(style.WIDTH_IN, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    with rc_context(style.RC):
        axes = figure.add_subplot()
        axes.plot([0.0, days], [0.0, 1.0])
        set_dates(axes, fleet)
        figure.draw_without_rendering()
    low, high = axes.get_xlim()
    labels = [
        label
        for place, label in zip(axes.get_xticks(), axes.get_xticklabels(), strict=True)
        if low <= place <= high
    ]
    boxes = [label.get_window_extent() for label in labels]
    assert len(labels) >= 3 and all(re.search(r"\d{4}-\d\d-\d\d$", x.get_text()) for x in labels)
    assert {x.get_fontsize() for x in labels} == {axes.get_yticklabels()[0].get_fontsize()}
    gaps = [after.x0 - before.x1 for before, after in pairwise(boxes)]
    assert min(gaps) > 5.0
    assert boxes[0].x0 > 0 and boxes[-1].x1 < figure.bbox.width


def test_campaigns_of_less_than_a_day_have_no_slope_a_day(found):
    assert "Slope a day" in trend_table(found).head
    hours = replace(found, last=found.first + timedelta(hours=5))
    table = trend_table(hours)
    assert not any("Slope" in head for head in table.head)
    assert {len(row) for row in table.rows} == {len(table.head)}


def test_a_number_whose_mean_has_a_step_has_no_line_of_a_trend(shifted, undrawn):
    drawings = {drawing.name: drawing for drawing in draw_fleet(shifted)}
    assert ("friction_n", "extend") in {(q.name, side) for q, side in stepped_numbers(shifted)}
    friction = drawings["drift-friction-n"]
    assert "Extending, trend" not in friction.csv.decode()


def test_unlike_campaigns_are_grouped_with_the_reason(shifted):
    page = fleet_page(shifted, ())
    assert shifted.compared == 26
    for reason in ("cylinder size", "loads", "working speed", "bench or origin"):
        assert page.count(f"not compared: other {reason}<") == 2  # kinds and campaigns
    assert 'class="sortable"' in page and ">S29<" in page


def test_histograms_need_ten_campaigns(tmp_path, undrawn):
    few = summary_of(made_table(tmp_path, 9))
    names = {drawing.name for drawing in draw_fleet(few)}
    assert "drift-friction-n" in names and not any("distribution" in name for name in names)
    assert "from 10 campaigns on." in fleet_page(few, ())


def test_a_figure_names_the_direction_that_has_too_few_campaigns_for_a_trend(found, undrawn):
    def caption(*few):
        spreads = tuple(
            replace(one, n=9, trend=None) if one.direction in few else one for one in found.spreads
        )
        drawings = draw_fleet(replace(found, spreads=spreads))
        return next(one.caption for one in drawings if one.name == "drift-friction-n")

    assert "Not tested" not in caption()
    assert "Not tested: retracting, with fewer than 10." in caption("retract")
    assert "Not tested" not in caption("extend", "retract")


def test_values_have_four_digits_however_wide_their_intervals_are(tmp_path, undrawn):
    few = summary_of(made_table(tmp_path, 4))
    rows = [
        replace(row, numbers={
            name: n and replace(n, low=n.value - 107.2, high=n.value + 107.2)
            for name, n in row.numbers.items()
        })
        for row in few.rows
    ]  # fmt: skip
    page = ordinary_spaces(fleet_page(replace(few, rows=tuple(rows)), ()))
    value = rows[0].numbers["friction_extend_n"].value
    assert f"{value:.1f}</td>" in page
    assert "friction, extending ±110 N" in page and "± 110" not in page  # once, not in each row


def test_sigma_between_campaigns_has_its_interval_and_few_campaigns_have_none(tmp_path, found):
    for direction, truth in (("extend", None), ("retract", 9.0)):
        one = spread(found, "friction_n", direction)
        assert 0 < one.between_low < one.between < one.between_high < 1.5 * one.between
        assert truth is None or one.between_low < truth < one.between_high
    column = [row[4] for row in spread_table(found).rows]
    assert all(re.fullmatch(r"[\d.]+ (± [\d.]+|\([\d.]+ to [\d.]+\))", cell) for cell in column)
    few = spread_table(summary_of(made_table(tmp_path, 4)))
    assert "σ by the trials" in few.head and not any("between" in cell for cell in few.head)


def test_the_limit_of_an_outlier_is_where_its_p_is_significant(found):
    for suspect in found.worst:
        for deviation in suspect.deviations:
            assert deviation.outlier == (abs(deviation.z) > deviation.limit)
    (*_, z, limit, _, verdict), *_ = worst_table(found, 1).rows
    assert verdict == "outlier" and float(z.strip("−+")) > float(limit) > 3  # of many values


def test_the_means_of_a_step_differ_by_the_size_that_is_shown(shifted):
    rows = step_table(shifted).rows
    assert len(rows) > 3
    for row in rows:
        before, after, size = (float(cell.split(" ±")[0].replace("−", "-")) for cell in row[2:5])
        decimals = len(row[4].split(" ±")[0].partition(".")[2])
        assert abs(after - before - size) <= 0.61 * 10**-decimals  # both with a further decimal


def test_a_campaign_has_its_folders_name_and_a_path_only_where_two_have_the_same():
    assert distinct_names(["/a/line/HC-1", "/a/line/HC-2"]) == {
        "/a/line/HC-1": "HC-1", "/a/line/HC-2": "HC-2"
    }  # fmt: skip
    names = distinct_names(["/a/b/HC-1", "/a/c/HC-1", "/a/c/HC-2"])
    assert list(names.values()) == ["b/HC-1", "c/HC-1", "HC-2"]


def test_campaigns_in_folders_of_the_same_name_are_named_by_their_paths(tmp_path):
    rng = np.random.default_rng(4)
    rows = [made_row(i, rng, f"/line/c{i:02d}/import", i, 60.0 * (i >= 18)) for i in range(26)]
    write_table(tmp_path / TABLE, map(cells_of, rows))
    found = summary_of(tmp_path)
    assert "Friction changed from c18/import on." in ordinary_spaces(fleet_verdict(found))
    outside = next(chart.outside for chart in found.charts if chart.outside)
    assert all(re.fullmatch(r"c\d\d/import", name) for name in outside)


def test_the_verdict_names_campaigns_beyond_a_limit_and_what_to_do_about_a_step(shifted):
    passed = replace(shifted, decisions=(("PASS", shifted.campaigns),))
    assert "Next step: none" not in fleet_verdict(passed)
    verdict = fleet_verdict(shifted)
    assert re.search(
        r"Friction changed from c18 on\. The change of friction is \+[\d.]+ ± [\d.]+ N "
        r"\([\d.]+ %\) extending: "
        "check whether the cylinders, the bench or its instruments changed there.",
        ordinary_spaces(verdict),
    )
    assert " have the decision PASS, but friction changed from c18 on." in fleet_verdict(passed)
    names = ("C-4", "C-7", "C-9", "C-11")
    charts = (replace(shifted.charts[0], outside=names), *shifted.charts[1:])
    verdict = fleet_verdict(replace(shifted, charts=charts))
    assert (
        f"4 of {shifted.compared} campaigns are beyond a control limit of the campaigns before the "
        "change (C-4, C-7, C-9, C-11)."
    ) in verdict
    steady = tuple(replace(chart, step=None, n_limits=chart.n) for chart in charts)
    assert "beyond a control limit (C-4" in fleet_verdict(replace(shifted, charts=steady))
    weak = replace(shifted, weak_checks=(("drift", 5),), drift_possible=0.351)
    drift = "A drift within campaigns may also cause this: the data of "
    some = f"{drift}5 of 26 allow one (up to 36 % in the worst)."
    assert some in fleet_verdict(weak)
    every = replace(weak, weak_checks=(("drift", 26),))
    assert f"{drift}all 26 allow one (" in fleet_verdict(every)
    assert drift not in fleet_verdict(shifted)


def test_the_top_of_the_page_has_few_tiles_and_counts_each_change_once(shifted, undrawn):
    (summary, *_) = fleet_document(shifted, ()).sections
    assert 4 <= len(summary.tiles) <= 7
    assert summary.tiles[0].value == "30 of 30" and "data: " in summary.tiles[0].more
    tiles = {tile.unit: tile for tile in summary.tiles}
    steps, drifts = tiles["numbers with a step"], tiles["numbers with a drift"]
    assert (steps.value, steps.more) == (f"1 of {len(shifted.charts)}", "of the mean, from c18 on")
    others = [one for one in shifted.spreads if one.trend is not None][1:]
    assert drifts.value == f"0 of {len(others)}"
    assert drifts.more == "of those without a step"


def test_the_charts_of_a_number_that_changed_are_in_the_summary_which_does_not_repeat_it(
    shifted, found, undrawn
):
    drawings = draw_fleet(shifted)
    summary, *_ = fleet_document(shifted, drawings).sections
    table = summary.tables[0]
    column = dict(zip((row[0] for row in table.rows), (row[3] for row in table.rows), strict=True))
    assert re.fullmatch(r"step at c18: \+.*", column["Friction, extending (N)"])
    assert column["Friction, retracting (N)"].startswith("not significant: ")
    charts = ["control-friction-n-extend", "control-friction-n-retract"]
    assert [drawing.name for drawing in summary.drawings] == charts
    assert len(summary.parts) == 3 and all(part.folded for part in summary.parts)
    both = [d.caption for d in drawings if d.name.startswith("control-friction-n-")]
    assert len(both) == 2 and "Rings: beyond the limits;" in both[0]
    said = " ".join(summary.items)
    assert "has changed" not in said and "beyond the limits" not in said


def test_breakaway_that_changes_against_friction_is_stated(shifted):
    chart = next(c for c in shifted.charts if c.quantity.name == "friction_n")
    (breakaway,) = (q for q in QUANTITIES if q.name == "breakaway_fit_n")
    falls = Trend(-11.3, -17.2, -1.8, 640.0, 0.014)
    of_fit = replace(spread(shifted, "friction_n"), quantity=breakaway, trend=falls)

    def said(trend):
        spreads = (*shifted.spreads, replace(of_fit, trend=trend))
        return " ".join(further_sentences(replace(shifted, spreads=spreads)))

    assert chart.step.after > chart.step.before
    text = ordinary_spaces(said(falls))
    assert "extending, falls while friction rises: by −11.3 (−17.2 to −1.8) N (p = 0.014" in text
    assert "kind breakaway" in text
    assert "while friction" not in said(replace(falls, p_holm=0.14))
    assert "while friction" not in said(Trend(11.3, 1.8, 17.2, 640.0, 0.014))


def test_a_number_is_rounded_by_its_interval_unless_the_rows_share_it(shifted):
    """Equal intervals are stated once, and the rows then keep the digits in which they differ."""

    def friction(halves):
        numbers = zip((0.6874e3, 0.6911e3), halves, strict=True)
        rows = tuple(
            replace(row, numbers=row.numbers | {name: FleetNumber(v, v - half, v + half)})
            for row, (v, half) in zip(shifted.rows[:2], numbers, strict=True)
        )
        table = campaign_table(replace(shifted, rows=rows))
        column = next(i for i, head in enumerate(table.head) if head.startswith("Friction, ext"))
        return [row[column] for row in table.rows]

    name = "friction_extend_n"
    assert name in shifted.rows[0].numbers
    assert friction((340.0, 110.0)) == ["690 ± 340", "690 ± 110"]
    assert friction((110.0, 110.0)) == ["687.4", "691.1"]


def test_cylinders_have_a_column_only_where_their_folders_have_other_names(shifted):
    def head(names):
        rows = tuple(
            replace(row, path=f"/line/{name}", specimen="S-1")
            for row, name in zip(shifted.rows, names, strict=False)
        )
        return campaign_table(replace(shifted, rows=rows)).head

    assert "Cylinder" in head(["S-1", "c2"]) and "Cylinder" not in head(["S-1"])


def test_campaigns_are_listed_by_the_numbers_in_their_names(tmp_path):
    rng = np.random.default_rng(4)
    paths = sorted(f"/line/{name}" for name in ("1", "2", "9", "10", "11", "100"))
    write_table(
        tmp_path / TABLE, (cells_of(made_row(i, rng, path, i)) for i, path in enumerate(paths))
    )
    names = [row[0] for row in campaign_table(summary_of(tmp_path)).rows]
    assert names == ["1", "2", "9", "10", "11", "100"]


def test_names_of_people_keep_their_capitals_in_headings(found, drawings):
    text = fleet_page(found, drawings)
    assert "Figures: Stribeck speed" in text and "Figures: friction" not in text
    assert uncapital("Stribeck speed") == "Stribeck speed" and uncapital("Friction") == "friction"


def test_a_campaign_is_compared_with_those_on_its_side_of_a_step(tmp_path):
    """A low value before a step of +40 N deviates, one step lower than the later ones does not."""
    rng = np.random.default_rng(4)
    rows = [made_row(i, rng, f"/line/c{i}", i, 60.0 * (i >= 18)) for i in range(26)]
    write_table(tmp_path / TABLE, map(cells_of, rows))
    found = summary_of(tmp_path)
    chart = next(c for c in found.charts if c.quantity.name == "friction_n")
    assert chart.step.real and chart.n_limits == 18
    values = [row.numbers["friction_n", "extend"].value for row in rows]
    expected = {
        suspect.path: deviation.median
        for suspect in found.worst
        for deviation in suspect.deviations
        if (deviation.quantity.name, deviation.direction) == ("friction_n", "extend")
    }
    assert {*expected.values()} == {np.median(values[:18]), np.median(values[18:])}
    assert all((m > 400) == (int(path[7:]) >= 18) for path, m in expected.items())
    table = chart_table(found)
    (row,) = [row for row in table.rows if row[0] == "Friction, extending (N)"]
    assert row[table.head.index("Mean and limits from")] == "the first 18"


@pytest.mark.usefixtures("wide_terminal")
def test_a_terminals_columns_are_aligned_where_signs_are_spelled_out(found):
    lines = fleet_text(found).splitlines()
    at = lines.index("Largest deviations")
    end = lines[at + 1].index("Outlier beyond") + len("Outlier beyond")
    assert lines[at + 2][:end].endswith("(s.d.)")
    assert all(line[end - 1].isdigit() and line[end] == " " for line in lines[at + 3 : at + 6])


def test_no_line_of_a_fleet_is_wider_than_a_terminal(found):
    assert max(map(len, fleet_text(found).splitlines())) <= 80


def test_one_campaign_has_no_smallest_and_largest():
    assert range_words(1) == "one campaign"
    assert range_words(2) == "smallest to largest of 2 campaigns"
