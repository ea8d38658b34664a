"""A figure in words and numbers: its data as CSV, its text alternative, its points' notes."""

import math
from collections.abc import Sequence

import numpy as np

from hbench.report.render.csv_text import csv_of
from hbench.report.render.numbers import short, significant
from hbench.report.render.series import DrawnSeries
from hbench.untrusted_text import as_cell

_MOST_SERIES = 10  # of a panel, described one by one
_TURN = 0.1  # of a series' range: a smaller change is not a turn


def data_csv(series: Sequence[DrawnSeries]) -> str:
    """Return all series as CSV: a row a point, a column a quantity, in the axes' units."""
    several = len({line.panel for line in series}) > 1
    names = list(dict.fromkeys(name for line in series for name in line.columns))
    rows = []
    for line in series:
        who = [str(line.panel), as_cell(line.label)] if several else [as_cell(line.label)]
        columns = [line.columns.get(name) for name in names]
        for i in range(len(line.x)):
            rows.append([*who, *("" if c is None else _cell(c[i]) for c in columns)])
    head = ["panel", "series", *names] if several else ["series", *names]
    return csv_of([as_cell(name) for name in head], rows)


def point_notes(series: DrawnSeries) -> list[str]:
    """Return the note of each point for the pointer, a line for each quantity."""
    head = [series.label] if series.label else []
    return [
        "\n".join([*head, *(line for line in _lines(series.columns, i) if line)])
        for i in range(len(series.x))
    ]


def alternative_text(title: str, series: Sequence[DrawnSeries]) -> str:
    """Describe a figure for readers who cannot see it."""
    sentences = [f"{title}."]
    panels = sorted({line.panel for line in series})
    for panel in panels:
        lines = [line for line in series if line.panel == panel]
        shown = [line for line in lines if line.points] or lines
        names = dict.fromkeys(f"{line.y_name} over {line.x_name}" for line in shown)
        where = f"Panel {panel} of {len(panels)}: " if len(panels) > 1 else ""
        sentences.append(f"{where}{'; '.join(names)}.")
        sentences += [_course(line) for line in shown[:_MOST_SERIES]]
        if len(shown) > _MOST_SERIES:
            sentences.append(f"{len(shown) - _MOST_SERIES} more series.")
    return " ".join(sentences)


def _course(series: DrawnSeries) -> str:
    """Describe the course of a series: its ends, and its extremes where it turns."""
    label = f"{series.label}: " if series.label else ""
    if isinstance(series.x[0], str) or isinstance(series.y[0], str):
        pairs = zip(series.x, series.y, strict=True)
        named = [" ".join((_shown(y), _shown(x))) for x, y in pairs]
        return f"{label}{'; '.join(named[:_MOST_SERIES])}."
    known = np.isfinite(series.x) & np.isfinite(series.y)
    x, y = np.asarray(series.x)[known], np.asarray(series.y)[known]
    if not len(x):
        return f"{label}no values."
    if len(x) == 1:
        return f"{label}{short(y[0])} at {short(x[0])}."
    points = f"{len(x)} points, " if series.points is not None else ""
    if np.all(np.diff(x) < 0):
        x, y = x[::-1], y[::-1]
    if np.any(np.diff(x) <= 0):
        return f"{label}{points}between {short(y.min())} and {short(y.max())}."
    turns = [0, *sorted({int(y.argmin()), int(y.argmax())} - {0, len(y) - 1}), len(y) - 1]
    reach = y.max() - y.min()
    steps = [f"from {short(y[0])} at {short(x[0])}"]
    for a, b in zip(turns[:-1], turns[1:], strict=True):
        change = y[b] - y[a]
        if abs(change) > _TURN * reach or b == turns[-1]:
            level = abs(change) <= _TURN * reach
            word = "stays near" if level else "falls to" if change < 0 else "rises to"
            steps.append(f"{word} {short(y[b])} at {short(x[b])}")
    return f"{label}{points}{', '.join(steps)}."


def _lines(columns: dict, i: int) -> list[str]:
    lines = []
    for name, values in columns.items():
        if name.startswith("± "):
            continue
        half = columns.get(f"± {name}")
        text = _shown(values[i])
        if half is not None and math.isfinite(half[i]):
            text += f" ± {significant(half[i], 2)}"
        lines.append(f"{name}: {text}" if text else "")
    return lines


def _shown(value: float | str) -> str:
    return value if isinstance(value, str) else significant(float(value), 4)


def _cell(value: float | str) -> str:
    if isinstance(value, str):
        return as_cell(value)
    return f"{value:.6g}" if math.isfinite(value) else ""
