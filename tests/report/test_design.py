"""Text, page and figures of a design, from records alone."""

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from hbench.config.schedule import Screening
from hbench.records import Check, DesignBasis, MarginRange
from hbench.report.design.checks import check_rows
from hbench.report.design.figures import draw_design
from hbench.report.design.page import design_page
from hbench.report.design.text import design_json, design_text
from hbench.report.render.document import Document
from tests.support.report.made_design import drawings_of_design, made_design
from tests.support.report.spaces import ordinary_spaces


@pytest.fixture(scope="module")
def design():
    return made_design()


def shown(design):
    """Return the text of the terminal without its lines."""
    return " ".join(design_text(design).split())


def test_the_terminal_gets_numbers_verdict_and_reasons_in_ascii(design):
    text = shown(design)
    assert text.isascii()
    assert "-110.76" in text and "-148.40" in text and "+34.00" in text and "NO" in text
    assert re.search(r"FAIL: .* 1 of 2 checks in .*ratio", text)
    assert "gain: 1500 V/m" in text and "time_constant: 18 ms" in text


def test_a_margin_without_limit_is_infinite_and_in_json_null(design):
    row = next(line for line in design_text(design).splitlines() if "ideal valve" in line)
    assert row.split()[-4:-1] == ["inf", "0.0", "-"]
    numbers = json.loads(design_json(design))
    first = numbers["loops"][0]["chains"][0]
    assert first["gain_margin"] is None and first["settling_s"] is None
    assert numbers["proposal"]["holds"] is False


@pytest.fixture(scope="module")
def drawings():
    return drawings_of_design()


def test_the_page_holds_everything_and_escapes_names(design, drawings):
    page = design_page(design, drawings)
    assert "<b>bench</b>" not in page and "&lt;b&gt;bench" in page
    verdict = page[page.index('class="verdict"') : page.index("<h2")]
    assert "&lt;+200\N{NO-BREAK SPACE}mm/s&gt;" in page and " 1 of 2 checks" in verdict
    assert page.count('class="plot"') == len(drawings) == 8  # with present and proposed gains


def test_a_loop_that_is_unstable_is_marked_and_has_no_overshoot(design):
    loop = design.loops[0]
    board = replace(loop.merits[-1], digital_modulus=1.01, overshoot=3e5)
    unstable = replace(design, loops=(replace(loop, merits=(*loop.merits[:-1], board)),))
    page = design_page(unstable, ())
    assert page.count("unstable</span>") == 1 and "30000000" not in page
    row = next(line for line in design_text(unstable).splitlines() if " board " in line)
    assert row.split()[-3:] == ["-", "-", "UNSTABLE"]


def test_a_checks_value_shows_on_which_side_of_its_limit_it_is():
    passing = Check("velocity: phase margin", 45.3, 45.0, "deg", True)
    failing = Check("velocity: phase margin", 44.96, 45.0, "deg", False)
    beyond = Check("bench: overshoot", 20.3, 20.0, "mm/s", False)
    rows = check_rows((passing, failing, beyond))
    assert [row[1] for row in rows] == ["45.3", "44.96", "20.3"]


def test_the_page_begins_with_what_it_was_computed_from(design):
    basis = DesignBasis("2026-11-25", "bench.yaml", 0.04, 0.025, 0.4, 1.4e7, (0.005, 0.375), 2.3e7,
                        0.4, (5.7205, 34.0682), False)  # fmt: skip
    page = ordinary_spaces(design_page(replace(design, basis=basis), ()))
    top = page[: page.index("<h2")]
    for words in ("2026-11-25", "bench.yaml", "bore 40 mm, rod 25 mm, stroke 400 mm", "140 bar"):
        assert words in top
    assert "position 5 to 375 mm, pressure 230 bar, speed 400 mm/s" in top
    text = shown(replace(design, basis=basis))
    assert "The bench file has 5.72 and 34.1 V s/m (not enabled)" in text


def test_the_check_of_stability_compares_a_modulus_with_its_limit():
    (row,) = check_rows((Check("all loops: largest modulus", 0.999923, 1.0, "", True),))
    assert row[:3] == ("all loops together: largest pole |z|", "0.999923", "< 1")


def test_present_gains_pass_or_fail_with_the_check_first(design):
    checks = (
        Check("velocity: phase margin", 50.0, 45.0, "deg", True),
        Check("velocity: gain margin", 5.7, 6.0, "dB", False),
    )
    page = ordinary_spaces(design_page(replace(design, proposal=None, checks=checks), ()))
    verdict = page[page.index('class="verdict"') :].partition("</p>")[0]
    assert (
        "FAIL: the present gains fail 1 of 2 checks at the operating point of this design "
        "(position 1000 mm, speed +1000 mm/s, load +500 N): gain margin 5.7 dB "
        "(limit 6 dB) in the velocity loop."
    ) in verdict
    assert "velocity loop from 800 to 772 V/m" in verdict  # 800 V/m less 0.3 dB
    assert "--propose" in verdict and page.index(">FAIL<") < page.index(">PASS<")
    assert page.index("Velocity: gain margin") < page.index("Velocity: phase margin")
    passing = replace(design, proposal=None, checks=checks[:1])
    assert "PASS: the present gains pass all 1 checks" in design_page(passing, ())
    assert json.loads(design_json(passing))["checks"][0]["holds"] is True


