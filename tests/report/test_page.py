"""The page: self-contained, escaped, and honest about what it shows."""

import html
import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser
from urllib.parse import unquote_to_bytes

import pytest

from hbench.analysis.screening.screen import CODES
from hbench.records import (
    Completeness,
    Fit,
    FitParameter,
    HeldOut,
    JointFit,
    PointTrials,
    Quality,
    QualityCheck,
    Selection,
)
from hbench.records.friction_laws import FRICTION_LAWS, PARAMETERS
from hbench.report.campaign.figures.all_figures import draw_all
from hbench.report.campaign.fit_tables import selection_words
from hbench.report.campaign.page import report_document
from hbench.report.campaign.page_tables import budget_table, cause_table, rejected_table
from hbench.report.campaign.quality.completeness import short_point_table
from hbench.report.campaign.quality.tables import quality_table
from hbench.report.campaign.quality.verdict import next_step, quality_verdict
from hbench.report.campaign.reasons import CAUSES
from hbench.report.render.document import Section, anchor
from hbench.report.render.document import page as page_of
from hbench.report.render.numbers import (
    force,
    half_width,
    in_mm_s,
    number,
    short,
    significant,
    span,
    span_with_intervals,
    whole_mm_s,
    with_interval,
)
from hbench.report.render.style import DARK
from tests.support.report.made_page import page_html, summarized
from tests.support.report.spaces import ordinary_spaces

VOID = {"meta", "img", "br", "link", "input", "hr"}
HOSTILE = "<script>alert(1)</script>\"'><img src=x onerror=alert(1)>&{{7*7}}"


