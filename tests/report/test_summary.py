"""The summary: friction at the working speed, breakaway, efficiency, and the data's quality."""

import json
import math
from dataclasses import replace

import pytest

from hbench.analysis.summary.completeness import PlannedRuns
from hbench.analysis.summary.quality import quality
from hbench.records import FitParameter
from hbench.report.campaign.fit_tables import fit_tables, fits_verdict
from hbench.report.campaign.page import report_document
from hbench.report.campaign.quality import quality_table, quality_verdict
from hbench.report.campaign.results_document import results_json
from hbench.report.campaign.summary import summary_section
from hbench.report.campaign.terminal import summary_text
from hbench.report.render.document import page
from hbench.report.render.numbers import alike, number, with_interval
from tests.support.analysis.drawn_seal import drawn_seal
from tests.support.report.made_page import page_html, summarized


def page_html_as_is(results):
    return page(report_document(results, ()))


def series(results, speed_m_s=None):
    return summarized(results, speed_m_s).headline.series


def checks(results):
    return {check.name: check for check in summarized(results).quality.checks}


def grade(results, name):
    return checks(results)[name].grade


def with_points(results, **changes):
    curves = tuple(
        replace(c, points=tuple(replace(p, **changes) for p in c.points)) for c in results.curves
    )
    return replace(results, curves=curves)


def test_the_working_speed_is_the_middle_one_of_those_measured(small):
    speeds = sorted(abs(p.v_m_s) for p in small.curves[0].points)
    assert small.headline.v_m_s == pytest.approx(speeds[2])
    for one, curve in zip(small.headline.series, small.curves, strict=True):
        assert (one.direction, one.f_load_n) == (curve.direction, curve.f_load_n)
        assert one.friction_n.value == abs(curve.points[2].friction_n)
        assert one.friction_n.u95 == one.friction_n.ci95 == curve.points[2].ci95_n


def test_a_point_stands_for_a_speed_asked_for_only_if_it_is_near(small):
    v = abs(small.curves[0].points[3].v_m_s)
    assert all(one.v_m_s == pytest.approx(v) for one in series(small, 1.15 * v))
    assert all(one.friction_n is None for one in series(small, 0.5))
    assert "friction" not in str(summary_section(summarized(small, 0.5)).tiles[0].more)


def test_strokes_of_one_speed_each_have_their_own_unless_a_speed_is_asked_for():
    strokes = drawn_seal(1, speeds=(12e-3, 6e-3))
    shown = {each.direction: each.v_m_s for each in strokes.headline.series}
    assert shown == {"extend": 12e-3, "retract": 6e-3}
    asked = summarized(strokes, 12e-3).headline.series
    assert {each.direction: each.v_m_s for each in asked} == {"extend": 12e-3, "retract": None}
    (tile, *_) = summary_section(strokes).tiles
    assert "6–12 mm/s" in tile.more


def test_half_band_and_slope_have_tiles_with_their_ranges_or_interval():
    seal = drawn_seal(1)
    tiles = {tile.unit: tile for tile in summary_section(seal).tiles if "half" in tile.more}
    halves = [band.half_n for band in seal.bands]
    assert tiles["N"].value == alike(halves)
    line = seal.band_trends[0].half
    expected = with_interval(1e5 * line.slope_n_pa, 1e5 * line.slope_ci95_n_pa)
    assert tiles["N/bar"].value == expected


def test_the_interval_is_that_of_trials_and_instruments_where_these_are_known(small):
    known = with_points(small, u95_n=77.0)
    assert all(one.friction_n.u95 == 77.0 != one.friction_n.ci95 for one in series(known))


def test_breakaway_is_the_fits_at_rest_and_says_so(small):
    known = with_points(small, sigma_instruments_n=10.0)
    one = series(known)[1].breakaway_n
    fitted = small.curves[1].fits[0].parameters["f_stiction_n"]
    assert one.value == fitted.value and one.basis == "extrapolated"
    assert one.u95 == pytest.approx(math.hypot(12.3, 19.59964))


