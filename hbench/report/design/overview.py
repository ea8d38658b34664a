"""Margins of all operating points as a table of colours."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from hbench.records import Design, PointMargins
from hbench.report.render import style
from hbench.report.render.numbers import number, short
from hbench.report.render.series import behind
from hbench.sentences import capital

SECTION = "overview"
TITLE = "Margins at all operating points"
CAPTION = (
    "Phase margins (above) and gain margins (below) of the present gains with all three loops on "
    "the board. Coloured: below the limit, the stronger the farther. Rows: position and load, "
    "which opposes the motion. Frame: the operating point of the other figures."
)
_MARGINS = {"phase margin": ("°", 0), "gain margin": ("dB", 1)}
_ORANGE = (0xD5 / 255, 0x5E / 255, 0x00)
_BELOW = LinearSegmentedColormap.from_list("below", [(*_ORANGE, 0.85), (*_ORANGE, 0.12)])


def overview_figure(design: Design) -> Figure:
    """Draw each loop's margins: a row for a position and a load, a column for a speed."""
    loops = list(dict.fromkeys(what.partition(":")[0] for what in design.grid[0].margins))
    limits = {check.what.partition(": ")[2]: check.limit for check in design.checks}
    speeds = sorted({point.v_m_s for point in design.grid})
    rows = sorted(set(map(_row, design.grid)))
    figure = style.new_figure(height_in=7.4, wide=True)
    panels = figure.subplots(len(_MARGINS), len(loops), sharex=True, sharey=True, squeeze=False)
    for across, (kind, (unit, decimals)) in zip(panels, _MARGINS.items(), strict=True):
        for axes, loop in zip(across, loops, strict=True):
            values = np.full((len(rows), len(speeds)), np.nan)
            for point in design.grid:
                row = rows.index(_row(point))
                values[row, speeds.index(point.v_m_s)] = point.margins[f"{loop}: {kind}"]
            image = _cells(axes, values, limits[kind], decimals)
            behind(image, {f"{capital(kind)} ({unit})": values.ravel()})
            _frame(axes, design, rows, speeds)
        across[0].set_ylabel(f"{capital(kind)} ({unit}), limit {short(limits[kind])}")
    for axes, loop in zip(panels[0], loops, strict=True):
        axes.set_title(f"{capital(loop)} loop")
    labels = [f"{short(1e3 * x)} mm, {load} N" for x, load in rows]
    panels[0, 0].set_yticks(range(len(rows)), labels)
    for axes in panels[-1]:
        axes.set_xticks(range(len(speeds)), [short(1e3 * v) for v in speeds])
        axes.set_xlabel("Speed (mm/s)")
    return figure


def _row(point: PointMargins) -> tuple[float, int]:
    """Return the position of a point, and its load in newtons, without sign."""
    return point.x_m, round(abs(point.f_load_n))


def _cells(axes: Axes, values: np.ndarray, limit: float, decimals: int) -> AxesImage:
    """Draw margins (m, n) with their values, those below the limit coloured."""
    below = np.where(values < limit, np.maximum(values, 0.0) / limit, np.nan)
    look = {"vmin": 0.0, "vmax": 1.0, "cmap": _BELOW, "label": "_margins"}
    image = axes.imshow(below, aspect="auto", **look)
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            rounded = round(value, decimals)  # a value below the limit is not written as the limit
            text = number(value, decimals + (value < limit <= rounded))
            axes.text(column, row, text, ha="center", va="center", fontsize=9)
    axes.grid(visible=False)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return image


def _frame(axes: Axes, design: Design, rows: list[tuple[float, int]], speeds: list[float]) -> None:
    """Frame the operating point of the other figures, where it is one of the grid."""
    for point in design.grid:
        same = (point.x_m, point.v_m_s) == (design.point["x_m"], design.point["v_m_s"])
        if same and np.isclose(point.f_load_n, design.f_load_n, rtol=1e-6):
            row = rows.index(_row(point))
            column = speeds.index(point.v_m_s)
            x, y = column + np.array([-1, 1, 1, -1, -1]) / 2, row + np.array([-1, -1, 1, 1, -1]) / 2
            axes.plot(x, y, color="#000000", linewidth=2, label="_point", clip_on=False)