class Parsed(HTMLParser):
    """Collects tags, attributes and text; fails where tags don't nest."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.attributes, self.words, self.open = [], [], [], []
        self.feed(html)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def page(small, drawings):
    return page_html(small, drawings)


def test_the_page_needs_nothing_else(page):
    parsed = Parsed(page)
    assert not {"link", "iframe", "object", "img"} & set(parsed.tags)
    for name, value in parsed.attributes:
        if name in ("src", "href"):
            assert value.startswith(("data:text/csv;", "#"))
        assert not name.startswith("on")
    assert "url(" not in page.replace("url(#", "") and "@import" not in page


def test_the_only_script_is_the_one_whose_hash_the_page_tells_the_browser(page):
    assert Parsed(page).tags.count("script") == 1
    (script,) = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    digest = b64encode(sha256(script.encode()).digest()).decode()
    policy = f"img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{digest}'"
    assert f"default-src 'none'; {policy}" in page


def test_links_of_the_page_lead_somewhere(page):
    attributes = Parsed(page).attributes
    ids = {value for name, value in attributes if name == "id"}
    links = {value for name, value in attributes if name == "href"}
    inside = {link[1:] for link in links if link.startswith("#")}
    assert len(inside) > 30 and inside <= ids


def test_every_figure_is_shown_once_with_words_for_those_who_do_not_see_it(page, drawings):
    parsed = Parsed(page)
    assert parsed.tags.count("figure") == len(drawings)
    labels = [value for name, value in parsed.attributes if name == "aria-label"]
    assert [label for label in labels if label in {d.seen for d in drawings}] == [
        drawing.seen for drawing in drawings
    ]
    assert f"Figure {len(drawings)}." in parsed.text


def test_no_two_elements_have_the_same_name(page):
    names = [value for name, value in Parsed(page).attributes if name == "id"]
    assert len(names) == len(set(names))


def test_the_data_of_every_figure_is_behind_its_link(page, drawings):
    links = [value for name, value in Parsed(page).attributes if name == "href"]
    data = [unquote_to_bytes(one.partition(",")[2]) for one in links if one.startswith("data:")]
    assert data == [drawing.csv for drawing in drawings]


def test_colours_of_figures_follow_the_page_into_the_dark(page):
    assert "var(--c0072b2,#0072b2)" in page and "--c0072b2: #4aa8e8;" in page
    drawn_colours = set(re.findall(r"(?:fill|stroke): (#[0-9a-f]{6})", page))
    assert not drawn_colours & set(DARK)


@pytest.mark.parametrize(
    "source,word", [("simulated", "Simulated"), ("imported", "Imported"), ("real", "Measured")]
)
def test_the_banner_says_where_the_numbers_come_from(small, source, word):
    results = replace(small, provenance=replace(small.provenance, source=source))
    html = page_html(results, ())
    assert re.search(rf'class="banner {source}">{word}\b', html)


def test_hostile_names_are_text_wherever_they_stand(small):
    fit = small.curves[0].fits[0]
    curve = replace(
        small.curves[0],
        label=HOSTILE,
        fits=(
            replace(
                fit,
                law=HOSTILE,
                message=HOSTILE,
                parameters={HOSTILE: fit.parameters["f_stiction_n"]},
            ),
        ),
    )
    run = replace(small.runs[0], reasons=(HOSTILE,))
    run = replace(run, run=replace(run.run, plan=replace(run.run.plan, run=HOSTILE, label=HOSTILE)))
    noted = replace(small.runs[1], notes=(HOSTILE,))
    provenance = replace(
        small.provenance,
        name=HOSTILE,
        bench=HOSTILE,
        firmware=HOSTILE,
        started=HOSTILE,
        software={HOSTILE: HOSTILE},
        details={HOSTILE: {HOSTILE: [HOSTILE]}},
    )
    eta = small.efficiency[0]
    eta = replace(
        eta, label=HOSTILE, points=(replace(eta.points[0], reason=HOSTILE), *eta.points[1:])
    )
    results = replace(
        small,
        provenance=provenance,
        curves=(curve,),
        runs=(run, noted),
        efficiency=(eta,),
        notes=(HOSTILE,),
    )
    html = page_html(results, draw_all(results))
    parsed = Parsed(html)
    assert parsed.tags.count("script") == 1  # the page's own
    assert not any(name.startswith("on") for name, _ in parsed.attributes)
    assert "<img" not in html
    assert "{{7*7}}" in parsed.text and "49}" not in parsed.text


def test_an_active_bound_is_flagged_with_its_message(page, small):
    text = Parsed(page).text
    message = small.curves[0].fits[0].message.replace("F_C", "F C")
    assert f"extending, 500 N {message}" in text
    assert len(re.findall(r"\b0 at lower \w+", text)) == len(re.findall(r"\bat lower\b", text)) == 1


def test_the_report_begins_with_friction_and_its_uncertainty_unless_the_data_is_poor(small):
    verdict = report_document(small, ()).verdict
    ends = [
        round(end(s.friction_n.value for s in small.headline.series if s.direction == direction))
        for direction in ("extend", "retract")
        for end in (min, max)
    ]
    sides = r"(\d+)–(\d+) N extending and (\d+)–(\d+) N retracting \("
    first = re.match(rf"Friction at \S+ mm/s is {sides}", verdict)
    assert list(map(int, first.groups())) == ends
    assert ", over all loads. " in verdict
    poor = replace(small, quality=replace(small.quality, grade="poor"))
    document = report_document(poor, ())
    assert "mm/s is" not in document.verdict
    (tiles,) = (each.tiles for each in document.sections if each.title == "Summary")
    assert [tile.unit for tile in tiles] == ["runs", ""] and tiles[1].value == "Poor"


def test_the_share_of_u_follows_from_numbers_that_are_not_rounded(small):
    first = small.headline.series[0]

    def of(value, u95):
        number = replace(first.friction_n, value=value, u95=u95, basis="trials")
        return replace(first, friction_n=number)

    series = (of(405.9, 121.7), of(405.1, 88.7))  # written: 410 ± 120 (29.3 %) and 405 ± 89
    changed = replace(small, headline=replace(small.headline, series=series))
    assert "U up to 120 N, 22–30 % of the value" in report_document(changed, ()).verdict


def test_the_ends_of_a_range_are_rounded_as_in_the_table_of_all_values(small):
    def wide(number):
        return replace(number, u95=150.0, basis="trials")

    series = tuple(replace(s, friction_n=wide(s.friction_n)) for s in small.headline.series)
    document = report_document(replace(small, headline=replace(small.headline, series=series)), ())
    rows = document.sections[0].tables[0]
    column = rows.head.index("Friction ± U (N)")
    for direction in ("extending", "retracting"):
        own = [row for row in rows.rows if direction in [cell.text for cell in row]]
        values = [row[column].text.partition(" ± ")[0] for row in own]
        ends = f"{min(values, key=int)}–{max(values, key=int)} N {direction}"
        assert all(int(value) % 10 == 0 for value in values) and ends in document.verdict


def test_the_table_of_results_has_the_forces_that_the_efficiency_is_made_of(small):
    table = report_document(small, ()).sections[0].tables[0]
    rows = [dict(zip(table.head, (cell.text for cell in row), strict=True)) for row in table.rows]
    for row in rows:
        numbers = (row[name].split(" ± ")[0].replace("−", "-") for name in (
            "Load cell F_applied (N)", "Friction ± U (N)", "Efficiency ± U (%)"))  # fmt: skip
        applied, friction, efficiency = map(float, numbers)
        sign = 1 if row["Direction"] == "extending" else -1
        ratio = applied / (applied + sign * friction)
        assert efficiency == pytest.approx(100 * min(ratio, 1 / ratio), abs=0.1)


def test_digits_show_whether_a_half_width_exceeds_its_value(small):
    """1545 is below 1547; with two digits of the half-width, 1550 would be above 1500."""
    curve, *others = small.curves
    parameter = FitParameter(-1547.1, 700.0, (-3289.4, -200.0), None, "N", {})
    fit = replace(curve.fits[0], parameters=curve.fits[0].parameters | {"f_coulomb_n": parameter})
    curves = (replace(curve, fits=(fit, *curve.fits[1:])), *others)
    text = Parsed(page_html(replace(small, curves=curves), ())).text
    assert "−1550 (−3290 to −200)" in text


def test_an_interval_that_only_linearised_is_too_wide_is_shown_with_it(small):
    curve, *others = small.curves
    interval, linearised = (0.0, 196.0), (-29.0, 233.0)
    parameter = FitParameter(
        102.0, 47.0, interval, None, "N", {"linearised": linearised}, wide=True
    )
    fit = replace(curve.fits[0], parameters=curve.fits[0].parameters | {"f_coulomb_n": parameter})
    curves = (replace(curve, fits=(fit, *curve.fits[1:])), *others)
    assert "102 (0 to 196) linearised ±130" in Parsed(
        page_html(replace(small, curves=curves), ())
    ).text.replace("\n", " ")


def test_an_interval_that_a_bound_cuts_off_has_no_linearised_one_beside_it(small):
    """(0 to 330) of 240 N: the linearised half-width of 200 N is below the value."""
    curve, *others = small.curves
    ends = {"linearised": (40.0, 440.0)}
    parameter = FitParameter(240.0, 90.0, (0.0, 330.0), None, "N", ends, wide=True)
    fit = replace(curve.fits[0], parameters=curve.fits[0].parameters | {"f_coulomb_n": parameter})
    curves = (replace(curve, fits=(fit, *curve.fits[1:])), *others)
    text = Parsed(page_html(replace(small, curves=curves), ())).text.replace("\n", " ")
    assert "240 (0 to 330)" in text and "(0 to 330) linearised" not in text
    assert "is cut off by a bound of the fit" in text


def test_a_tile_of_some_series_counts_them(small):
    first, *others = small.headline.series
    headline = replace(small.headline, series=(replace(first, friction_n=None), *others))
    document = report_document(replace(small, headline=headline), ())
    some = f"{len(others)} of {len(others) + 1} loads and directions"
    assert some in " ".join(map(str, document.sections[0].tiles))
    assert f", over {some}." in document.verdict
    labelled = (replace(first, friction_n=None, label="no load"), *others)
    document = report_document(
        replace(small, headline=replace(small.headline, series=labelled)), ()
    )
    assert f", over {len(others)} of {len(others) + 1} series." in document.verdict


def test_the_verdict_and_the_tile_round_the_same_friction_alike(small):
    first, second, *_ = small.headline.series
    known = first.friction_n
    values = (("extend", 448.6, 88.9), ("extend", 503.9, 100.1), ("retract", 509.7, 82.9))
    series = tuple(
        replace(second, direction=way, friction_n=replace(known, value=value, u95=half))
        for way, value, half in values
    )
    headline = replace(small.headline, series=series)
    document = report_document(replace(small, headline=headline), ())
    assert "450–500 N extending and 510 N retracting" in ordinary_spaces(document.verdict)
    assert document.sections[0].tiles[0].value == "450–510"


def test_a_load_cell_that_differs_from_the_set_load_is_explained_without_efficiency_too(small):
    def explanation(difference_n):
        curves = tuple(
            replace(c, points=tuple(replace(p, f_applied_n=c.f_load_n + difference_n)
                                    for p in c.points))
            for c in small.curves
        )  # fmt: skip
        series = tuple(replace(each, efficiency=None) for each in small.headline.series)
        headline = replace(small.headline, series=series)
        document = report_document(replace(small, curves=curves, headline=headline), ())
        return dict(document.sections[0].parts[0].facts).get("Load", "")

    assert "by the friction of the load cylinder" in explanation(300.0)
    assert explanation(0.2) == ""


def test_the_summary_names_the_checks_that_are_not_good_and_the_next_step(small):
    checks = tuple(replace(check, grade="good") for check in small.quality.checks)
    good = replace(small, quality=replace(small.quality, checks=checks))
    weak = [
        replace(check, grade="with care") if check.name == "repeatability" else check
        for check in checks
    ]
    other = replace(small, quality=replace(small.quality, checks=tuple(weak)))
    steps = []
    for results in (good, other):
        steps.append(report_document(results, ()).verdict.partition("Next step: ")[2])
    assert steps[0] == "" and steps[1].startswith("make more trials of each point")


def test_the_page_states_whether_a_decision_takes_the_reservation_on_the_data_into_account(small):
    """U contains the tolerances and the scatter of the trials, but no hidden drift."""
    section = Section("Decision", ("PASS: all.",))

    def made(*names, **more):
        checks = tuple(
            replace(check, grade="with care" if check.name in names else "good", value=19.0)
            for check in small.quality.checks
        )
        quality = replace(small.quality, grade="with care", checks=checks)
        document = report_document(replace(small, quality=quality), (), decision=section, **more)
        verdict, _, step = document.verdict.partition(" Next step: ")
        assert [each.title for each in document.sections[:2]] == ["Decision", "Summary"]
        return verdict, step, dict(document.sections[1].facts)["Data"]

    verdict, step, data = made("instruments")
    assert verdict == (
        "PASS: all. Use the data with care (instruments); U takes this into account."
    )
    assert step == ""
    verdict, _, _ = made("instruments", complete_u="U of friction")
    assert verdict.endswith("U of friction takes this into account.")
    assert made("instruments", complete_u="")[0].endswith("U does not take this into account.")
    assert "make friction uncertain by" in data and "Calibrate the sensors" in data
    verdict, step, _ = made("instruments", "trials_per_point")
    assert verdict.endswith("instruments); U takes only a part of this into account.")
    assert step.startswith("make at least three trials") and "alibrate" not in step
    assert made("trials_per_point")[0].endswith("U does not take this into account.")
    _, step, data = made("instruments", step="repeat it")
    assert step == "repeat it." and "Calibrate the sensors" in data
    undecided = report_document(small, ())
    assert "U takes" not in undecided.verdict
    assert "Data" not in dict(undecided.sections[0].facts)


def test_tolerances_are_stated_in_the_bench_file_or_else_in_the_map_of_an_import(small):
    def quality(uncertain_by: float | None):
        checks = tuple(
            replace(check, grade="with care", value=uncertain_by)
            if check.name == "instruments"
            else replace(check, grade="good")
            for check in small.quality.checks
        )
        return replace(small.quality, grade="with care", checks=checks)

    assert next_step(quality(20.0), "").endswith("state the new tolerances in the bench file.")
    assert next_step(quality(None), "") == "State the tolerances of the sensors in the bench file."
    quality = quality(20.0)
    imported = replace(small, quality=quality)
    imported = replace(imported, provenance=replace(small.provenance, source="imported"))
    step = report_document(imported, ()).verdict
    assert step.endswith("state the new tolerances in the map, then import again.")


def test_the_next_step_of_poor_data_is_that_of_its_poor_checks_and_refers_to_the_reasons(stribeck):
    grades = {"runs_accepted": "poor", "instruments": "with care"}
    checks = tuple(
        replace(check, grade=grades.get(check.name, "good")) for check in stribeck.quality.checks
    )
    poor = replace(stribeck.quality, grade="poor", checks=checks)
    document = report_document(replace(stribeck, quality=poor), ())
    text = Parsed(page_of(document)).text
    (number,) = re.findall(
        r"Next step: correct the causes of the rejected runs \(Table (\d+) states what to look "
        r"for\), then measure again\.(?! Calibrate)",
        text,
    )
    assert f"Table {number}. Reasons, and what to look for" in text


def test_how_breakaway_was_determined_is_in_the_head_if_all_series_share_it(small):
    assert "Breakaway ± U (N), extrapolated" in summary_table_of(small).head
    first, *others = small.headline.series
    measured = replace(first, breakaway_dwell_s=120.0)
    mixed = replace(small, headline=replace(small.headline, series=(measured, *others)))
    table = summary_table_of(mixed)
    cells = [row[table.head.index("Breakaway ± U (N)")] for row in table.rows]
    assert cells[0].text.endswith(" after 120 s at rest") and cells[1].flag == "extrapolated"


def test_a_quantity_that_no_series_has_has_no_column(small):
    assert "Breakaway ± U (N)" in Parsed(page_html(small, ())).text
    series = tuple(
        replace(each, breakaway_n=None, breakaway_pa=None) for each in small.headline.series
    )
    headline = replace(small.headline, series=series)
    assert "Breakaway" not in summary_table_head(replace(small, headline=headline))


def summary_table_of(results):
    summary = report_document(results, ()).sections[0]
    return (summary.tables or summary.parts[0].tables)[0]  # a long one is folded


def summary_table_head(results):
    return " ".join(summary_table_of(results).head)


def test_a_label_that_all_runs_share_is_in_the_identity_and_in_no_table(small):
    def labelled(number):
        """Return the results with the label of seal A in all runs, or in the first ``number``."""
        runs = tuple(
            replace(run, run=replace(run.run, plan=replace(run.run.plan, label="seal A")))
            for run in small.runs[:number]
        )
        curves = tuple(replace(curve, label="seal A") for curve in small.curves)
        return replace(small, runs=runs + small.runs[number:] if number else runs, curves=curves)

    every, some = (report_document(labelled(n), ()) for n in (None, 1))
    assert dict(every.identity)["Label of the runs"] == "seal A"
    assert "Label of the runs" not in dict(some.identity)
    tables = [re.findall("seal A", page_of(each)) for each in (every, some)]
    assert len(tables[0]) == 1 < len(tables[1])


def test_an_imported_campaign_has_the_time_of_its_import_and_the_name_of_its_bench(small):
    provenance = replace(small.provenance, source="imported", bench="seal stand")
    facts = dict(report_document(replace(small, provenance=provenance), ()).identity)
    assert facts["Bench"] == "seal stand (name in the map of the import)"
    assert facts["Imported"] and facts["Measured"].startswith("date not recorded")
    dated = replace(provenance, settings={"test": {"date": "2026-03-02"}})
    facts = dict(report_document(replace(small, provenance=dated), ()).identity)
    assert facts["Measured"] == "2026-03-02"


def test_a_complete_campaign_with_a_point_without_a_trial_reports_that_point_once():
    point = PointTrials("steady", "", "extend", 500.0, None, None, 0.1, 0, 3)
    checks = (
        QualityCheck("complete", "with care", 100.0, "%", 100.0, 80.0, 8, 8),
        QualityCheck("trials_per_point", "poor", 0, "trials", 3, 1, 1),
    )
    quality = Quality("poor", checks, Completeness(8, False, (), 2, (point,)), ())
    assert "missing" not in next_step(quality, "")
    assert quality_verdict(quality).count("no accepted trial") == 1
    assert quality_verdict(quality, count_runs=False).count("no accepted trial") == 1
    words = "Accepted trials are missing: 1 of 2 points has no accepted trial. The data is poor."
    assert quality_verdict(quality).startswith(words)  # no run is missing: it is not incomplete
    rejected = QualityCheck("runs_accepted", "poor", 12.5, "%", 95.0, 80.0, 1, 8)
    poor = quality_verdict(replace(quality, checks=(*checks, rejected)))
    begin = "The data is poor; do not rely on the numbers below. 1 of 8 runs was accepted."
    assert poor.startswith(f"{begin} Accepted trials are missing: 1 of 2 points")
    found = [row[2].text for row in quality_table(quality).rows]
    assert found == [
        "8 of 8 planned runs were made; 1 point has no accepted trial",
        "none at 1 point",
    ]


def test_points_beside_one_without_a_trial_are_used_with_care_where_a_force_is_not_measured():
    """A weight takes from the friction of one direction, and from the limits of its screening."""
    point = PointTrials("steady", "", "retract", 500.0, None, None, 0.1, 0, 3)
    missing = QualityCheck("trials_per_point", "poor", 0, "trials", 3, 1, 1)
    weight = QualityCheck("equal_directions", "with care", 104.0, "%", 33.3, None, 2, 9)
    spread = QualityCheck("repeatability", "with care", 7.0, "%", 5.0, 15.0)
    complete = Completeness(8, False, (), 2, (point,))
    quality = Quality("poor", (missing, weight, spread), complete, ())
    words = quality_verdict(quality)
    assert "those of the other points. Use these with care. Both directions: at 2 of 9" in words
    assert next_step(quality, "").startswith("Look for a force that is not measured, such as a")
    without = Quality("poor", (missing, spread), complete, ())
    assert quality_verdict(without).endswith("The numbers below are those of the other points.")
    assert next_step(without, "") == "Make at least three trials of each point."


def test_speeds_of_a_page_are_in_mm_per_second_only(page):
    text = Parsed(page).text
    assert re.search(r"\d mm/s\b", text)
    assert not re.search(r"\d m/s(?!²)", text)


def test_parameters_are_shown_with_the_half_width_of_their_interval(page):
    text = Parsed(page).text
    assert "50.0 ± 7.1" in text  # 0.05 m/s +- 0.0071 m/s, shown in mm/s
    assert "1300 ± 140" in text  # a half-width of 145 N s/m, to the even digit
    label = PARAMETERS["v_stribeck_m_s"].label.replace("v_s", "v s")  # its index is below the line
    assert f"{label} (mm/s)" in text


def test_rejected_runs_stand_with_their_reasons_and_fold_when_many(stribeck):
    html = page_html(stribeck, ())
    assert re.search(r"Off reference: [^<]*\b187\.3\smm/s", html)
    assert "<details open>" in html
    many = replace(
        stribeck, runs=tuple(replace(r, reasons=("end_stop: x",)) for r in stribeck.runs)
    )
    many = replace(many, notes=tuple(map(str, range(40))))
    assert "<details open>" not in page_html(many, ())


def test_more_reasons_than_rejected_runs_are_explained(small):
    def text(*reasons_of_runs):
        runs = tuple(replace(run, reasons=()) for run in small.runs)
        rejected = [replace(run, reasons=reasons)
                    for run, reasons in zip(runs, reasons_of_runs, strict=False)]  # fmt: skip
        results = replace(small, runs=(*rejected, *runs[len(rejected) :]))
        return ordinary_spaces(page_html(results, ()))

    assert "reasons belong" not in text()
    assert "reasons belong" not in text(("stalled: x",), ("gapped: z",))
    several = text(("stalled: x", "not_steady: y"), ("gapped: z",))
    assert "The 3 reasons belong to 2 runs: a run counts under each" in several


def test_the_best_law_is_one_conclusion_over_all_curves(small):
    """1.5 N against 18.9 N in each of two curves, whose differences are not significant alone."""
    laws = HeldOut("tustin", 1.47), HeldOut("marton_lantos", 18.9)
    found = Selection(laws, 354.0, 180.0, False, 6)
    both = tuple(replace(curve, selection=found) for curve in small.curves[:2])

    def words(*curves):
        return selection_words(replace(small, curves=curves, joint_fits=()))

    assert words(*both) == (
        "Tustin predicts best in all 2 curves: RMS error 1.47 N, that of the next law 18.9 N. "
        "This is significant in no single curve: with 6 held-out speeds, one large error can "
        "decide."
    )
    sure = replace(both[0], selection=replace(found, distinguishable=True))
    assert words(sure, both[1]).endswith("This is significant in 1 of them.")
    other = replace(both[0], selection=replace(found, laws=laws[::-1]))
    assert words(other, both[1]).startswith("No law predicts best in all 2 curves: ")


def test_a_campaign_without_a_single_good_run_still_has_a_page(small, undrawn):
    runs = tuple(replace(run, reasons=("truncated: x",), means=None) for run in small.runs)
    results = replace(small, runs=runs, curves=(), efficiency=())
    document = report_document(summarized(results), draw_all(results))
    (friction,) = [section for section in document.sections if anchor(section) == "friction"]
    assert friction.paragraphs and not friction.drawings and not friction.tables
    assert f"0 of {len(runs)}" in Parsed(page_of(document)).text
    assert Parsed(page_html(replace(results, runs=()), ())).text


def test_a_parameter_without_an_interval_and_a_failed_fit_are_flagged(small):
    fit = small.curves[1].fits[0]
    loose = replace(fit.parameters["f_stiction_n"], se=None, ci95=None)
    fit = replace(fit, converged=False, parameters={**fit.parameters, "f_stiction_n": loose})
    results = replace(small, curves=(replace(small.curves[1], fits=(fit,)),))
    text = Parsed(page_html(results, ())).text
    assert "not determined" in text and "not converged" in text


def test_runs_of_one_kind_are_counted_with_their_speeds(small):
    accepted = replace(small, runs=tuple(run for run in small.runs if run.accepted))
    measured = dict(report_document(accepted, ()).sections[0].facts)["Measured"]
    count = len(accepted.runs)
    assert measured == f"{count} steady runs at 1–200 mm/s, 2 loads of 500–5000 N, both directions."


def test_points_without_enough_trials_are_in_the_order_of_series_and_speed():
    made = (("retract", -500.0, -0.1), ("extend", 5000.0, 0.1), ("extend", 500.0, 0.2))
    points = [
        PointTrials("steady", "", side, load, None, None, v, 0, 3)
        for side, load, v in (*made, ("extend", 500.0, 0.1))
    ]
    rows = [[str(getattr(c, "text", c)) for c in row] for row in short_point_table(points).rows]
    assert [row[-2] for row in rows] == ["100.0", "200.0", "100.0", "−100.0"]
    assert [row[0] for row in rows] == ["extending"] * 3 + ["retracting"]
    assert "Reference (mm/s)" in short_point_table(points).head
    push = PointTrials("breakaway", "", "extend", 500.0, None, None, 0.0, 0, 3, 10.0)
    mixed = short_point_table([push, points[0]])
    assert "Reference" in mixed.head and "Reference (mm/s)" not in mixed.head
    at = mixed.head.index("Reference")
    (first, second) = (str(getattr(row[at], "text", row[at])) for row in mixed.rows)
    assert first == "after 10 s at rest" and second.endswith(" mm/s")


def test_bands_have_their_table_where_too_few_speeds_have_no_figure(seals):
    """The tile of the half band is a number of this table."""
    usable = replace(seals, quality=replace(seals.quality, grade="with care"))
    document = report_document(usable, ())
    text = Parsed(page_of(document)).text
    assert any("half band: mean of extending" in tile.more for tile in document.sections[0].tiles)
    assert "Too few speeds for a curve" in text and "Half band (N)" in text
    assert all(with_interval(b.half_n, b.half_ci95_n) in text for b in seals.bands)


def test_the_seals_page_tables_friction_against_pressure(seals, undrawn):
    text = Parsed(page_html(seals, draw_all(seals))).text
    assert "Half band (N)" in text
    assert all(with_interval(b.middle_n, b.middle_ci95_n) in text for b in seals.bands)
    assert "chamber pressure" in text and "1–7 bar" in text
    assert "Fitted parameters" not in text


def test_rod_side_pressures_have_a_column_only_where_they_tell_rows_apart(small, two_rod_sides):
    assert "P Lr (bar)" not in Parsed(page_html(small, ())).text
    text = Parsed(page_html(two_rod_sides, ())).text
    # Summary, parameters, points, efficiencies and rejected runs.
    assert text.count("P Lr (bar)") == 4 + 2 * any(not run.accepted for run in small.runs)
    assert "60.00" in text and "15.00" in text
    assert "extending, 500 N, 60 bar F C " in text


def test_a_full_campaign_stays_under_two_megabytes(stribeck):
    assert len(page_html(stribeck, draw_all(stribeck)).encode()) < 2_000_000


@pytest.mark.parametrize(
    "value,half,text",
    [
        (412.34, 23.4, "412 ± 23"),
        (0.05012, 0.0071, "0.0501 ± 0.0071"),
        (-3.756, 0.13, "−3.76 ± 0.13"),
        (1300.4, 145.2, "1300 ± 150"),
        (453.4, 99.6, "450 ± 100"),
        (0.0453, 0.00996, "0.045 ± 0.010"),
        (3911.2, 1326.0, "3900 ± 1300"),
        (12.3456, None, "12.3"),
        (0.0, None, "0"),
        (5.0, float("inf"), "5.00"),
        (None, 1.0, "–"),
        (float("nan"), 1.0, "–"),
    ],
)
def test_a_number_is_rounded_by_its_interval(value, half, text):
    assert with_interval(value, half) == text


def test_a_range_has_the_decimals_of_its_less_certain_end():
    assert span_with_intervals([(1.7, 3.8), (16.08, 0.23)]) == "1.7–16.1"
    assert span_with_intervals([(405.2, 89.0), (524.4, 120.0)]) == "410–520"


def test_the_smaller_end_of_a_range_is_in_front_however_uncertain_the_larger_is():
    assert span_with_intervals([(3300, 1500), (3400, 15000)]) == "3300–3400"
    assert span_with_intervals([(-0.377, 23.0), (-0.127, 0.105)]) == "−0.38 to −0.13"


def test_a_half_width_alone_has_two_digits():
    assert [half_width(half) for half in (111.4, 99.6, 9.44, 0.0)] == ["110", "100", "9.4", "0"]


def test_numbers_read_as_people_write_them():
    assert [short(v) for v in (5.0, 1.2, 49.087, 5000.0, 0.0, 100.0)] == [
        "5", "1.2", "49.1", "5000", "0", "100",
    ]  # fmt: skip
    assert force(-500.0) == "−500 N" and force(None) == "not set"
    assert span([5.0, 200.0]) == "5–200" and span([7.0]) == "7"
    assert span([0.948, 7.05]) == "0.95–7.05" and span([1.14, 200.0]) == "1–200"
    assert span([0.5, 2.0]) == "0.5–2"
    assert span([0.948, 38.0]) == "0.95–38" and span([0.0, 38.0]) == "0–38"
    assert number(-0.25, 1) == "−0.2" and significant(3.2e9, 3) == "3.20e+09"


def test_a_number_that_is_rounded_up_to_a_power_of_ten_has_no_further_digit():
    assert [significant(v, 2) for v in (0.0996, 0.994, 0.996, 9.96, -99.6)] == [
        "0.10", "0.99", "1.0", "10", "−100",
    ]  # fmt: skip
    assert [significant(v, 3) for v in (99.96, 0.09996, 1.234)] == ["100", "0.100", "1.23"]


def test_speeds_below_1_mm_s_keep_two_digits():
    speeds = (0.2, -0.0038, 0.00038, 0.0, None)
    assert [in_mm_s(v) for v in speeds] == ["200.0", "−3.8", "0.38", "0.0", "–"]
    assert [whole_mm_s(v) for v in (0.0824, 0.0038, 0.00038)] == ["82", "3.8", "0.38"]


def test_the_parts_of_an_efficiencys_uncertainty_have_columns_the_largest_first(page):
    text = Parsed(page).text
    head = " ".join(
        rf"{part} \(% points\)"
        for part in ("Piston-side pressure", "Load cell", "Rod-side pressure", "Trials")
    )
    assert re.search(head, text)
    assert re.search(r"1\.5 1\.0 0\.5\d* 0\.2\d", text)


def test_the_uncertainty_of_a_mean_efficiency_has_two_digits_or_one_trial_as_its_reason(small):
    first, *others = small.efficiency

    def cell(u):
        curve = replace(first, mean=replace(first.mean, sigma_combined=u))
        table = budget_table(replace(small, efficiency=(curve, *others)))
        found = table.rows[0][table.head.index("u (% points)")]
        return found.text, found.flag

    assert cell(0.00919) == ("0.92", "") and cell(0.0212) == ("2.1", "")
    assert cell(None) == ("–", "one trial")


def test_held_out_errors_and_laws_of_all_loads_have_their_tables(small):
    laws = (HeldOut("tustin", 3.21), HeldOut("marton_lantos", 13.9))
    found = Selection(laws, 182.0, 68.0, True, 13)
    parameters = {"k3_n_pa": FitParameter(1.5e-5, 1e-6, (1.3e-5, 1.8e-5), None, "N/Pa")}
    joint = JointFit("steady", "", 4, 60, (Fit("pressure_based", parameters, 3.7, True, ""),), None)
    curves = (replace(small.curves[0], selection=found), *small.curves[1:])
    html = page_html(replace(small, curves=curves, joint_fits=(joint,)), ())
    text = Parsed(html).text
    assert f"{FRICTION_LAWS['marton_lantos'].title} (13.9 N)" in text
    assert "RMS error 3.21 N, that of the next law 13.9 N. This is significant." in text
    assert "1.50 (1.30 to 1.80)" in text  # N/bar
    assert 'id="laws"' in html and 'id="laws"' not in page_html(small, ())


def test_rejected_runs_of_poor_data_are_before_the_results_and_remarks_on_fits_after_them(
    stribeck, small
):
    def titles(results):
        return [section.title for section in report_document(results, ()).sections]

    good = titles(stribeck)
    assert good.index("Rejected runs") > good.index("Friction")
    poor = titles(replace(stribeck, quality=replace(stribeck.quality, grade="poor")))
    assert poor[:2] == ["Rejected runs", "Summary"]
    curve = small.curves[0]
    fits = tuple(replace(fit, message="few points") for fit in curve.fits)
    remarked = titles(replace(small, curves=(replace(curve, fits=fits),)))
    assert remarked[-2:] == ["Appendix: all points", "Appendix: remarks on the fits"]


def test_a_rejected_run_has_its_main_reason_apart_from_further_ones(small):
    one, two, *others = small.runs
    runs = (
        replace(one, reasons=("stalled: a", "gapped: b", "gapped: d")),
        replace(two, reasons=("gapped: c",)),
    )
    table = rejected_table(replace(small, runs=(*runs, *others)))
    assert table.head[-2:] == ("Main reason", "Further reasons")
    first, second = ([cell.text for cell in row[-2:]] for row in table.rows[:2])
    assert (first, second) == (["Stalled: a.", "gapped"], ["Gapped: c.", ""])
    table = rejected_table(replace(small, runs=(runs[1], *others)))
    assert table.head[-1] == "Reason" and table.rows[0][-1].text == "Gapped: c."


def test_each_reason_for_rejection_has_a_cause_to_look_for(small):
    assert set(CAUSES) == set(CODES)
    reasons = ("changed: runs/0001.dat", "too_short: 0.1 s")
    runs = (replace(small.runs[0], reasons=reasons), *small.runs[1:])
    causes = cause_table(replace(small, runs=runs)).rows
    found = {row[0].text: tuple(cell.text for cell in row[1:]) for row in causes}
    assert found["Changed"] == ("1", CAUSES["changed"])
    assert found["Too short"] == ("1", CAUSES["too_short"])


def test_a_breakaway_by_fits_that_are_not_determined_is_stated_with_them(small):
    """All but one fit are not determined, and friction exceeds breakaway by less than U."""
    tustin = next(each for each in small.fit_verdicts if each.law == "tustin")
    assert tustin.determined < tustin.fits
    series = tuple(
        replace(
            each,
            friction_n=replace(each.friction_n, value=671.0),
            breakaway_n=replace(each.friction_n, value=660.0, u95=120.0, basis="extrapolated"),
        )
        for each in small.headline.series
    )
    weak = replace(small, headline=replace(small.headline, series=series))
    weak = replace(weak, quality=replace(weak.quality, grade="with care"))
    page = ordinary_spaces(page_of(report_document(weak, ())))
    share = f"{tustin.determined} of {tustin.fits} Tustin fits determine all their parameters"
    assert (
        "breakaway by Tustin's law, extrapolated, all loads and directions; U up to"
        in html.unescape(page)
    )
    assert (
        f"Extrapolated to rest, which is no measurement. {share}. Before relying on breakaway"
        in page
    )
    assert "Where friction at the working speed is larger, the difference is within U" in page


def test_a_row_of_one_trial_states_it_once(small):
    first, *others = small.headline.series
    single = replace(first.friction_n, u95=None, basis="one_trial")
    pressure = replace(single, value=3.29e5)
    series = (replace(first, friction_n=single, friction_pa=pressure), *others)
    found = replace(small, headline=replace(small.headline, series=series))
    summary = next(each for each in report_document(found, ()).sections if each.title == "Summary")
    table = summary.tables[0]
    row = next(row for row in table.rows if any(cell.text == "3.29" for cell in row))
    assert row[table.head.index("Trials alone (N)")].text == "one trial"
    assert [f"{cell.text} {cell.flag}".count("one trial") for cell in row].count(1) == 1


def test_u_names_what_it_contains(small):
    def words(**changes):
        changes = {"sigma_instruments_n": 50.0, **changes}
        curves = tuple(
            replace(curve, points=tuple(replace(point, **changes) for point in curve.points))
            for curve in small.curves
        )
        return ordinary_spaces(page_of(report_document(replace(small, curves=curves), ())))

    assert "uncertainty of trials and instruments together" in words()
    assert "of trials, instruments and drift together" in words(sigma_drift_n=20.0)
    without = words(sigma_drift_n=20.0, sigma_instruments_n=None)
    assert "U is the expanded uncertainty of trials and drift, for" in without
    assert "U is the half-width" not in without and "does not contain the errors of" in without
    assert "U is the half-width of the 95 % interval" in words(sigma_instruments_n=None)


def test_the_verdict_on_breakaway_has_the_time_at_rest_where_all_have_the_same(small):
    def verdict(*rests):
        series = tuple(
            replace(
                each,
                v_m_s=None,
                friction_n=None,
                efficiency=None,
                breakaway_n=replace(each.friction_n, basis="breakaway"),
                breakaway_dwell_s=rest,
            )
            for each, rest in zip(small.headline.series, rests, strict=False)
        )
        quality = replace(small.quality, grade="with care")
        headline = replace(small.headline, series=series)
        return report_document(replace(small, headline=headline, quality=quality), ()).verdict

    assert verdict(60.0, 60.0).startswith("Breakaway after 60 s at rest is ")
    assert verdict(60.0, 10.0).startswith("Breakaway is ")


def test_a_remark_that_all_efficiencies_share_is_above_their_table(small):
    def appendix(reasons):
        curve = small.efficiency[0]
        points = tuple(
            replace(point, sigma=None, sigma_as_printed=None, u95=None, reason=reason)
            for point, reason in zip(curve.points, reasons, strict=False)
        )
        results = replace(small, efficiency=(replace(curve, points=points),))
        parts = next(
            s for s in report_document(results, ()).sections if s.title == "Appendix: all points"
        ).parts
        return parts[-1].items, parts[-1].tables[0].head

    items, head = appendix(["no sigma: unknown"] * 20)
    assert items == ("No sigma: unknown.",) and "Remark" not in head
    assert not {"σ of instruments (% points)", "U of both (% points)"} & set(head)
    items, head = appendix(["no sigma: unknown", *[""] * 20])
    assert not items and "Remark" in head


def test_the_instruments_share_at_one_point_is_no_median(small):
    check = QualityCheck("instruments", "with care", 21.0, "%", 10.0, None, of=1)
    found = replace(small, quality=replace(small.quality, checks=(check,)))
    assert "uncertain by ±21 % (95 %)" in ordinary_spaces(page_of(report_document(found, ())))
    several = replace(found, quality=replace(found.quality, checks=(replace(check, of=2),)))
    page = ordinary_spaces(page_of(report_document(several, ())))
    assert "±21 % (95 %, median over all operating points)" in page


def test_notes_of_the_analysis_are_sentences(small):
    notes = ("no fit for 1 of 1 curves", "The order is not known.")
    sections = report_document(replace(small, notes=notes), ()).sections
    (settings,) = (section for section in sections if section.anchor == "settings")
    assert settings.parts[0].items == ("No fit for 1 of 1 curves.", "The order is not known.")


def test_of_one_load_the_verdict_names_the_directions_alone(small):
    series = [s for s in small.headline.series if abs(s.f_load_n) == 500]
    assert len(series) == 2
    one = replace(small, headline=replace(small.headline, series=tuple(series)))
    assert re.search(r"retracting \(U [^)]*\)\. ", report_document(one, ()).verdict)
    tiles = [tile for s in report_document(one, ()).sections for tile in s.tiles]
    assert "both directions; U up to" in tiles[0].more
    assert "all loads and directions" not in page_of(report_document(one, ()))


def test_a_page_without_steady_runs_states_whether_any_was_made(small):
    def friction_of(results):
        sections = report_document(results, ()).sections
        return next(each.paragraphs[0] for each in sections if each.title == "Friction")

    def of_kind(screened, kind):
        return replace(
            screened, run=replace(screened.run, plan=replace(screened.run.plan, kind=kind))
        )

    bare = replace(small, curves=(), efficiency=(), bands=())
    assert friction_of(bare).startswith("No steady run was accepted.")
    ramps = replace(bare, runs=tuple(of_kind(run, "ramp") for run in small.runs))
    assert friction_of(ramps).startswith("No steady run was made.")


def test_largest_parts_of_the_uncertainty_are_named_only_where_they_are_known(small):
    (check,) = (each for each in small.quality.checks if each.name == "instruments")
    poor = replace(check, grade=small.quality.grade, value=0.5)
    quality = replace(small.quality, checks=(poor,))
    assert "largest parts of the uncertainty (load cell)" in next_step(quality, "load cell")
    unknown = next_step(quality, "")
    assert "largest parts" not in unknown and "sensors of pressure and force" in unknown
