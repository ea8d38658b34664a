"""A page states what was measured, on what, and whether the campaign was completed."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.identification.steady_curves import laws_along_curves
from hbench.records import Fit, IdentifiedLaw, QualityCheck
from hbench.report.campaign.page import report_document
from hbench.report.campaign.quality.verdict import quality_verdict
from hbench.report.campaign.terminal import summary_text
from hbench.report.identification.text import parameter_words
from hbench.report.render.document import page
from hbench.report.render.markdown import markdown


@pytest.fixture
def named(small):
    settings = small.provenance.settings | {
        "specimen": {"serial": "HC-0007", "maker": "Acme <b>", "bore": "40 mm", "rod": "25 mm"},
        "test": {"operator": "M. Weber", "number": "T-12"},
        "instruments": {
            "force": {"calibration": {"serial": "F1", "certificate": "D-K 17", "due": "2027-01-31"}}
        },
    }
    return replace(small, provenance=replace(small.provenance, settings=settings))


def test_the_head_of_a_report_has_the_identity_of_the_test(named):
    made = report_document(named, ())
    facts = dict(made.identity)
    assert facts["Cylinder"] == "HC-0007" and facts["Dimensions"] == "bore 40 mm, rod 25 mm"
    assert facts["Operator"] == "M. Weber" and facts["Test number"] == "T-12"
    assert facts["Instruments"] == "force (no. F1, certificate D-K 17, due 2027-01-31)"
    text = page(made)
    assert "Acme &lt;b&gt;" in text and text.index("HC-0007") < text.index("<h2")
    assert "**Cylinder:** HC-0007" in markdown(made)


def test_a_report_without_identity_says_that_none_was_recorded(small):
    facts = dict(report_document(small, ()).identity)
    assert facts["Cylinder"] == "no serial number recorded"
    imported = replace(small, provenance=replace(small.provenance, source="imported"))
    facts = dict(report_document(imported, ()).identity)
    assert facts["Cylinder"] == "no serial number recorded"
    assert facts["Instruments"] == "no calibration recorded"


def test_begin_and_end_are_stated_with_their_date_once_and_equal_ones_once(small):
    def measured(stopped):
        times = {"started": "2026-01-01T08:00:00+00:00", "stopped": f"2026-01-01T{stopped}+00:00"}
        made = replace(small, provenance=replace(small.provenance, **times))
        return dict(report_document(made, ()).identity)["Simulated time"]

    assert measured("08:07:50") == "2026-01-01 08:00:00 to 08:07:50 UTC"
    assert measured("08:00:00") == "2026-01-01 08:00:00 UTC for every run"


def test_an_aborted_campaign_has_its_alarm_before_everything_else(small):
    assert report_document(small, ()).alarm == ""
    completeness = replace(
        small.quality.completeness, planned=96, not_completed=tuple(map(str, range(40)))
    )
    last = small.runs[-1]
    stopped = replace(last, reasons=(f"aborted: run {last.run.plan.run}: the board stopped",))
    broken = replace(
        small,
        runs=(*small.runs[:-1], stopped),
        quality=replace(small.quality, completeness=completeness),
    )
    made = report_document(broken, ())
    assert made.alarm.startswith("ABORTED CAMPAIGN: 56 of 96 planned runs were completed.")
    number, motion = last.run.plan.run, r"\(steady, [−0-9.]+ mm/s, [−0-9]+ N\)"
    assert re.search(rf"Run {number} {motion} ended early: the board stopped\.", made.alarm)
    assert made.tab.endswith("(simulated, incomplete)")  # also in the header of each sheet
    text = page(made)
    assert text.index('class="alarm"') < text.index('class="banner') < text.index("<h2")
    terminal = " ".join(summary_text(broken).split())
    assert "(simulated) ABORTED CAMPAIGN: 56 of 96 planned runs were completed." in terminal
    assert "ended early: the board stopped." in terminal and terminal.count("56 of 96") == 1
    summary = dict(made.sections[0].facts)
    assert f"{len(small.runs)} steady runs" in summary["Measured"]
    assert "of which 1 was interrupted" in summary["Measured"]
    fits = next(section for section in made.sections if section.title == "Fitted laws")
    assert all(part.folded for part in fits.parts) and "unfinished" in fits.paragraphs[0]
    assert "Next step: find and correct the cause of the stop. Continue" in made.verdict
    slow = "aborted: the speed was off by more than limits.speed_error for limits.unknown"
    limits = replace(broken.provenance, settings={"limits": {"speed_error": "40 mm/s"}})
    off = replace(broken, runs=(*small.runs[:-1], replace(last, reasons=(slow,))))
    alarm = report_document(replace(off, provenance=limits), ()).alarm
    assert "by more than 40 mm/s (limits.speed_error) for limits.unknown." in alarm
    halted = replace(last, reasons=("aborted: interrupted by the operator",))
    by_hand = report_document(replace(broken, runs=(*small.runs[:-1], halted)), ())
    assert "cause of the stop" not in by_hand.verdict and "--resume" in by_hand.verdict
    left = replace(last, reasons=("unfinished: hbench ended before the run did",))
    alarm = report_document(replace(broken, runs=(*small.runs[:-1], left)), ()).alarm
    assert alarm.startswith("INCOMPLETE CAMPAIGN: 56 of 96")
    assert f"hbench ended during run {last.run.plan.run}, or is still making it." in alarm
    running = replace(broken, runs=small.runs)
    assert report_document(running, ()).alarm.startswith("INCOMPLETE CAMPAIGN: 56 of 96")


def test_the_alarm_alone_states_that_the_numbers_are_those_of_the_completed_runs(small):
    completeness = replace(
        small.quality.completeness, planned=96, not_completed=tuple(map(str, range(40)))
    )
    complete = QualityCheck("complete", "poor", 58.0, "%", 100.0, 80.0, count=56, of=96)
    quality = replace(
        small.quality, grade="poor", completeness=completeness, checks=(complete,), implausible=()
    )
    made = report_document(replace(small, quality=quality), ())
    assert "are those of the completed runs" in made.alarm
    assert "completed runs" not in made.verdict and "The data is poor." in made.verdict
    assert "The numbers below are those of the completed runs." in quality_verdict(quality)


def test_an_identified_law_is_drawn_along_the_measured_speeds(small):
    curve = small.curves[0]
    section = {
        "law": "tustin", "coulomb": "300 N", "stiction": "480 N", "stribeck_velocity": "50 mm/s",
        "viscous": "1300 N s/m", "piston_seal": "0 N/bar", "rod_seal": "0 N/bar",
        "stribeck_exponent": 1.0, "scatter": "0 %",
    }  # fmt: skip
    law = IdentifiedLaw("tustin", Fit("tustin", {}, 0.0, True, ""), section=section)
    (along,) = laws_along_curves([curve], [law])
    v = along.v_m_s
    assert (v[0], v[-1]) == (curve.points[0].v_m_s, curve.points[-1].v_m_s)
    expected = 300 + 180 * np.exp(-v / 0.05) + 1300 * v
    np.testing.assert_allclose(along.friction_n["tustin"], expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "words", "unit"),
    [
        ("v_stribeck_m_s", "Stribeck velocity v_s", "mm/s"),
        ("theta_2_n", "Force of element 2 θ_2", "N"),
        ("extend_low_force_n", "Force at rest a_1, extending", "N"),
        ("own_n", "own_n", "N"),
    ],
)
def test_parameters_of_identified_laws_have_titles_and_symbols(name, words, unit):
    assert parameter_words(name, "N") == (words, unit)
