"""Sheets of A4 that are filled from the top, and words broken by their measured widths."""

from collections.abc import Callable
from functools import cache

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.textpath import TextToPath

from hbench.report.render.numbers import unit_kept
from hbench.report.render.symbols import pieces

SHEET_WIDTH, SHEET_HEIGHT = 595.28, 841.89  # of A4
LEFT, _TOP, _BOTTOM = 43.0, 50.0, 44.0
INNER = SHEET_WIDTH - 2 * LEFT
LINE = 1.27  # times the size of the letters
INK, _RULE = "#000000", "#bbbbbb"
_FAMILY = "DejaVu Sans"
_INDEX, _DROP = 0.74, 0.18  # size of an index and its depth, per size of the letters
_TOGETHER = 6  # lines of a paragraph that is not broken


class Pen:
    """Place on the sheets that is filled next: a column at a height."""

    def __init__(self) -> None:
        self.done: list[Figure] = []
        self.x, self.width = LEFT, INNER
        self.on_turn: Callable[[], None] | None = None  # repeats the head of a table
        self._waiting: list[tuple[float, Callable[[], None]]] = []  # heights, and what sets them
        self._turn()

    def _turn(self) -> None:
        figure = Figure(figsize=(SHEET_WIDTH / 72, SHEET_HEIGHT / 72))
        FigureCanvasAgg(figure)
        self.done.append(figure)
        self.y = _TOP
        while self._waiting and self._has_room(self._waiting[0][0]):
            self._waiting.pop(0)[1]()

    def _has_room(self, height: float) -> bool:
        return self.y + height <= SHEET_HEIGHT - _BOTTOM or self.y == _TOP

    def room(self, height: float) -> None:
        """Begin another sheet where this one has less than ``height`` left."""
        sheets = len(self.done)
        while not self._has_room(height):
            self._turn()
        if len(self.done) > sheets and self.on_turn is not None:
            self.on_turn()

    def floating(self, height: float, place: Callable[[], None]) -> None:
        """Call ``place`` here, or at the top of the next sheet; what follows fills this one.

        What is set keeps its order: nothing is placed before what already waits.
        """
        self._waiting.append((height, place))
        if len(self._waiting) == 1 and self._has_room(height):
            self._waiting.pop()[1]()

    def place_waiting(self) -> None:
        """Place all that waits for another sheet."""
        while self._waiting:
            self._turn()

    def space(self, height: float) -> None:
        """Leave a height empty."""
        self.y += height

    def write(self, line: str, size: float, x: float | None = None, **look: str) -> None:
        """Set a line and go below it."""
        self.y += size * LINE
        set_text(self.done[-1], self.x if x is None else x, self.y, line, size, **look)

    def words(self, text: str, size: float, weight: str = "normal", color: str = INK) -> None:
        """Set a paragraph in the column, over sheets if need be."""
        lines = wrapped(text, self.width, size, weight)
        if len(lines) <= _TOGETHER:
            self.room(len(lines) * size * LINE)
        for line in lines:
            self.room(size * LINE)
            self.write(line, size, weight=weight, color=color)

    def rule(self, color: str = _RULE, width: float = 0.6) -> None:
        """Draw a line over the column."""
        y = 1 - self.y / SHEET_HEIGHT
        ends = self.x / SHEET_WIDTH, (self.x + self.width) / SHEET_WIDTH
        self.done[-1].add_artist(Line2D(ends, (y, y), color=color, linewidth=width))

    def frame(self, top: float, bottom: float, color: str, width: float = 1.5) -> None:
        """Frame the column between two heights of this sheet."""
        box = Rectangle(
            (self.x / SHEET_WIDTH, 1 - bottom / SHEET_HEIGHT),
            self.width / SHEET_WIDTH,
            (bottom - top) / SHEET_HEIGHT,
            fill=False,
            edgecolor=color,
            linewidth=width,
        )
        self.done[-1].add_artist(box)

    def image(self, pixels: np.ndarray, left: float, wide: float, high: float, **look: str) -> None:
        """Set an image [pt] at this height; the height stays, since others may stand beside it."""
        box = (
            left / SHEET_WIDTH,
            1 - (self.y + high) / SHEET_HEIGHT,
            wide / SHEET_WIDTH,
            high / SHEET_HEIGHT,
        )
        axes = self.done[-1].add_axes(box)
        axes.imshow(pixels, aspect="auto", **look)
        axes.set_axis_off()

    def bar(self, top: float, bottom: float, color: str, width: float = 4.0) -> None:
        """Draw a bar at the left of the column between two heights of this sheet."""
        x, ends = (self.x + width / 2) / SHEET_WIDTH, (top, bottom)
        y = [1 - end / SHEET_HEIGHT for end in ends]
        line = Line2D((x, x), y, color=color, linewidth=width, solid_capstyle="butt")
        self.done[-1].add_artist(line)


