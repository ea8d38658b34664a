"""Figures of the residuals of balances over velocity, load, position and time."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from hbench.records import DIRECTION_WORDS, Diagnosis, ResidualMap
from hbench.records.reconcile.diagnosis import REST_M_S, SIGNIFICANT_P
from hbench.report.diagnosis.figures.colour_scales import PLACES, RESIDUALS, VELOCITIES
from hbench.report.diagnosis.names import (
    AXES,
    added_words,
    balance,
    in_unit,
    of_strokes,
    shown,
)
from hbench.report.diagnosis.words.deviation import largest_deviation
from hbench.report.render import style
from hbench.report.render.series import behind

_WORST = 4  # balances side by side in a map
_CELLS = 24  # of a map, either way
_PARTS = 8  # of an axis, each with its median
_SMALL, _LARGE = 9, 36  # area of a point: of many windows, and of the strokes at one load
_SEEN = 99.0  # percentile that the axis shows
_LEAST = 3.0  # scatters that an axis shows at least, either way
# Each panel's axis, and the quantity of its colours.
_PANELS = (("v_m_s", "load_n"), ("x_m", "load_n"), ("t_s", "load_n"), ("load_n", "v_m_s"))
_AT_ONE_LOAD = (("v_m_s", "x_m"), ("t_s", "x_m"), ("x_m", "v_m_s"))
_COLOURS = {"load_n": PLACES, "x_m": PLACES, "v_m_s": VELOCITIES}
_EDGE = "#9ca3af"  # of a point that stands alone, seen on a light and on a dark page
_TITLES = ("before", "after")
_REPEATABILITY = "× repeatability"


def maps_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the worst balances over velocity and load, signed, in one scale of colours.

    At one load they are drawn over velocity and position.
    """
    names = shown_balances(diagnosis)[:_WORST]
    sides = _sides(diagnosis)
    figure = style.new_figure(height_in=0.9 + 2.3 * len(sides), wide=True)
    panels = figure.subplots(len(sides), len(names), sharex=True, sharey=True, squeeze=False)
    upwards = "load_n" if has_loads(diagnosis) else "x_m"
    axis = AXES[upwards]
    cells = [[_cells(side, name, upwards) for name in names] for side in sides]
    largest = max(float(np.max(np.abs(cell[2]), initial=_LEAST)) for row in cells for cell in row)
    norm = Normalize(-largest, largest)
    for row, panel_row, title in zip(cells, panels, _TITLES, strict=False):
        for (v, up, value, count), axes, name in zip(row, panel_row, names, strict=True):
            size = 14 + 46 * np.sqrt(count / max(count.max(initial=1), 1))
            dots = axes.scatter(
                1e3 * v, shown(up, axis), c=value, s=size, norm=norm, cmap=RESIDUALS,
                edgecolors="#6b7280", linewidths=0.4, label=f"_{balance(name).title}, {title}",
            )  # fmt: skip
            behind(dots, {f"Residual ({_REPEATABILITY})": value, "windows": count})
        label = f"{axis.title.capitalize()} ({axis.unit})"
        panel_row[0].set_ylabel(f"{title.capitalize()}\n{label}" if len(sides) > 1 else label)
    for axes, name in zip(panels[0], names, strict=True):
        axes.set_title(balance(name).title, fontsize=9.5)
    for axes in panels[-1]:
        axes.set_xlabel("Velocity (mm/s)")
    bar = figure.colorbar(
        ScalarMappable(norm, RESIDUALS), ax=panels, label=f"Residual ({_REPEATABILITY})", pad=0.01
    )
    style.simulated(bar.ax, diagnosis)
    return figure


