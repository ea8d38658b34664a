"""Traces of rejected runs: the channel that shows why, in people's units."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.records import Run
from hbench.report.campaign.figures.all_figures import draw_all
from hbench.report.campaign.figures.traces import MOST_RUNS, traces
from hbench.report.campaign.page_tables import cause_table
from hbench.report.campaign.reasons import reason_counts
from hbench.report.campaign.sections.rejected import rejected_sections
from hbench.report.render.figures import of_section
from hbench.report.render.series import series_of

T = np.arange(100) / 100


def rejected(small, count, *reasons, **channels):
    plan = small.runs[0].run.plan
    run = Run(plan, t_s=T, x_m=0.1 + 0.05 * T, **channels)
    bad = replace(small.runs[0], run=run, reasons=reasons)
    named = [replace(bad, run=replace(run, plan=replace(plan, run=str(i)))) for i in range(count)]
    return replace(small, runs=(*named, replace(small.runs[0], reasons=())))


def test_a_speed_that_was_missed_is_shown_beside_its_reference(small):
    results = rejected(small, 1, "off_reference: x", v_m_s=0.04 + 0 * T, v_ref_m_s=0.05 + 0 * T)
    speed, reference = series_of(traces(results)["off_reference"])
    assert (speed.label, reference.label) == ("velocity", "reference")
    assert speed.y_name == "Velocity (mm/s)" and speed.x_name == "Time (s)"
    np.testing.assert_allclose(speed.y, 40.0)
    np.testing.assert_allclose(reference.y, 50.0)


def test_crosses_are_explained_only_where_there_are_some(small):
    figure = traces(rejected(small, 1, "not_steady: x"))["not_steady"]
    assert "Crosses" not in figure.get_supxlabel()


def test_a_run_without_a_logged_velocity_shows_that_of_its_position(small):
    (speed, _) = series_of(traces(rejected(small, 1, "not_steady: x"))["not_steady"])
    np.testing.assert_allclose(speed.y, 50.0)


@pytest.mark.parametrize(
    "code,channel,label,scale",
    [
        ("valve_saturated", "u_t_v", "u_T", 1.0),
        ("sensor_saturated", "p_tp_pa", "P_Tp", 1e-5),
    ],
)
def test_records_at_a_limit_are_crossed(small, code, channel, label, scale):
    values = np.where(T > 0.5, 10.0, 1.0) / scale
    flags = {code: T > 0.5}
    figure = traces(rejected(small, 1, f"{code}: x", **{channel: values}, **flags))[code]
    (line,) = series_of(figure)
    assert line.label == label
    legend = figure.legends[0].get_texts()[0].get_text()
    assert legend == f"${label[0]}_{{{label[2:]}}}$"  # with an index below the line
    assert "Crosses: at a limit." in figure.get_supxlabel()
    np.testing.assert_allclose(line.y, values * scale)
    crosses = [one for one in figure.axes[0].lines if one.get_marker() == "x"]
    assert len(crosses) == 1 and min(crosses[0].get_xdata()) > 0.5


@pytest.mark.parametrize(
    "code,reason,channel,y_name",
    [
        ("sensor_saturated", "F_applied is at its maximum, 12251 N", "f_applied_n", "Force (N)"),
        ("sensor_saturated", "x is constant at 100.0 mm", "x_m", "Position (mm)"),
        ("valve_saturated", "u_L1 is at its minimum, -10.0 V", "u_l1_v", "Valve (V)"),
    ],
)
def test_the_crosses_are_on_the_channel_that_the_reason_names(small, code, reason, channel, y_name):
    logged = {
        "p_s_pa": 150e5 + 0 * T,
        "f_applied_n": 12251 + 0 * T,
        "u_t_v": 12 + 0 * T,
        "u_l1_v": -10 + 0 * T,
    }
    words = f"{code}: {reason}, in 49 of the 100 records of the window (none allowed)"
    rows = rejected(small, 1, words, **logged, **{code: T > 0.5})
    axes = traces(rows)[code].axes[0]
    (crosses,) = [line for line in axes.lines if line.get_marker() == "x"]
    values = rows.runs[0].run.channel(channel) * (1e3 if channel == "x_m" else 1.0)
    np.testing.assert_allclose(crosses.get_ydata(), values[T > 0.5])
    assert axes.get_ylabel() == y_name


def test_a_gap_in_the_log_is_a_gap_in_the_line(small):
    results = rejected(small, 1, "gapped: x")
    keep = (T < 0.3) | (T > 0.6)
    run = replace(results.runs[0].run, t_s=T[keep], x_m=0.1 + 0.05 * T[keep])
    results = replace(results, runs=(replace(results.runs[0], run=run),))
    x, y = traces(results)["gapped"].axes[0].lines[0].get_data()
    assert np.isnan(y).sum() == 1 and np.isnan(y[30])


def test_the_first_runs_of_a_reason_are_shown_and_how_many_there_are(small):
    figure = traces(rejected(small, 9, "end_stop: x"))["end_stop"]
    assert len(figure.axes) == MOST_RUNS
    words = {text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text"))}
    assert any(re.match(rf"9 runs\b.* {MOST_RUNS}\b", word) for word in words)


def test_a_run_without_samples_has_no_trace(small):
    results = rejected(small, 1, "too_short: x")
    run = replace(results.runs[0].run, t_s=T[:0], x_m=T[:0])
    assert traces(replace(results, runs=(replace(results.runs[0], run=run),))) == {}


def test_a_run_counts_once_for_a_reason_that_it_has_twice(small):
    results = rejected(small, 2, "not_steady: speed", "not_steady: friction", "gapped: x")
    assert reason_counts(results) == {"not_steady": 2, "gapped": 2}


def test_what_no_channel_shows_has_no_trace_and_other_reasons_of_the_run_have(small):
    shown = traces(rejected(small, 1, "changed: x", "truncated: x", "gapped: x"))
    assert list(shown) == ["gapped"]


def test_the_caption_of_a_trace_is_above_its_lines(small):
    full = {"u_t_v": 10 + 0 * T, "u_l1_v": 10 * np.sin(9 * T)}
    figure = traces(rejected(small, 4, "valve_saturated: x", **full, valve_saturated=T >= 0))[
        "valve_saturated"
    ]
    figure.draw_without_rendering()
    for axes in figure.axes:
        (caption,) = (text for text in axes.texts if text.get_text().startswith("run "))
        top = axes.transData.transform((0.0, 10.0))[1] + figure.dpi / 72 * 4  # of a cross
        assert caption.get_window_extent().y0 > top
        assert caption.get_window_extent().y1 <= axes.get_window_extent().y1


def test_the_reasons_are_counted_once_in_their_table(stribeck):
    """And not in a figure beside it too."""
    assert sum(int(row[1].text) for row in cause_table(stribeck).rows) == 8
    (section,) = rejected_sections(stribeck, of_section(draw_all(stribeck), "rejected"))[:1]
    drawn = [each.name for part in section.parts for each in part.drawings]
    assert "rejected" not in drawn