def test_breakaway_without_a_fit_is_where_the_slowest_ramp_begins_to_slide(small):
    curve = small.curves[0]
    starts = {0.1: 900.0, 0.03: 700.0}
    ramps = []
    for a, peak in starts.items():
        points = list(curve.points)
        points[0] = replace(points[0], friction_n=1.0)  # before the seals have slid
        points[1] = replace(points[1], friction_n=peak, ci95_n=9.0)
        fit = replace(curve.fits[0], line=tuple((p.v_m_s, 1.0) for p in points[1:]))
        ramps.append(replace(curve, kind="ramp", a_ref_m_s2=a, points=tuple(points), fits=(fit,)))
    unfitted = tuple(replace(each, fits=()) for each in small.curves)
    one = series(replace(small, curves=(*unfitted, *ramps)))[0].breakaway_n
    assert (one.value, one.u95, one.basis) == (700.0, 9.0, "ramp")
    with_fit = series(replace(small, curves=(*small.curves, *ramps)))[0].breakaway_n
    assert with_fit.basis == "extrapolated"
    alone = series(replace(small, curves=tuple(ramps), efficiency=()))
    assert len(alone) == 1 and alone[0].friction_n is None and alone[0].breakaway_n.value == 700.0


def test_efficiency_is_that_of_the_same_direction_load_and_speed(small):
    for one, curve in zip(small.headline.series, small.efficiency, strict=True):
        assert one.efficiency.value == curve.points[2].efficiency
        assert one.efficiency.u95 == curve.points[2].u95
    without = [
        replace(curve, points=tuple(replace(point, u95=None) for point in curve.points))
        for curve in small.efficiency
    ]
    for one, curve in zip(series(replace(small, efficiency=tuple(without))), without, strict=True):
        assert one.efficiency.u95 == curve.points[2].ci95  # of the trials alone


@pytest.mark.parametrize("rejected,expected", [(0, "good"), (4, "with care"), (20, "poor")])
def test_the_share_of_accepted_runs_is_graded(small, rejected, expected):
    runs = [replace(run, reasons=()) for run in small.runs]
    runs[:rejected] = [replace(run, reasons=("gapped: x",)) for run in runs[:rejected]]
    assert len(runs) == 60
    assert grade(replace(small, runs=tuple(runs)), "runs_accepted") == expected


@pytest.mark.parametrize("n,expected", [(3, "good"), (2, "with care"), (1, "poor")])
def test_the_fewest_trials_of_a_point_are_graded(small, n, expected):
    assert grade(with_points(small, n=n), "trials_per_point") == expected


@pytest.mark.parametrize(
    "half,expected", [(10.0, "good"), (60.0, "with care"), (200.0, "poor")]
)  # of 350 to 700 N
def test_the_trials_scatter_is_graded(small, half, expected):
    assert grade(with_points(small, ci95_n=half), "repeatability") == expected


@pytest.mark.parametrize("sigma,expected", [(5.0, "good"), (500.0, "with care")])
def test_instruments_never_make_data_poor_but_may_ask_for_care(small, sigma, expected):
    assert grade(with_points(small, sigma_instruments_n=sigma), "instruments") == expected
    assert grade(small, "instruments") == "with care"  # not known


def test_fits_have_verdicts_of_their_own_and_leave_the_grade_of_the_data(small):
    good = with_points(small, n=3, sigma_instruments_n=5.0)
    good = replace(good, runs=tuple(replace(run, reasons=()) for run in good.runs))
    loose = FitParameter(1.0, None, None, None, "N")
    wide = FitParameter(1.0, 2.0, (-3.0, 5.0), None, "N", wide=True)

    def with_fits(**changes):
        curves = tuple(replace(c, fits=(replace(c.fits[0], **changes),)) for c in good.curves)
        return summarized(replace(good, curves=curves))

    assert [curve.fits[0].verdict for curve in good.curves[:2]] == ["not determined", "determined"]
    for changes, verdict in (
        ({"parameters": {"f_coulomb_n": loose}}, "not determined"),
        ({"parameters": {"f_coulomb_n": wide}}, "not determined"),
        ({"parameters": {}}, "not determined"),
        ({"converged": False}, "not converged"),
    ):
        changed = with_fits(**changes)
        assert {curve.fits[0].verdict for curve in changed.curves} == {verdict}
        assert changed.quality.grade == "good"
        assert "good" in quality_verdict(changed.quality)
        for text in (fits_verdict(changed), summary_text(changed), page_html(changed, ())):
            assert "all parameters determined: Tustin 0 of 4" in text
        (written,) = json.loads(results_json(changed))["fit_verdicts"]
        assert written["fits"] == written[verdict.replace(" ", "_")] == 4


