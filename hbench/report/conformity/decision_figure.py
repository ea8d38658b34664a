"""Figure of decisions: measured values with their U, on a scale on which each limit is 100 %."""

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import blended_transform_factory

from hbench.records.conformity.acceptance import Conformity, ConformityCheck, Rule
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches
from hbench.report.render.numbers import unit_kept
from hbench.report.render.series import behind
from hbench.units import from_si

_TITLE = "Measured values against their limits"
_CAPTION = (
    "Each value as a share of its limit. All limits are the line at 100 %; values in the "
    "green strip conform."
)
_TWO_SIDED = (
    "Two limits: distance from the middle between them, as a share of half of their distance."
)
_EFFICIENCY = "Efficiency: loss as a share of the permitted loss."
_LOWER = "Lower limit: 100 % is the limit, 0 % is twice the limit."
_READ_AS, _GUARD_BAND = "Bar: measured value ± U.", "Hatched: guard band, as wide as U."
_MOST_ROWS = 10  # of a figure: two side by side fit below the head of a sheet
_LABEL, _HEADING, _NOTE = 20, 52, 60  # letters of a line
_ROW_IN, _LINE_IN, _REST_IN = 0.13, 0.165, 0.95  # heights: of a row without its lines, of a line
_HALF = 0.33  # height of a strip
_LEAST, _MOST = -0.5, 2.0  # shares of the limit beyond which a value is an arrow at the edge
_PASS, _FAIL, _MARGINAL, _NEUTRAL = "#0072B2", "#D55E00", "#E69F00", "#6b7280"
_LOOKS: dict[Conformity, dict[str, Any]] = {
    "FAIL": {"color": _FAIL, "marker": "X", "markersize": 8.5},
    "NOT TESTED": {"color": _NEUTRAL, "marker": "s", "markerfacecolor": "white", "markersize": 7},
    "MARGINAL": {
        "color": _MARGINAL,
        "marker": "D",
        "markersize": 7.5,
        "markeredgecolor": "#000000",
    },
    "PASS": {"color": _PASS, "marker": "o", "markersize": 6.5},
}
_PILLS: dict[Conformity, dict[str, Any]] = {
    "FAIL": {"facecolor": _FAIL, "alpha": 0.3, "linewidth": 0},
    "NOT TESTED": {"facecolor": "white", "edgecolor": "#374151", "linestyle": (0, (3, 2))},
    "MARGINAL": {"facecolor": _MARGINAL, "alpha": 0.4, "linewidth": 0},
}


@dataclass(frozen=True)
class DecisionRow:
    """Decision as it is drawn."""

    check: ConformityCheck
    quantity: str  # with its limit, above the rows that have it in common
    series: str
    decision: str


