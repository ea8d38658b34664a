"""Figures of a preview: a file's position, speed, pressures and forces over time."""

from collections.abc import Iterator

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from hbench.records import ImportPreview, PreviewedFile, PreviewedLog, PreviewedRun
from hbench.report.import_preview.names import display, symbol
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches

_MOST_SAMPLES = 1600  # of a line; a longer log is drawn by its lowest and highest values
_MOST_NUMBERS = 24  # runs whose numbers fit above the position
_REST, _ACCEPTED, _REJECTED = style.COLOURS[5], style.COLOURS[2], style.COLOURS[1]
_GAP = 10  # medians of the steps of time: a longer step breaks a line
_VISIBLE = 0.005  # of a channel's range: a smaller zero offset is not drawn
_PRESSURES = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa")
_FORCES = ("f_applied_n", "f_drive_n")
_HEIGHT_IN = {"x": 1.9, "v": 1.7, "p": 2.0, "f": 1.7}


def draw_preview(preview: ImportPreview) -> dict[str, Drawing]:
    """Draw the files that have samples; return their figures by the files' names."""
    sketches = []
    files = [file for file in preview.files if file.log is not None]
    for number, file in enumerate(files, start=1):
        with rc_context(style.RC):
            figure = draw_file(file)
        title = style.safe(file.name, most=80)
        sketches.append(Sketch(f"file-{number}", file.series, title, _caption(file), figure))
    drawn = draw_sketches(sketches)
    return {file.name: drawing for file, drawing in zip(files, drawn, strict=True)}


def draw_file(file: PreviewedFile) -> Figure:
    """Draw a file's channels over time, its rest, and the steady window of each run."""
    assert file.log is not None
    log = file.log
    rows = ["x", "v"]
    rows += ["p"] if _logged(file, _PRESSURES) else []
    rows += ["f"] if _logged(file, _FORCES) else []
    heights = [_HEIGHT_IN[row] for row in rows]
    figure = style.new_figure(height_in=sum(heights) + 0.9, wide=True)
    panels = figure.subplots(len(rows), sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    for row, axes in zip(rows, panels, strict=True):
        _PANELS[row](axes, file, log)
        _shade(axes, file, log)
        if row == rows[min(2, len(rows) - 1)]:
            _limits(axes, log)
        if len(axes.get_legend_handles_labels()[1]) > 1:
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.3)
    _number(panels[0], file.runs)
    figure.align_ylabels(panels)
    panels[0].set_title(style.safe(file.name, most=80), pad=14 if file.runs else 6)
    panels[-1].set_xlabel("Time (s)")
    _legend(figure, file, log)
    return figure


def _logged(file: PreviewedFile, names: tuple[str, ...]) -> list[str]:
    """Return the channels among ``names`` that are columns of the file."""
    columns = {channel.name for channel in file.channels if channel.column}
    return [name for name in names if name in columns]


def _position(axes: Axes, file: PreviewedFile, log: PreviewedLog) -> None:
    unit, factor = display(log.units["x_m"])
    t_s, x = log.channels["t_s"], factor * log.channels["x_m"]
    axes.plot(*_thinned(t_s, x), color="#000000", linewidth=1.0, label="_position")
    for run in file.runs:
        if run.at_speed_s is not None:
            inside = (t_s >= run.at_speed_s[0]) & (t_s <= run.at_speed_s[1])
            look = {"color": style.COLOURS[0], "linewidth": 2.6, "solid_capstyle": "round"}
            axes.plot(*_thinned(t_s[inside], x[inside]), label="_nolegend_", **look)
    axes.set_ylabel(f"Position ({unit})")
    axes.margins(y=0.08)


def _speed(axes: Axes, file: PreviewedFile, log: PreviewedLog) -> None:
    unit, factor = display(log.units.get("v_m_s", log.units["x_m"] + "/s"))
    t_s = log.channels["t_s"]
    if "v_m_s" in log.channels:
        v = factor * log.channels["v_m_s"]
        axes.plot(*_thinned(t_s, v), color=style.COLOURS[4], linewidth=0.8, label="logged")
    blocks = factor * log.block_v_m_s
    label = "of the position"
    axes.plot(*_thinned(log.block_t_s, blocks), color="#000000", linewidth=1.0, label=label)
    if "v_ref_m_s" in log.channels:
        logged = factor * log.channels["v_ref_m_s"]
        look = {"color": style.COLOURS[2], "linestyle": "--", "linewidth": 1.2}
        axes.plot(*_thinned(t_s, logged), label="logged reference", **look)
    label = "nominal"
    for run in file.runs:
        if run.at_speed_s is not None:
            v_ref = factor * run.screened.run.plan.v_ref_m_s
            look = {"color": style.COLOURS[0], "linestyle": "--", "linewidth": 1.4}
            axes.plot(run.at_speed_s, (v_ref, v_ref), label=label, **look)
            label = "_nolegend_"
    axes.set_ylabel(f"Speed ({unit})")


def _pressures(axes: Axes, file: PreviewedFile, log: PreviewedLog) -> None:
    _lines(axes, file, log, _PRESSURES)
    axes.set_ylabel("Pressure (bar)")