def test_a_fits_table_names_the_parameters_that_are_not_determined(small):
    table = fit_tables(small)["tustin"]
    verdicts = [row[-1].text or row[-1].flag for row in table.rows]
    assert verdicts == ["F_C not determined", "determined", "determined", "determined"]


def test_the_verdict_is_the_worst_grade_and_its_sentence_has_the_checks_of_that_grade(small):
    few = summarized(with_points(small, n=1)).quality
    assert few.grade == "poor"
    rows = [[cell.text for cell in row] for row in quality_table(few).rows]
    for check, (name, _, value, *_) in zip(few.checks, rows, strict=True):
        assert (name.lower() in quality_verdict(few).lower()) == (check.grade == "poor")
        assert check.name != "trials_per_point" or value in quality_verdict(few)
    good = with_points(replace(small, curves=small.curves[1:]), sigma_instruments_n=5.0)
    good = replace(good, runs=tuple(replace(run, reasons=()) for run in good.runs))
    good = summarized(with_points(good, n=3)).quality
    assert good.grade == "good" and {check.grade for check in good.checks} == {"good"}
    assert f" {len(good.checks)} checks" in quality_verdict(good)


def with_plan(results, missing=()):
    """The results of a campaign whose plan has all its runs; those in ``missing`` were not made."""
    plans = tuple(run.run.plan for run in results.runs)
    runs = tuple(run for run in results.runs if run.run.plan.run not in missing)
    planned = PlannedRuns(plans, frozenset(run.run.plan.run for run in runs))
    return replace(
        results,
        runs=runs,
        quality=quality(runs, results.curves, results.efficiency, planned),
    )


def accepted_all(results):
    return replace(results, runs=tuple(replace(run, reasons=()) for run in results.runs))


def test_a_campaign_without_its_last_run_is_headed_as_incomplete(small):
    good = accepted_all(with_points(small, n=3))
    whole = with_plan(good)
    assert whole.quality.completeness.not_completed == ()
    assert {c.name: c for c in whole.quality.checks}["complete"].grade == "good"
    assert "incomplete" not in quality_verdict(whole.quality)
    last = good.runs[-1].run.plan.run
    cut = with_plan(good, missing={last})
    check = {c.name: c for c in cut.quality.checks}["complete"]
    assert (check.grade, check.count, check.of) == ("with care", 59, 60)
    assert cut.quality.completeness.not_completed == (last,)
    (point,) = cut.quality.completeness.short_points
    assert (point.accepted, point.planned) == (2, 3)
    for text in (summary_text(cut), page_html_as_is(cut)):
        assert "incomplete: 1 of 60 planned runs was not completed; 1 has fewer" in text
        assert "--resume" in text
    assert "59 of 60" in {tile.value for tile in summary_section(cut).tiles}
    written = json.loads(results_json(cut))["quality"]["completeness"]
    assert written["planned"] == 60 and written["not_completed"] == [last]


def test_a_point_whose_runs_were_all_rejected_counts_with_no_trial(small):
    good = accepted_all(with_points(small, n=3))
    *points, lost = good.curves[0].points
    curve = replace(good.curves[0], points=tuple(points))
    runs = tuple(
        replace(run, reasons=("gapped: x",)) if run.run.plan.run in lost.runs else run
        for run in good.runs
    )
    without = replace(good, runs=runs, curves=(curve, *good.curves[1:]))
    for results in (summarized(without), with_plan(without)):  # imported; measured
        check = {c.name: c for c in results.quality.checks}["trials_per_point"]
        assert (check.value, check.count, check.grade) == (0, 1, "poor")
        (point,) = results.quality.completeness.short_points
        assert (point.accepted, point.v_ref_m_s) == (0, pytest.approx(lost.v_m_s))
        verdict = quality_verdict(results.quality)
        assert verdict.startswith("The campaign is incomplete: 1 of 20 points has no accepted")
        assert "of the other points" in verdict and "do not rely" not in verdict
        shown = summary_section(results).parts[-1].tables[1]
        assert shown.rows[0][-1].text == "0 of 3"


