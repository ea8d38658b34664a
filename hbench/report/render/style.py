"""Style of all figures: colours, markers, sizes, and settings for reproducible bytes."""

import textwrap
from collections.abc import Collection, Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from hbench.records import Curve, Diagnosis, Identification, Results

Measured = Results | Diagnosis | Identification  # with the provenance of the data

# Okabe and Ito's colours, distinguishable with any colour vision, without their yellow, in which
# thin lines are invisible on white.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# What a page shows in the dark instead, by colour in lower case; the files stay light.
DARK = {
    "#0072b2": "#4aa8e8",
    "#d55e00": "#ff8a3d",
    "#009e73": "#34c99a",
    "#cc79a7": "#e59cc5",
    "#e69f00": "#f5bd42",
    "#56b4e9": "#8fd0f7",
    "#000000": "#eef1f4",
    "#ffffff": "#1c2026",
    "#374151": "#a9b2bd",
    "#6b7280": "#9aa4b1",
    "#9ca3af": "#77808c",
    "#d1d5db": "#4b5563",
    "#e5e7eb": "#323841",
}
ON_MAPS = "#fefefe"  # white in the dark too, on the colours of a map
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
QUIET = "#6b7280"

WIDTH_IN = 5.2  # two side by side on a desktop page; the type stays legible at half this width
NARROW_IN = 4.3  # as wide as a phone, without scrolling
_TITLE_LINE = 30  # letters of a line of its title
WIDE_IN = 10.8  # over the whole width of a desktop page

RC: Any = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so that it is the same everywhere
    "font.size": 11,
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 11,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,  # of a position that hardly changes
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#374151",
    "grid.color": "#e5e7eb",
    "grid.linewidth": 0.8,
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "xtick.color": "#374151",
    "ytick.color": "#374151",
    "legend.fontsize": 10,
    "legend.title_fontsize": 10,
    "legend.frameon": False,
    "legend.handletextpad": 0.3,
    "legend.columnspacing": 1.2,
    "lines.linewidth": 1.6,
    "lines.markersize": 5.5,
    "svg.fonttype": "path",
    "svg.hashsalt": "hbench",  # element names from the content, not from a random number
    "path.simplify": False,
}

POINTS: dict[str, Any] = {
    "linestyle": "none",
    "capsize": 2.5,
    "elinewidth": 1.1,
    "markeredgewidth": 0.9,
    "zorder": 3,
}
_LEVELS = 12  # of a map's colours
_MARGIN = 0.05  # of an axis that several maps have
OF_MAPS = "Dots: measured; colours between them are linearly interpolated."
DOTS = {  # where a map was measured
    "linestyle": "none",
    "marker": "o",
    "markersize": 3.5,
    "markerfacecolor": ON_MAPS,
    "markeredgecolor": "#010101",
    "markeredgewidth": 0.6,
    "clip_on": False,
}
SMALL_POINTS = {**POINTS, "markersize": 4, "capsize": 0, "elinewidth": 0.9}