def _forces(axes: Axes, file: PreviewedFile, log: PreviewedLog) -> None:
    _lines(axes, file, log, _FORCES)
    unit, _ = display(log.units[_logged(file, _FORCES)[0]])
    axes.set_ylabel(f"{'Torque' if 'm' in unit else 'Force'} ({unit})")


_PANELS = {"x": _position, "v": _speed, "p": _pressures, "f": _forces}


def _lines(axes: Axes, file: PreviewedFile, log: PreviewedLog, names: tuple[str, ...]) -> None:
    """Draw channels, and dotted what they were before the zero offset was subtracted."""
    zeros = {channel.name: channel.zero for channel in file.channels}
    t_s = log.channels["t_s"]
    for number, name in enumerate(_logged(file, names)):
        _, factor = display(log.units[name])
        values, colour = factor * log.channels[name], style.COLOURS[number]
        axes.plot(*_thinned(t_s, values), color=colour, linewidth=1.0, label=symbol(name))
        zero = zeros.get(name) or 0.0
        if abs(zero) > _VISIBLE * np.ptp(values[np.isfinite(values)] / factor):
            look = {"color": colour, "linewidth": 1.0, "linestyle": ":"}
            label = f"{symbol(name)}, as logged"
            axes.plot(*_thinned(t_s, values + factor * zero), label=label, **look)


def _limits(axes: Axes, log: PreviewedLog) -> None:
    """Mark the samples at which a sensor is at a limit of its converter."""
    clipped = log.channels.get("sensor_saturated", np.zeros(0)) > 0
    if clipped.any():
        t_s = log.channels["t_s"][clipped]
        t_s = t_s[:: -(-len(t_s) // _MOST_SAMPLES)]
        at_bottom = {"transform": axes.get_xaxis_transform(), "clip_on": False}
        look = {"color": _REJECTED, "linestyle": "none", "marker": "|", "markersize": 7}
        axes.plot(t_s, np.zeros(len(t_s)), label="a sensor at its limit", **look, **at_bottom)


def _shade(axes: Axes, file: PreviewedFile, log: PreviewedLog) -> None:
    """Shade the rest, the averaged windows of accepted runs, and rejected runs."""
    if log.rest_s is not None:
        axes.axvspan(*log.rest_s, color=_REST, alpha=0.22, linewidth=0, zorder=0)
    for run in file.runs:
        start, stop = window_of(run)
        if run.screened.accepted:
            axes.axvspan(start, stop, color=_ACCEPTED, alpha=0.20, linewidth=0, zorder=0)
        else:
            look = {"facecolor": "none", "edgecolor": _REJECTED, "alpha": 0.7, "linewidth": 0}
            axes.axvspan(start, stop, hatch="//", zorder=0, **look)


def window_of(run: PreviewedRun) -> tuple[float, float]:
    """Return the steady window [s]; without one, what is at the reference speed, or all."""
    means = run.screened.means
    if means is not None:
        return means.t_start_s, means.t_stop_s
    return run.at_speed_s or run.span_s


def _number(axes: Axes, runs: tuple[PreviewedRun, ...]) -> None:
    """Write the number of each run above its window."""
    for run in runs if len(runs) <= _MOST_NUMBERS else ():
        start, stop = window_of(run)
        axes.annotate(
            run.screened.run.plan.run.lstrip("0"),
            ((start + stop) / 2, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
            fontsize=8.5,
            color=style.QUIET if run.screened.accepted else _REJECTED,
        )


def _legend(figure: Figure, file: PreviewedFile, log: PreviewedLog) -> None:
    """Explain the shades that occur."""
    handles = []
    if log.rest_s is not None:
        handles.append(Patch(color=_REST, alpha=0.3, label="rest"))
    if any(run.screened.accepted for run in file.runs):
        handles.append(Patch(color=_ACCEPTED, alpha=0.3, label="averaged (accepted)"))
    if any(not run.screened.accepted for run in file.runs):
        look = {"facecolor": "none", "edgecolor": _REJECTED, "hatch": "//", "linewidth": 0.5}
        handles.append(Patch(label="rejected", **look))
    if handles:
        figure.legend(handles=handles, ncols=len(handles), loc="outside lower left")


def _thinned(t_s: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a line with at most some samples: the lowest and the highest of each interval.

    The line is broken where the log has a gap.
    """
    if len(t_s) > _MOST_SAMPLES:
        size = -(-len(t_s) // (_MOST_SAMPLES // 2))
        kept = np.unique(list(_extremes(values, size)))
        t_s, values = t_s[kept], values[kept]
    return style.broken_line(t_s, values, _GAP)


def _extremes(values: np.ndarray, size: int) -> Iterator[int]:
    for start in range(0, len(values), size):
        part = values[start : start + size]
        if np.isfinite(part).any():
            yield start + int(np.nanargmin(part))
            yield start + int(np.nanargmax(part))


def _caption(file: PreviewedFile) -> str:
    parts = []
    if any(run.at_speed_s is not None for run in file.runs):
        parts.append("Position: thick where the speed is constant.")
    if file.runs:
        parts.append("Numbers: runs, as in the table below.")
    if any(channel.zero for channel in file.channels):
        parts.append("Dotted: as logged, before the zero offset was subtracted.")
    parts.append("Speed: from the position, over 0.1 s.")
    return " ".join(parts)
