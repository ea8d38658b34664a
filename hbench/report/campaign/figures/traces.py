"""Small traces of rejected runs, a figure a reason: the channel that shows why."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.channels import CHANNELS
from hbench.records import Results, Run, ScreenedRun
from hbench.report.campaign.reasons import code_of, reason_counts
from hbench.report.render import style
from hbench.report.render.numbers import short

MOST_RUNS = 4  # of a reason; the table has them all
MOST_REASONS = 8
_MOST_SAMPLES = 600  # of a trace; a longer log is thinned
_SYMBOL = re.compile(r"(\w)_(\w+)")
_HEADROOM = 0.4  # of a trace's range, for the caption above it
_GAP = 2.5  # medians of the steps of time: a longer step breaks a line
_FLAGS = ("sensor_saturated", "valve_saturated")  # reasons with marked records
# Of a sensor at its limit, by its SI unit: label of the axis, and its unit per SI unit.
_SENSOR_AXES = {
    "m": ("Position (mm)", 1e3),
    "Pa": ("Pressure (bar)", 1e-5),
    "N": ("Force (N)", 1.0),
}
_LINES = (style.COLOURS[0], style.COLOURS[2], style.COLOURS[3], style.COLOURS[4])


@dataclass(frozen=True)
class _Line:
    label: str
    values: np.ndarray
    dashed: bool = False


def has_traces(results: Results) -> bool:
    """Return whether a rejected run has samples to draw."""
    return any(len(run.run.t_s) for run in results.runs if not run.accepted)


def traces(results: Results) -> dict[str, Figure]:
    """Draw the first rejected runs of each of the most frequent reasons over time [s]."""
    figures = {}
    rejected = [run for run in results.runs if not run.accepted and len(run.run.t_s)]
    for code, _ in reason_counts(results).most_common(MOST_REASONS):
        if code in _WITHOUT_TRACE:
            continue
        runs = [run for run in rejected if any(code_of(r) == code for r in run.reasons)]
        if runs:
            figures[code] = _figure(results, code, runs)
    return figures


def _figure(results: Results, code: str, runs: list[ScreenedRun]) -> Figure:
    shown = runs[:MOST_RUNS]
    figure = style.new_figure(height_in=1.5 + 1.15 * len(shown))
    all_axes = figure.subplots(len(shown), squeeze=False)[:, 0]
    name, lines_of = _CHANNELS.get(code, _POSITION)
    for axes, run in zip(all_axes, shown, strict=True):
        limited = _limited(run, code)
        own_name, lines = _lines_of_limited(run.run, limited) or (name, lines_of(run.run))
        _trace(axes, run, lines, code, limited, first=axes is all_axes[0])
        axes.set_ylabel(own_name, fontsize=9)
    all_axes[-1].set_xlabel("Time (s)")
    style.head(all_axes[0], f"Rejected: {code.replace('_', ' ')}", results)
    more = f"{len(runs)} runs; the first {len(shown)}" if len(runs) > len(shown) else "All runs"
    grey = " Grey: steady window." if any(run.means is not None for run in shown) else ""
    crosses = " Crosses: at a limit." if code in _FLAGS else ""
    style.read_as(figure, f"{more} of this reason.{grey}{crosses}")
    style.legend_above(figure, all_axes[0])
    return figure


def _limited(screened: ScreenedRun, code: str) -> list[str]:
    """Return the channels that the reason reports at a limit, such as "P_S is at its maximum"."""
    reasons = " ".join(reason for reason in screened.reasons if code_of(reason) == code)
    symbols = re.findall(r"(\w+) is (?:at its|constant at)", reasons) if code in _FLAGS else []
    return [name for name, channel in CHANNELS.items() if channel.symbol in symbols]


def _lines_of_limited(run: Run, limited: list[str]) -> tuple[str, list[_Line]] | None:
    """Return the axis label and the sensors at a limit; None where a valve is, or none is known.

    Sensors of another unit than the first are left out.
    """
    units = [CHANNELS[name].unit for name in limited]
    if not units or units[0] not in _SENSOR_AXES:
        return None
    label, scale = _SENSOR_AXES[units[0]]
    names = [name for name, unit in zip(limited, units, strict=True) if unit == units[0]]
    return label, [_Line(CHANNELS[name].symbol, scale * run.channel(name)) for name in names]


def _trace(
    axes: Axes,
    screened: ScreenedRun,
    lines: list[_Line],
    code: str,
    limited: list[str],
    first: bool,
) -> None:
    run, plan = screened.run, screened.run.plan
    step = -(-len(run.t_s) // _MOST_SAMPLES)
    mark = "" if first else "_"  # one legend for all
    if screened.means is not None:
        axes.axvspan(screened.means.t_start_s, screened.means.t_stop_s, color="#e5e7eb", zorder=0)
    for number, line in enumerate(lines):
        look: dict[str, Any] = {"color": style.QUIET, "linestyle": "--"} if line.dashed else {}
        look = {"color": _LINES[number % len(_LINES)], "linewidth": 1.0, **look}
        shown = _SYMBOL.sub(r"$\1_{\2}$", line.label)  # the index is set below the line
        label = f"{mark}{shown}, run {style.safe(plan.run)}" if mark else shown
        points = style.broken_line(run.t_s[::step], line.values[::step], _GAP)
        axes.plot(*points, label=label, **look)
    flagged = getattr(run, code) if code in _FLAGS else None
    if flagged is not None and flagged.any() and lines:
        at = np.flatnonzero(flagged)
        at = at[:: -(-len(at) // 60)]
        symbols = {CHANNELS[name].symbol for name in limited}
        crossed = [line for line in lines if line.label in symbols] or lines
        if code == "valve_saturated" and not symbols:  # the one nearest to the voltage limit
            crossed = [max(lines, key=lambda line: np.abs(line.values[flagged]).mean())]
        for line in crossed:
            values = line.values[at]
            axes.plot(run.t_s[at], values, "x", color=style.COLOURS[1], markersize=4, zorder=4)
    axes.tick_params(labelsize=8)
    load = "" if plan.f_load_n is None else f", {short(plan.f_load_n)} N"
    caption = f"run {style.safe(plan.run, 20)}: {short(1e3 * plan.v_ref_m_s)} mm/s{load}"
    axes.annotate(
        caption,
        (0.995, 0.96),
        xycoords="axes fraction",
        ha="right",
        va="top",
        fontsize=8.5,
        zorder=5,
    )
    axes.margins(y=0.1)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + _HEADROOM * (high - low))


def _speeds(run: Run) -> list[_Line]:
    if run.v_m_s is not None:
        speed = run.v_m_s
    else:
        speed = np.gradient(run.x_m, run.t_s) if len(run.t_s) > 1 else np.zeros(len(run.t_s))
    reference = run.v_ref_m_s
    if reference is None:
        reference = np.full(len(run.t_s), run.plan.v_ref_m_s)
    return [_Line("velocity", 1e3 * speed), _Line("reference", 1e3 * reference, dashed=True)]


def _positions(run: Run) -> list[_Line]:
    lines = [_Line("position", 1e3 * run.x_m)]
    stroke = run.plan.specimen.stroke_m
    if stroke is not None:
        ends = np.ones(len(run.t_s))
        lines.append(_Line("ends of the stroke", 0 * ends, dashed=True))
        lines.append(_Line("_end of the stroke", 1e3 * stroke * ends, dashed=True))
    return lines


def _sensors(run: Run) -> list[_Line]:
    return _measured(run, ("p_tp_pa", "p_tr_pa", "p_s_pa"), 1e-5)


def _valves(run: Run) -> list[_Line]:
    return _measured(run, ("u_t_v", "u_l1_v", "u_l2_v"), 1.0)


def _measured(run: Run, names: tuple[str, ...], scale: float) -> list[_Line]:
    known = [name for name in names if getattr(run, name) is not None]
    return [_Line(CHANNELS[name].symbol, scale * run.channel(name)) for name in known]


_SPEED = ("Velocity (mm/s)", _speeds)
_POSITION = ("Position (mm)", _positions)
# A checksum that differs and an early end do not show in a channel.
_WITHOUT_TRACE = ("changed", "truncated")
# The channel drawn for each reason; position for all others, such as a gap.
_CHANNELS: dict[str, tuple[str, Callable[[Run], list[_Line]]]] = {
    "off_reference": _SPEED,
    "not_steady": _SPEED,
    "too_short": _SPEED,
    "incomplete": _SPEED,
    "sensor_saturated": ("Pressure (bar)", _sensors),
    "valve_saturated": ("Valve (V)", _valves),
}