def series_style(index: int, hollow: bool = False) -> dict[str, Any]:
    """Return colour and marker of the series number ``index``: all differ up to 49."""
    colour = COLOURS[index % len(COLOURS)]
    marker = MARKERS[(index + index // len(COLOURS)) % len(MARKERS)]
    face = "white" if hollow else colour
    return {"color": colour, "marker": marker, "markerfacecolor": face}


def new_figure(height_in: float, wide: bool = False, narrow: bool = False) -> Figure:
    """Return an empty figure of the report's width, of a whole page's or of a phone's."""
    width_in = WIDE_IN if wide else NARROW_IN if narrow else WIDTH_IN
    return Figure(figsize=(width_in, height_in), layout="constrained")


def head(axes: Axes, title: str, results: Measured, last: Axes | None = None) -> None:
    """Put the title, and a mark on the figures of a simulated campaign.

    ``last`` are the axes at the right of a row, above which the mark is written.
    """
    title = safe(title)
    if last is None and axes.figure.get_figwidth() <= WIDTH_IN:
        title = textwrap.fill(title, _TITLE_LINE)  # beside the mark of simulated data
    axes.set_title(title)
    simulated(last or axes, results)


def simulated(axes: Axes, results: Measured) -> None:
    """Mark the figure of a simulated campaign at the right above the axes."""
    mark_sources(axes, [results.provenance.source], "")


def mark_sources(axes: Axes, sources: Collection[str], partly: str) -> None:
    """Mark the figure of simulated campaigns; ``partly`` is the mark where others are not."""
    if "simulated" in sources:
        mark = "simulated" if len(set(sources)) == 1 else partly
        axes.set_title(mark, loc="right", color=QUIET, fontsize=10, fontweight="normal")


READ_AS = "read-as"  # name of this note in the SVG


def read_as(figure: Figure, note: str) -> None:
    """Write below the axes how to read the figure, such as the meaning of its bars."""
    figure.supxlabel(note, x=0.01, ha="left", fontsize=8.5, color=QUIET).set_gid(READ_AS)


def legend_above(figure: Figure, axes: Axes, title: str = "", columns: int = 4) -> None:
    """Put the legend above the axes, where it covers no data; nothing where there is no entry."""
    handles, labels = axes.get_legend_handles_labels()
    if labels:
        columns = min(columns, len(labels))
        figure.legend(
            handles, labels, title=title, ncols=columns, alignment="left", loc="outside upper left"
        )


def plain_log(axis: Axis) -> None:
    """Write a logarithmic axis's numbers as they are: 2, not 2 × 10^0; in few decades 1, 2, 5."""
    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 300 * low else (1,)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def start_at_zero(axes: Axes) -> None:
    """Start a speed or pressure axis at zero, with room for a point near it."""
    _, right = axes.get_xlim()
    axes.set_xlim(left=-0.02 * right)


def share_limits(axes: Iterable[Axes]) -> None:
    """Give all axes the widest limits among them, so that figures can be compared by eye."""
    axes = list(axes)
    if not axes:
        return
    for get, set_ in (("get_xlim", "set_xlim"), ("get_ylim", "set_ylim")):
        limits = [getattr(panel, get)() for panel in axes]
        widest = (min(low for low, _ in limits), max(high for _, high in limits))
        for panel in axes:
            getattr(panel, set_)(widest)


def common_limits(arrays: Iterable[np.ndarray]) -> tuple[float, float]:
    """Return the ends of an axis for all ``arrays``, with a margin."""
    values = np.concatenate([np.ravel(each) for each in arrays])
    margin = _MARGIN * float(np.ptp(values))
    return float(values.min()) - margin, float(values.max()) + margin


def common_levels(arrays: Iterable[np.ndarray]) -> np.ndarray | None:
    """Return the levels of the colours for maps of all ``arrays``; None without finite values."""
    values = np.concatenate([np.ravel(each) for each in arrays])
    known = values[np.isfinite(values)]
    if not len(known):
        return None
    return MaxNLocator(_LEVELS).tick_values(float(known.min()), float(known.max()))


def label_contours(axes: Axes, lines: ContourSet) -> None:
    """Write every other level on its line; none that the end of the colours would cut.

    The limits of the axes must be set.
    """
    inside = axes.dataLim.transformed(axes.transData)
    for text in list(axes.clabel(lines, list(lines.levels)[1::2], fontsize=8, fmt="%g")):
        corners = text.get_window_extent().corners()
        if inside.count_contains(corners) < len(corners):
            text.remove()


def columns(curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a curve's velocities, frictions and half-widths of intervals (nan: none)."""
    points = curve.points
    interval = [np.nan if point.ci95_n is None else point.ci95_n for point in points]
    return (
        np.array([point.v_m_s for point in points], dtype=float),
        np.array([point.friction_n for point in points], dtype=float),
        np.array(interval, dtype=float),
    )


def bars(half_widths: np.ndarray) -> np.ndarray | None:
    """Return half-widths of error bars; None where no point has one, for a legend without bars."""
    return half_widths if np.isfinite(half_widths).any() else None


def safe(text: str, most: int = 42) -> str:
    """Make a campaign's text safe for a figure: one line, no formula, limited length."""
    line = " ".join(text.split())
    line = line if len(line) <= most else line[: most - 1] + "…"
    return line.replace("$", r"\$")


def broken_line(
    t_s: np.ndarray, values: np.ndarray, longest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Break a line over time where a step is longer than ``longest`` times their median."""
    if len(t_s) < 3:
        return t_s, values
    steps = np.diff(t_s)
    gaps = np.flatnonzero(steps > longest * np.median(steps)) + 1
    return np.insert(t_s, gaps, np.nan), np.insert(values.astype(float), gaps, np.nan)