def with_friction(results, friction_n, half):
    """The results with one friction against the motion, in the first point of each curve."""
    curves = []
    for curve in results.curves:
        one, *rest = curve.points
        value = curve.against_motion * friction_n
        one = replace(one, friction_n=value, ci95_n=half, u95_n=None)
        curves.append(replace(curve, points=(one, *rest)))
    return replace(results, curves=tuple(curves))


def test_friction_with_the_motion_is_negative_and_called_an_error_of_the_instruments(small):
    known = with_points(small, n=3, sigma_instruments_n=5.0)
    slowest = 1e3 * small.curves[0].points[0].v_m_s
    wrong = summarized(with_friction(known, -10.2, 4.0), 1e-3 * slowest)
    assert {one.friction_n.value for one in wrong.headline.series} == {-10.2}
    check = checks(with_friction(known, -10.2, 4.0))["plausible_signs"]
    assert (check.grade, check.value, check.count) == ("poor", 4, 4)
    terminal = summary_text(wrong).replace("+-", "±").replace("-10", "−10")
    for text in (terminal, page_html(wrong, ())):
        assert "instruments, their zero or an area are in error" in text
        assert f"extend, 500 N, {number(slowest)} mm/s: friction −10.2 ± 4.0 N" in text
    written = json.loads(results_json(wrong))["quality"]["implausible"]
    assert [(p["quantity"], p["value"], p["beyond"]) for p in written] == [
        ("friction_n", -10.2, True)
    ] * 4
    within = with_friction(known, -10.2, 40.0)
    assert grade(within, "plausible_signs") == "with care"
    assert "in error" not in quality_verdict(summarized(within).quality)
    assert grade(with_friction(known, 10.2, 4.0), "plausible_signs") == "good"


@pytest.mark.parametrize(
    "value,u95,expected", [(1.03, 0.02, "poor"), (1.03, 0.05, "with care"), (0.99, 0.02, "good")]
)
def test_an_efficiency_above_100_percent_is_implausible(small, value, u95, expected):
    first, *others = small.efficiency
    point = replace(first.points[0], efficiency=value, u95=u95)
    curve = replace(first, points=(point, *first.points[1:]))
    found = summarized(replace(small, efficiency=(curve, *others))).quality
    assert {c.name: c for c in found.checks}["plausible_signs"].grade == expected
    assert ("efficiency 103.0 ± 2.0 %" in quality_verdict(found)) == (expected == "poor")


def test_a_range_with_a_negative_end_has_no_dash_that_looks_like_a_minus():
    assert alike([-10.2, 600.0]) == "−10 to 600" and alike([10.0, 600.0]) == "10–600"


def test_a_campaign_without_anything_is_poor_and_has_a_summary(small):
    bare = replace(small, runs=(), curves=(), efficiency=())
    bare = summarized(bare)
    assert bare.quality.grade == "poor" and bare.headline.v_m_s is None
    assert summary_section(bare).tiles[0].value == "0 of 0"


def test_ranges_of_measured_numbers_keep_their_decimals_and_zero_has_no_sign():
    assert alike([67.71, 92.96]) == "67.7–93.0" and alike([402.4, 529.0]) == "402–529"
    assert number(-0.04) == "0.0" and number(-0.06) == "−0.1" and number(-10.0) == "−10.0"


def test_a_tile_says_that_a_flag_is_of_some_and_that_efficiency_is_in_points(small):
    one, *others = small.curves
    few = replace(one, points=tuple(replace(p, n=1, ci95_n=None) for p in one.points))
    friction, _, efficiency, *_ = summary_section(
        summarized(replace(small, curves=(few, *others)))
    ).tiles
    assert "partly" in friction.more and friction.unit == "N"
    assert efficiency.unit == "%" and "points" in efficiency.more
