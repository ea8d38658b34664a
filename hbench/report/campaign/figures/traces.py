"""Small traces of rejected runs, a figure a reason: the channel that shows why."""

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
        _trace(axes, run, lines_of(run.run), code, first=axes is all_axes[0])
        axes.set_ylabel(name, fontsize=9)
    all_axes[-1].set_xlabel("Time (s)")
    style.head(all_axes[0], f"Rejected: {code.replace('_', ' ')}", results)
    more = f"{len(runs)} runs; the first {len(shown)}" if len(runs) > len(shown) else "All runs"
    style.read_as(figure, f"{more} of this reason. Grey: steady window. Crosses: at a limit.")
    style.legend_above(figure, all_axes[0])
    return figure


def _trace(axes: Axes, screened: ScreenedRun, lines: list[_Line], code: str, first: bool) -> None:
    run, plan = screened.run, screened.run.plan
    step = -(-len(run.t_s) // _MOST_SAMPLES)
    mark = "" if first else "_"  # one legend for all
    if screened.means is not None:
        axes.axvspan(screened.means.t_start_s, screened.means.t_stop_s, color="#e5e7eb", zorder=0)
    for number, line in enumerate(lines):
        look: dict[str, Any] = {"color": style.QUIET, "linestyle": "--"} if line.dashed else {}
        look = {"color": _LINES[number % len(_LINES)], "linewidth": 1.0, **look}
        label = f"{mark}{line.label}, run {style.safe(plan.run)}" if mark else line.label
        axes.plot(*_broken(run.t_s[::step], line.values[::step]), label=label, **look)
    flags = {"sensor_saturated": run.sensor_saturated, "valve_saturated": run.valve_saturated}
    flagged = flags.get(code)
    if flagged is not None and flagged.any() and lines:
        at = np.flatnonzero(flagged)
        at = at[:: -(-len(at) // 60)]
        largest = np.max([np.abs(line.values) for line in lines], axis=0)
        axes.plot(run.t_s[at], largest[at], "x", color=style.COLOURS[1], markersize=4, zorder=4)
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
    axes.margins(y=0.25)


def _broken(t_s: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Break a line where the log has a gap."""
    steps = np.diff(t_s)
    if not len(steps):
        return t_s, values
    gaps = np.flatnonzero(steps > 2.5 * np.median(steps)) + 1
    return np.insert(t_s, gaps, np.nan), np.insert(values.astype(float), gaps, np.nan)


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
    names = ("p_tp_pa", "p_tr_pa", "p_s_pa")
    channels = {CHANNELS[name].symbol: getattr(run, name) for name in names}
    return [_Line(label, values / 1e5) for label, values in channels.items() if values is not None]


def _valves(run: Run) -> list[_Line]:
    channels = {"test valve": run.u_t_v, "load valve 1": run.u_l1_v, "load valve 2": run.u_l2_v}
    return [_Line(label, values) for label, values in channels.items() if values is not None]


_SPEED = ("Velocity (mm/s)", _speeds)
_POSITION = ("Position (mm)", _positions)
# The channel drawn for each reason; position for all others, such as a gap or an early end.
_CHANNELS: dict[str, tuple[str, Callable[[Run], list[_Line]]]] = {
    "off_reference": _SPEED,
    "not_steady": _SPEED,
    "too_short": _SPEED,
    "incomplete": _SPEED,
    "sensor_saturated": ("Pressure (bar)", _sensors),
    "valve_saturated": ("Valve (V)", _valves),
}