@cache
def _font(weight: str) -> FontProperties:
    return FontProperties(family=_FAMILY, weight=weight, size=100)


_MEASURE = TextToPath()


@cache
def _letters() -> frozenset[int]:
    return frozenset(get_font(findfont(_font("normal"))).get_charmap())


def is_in_font(text: str) -> bool:
    """Return whether the font of the sheets has all letters of a text."""
    return all(letter.isspace() or ord(letter) in _letters() for letter in text)


def width_of(text: str, weight: str) -> float:
    """Return the width of a text per point of its size: its letters' advances, without kerning."""
    return sum(
        (_INDEX if low else 1.0) * sum(_advance(letter, weight) for letter in each)
        for each, low in pieces(text)
    )


@cache
def _advance(letter: str, weight: str) -> float:
    font = _font(weight)
    return float(_MEASURE.get_text_width_height_descent(letter, font, False)[0]) / 100


@cache
def _set_width(text: str, weight: str) -> float:
    """Return the width of a text as it is set, with kerning, per point of its size."""
    return float(_MEASURE.get_text_width_height_descent(text, _font(weight), False)[0]) / 100


def words_of(text: str) -> list[str]:
    """Return the pieces between which a text may be broken; a number and its unit are one."""
    return unit_kept(text).split(" ")


def wrapped(text: str, width: float, size: float, weight: str = "normal") -> list[str]:
    """Break a text into lines of at most ``width``; a longer word is broken too."""
    width += 0.01  # of rounding
    lines, line = [], ""
    for word in words_of(text):
        longer = f"{line} {word}".strip()
        if width_of(longer, weight) * size <= width:
            line = longer
            continue
        if line:
            lines.append(line)
        while len(word) > 1 and width_of(word, weight) * size > width:
            fits = max(
                1, sum(width_of(word[:n], weight) * size <= width for n in range(1, len(word)))
            )
            lines.append(word[:fits])
            word = word[fits:]
        line = word
    return [*lines, line] if line or not lines else lines


def set_text(sheet: Figure, x: float, y: float, text: str, size: float, **look: str) -> None:
    """Set a line with its base at a place of the sheet; the index of a symbol goes below it.

    Text is no mathematics. A line in letters of another family, such as code, is set as it is.
    """
    style = {"color": INK, "va": "baseline", **look}
    text = text.replace("\N{NO-BREAK SPACE}", " ")
    parts = [(text, False)] if "family" in look else [part for part in pieces(text) if part[0]]
    if len(parts) > 1:
        weight = look.get("weight", "normal")
        shift = {"left": 0.0, "center": 0.5, "right": 1.0}[style.pop("ha", "left")]
        x -= shift * width_of(text, weight) * size
    for each, low in parts:
        height = size * (_INDEX if low else 1.0)
        place = x / SHEET_WIDTH, 1 - (y + (_DROP * size if low else 0.0)) / SHEET_HEIGHT
        sheet.text(*place, each, size=height, parse_math=False, **style)
        if len(parts) > 1:
            x += _set_width(each, weight) * height