def shape_figure(diagnosis: Diagnosis, name: str) -> Figure:
    """Draw one balance against each axis, before above after, in one scale."""
    sides = _sides(diagnosis)
    columns = _panels(diagnosis)
    figure = style.new_figure(height_in=1.1 + 2.5 * len(sides), wide=True)
    panels = figure.subplots(len(sides), len(columns), sharex="col", sharey=True, squeeze=False)
    values = [side.value[:, side.names.index(name)] for side in sides]
    strokes = of_strokes(diagnosis)
    only_held_out = bool(diagnosis.confirmed) and not strokes
    unit = sides[0].unit
    limits = _limits(np.concatenate(values), 0.0 if unit else _LEAST)
    for row, side, value, title in zip(panels, sides, values, _TITLES, strict=False):
        for axes, (across, colour) in zip(row, columns, strict=True):
            _points(axes, side, value, across, colour, limits, only_held_out, strokes)
        _windows(row[0], side, value, title, columns)
        row[0].set_ylabel(f"Residual {title if len(sides) > 1 else ''}\n({unit or _REPEATABILITY})")
        row[0].set_ylim(*limits)
    for axes, (across, _) in zip(panels[-1], columns, strict=True):
        axis = AXES[across]
        axes.set_xlabel(f"{axis.title.capitalize()} ({axis.unit})")
    _colour_bars(figure, panels, sides[0], columns)
    style.head(panels[0, 0], balance(name).title, diagnosis, panels[0, -1])
    if not unit:
        (scatter,) = (in_unit(gap, gap.scatter) for gap in diagnosis.where if gap.name == name)
        look: dict[str, Any] = {"color": style.QUIET, "fontsize": 10, "fontweight": "normal"}
        panels[0, len(columns) - 2].set_title(f"repeatability {scatter}", loc="right", **look)
    return figure