def test_the_page_explains_that_limits_of_speed_depend_on_the_speed(design):
    """The limits of the screening: 0.5 mm/s at 5 mm/s, 2 mm/s at 200 mm/s; ripple 2 and 10 mm/s."""
    rules = Screening()
    assert [1e3 * rules.speed_limit(v) for v in (0.005, 0.2)] == pytest.approx([0.5, 2.0])
    page = ordinary_spaces(design_page(design, ()))
    checks = page[page.index(">Checks</h2>") :]
    stated = "The limits of the mean speed error and of the speed ripple are those of the screening"
    assert f"{stated} and depend on the speed" in checks[: checks.index("<table")]


def test_the_verdict_emphasises_what_passes_or_fails_with_the_word_itself():
    rest = "A sentence on the method follows here. " * 9
    for verdict, emphasised in (
        (
            f"FAIL. Do not use the gains. {rest}",
            "FAIL. Do not use the gains.",
        ),  # one word has the next
        (f"Friction is 4 N. {rest}", "Friction is 4 N."),
    ):
        first, others = Document("t", "", (), verdict.strip()).headline
        assert first == emphasised and others == rest.strip()


def test_a_proposal_states_that_the_present_gains_fail(design):
    failed = Check("velocity: gain margin", 5.7, 6.0, "dB", False)
    stated = (
        "The present gains fail 1 of 1 checks at the operating point of this design (position "
        "1000 mm, speed +1000 mm/s, load +500 N): gain margin 5.7 dB "
        "(limit 6 dB) in the velocity loop."
    )
    for closed_loop, verdict in ((design.proposal.closed_loop, "FAIL:"), ((), "PASS:")):
        proposal = replace(design.proposal, closed_loop=closed_loop)
        made = replace(design, checks=(failed,), proposal=proposal)
        assert stated in shown(made)
        page = ordinary_spaces(design_page(made, ()))
        head = page[page.index('class="verdict"') : page.index("<h2")]
        assert verdict in head and stated in head
        assert "Checks at the operating point that the present gains fail" in page
    assert "The present gains fail" not in shown(design)


def test_the_loops_with_the_gains_to_be_used_come_first_and_the_others_are_folded(design, drawings):
    passing = replace(design.proposal, closed_loop=())
    for proposal, first, second in (
        (design.proposal, "present", "proposed"),  # it fails
        (passing, "proposed", "present"),
    ):
        page = design_page(replace(design, proposal=proposal), drawings)
        assert f">Loops with the {first} gains</h2>" in page
        assert f"<summary>Loops with the {second} gains <" in page
        assert page.count(f"Those with the {second} gains are folded") == 1
    numbers = json.loads(design_json(design))
    assert [loop["gain"] for loop in numbers["proposal"]["loops"]] == [1500.0]
    assert "1500 V/m" in shown(design).partition("proposal")[2]


@pytest.mark.parametrize(
    ("others", "step"),
    [
        ({1.3: True}, "With --ratio 1.3 the proposed gains pass all checks"),
        ({1.3: False, 2.3: True}, "With --ratio 2.3 the proposed gains pass all checks"),
        ({1.3: False, 2.3: False}, "was tried passes (1.7, 1.3 and 2.3): correct the bench file"),
    ],
)
def test_a_failing_proposal_states_the_ratio_that_passes_or_that_none_does(design, others, step):
    checks = (Check("softer: overshoot", 30.0, 20.0, "mm/s", False),)
    proposal = replace(design.proposal, closed_loop=checks, other_ratios=others)
    failing = replace(design, proposal=proposal)
    page = re.sub("<.*?>", "", ordinary_spaces(design_page(failing, ())))
    assert step in shown(failing) and step in page
    stated = json.loads(design_json(failing))["proposal"]["other_ratios"]
    assert {each["ratio"]: each["holds"] for each in stated} == others


def test_the_failed_checks_are_in_the_order_of_their_excess_over_the_limit(design):
    checks = (
        Check("bench: mean speed error", 2.7, 2.0, "mm/s", False),
        Check("bench: load pressure error", 25.0, 1.5, "bar", False),
        Check("softer: load pressure error", 26.0, 1.5, "bar", False),
        Check("bench: rejected runs", 1, 0, "runs", False),
    )
    failing = replace(design, proposal=replace(design.proposal, closed_loop=checks))
    assert (
        "The worst: rejected runs 1 (limit 0) on the bench, load pressure error 26 bar (limit "
        "1.5 bar) on the softer bench, mean speed error 2.7 mm/s (limit 2 mm/s) on the bench."
    ) in shown(failing)