def draw_decisions(
    rows: Sequence[DecisionRow], rule: Rule | None, simulated: bool, png: bool
) -> tuple[Drawing, ...]:
    """Draw the decisions in their order, in one figure or in several of about the same length.

    A value is ``1 - margin / tolerance`` of its limit: below 100 % it conforms. The guard band,
    which is as wide as U, is drawn where the rule has one. ``png`` draws them as PNG too.
    """
    number = -(-len(rows) // _MOST_ROWS)
    parts = [[rows[i] for i in part] for part in np.array_split(np.arange(len(rows)), number or 1)]
    sketches = []
    for count, part in enumerate(parts, start=1):
        if not part:
            continue
        with rc_context(style.RC):
            figure = _draw(part, _ends(rows), rule, simulated)
        of = f" ({count}/{number})" if number > 1 else ""
        name = f"decisions-{count}" if number > 1 else "decisions"
        caption = " ".join(_caption(rows))
        sketches.append(Sketch(name, "decision", _TITLE + of, caption, figure))
    return draw_sketches(sketches, png)


def _caption(rows: Sequence[DecisionRow]) -> Iterator[str]:
    yield _CAPTION
    limits = [row.check.requirement for row in rows]
    lower = [limit for limit in limits if limit.high is None]
    if any(limit.low is not None and limit.high is not None for limit in limits):
        yield _TWO_SIDED
    if any(limit.quantity == "efficiency" for limit in lower):
        yield _EFFICIENCY
    if any(limit.quantity != "efficiency" for limit in lower):
        yield _LOWER


def _draw(
    rows: Sequence[DecisionRow],
    ends: tuple[float, float],
    rule: Rule | None,
    simulated: bool,
) -> Figure:
    lines = [_lines(row.series, _LABEL, 2) for row in rows]
    headings = [
        _lines(row.quantity, _HEADING, 3) if i == 0 or row.quantity != rows[i - 1].quantity else []
        for i, row in enumerate(rows)
    ]
    # The centre of each row and the top of its heading, in inches from the top.
    at, tops, depth = list[float](), list[float](), 0.0
    for heading, label in zip(headings, lines, strict=True):
        depth += 0.08 if heading and at else 0.0
        tops.append(depth)
        depth += len(heading) * _LINE_IN
        height = _ROW_IN + max(1, len(label)) * _LINE_IN
        at.append(depth + height / 2)
        depth += height
    guard = rule == "guard_band"
    note = " ".join(filter(None, (_READ_AS, _GUARD_BAND if guard else "")))
    note = textwrap.fill(note, _NOTE)
    height_in = depth + _REST_IN + 0.13 * note.count("\n")
    figure = style.new_figure(height_in, narrow=True)
    axes = figure.add_subplot()
    axes.set(xlim=ends, ylim=(depth, 0), xlabel="Share of the limit (%)")
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    labels = ["\n".join(map(_plain, label)) for label in lines]
    axes.set_yticks(at, labels, fontsize=9.5, color="#374151")
    figures_left = blended_transform_factory(figure.transFigure, axes.transData)
    for heading, top in zip(headings, tops, strict=True):
        text = "\n".join(map(_plain, heading))
        axes.text(
            *(0.012, top + 0.02, text),
            **{"transform": figures_left, "va": "top", "fontsize": 9.5, "weight": "bold"},
        ).set_in_layout(False)
    for row, y in zip(rows, at, strict=True):
        _strip(axes, row, y, guard)
        pill = _PILLS.get(row.check.decision)
        box = {"boxstyle": "round,pad=0.25", **pill} if pill else None
        axes.text(
            *(1.03, y, row.decision),
            **{"transform": axes.get_yaxis_transform(), "va": "center", "fontsize": 9.5},
            **{"weight": "bold" if pill else "normal", "bbox": box},
        )
    for decision, look in _LOOKS.items():
        chosen = [i for i, row in enumerate(rows) if row.check.decision == decision]
        if chosen:
            _points(axes, [rows[i] for i in chosen], [at[i] for i in chosen], look)
    axes.set_title("Decisions")
    if simulated:
        look = {"color": style.QUIET, "fontsize": 10, "fontweight": "normal"}
        axes.set_title("simulated", loc="right", **look)
    style.read_as(figure, note)
    return figure


def _ends(rows: Sequence[DecisionRow]) -> tuple[float, float]:
    """Return the ends [%] of the axis: 0, the limit, and all values that are not too far off."""
    known = [place for row in rows if (place := _place(row.check)) is not None]
    reach = [value + side * (half or 0.0) for value, half in known for side in (-1, 1)]
    low, high = min([0.0, *reach]), max([1.15, *reach])
    return 100 * max(low, _LEAST) - 4, 100 * min(high, _MOST) + 4


def _place(check: ConformityCheck) -> tuple[float, float | None] | None:
    """Return a value and its U as shares of the limit; None where there is none."""
    measured, tolerance = check.measurement, check.requirement.permitted
    if measured is None or not tolerance:
        return None
    value = 1 - check.requirement.margin(measured.value) / tolerance
    return value, None if measured.u95 is None else measured.u95 / tolerance


def _strip(axes: Axes, row: DecisionRow, y: float, guard: bool) -> None:
    """Draw what conforms, and the guard band; what is missing in words."""
    half = _HALF * (_ROW_IN + _LINE_IN)
    left, right = axes.get_xlim()
    place = _place(row.check)
    if place is None:
        look = {"facecolor": "none", "edgecolor": "#9ca3af", "hatch": "....", "linewidth": 0.6}
        axes.barh(y, right - left, 2 * half, left, label="_nolegend_", **look)
        known = row.check.measurement is not None
        text = "no share of a limit of 0" if known else "no measured value"
        box = {"facecolor": "white", "linewidth": 0, "boxstyle": "square,pad=0.15"}
        look = {"ha": "center", "va": "center", "fontsize": 9, "color": "#374151"}
        axes.text((left + right) / 2, y, text, bbox=box, **look)
        return
    axes.barh(
        *(y, 100 - left, 2 * half, left),
        **{"color": "#009E73", "alpha": 0.16, "linewidth": 0, "label": "_nolegend_"},
    )
    line = {"color": "#000000", "linewidth": 2.2, "solid_capstyle": "butt", "zorder": 2}
    axes.plot((100, 100), (y - 1.35 * half, y + 1.35 * half), label="_nolegend_", **line)
    if guard and place[1]:
        start = max(left, 100 * (1 - place[1]))
        look = {"facecolor": "none", "edgecolor": _MARGINAL, "hatch": "/////", "linewidth": 0.8}
        axes.barh(y, 100 - start, 2 * half, start, label="_nolegend_", **look)


def _points(
    axes: Axes, rows: Sequence[DecisionRow], at: Sequence[float], look: dict[str, Any]
) -> None:
    """Draw the values of one decision with U; an arrow at the edge shows one beyond it."""
    left, right = axes.get_xlim()
    places = [_place(row.check) or (np.nan, None) for row in rows]
    x = 100 * np.array([value for value, _ in places])
    half = 100 * np.array([np.nan if u is None else u for _, u in places])
    shown = {**style.POINTS, "elinewidth": 1.6, "capsize": 3.5, **look}
    bars = axes.errorbar(x, at, xerr=style.bars(half), label=f"_{rows[0].decision}", **shown)
    behind(bars, _columns(rows))
    for value, y in zip(x, at, strict=True):
        if left <= value <= right or np.isnan(value):
            continue
        end, way = (right, "right") if value > right else (left, "left")
        text = f"{value:.0f} % \N{BLACK RIGHT-POINTING TRIANGLE}"
        if way == "left":
            text = f"\N{BLACK LEFT-POINTING TRIANGLE} {value:.0f} %".replace("-", "\N{MINUS SIGN}")
        look = {"ha": way, "va": "center", "fontsize": 9, "weight": "bold", "color": "#000000"}
        box = {"facecolor": "white", "linewidth": 0, "boxstyle": "square,pad=0.15"}
        axes.text(end, y, text, bbox=box, zorder=5, **look)


def _columns(rows: Sequence[DecisionRow]) -> dict[str, list[float | str]]:
    """Return what a point's note and the figure's data have besides the shares."""
    measured, halves, units = list[float | str](), list[float | str](), list[float | str]()
    for row in rows:
        value, unit = row.check.measurement, row.check.requirement.unit
        measured.append(np.nan if value is None else from_si(value.value, unit))
        no_u = value is None or value.u95 is None
        halves.append(np.nan if no_u else from_si(value.u95, unit))  # type: ignore[union-attr, arg-type]
        units.append(unit)
    quantities: list[float | str] = [row.quantity for row in rows]
    return {"quantity": quantities, "measured": measured, "± measured": halves, "unit": units}


def _lines(text: str, width: int, most: int) -> list[str]:
    """Break a text into at most ``most`` lines of about the width of ``width`` letters."""
    lines = textwrap.wrap(unit_kept(text), width, break_on_hyphens=False) or [""]
    if len(lines) <= most:
        return lines
    return [*lines[: most - 1], textwrap.shorten(" ".join(lines[most - 1 :]), width)]


def _plain(line: str) -> str:
    """Return a line that is no formula."""
    return style.safe(line, len(line))