def _panels(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return the panels whose axes are known: pairs of strokes have no position."""
    columns = _PANELS if has_loads(diagnosis) else _AT_ONE_LOAD
    side = diagnosis.residuals_before
    known = tuple(each for each in columns if np.isfinite(getattr(side, each[0])).any())
    return known[::-1] if of_strokes(diagnosis) else known  # the load first


def _limits(values: np.ndarray, least: float) -> tuple[float, float]:
    low, high = np.nanpercentile(values, [100 - _SEEN, _SEEN])
    low, high = min(float(low), -least), max(float(high), least)
    room = 0.06 * (high - low)
    return low - room, high + room


def worst(diagnosis: Diagnosis) -> list[str]:
    """Return the balances with significant gaps that matter.

    Without any, the one whose deviation exceeds its limit most, which the verdict names, and the
    one with the largest gap.
    """
    known = [gap for gap in diagnosis.where if gap.name in diagnosis.residuals_before.names]
    real = [gap for gap in known if gap.p_value < SIGNIFICANT_P]
    large = [gap.name for gap in real if not gap.deviation <= gap.material]
    others = (largest_deviation(known), *known[:1])
    return large or list(dict.fromkeys(gap.name for gap in others if gap is not None))


def shown_balances(diagnosis: Diagnosis) -> list[str]:
    """Return the worst balances, and those that the effects do not explain."""
    known = diagnosis.residuals_before.names
    rest = [gap.name for gap in diagnosis.rest if gap.name in known]
    return list(dict.fromkeys((*worst(diagnosis)[:_WORST], *rest)))


def _sides(diagnosis: Diagnosis) -> list[ResidualMap]:
    before, after = diagnosis.residuals_before, diagnosis.residuals_after
    return [before, after] if added_words(diagnosis) else [before]


def has_loads(diagnosis: Diagnosis) -> bool:
    """Return whether the windows are at more than one load."""
    loads = diagnosis.residuals_before.load_n
    return len(np.unique(loads[np.isfinite(loads)])) > 1


def _cells(
    side: ResidualMap, name: str, upwards: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the means of windows that lie close: velocity, ``upwards``, residual; their number."""
    value = side.value[:, side.names.index(name)]
    up = getattr(side, upwards)
    known = np.isfinite(value) & np.isfinite(up)
    v, up, value = side.v_m_s[known], up[known], value[known]
    if not len(value):
        return v, up, value, value
    count = np.histogram2d(v, up, _CELLS)[0]
    sums = (np.histogram2d(v, up, _CELLS, weights=each)[0] for each in (v, up, value))
    some = count > 0
    return (*(each[some] / count[some] for each in sums), count[some])


def _points(
    axes: Axes,
    side: ResidualMap,
    value: np.ndarray,
    across: str,
    colour: str,
    limits: tuple[float, float],
    only_held_out: bool,
    strokes: bool,
) -> None:
    x = shown(getattr(side, across), AXES[across])
    known = np.isfinite(value) & np.isfinite(x)
    coloured = known & (side.held_out if only_held_out else True)
    inside = np.clip(value, *limits)
    if not side.unit:
        axes.axhspan(-1, 1, color="#e5e7eb", zorder=0)
    axes.axhline(0, color="#374151", linewidth=0.8, zorder=1)
    grey = known & ~coloured
    axes.scatter(
        x[grey], inside[grey], s=5, color=_EDGE, rasterized=True, clip_on=False, linewidths=0
    )
    shade = shown(getattr(side, colour), AXES[colour])
    colours = _scale(side, colour).to_rgba(shade[coloured])
    axes.scatter(
        x[coloured], inside[coloured], c=colours, s=_LARGE if strokes else _SMALL, rasterized=True,
        clip_on=False, edgecolors=_EDGE, linewidths=0.8 if strokes else 0,
    )  # fmt: skip
    if strokes:  # a pair of them has no direction
        return
    for way, marker, direction in ((1, ">", "extend"), (-1, "<", "retract")):
        going = known & (way * side.v_m_s > REST_M_S)
        middles, medians = _medians(x[going], value[going])
        axes.plot(
            middles, np.clip(medians, *limits), marker, color="black",
            markeredgecolor="white", markeredgewidth=0.7, markersize=6.5, linestyle="none",
            label=f"_medians, {DIRECTION_WORDS[direction]}",
        )  # fmt: skip


def _windows(
    axes: Axes,
    side: ResidualMap,
    value: np.ndarray,
    title: str,
    panels: Sequence[tuple[str, str]],
) -> None:
    """Put every window's numbers behind the figure, whose points are drawn as an image."""
    known = np.isfinite(value)
    (first, _), *others = panels
    axes.set_autoscale_on(False)
    (line,) = axes.plot(shown(getattr(side, first), AXES[first])[known], value[known], " ")
    line.set_label(f"_windows {title}")
    columns = {}
    for name, _ in others:
        axis, values = AXES[name], shown(getattr(side, name), AXES[name])
        columns[f"{axis.title.capitalize()} ({axis.unit})"] = values[known]
    behind(line, columns)


def _medians(x: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the medians of up to ``_PARTS`` stretches of x with about as many windows each.

    A stretch in which no window is within the repeatability of the median is left out: its windows
    form groups, and the median lies between them.
    """
    if not len(x):
        return x, value
    cuts = np.unique(np.quantile(x, np.arange(1, _PARTS) / _PARTS))
    interval = np.searchsorted(cuts, x)
    stretches = [(x[interval == i], value[interval == i]) for i in np.unique(interval)]
    medians = [
        (np.median(across), middle)
        for across, values in stretches
        for middle in [np.median(values)]
        if np.abs(values - middle).min() <= 1
    ]
    x_mid, y_mid = np.array(medians).reshape(-1, 2).T
    return x_mid, y_mid


def _scale(side: ResidualMap, colour: str) -> ScalarMappable:
    values = shown(getattr(side, colour), AXES[colour])
    span = Normalize(float(np.nanmin(values)), float(np.nanmax(values)))
    return ScalarMappable(span, _COLOURS[colour])


def _colour_bars(
    figure: Figure, panels: np.ndarray, side: ResidualMap, columns: Sequence[tuple[str, str]]
) -> None:
    """Put a bar for each colour below its panels: beside the next one it looks like an axis."""
    colours = [colour for _, colour in columns]
    for colour in dict.fromkeys(colours):
        axis = AXES[colour]
        above = panels[:, [each == colour for each in colours]]
        figure.colorbar(
            _scale(side, colour), ax=above, location="bottom", aspect=20 * above.shape[1],
            label=f"Colour: {axis.title} ({axis.unit})", pad=0.02,
        )  # fmt: skip