@pytest.mark.usefixtures("wide_terminal")
def test_a_cause_that_several_checks_have_is_stated_once_in_words(design):
    stop = (
        "the board stopped itself: speed_error: the speed was off its reference by more than "
        "30 mm/s for 0.5 s"
    )
    at = "+60 mm/s, 500 N"
    checks = tuple(
        Check(f"{plant}: runs cut short", 18, 0, "runs", False, f"{at}: run {run}: {stop}")
        for plant, run in (("bench", "0001"), ("softer", "0001"), ("stiffer", "0015"))
    )
    failing = replace(design, proposal=replace(design.proposal, closed_loop=checks))
    for text in (shown(failing), design_page(failing, ())):
        cause = "at +60 mm/s, 500 N, the speed was off its reference by more than 30 mm/s"
        assert ordinary_spaces(text).count(cause) == 1
        assert ordinary_spaces(text).count(f"{at}: the board stopped itself") == 3


@pytest.mark.slow
def test_every_figure_is_the_same_twice(design, drawings):
    for one, two in zip(drawings, draw_design(design), strict=True):
        assert one.svg == two.svg
        ET.fromstring(one.svg)


def test_bode_tells_margins_and_marks_them_where_they_are_read(design):
    from hbench.report.design.figures import bode, locus, pole_zero, step_figure

    figure = bode(design.loops[0])
    gain, phase = figure.axes
    labels = [line.get_label() for line in gain.lines]
    margins = dict(label.split(": ") for label in labels if "°" in label)
    assert margins["valve"] == "PM 90°, GM 12.0 dB" and margins["ideal valve"] == "PM 90°"
    marks = [line.get_xydata()[0] for line in phase.lines if len(line.get_xydata()) == 1]
    assert marks and all(mark == pytest.approx((100.0, -90.0), abs=0.1) for mark in marks)
    for draw in (bode, locus, pole_zero, step_figure):
        axes = draw(design.loops[0]).axes[-1]
        assert axes.get_xlabel() and axes.get_ylabel()


def test_all_closed_loop_poles_lie_within_the_axes(design):
    from hbench.report.design.figures import locus, pole_zero

    loop = design.loops[0]
    merits = replace(loop.merits[0], poles_rad_s=np.array([-270.0 + 1069.0j, -270.0 - 1069.0j]))
    for draw in (locus, pole_zero):
        plane = draw(replace(loop, merits=(merits, *loop.merits[1:]))).axes[0]
        (left, right), (low, high) = plane.get_xlim(), plane.get_ylim()
        assert left < -270.0 < right and low < -1069.0 and 1069.0 < high


def test_the_worst_operating_point_comes_before_the_one_of_the_design(design):
    """6 dB are asked for: 1.3 dB elsewhere is graver than 5.7 dB here."""
    checks = (
        Check("velocity: phase margin", 50.0, 45.0, "deg", True),
        Check("velocity: gain margin", 5.7, 6.0, "dB", False),
    )
    ranges = {
        "velocity: gain margin": MarginRange(
            3.5, 12.7, "position 190 mm, speed +20 mm/s, load +500 N"
        ),
        "piston pressure: gain margin": MarginRange(
            1.3, 21.6, "position 375 mm, speed -40 mm/s, load -800 N"
        ),
    }
    found = replace(
        design, proposal=None, checks=checks, margin_ranges=ranges, points=54, points_failed=30
    )
    worst = (
        "FAIL: the present gains fail a check at 30 of 54 operating points, worst with 1.3 dB "
        "(limit 6 dB) in the piston pressure loop at position 375 mm, speed -40 mm/s, load -800 N. "
        "Oscillations decay slowly there, and a loop gain 16 % above that of the model makes the "
        "loop unstable"
    )
    here = "The gains also fail 1 of 2 checks at the operating point of this design (position"
    step = "To pass at this point alone, lower the gain K_c of the velocity loop from 800 to 772"
    text = shown(found)
    assert 0 < text.index(worst) < text.index("--propose searches") < text.index(here)
    assert text.index(here) < text.index(step)
    document = json.loads(design_json(found))
    assert document["margin_ranges"]["velocity: gain margin"] == [3.5, 12.7]
    assert document["points_failed"] == 30
    assert "FAIL: the present gains fail a check at 30" in shown(
        replace(found, checks=checks[:1])
    )  # the point of the design alone would pass
    good = {"velocity: gain margin": MarginRange(6.5, 12.7, "position 190 mm")}
    passing = replace(found, checks=checks[:1], margin_ranges=good, points_failed=0)
    assert "PASS: the present gains" in shown(passing)
    text = shown(passing)
    assert "The smallest margins of all points are 6.5 dB in the velocity" in text


def test_the_terminals_checks_have_the_failed_first_and_no_empty_column(design):
    checks = (
        Check("velocity: phase margin", 50.0, 45.0, "deg", True),
        Check("velocity: gain margin", 5.7, 6.0, "dB", False),
    )
    lines = design_text(replace(design, proposal=None, checks=checks)).splitlines()
    at = next(i for i, line in enumerate(lines) if re.match("check  +value", line))
    assert "worst at" not in lines[at]
    assert lines[at + 1].startswith("velocity: gain margin") and lines[at + 1].endswith("FAIL")


def test_no_line_of_a_design_is_wider_than_a_terminal(design):
    assert max(map(len, design_text(design).splitlines())) <= 80
