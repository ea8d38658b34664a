"""Results of ``simulate``: a phenomenon with its curves and its defining numbers."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Line:
    """One series of a panel, in the units of the panel's axes."""

    label: str
    x: np.ndarray  # (n,)
    y: np.ndarray  # (n,)
    points: bool = False  # simulated one by one, beside a line of theory


@dataclass(frozen=True)
class Panel:
    """Pair of axes with their units, series and marks."""

    name: str
    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    x_log: bool = False
    y_log: bool = False
    marks: tuple[tuple[float, str], ...] = ()  # upright lines at x, each with its words
    names: tuple[tuple[float, float, str], ...] = ()  # words beside points (x, y)


@dataclass(frozen=True)
class Finding:
    """Number that defines a phenomenon, and its value by theory or the source."""

    quantity: str
    unit: str
    simulated: float
    expected: float | None  # None where there is nothing to compare with
    note: str = ""  # the formula, or where the expected number comes from


@dataclass(frozen=True)
class WordTable:
    """Table as it is printed."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Phenomenon:
    """Scripted simulation: its explanation, its curves and its defining numbers."""

    name: str
    title: str
    text: tuple[str, ...]  # paragraphs: method, result, explanation
    panels: tuple[Panel, ...]
    findings: tuple[Finding, ...]
    tables: tuple[WordTable, ...] = ()
