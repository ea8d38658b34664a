"""The page, the figures and the JSON of a comparison."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.records import (
    CampaignDifferences,
    CurveDifference,
    Difference,
    Drift,
    DriftEffect,
    FrictionDifference,
    MeanAtSpeed,
    MeanOfCurves,
    OilTemperature,
    PointTrials,
)
from hbench.report.comparison.figures import draw_differences, draw_pair
from hbench.report.comparison.settings import settings_that_differ
from hbench.report.comparison.text import differences_json, differences_page, differences_text
from tests.support.report.spaces import ordinary_spaces

NOTE = "retract: A"

DRIFT = Drift(
    "time", "relative", 0.001, 0.5, -2.0, 50.0, None, None, None, 0.9, 6, 18, 11, 72.0, 1.0, False
)  # fmt: skip


@pytest.fixture(scope="module")
def found(small):
    curve = small.curves[0]
    points = tuple(
        FrictionDifference(p.v_m_s, Difference(400.0, 440.0, 4.0, 12.0, 15.0, 1e-3, 0.004), i == 1)
        for i, p in enumerate(curve.points)
    )
    same = FrictionDifference(0.3, Difference(400.0, 401.0, 4.0, 12.0, 15.0, 0.8, 1.0), False)
    mean = Difference(400.0, 440.0, 2.0, 5.0, 8.0, 1e-6, 1e-6)
    one = CurveDifference(curve, curve, (*points, same), mean, None, ())
    names = "before", "<after>"
    provenance = small.provenance
    qualities = (small.quality, small.quality)
    return CampaignDifferences(names, provenance, provenance, qualities, True, (one,), (NOTE,))


def test_the_verdict_stands_first_with_the_interval_of_trials_and_instruments(found):
    page = ordinary_spaces(differences_page(found, draw_differences(found)))
    verdict = page[: page.index("<table")]
    assert " 1 of 1 " in verdict and ", 500 N: +40.0 ± 8.0 N" in verdict
    assert re.search(r"<h1>&lt;after&gt; \w+ before</h1>", page)
    assert NOTE in page


def test_the_page_states_the_coverage_of_u(found):
    k_2 = replace(found.a, settings={"instruments": {"expansion": "k_2"}})
    for a, b, words in (
        (found.a, found.b, "Expanded uncertainty for a coverage probability of 95 %: of the"),
        (k_2, k_2, "uncertainty with the coverage factor k = 2 that the campaigns state: of the"),
        (found.a, k_2, "of 95 %, that of B with the coverage factor k = 2 that it states: of the"),
    ):
        assert words in ordinary_spaces(differences_page(replace(found, a=a, b=b), ()))


def test_a_difference_that_is_not_significant_is_not_in_the_verdict(found):
    (one,) = found.curves
    none = replace(one, mean_n=replace(one.mean_n, p_holm=0.3))
    page = ordinary_spaces(differences_page(replace(found, curves=(none,)), ()))
    verdict = page[page.index('<p class="verdict"') : page.index("<dl")]
    assert " 1 of 1 " not in verdict and "±" not in verdict
    assert "40.0 N (U 8.0 N), which exceeds its uncertainty but may be chance (p = 0.30)" in verdict
    small = replace(one, mean_n=replace(one.mean_n, b=405.0, p_holm=0.3))
    page = ordinary_spaces(differences_page(replace(found, curves=(small,)), ()))
    assert "the largest is 5.0 N (U 8.0 N)." in page
    single = replace(none, mean_n=replace(one.mean_n, p_holm=None, ci95=None, u95=None))
    page = ordinary_spaces(differences_page(replace(found, curves=(single,)), ()))
    assert "40.0 N (no interval)" in page


def test_data_to_be_used_with_care_is_reported_beside_the_verdict(found):
    a, b = (replace(found.qualities[0], grade=grade) for grade in ("good", "with care"))
    page = differences_page(replace(found, qualities=(a, b)), ())
    verdict = page[page.index('<p class="verdict"') : page.index("<dl")]
    assert "the data of B with care" in verdict
    assert 'class="alarm"' not in page
    assert page.index("Further checks</h2>") < page.index("Data of A")


def test_an_incomplete_campaign_and_poor_data_are_reported_before_the_differences(found):
    good, _ = found.qualities
    half = replace(
        good.completeness,
        planned=96,
        not_completed=tuple(map(str, range(40))),
    )
    broken = replace(found, qualities=(good, replace(good, grade="poor", completeness=half)))
    page = differences_page(broken, ())
    verdict = page[: page.index("<table")]
    assert "B is incomplete and has poor data." in verdict and "A is" not in verdict
    assert "40 of 96 planned runs" in page and "40 of 96 planned runs" in differences_text(broken)
    assert json.loads(differences_json(broken))["quality"]["b"]["grade"] == "poor"
    assert "incomplete" not in differences_page(found, ())
    point = PointTrials("steady", "", "extend", 500.0, None, None, 0.1, 0, 3)
    short = replace(good.completeness, short_points=(point,))  # the other points are compared
    short = replace(found, qualities=(good, replace(good, completeness=short)))
    assert "Do not rely" not in differences_page(short, ())


def test_the_terminal_gets_the_same_numbers_in_ascii(found):
    text = differences_text(found)
    assert text.isascii()
    assert "40.0 +- 8.0" in text and "  significant" in text and NOTE in text


def test_json_holds_every_difference_with_its_sign_and_verdict(found):
    document = json.loads(differences_json(found))
    (curve,) = document["curves"]
    assert document["schema"] == "hbench.comparison/1"
    assert curve["friction_n"]["difference"] == 40.0 and curve["friction_n"]["real"] is True
    assert [point["friction_n"]["real"] for point in curve["points"]] == [True] * 5 + [False]
    assert [point["between"] for point in curve["points"]][:2] == [False, True]
    assert curve["efficiency"] is None


def test_a_figure_fills_the_points_that_differ_and_is_the_same_twice(found):
    axes = draw_pair(found.curves[0], found).axes[1]
    faces = {
        line.get_markerfacecolor(): line.get_ydata() for line in axes.lines if len(line.get_xdata())
    }
    np.testing.assert_allclose(faces["#000000"], 40.0)
    np.testing.assert_allclose(faces["white"], 1.0)
    assert "B − A" in axes.get_ylabel()
    assert draw_differences(found) == draw_differences(found)


def test_captions_explain_no_marks_that_the_figures_do_not_have(found):
    (one,) = found.curves
    none = replace(one, points=tuple(replace(p, friction_n=one.points[-1].friction_n)
                                     for p in one.points))  # fmt: skip
    (filled,) = draw_differences(found)
    (hollow,) = draw_differences(replace(found, curves=(none,)))
    assert "Filled: significant at this speed alone" in filled.caption
    count = len(one.points)
    assert f"single curve is significant, after correction for {count} tests." in hollow.caption
    assert "Filled" not in hollow.caption


def test_differences_are_drawn_on_the_same_axis(found, monkeypatch):
    (one,) = found.curves
    last = one.points[-1]
    twenty = replace(last.friction_n, b=last.friction_n.a + 20.0)
    small = replace(one, points=tuple(replace(p, friction_n=twenty) for p in one.points))
    figures = []
    monkeypatch.setattr(
        "hbench.report.comparison.figures.draw_sketches",
        lambda sketches: figures.extend(sketch.figure for sketch in sketches) or (),
    )
    draw_differences(replace(found, curves=(one, small)))
    first, second = (figure.axes[1].get_ylim() for figure in figures)
    assert first == second


def test_the_row_of_the_mean_has_its_u_and_p_and_the_page_its_size_by_speed(found):
    speeds = (MeanAtSpeed(0.008, 2.0, 14.0), MeanAtSpeed(0.18, 25.0, 5.0))
    mean = MeanOfCurves(13.3, 6.3, 662.0, 4, 2.4, 2e-7, None, speeds)
    page = ordinary_spaces(differences_page(replace(found, mean_of_curves=mean), ()))
    cells = re.search(r"mean over all 4 curves.*?</tr>", page[page.index("<table") :], re.DOTALL)[0]
    assert "13.3 ± 6.3" in cells and "0.0001" in cells
    assert "B − A at each speed, means over the curves" in page and ">2 ± 14<" in page
    words = "from 2 ± 14 N at 8 mm/s to 25.0 ± 5.0 N at 180 mm/s (trials alone)."
    assert f"The difference depends on speed, {words}" in page
    assert "is 13.3 ± 6.3 N (trials alone), or 2.0 %, higher" in page
    assert ">B − A ± trials<" in page and ">B − A ± U</th></tr>" not in page
    of_speeds = tuple(replace(each, u95_n=20.0) for each in speeds)
    with_u = replace(mean, u95_a=80.0, u95_b=90.0, speeds=of_speeds)
    page = ordinary_spaces(differences_page(replace(found, mean_of_curves=with_u), ()))
    row = re.search(r">8\.0<.*?</tr>", page[page.index("B − A at each speed") :], re.DOTALL)[0]
    assert ">2 ± 20<" in row and ">2 ± 14<" in row
    assert "is 13.3 ± 6.3 N (U), or 2.0 %, higher" in page
    assert "U does not contain a new mounting" in page
    alike = replace(mean, speeds=(speeds[0], MeanAtSpeed(0.18, 20.0, 5.0)))
    assert "depends on speed" not in differences_page(replace(found, mean_of_curves=alike), ())


def test_a_comparison_states_each_setting_that_differs(found):
    assert settings_that_differ(found) == ()
    assert "schedule and software of both campaigns agree" in differences_page(found, ())
    oil = {"bulk_modulus": "700 bar", "points": {"density": "870 kg/m^3"}}
    a = replace(found.a, settings={"oil": oil}, firmware="one")
    b = replace(found.b, settings={"oil": oil | {"points": {"density": "850 kg/m^3"}}, "x": 1})
    changed = replace(found, a=a, b=replace(b, firmware="two"))
    assert settings_that_differ(changed) == (
        ("bench", "firmware", "one", "two"),
        ("oil", "points density", "870 kg/m³", "850 kg/m³"),
        ("x", "value", "–", "1"),
    )
    text = differences_page(changed, ())
    assert re.search(r'<p class="verdict">[^<]*3 settings differ between A and B; ', text)
    imported = replace(found, a=a, b=replace(a, settings={"x": 1}))
    assert settings_that_differ(imported) == (
        ("oil", "all 2 settings", "stated", "–"),
        ("x", "value", "–", "1"),
    )


@pytest.mark.usefixtures("wide_terminal")
def test_different_simulated_plants_are_stated_with_the_campaigns_and_are_no_settings(found):
    a, b = (
        replace(found.a, details={"port": "sim", "plant": {"sha256": checksum}})
        for checksum in (64 * "a", 64 * "b")
    )
    changed = replace(found, a=a, b=b)
    assert settings_that_differ(changed) == ()
    page = ordinary_spaces(differences_page(changed, ()))
    identity = page[page.index('<dl class="identity"') : page.index("</dl>")]
    assert "Different plant files, for two cylinders" in identity
    settings = page[page.index(">Settings that differ</dt>") :]
    assert "None: bench file, instruments" in settings and "The simulated plants differ" in settings
    assert "The simulated plants differ" not in differences_page(found, ())
    assert "Simulated plants" not in differences_page(replace(changed, b=a), ())
    measured = replace(b, source="real", details={"port": "/dev/ttyUSB0"})
    for other in (measured, replace(b, source="imported", details={})):
        assert "plant file" not in differences_text(replace(changed, b=other))
    own = replace(changed, b=replace(b, details={"port": "sim"}))
    text = ordinary_spaces(differences_text(own))
    assert "A was simulated with a plant file, B with the bench file's plant." in text


def test_the_verdict_states_the_largest_drift_that_speed_hides(found):
    drift = DRIFT

    def text(drift):
        return " ".join(differences_text(replace(found, drifts=(None, drift))).split())

    hidden = (
        "These runs do not show whether this comes from the cylinders or from a drift: a drift of "
        "up to 52 % within a campaign is possible and is not part of U. To compare single curves, "
        "measure both again with order: random in the schedule."
    )
    assert hidden in text(drift)
    found_drift = "from a drift: friction drifted, and the order of the runs mixes this with speed."
    assert found_drift in text(replace(drift, p=0.001))
    assert "order: random" not in text(replace(drift, separated=True))
    dateless = replace(found, drifts=(None, replace(drift, basis="order")))
    page = differences_page(dateless, ())
    assert (
        "0 of 6 differences at single speeds are significant; 5 exceed their uncertainty, but may "
        "come from a drift."
    ) in page
    assert ">significant<" not in page and "May be drift</dt>" in page
    undated = "The times of the runs are not known, so its size is uncertain."
    assert undated in text(replace(drift, basis="order")) and undated not in text(drift)
    (one,) = found.curves
    none = replace(one, mean_n=replace(one.mean_n, p_holm=0.3))
    found = replace(found, curves=(none,))
    assert "A drift may hide a difference: a drift of up to 52 %" in text(drift)


@pytest.mark.usefixtures("wide_terminal")
def test_of_a_drift_that_both_campaigns_have_the_part_in_the_difference_is_stated(found):
    """40 ± 8 N: significant with a drift of 20 ± 11 N or less, and not with one of 20 ± 13 N."""
    drift = DRIFT

    def text(half_n, mean=None, p_holm=1e-6):
        (one,) = found.curves
        one = replace(
            one,
            drift_n=DriftEffect(-20.0, half_n),
            mean_n=replace(one.mean_n, p_holm=p_holm),
        )
        compared = replace(found, drifts=(drift, drift), curves=(one, one), mean_of_curves=mean)
        return differences_text(compared)

    def words(*arguments, **changes):
        return " ".join(text(*arguments, **changes).split())

    small = text(11.0)
    assert "up to 31 N of the difference of a curve and is not part of U; the differences" in words(
        11.0
    )
    assert "52 % within" not in small and "order: random" not in small
    large = words(13.0)
    assert (
        "A drift may account for up to 33 N of the difference of a curve and is not part" in large
    )
    assert "part of U: the order of the runs does not separate the two." in large
    assert "To compare single curves, measure both again with order: random" in large
    assert "A drift may hide a difference: it may account for up to 33 N" in words(13.0, p_holm=0.4)
    over = text(13.0, MeanOfCurves(40.0, 8.0, 400.0, 2, 3.0, 1e-6, DriftEffect(0.0, 1e-9)))
    sure = (
        "Friction of <after> is 40.0 +- 8.0 N (trials alone), or 10 %, higher than that of before, "
        "in the mean over all 2 curves. This assumes that any drift within the campaigns was "
        "linear. The interval does not contain a new mounting: "
    )
    together = " ".join(over.split())
    note = (
        "Drift: A linear drift, unlike a warm-up, cancels in this mean, but may account for up to"
    )
    assert note in together
    assert together.startswith(sure)  # and no difference of a curve is called significant
    assert "Mean friction differs" not in over
    assert "mount one of the two cylinders again" in together and "mount one" not in large

    def verdicts(text):
        rows = [line for line in text.splitlines() if line.startswith(("extending", "mean over"))]
        return [re.split("  +", line.strip()) for line in rows]

    *curves, mean = verdicts(over)
    assert [row[6] for row in curves[:2]] == ["33", "33"]
    assert [row[4] for row in curves[:2]] == ["may be drift"] * 2
    assert [row[4] for row in verdicts(small)[:2]] == ["significant"] * 2
    one = replace(found.curves[0], drift_n=DriftEffect(-20.0, 13.0))
    hidden = replace(found, drifts=(drift, drift), curves=(one,))
    page = differences_page(hidden, draw_differences(hidden))
    assert (
        "0 of 6 differences at single speeds are significant; 5 exceed their uncertainty, but may "
        "come from a drift."
    ) in page
    assert ">significant<" not in page and "Filled" not in page
    assert "single speed of a single curve is significant beyond a possible drift, after" in page
    page = differences_page(found, draw_differences(found))
    assert "5 of 6 differences at single speeds are significant." in page
    assert "from a drift" not in page and "not explained by a drift" not in page
    assert mean == [
        "mean over all 2 curves, one test",
        "400.0",
        "440.0",
        "40.0 +- 8.0",
        "significant",
        "< 0.0001",
        "cancels",
    ]
    hidden = words(13.0, MeanOfCurves(-10.0, 8.0, 400.0, 2, 3.0, 1e-3, DriftEffect(1.0, 2.0)))
    assert (
        "The mean difference over all 2 curves, -10.0 +- 8.0 N, is not significant; a linear drift "
        "accounts for at most 3.0 N of this mean. To compare"
    ) in hidden
    assert hidden.startswith("Mean friction differs")


def test_the_page_states_the_oil_temperature_of_both_or_that_it_was_not_measured(found):
    assert "Not measured in either campaign." in differences_page(found, ())
    oil = OilTemperature("temp_tank_k", 313.15, 311.15, 315.15, 36, None, "no reason")
    warm = replace(found, oil_temperatures=(oil, None))
    page = ordinary_spaces(differences_page(warm, ()))
    assert "A: 40.0 °C (38.0 to 42.0 °C) in the tank; B: not measured." in page
    cold = replace(oil, mean_k=305.15, low_k=304.15, high_k=306.15)
    page = ordinary_spaces(differences_page(replace(found, oil_temperatures=(oil, cold)), ()))
    assert "The oil was 8.0 K warmer in A." in page
    text = differences_text(warm)
    assert "warmer" not in text
    assert text.isascii() and "40.0 degC (38.0 to 42.0 degC)" in text
    assert json.loads(differences_json(warm))["oil_temperature"]["a"]["mean_k"] == 313.15


def test_serial_numbers_seeds_of_noise_and_folders_of_logs_are_no_settings_that_differ(found):
    a, b = (
        replace(
            found.a,
            settings={"specimen": {"serial": serial}},
            details={"seed": serial, "folder": f"logs {serial}"},
        )
        for serial in ("7", "8")
    )
    changed = replace(found, a=a, b=b)
    assert settings_that_differ(changed) == ()
    assert "before, cylinder 7, " in differences_page(changed, ())


def test_a_and_b_are_drawn_beside_each_other_with_their_measured_speeds_in_the_data(found):
    figure = draw_pair(found.curves[0], found)
    above = figure.axes[0]
    a, b = (bars.lines[0] for bars in above.containers)
    assert a.get_xdata() == pytest.approx(b.get_xdata())
    left, right = (line.get_transform().transform((100.0, 400.0))[0] for line in (a, b))
    assert right - left == pytest.approx(0.08 * figure.dpi)
    assert above.get_ylim()[1] > max(b.get_ydata())


def test_no_line_of_a_comparison_is_wider_than_a_terminal(found):
    assert max(map(len, differences_text(found).splitlines())) <= 80
