"""Series of a figure as data, read back from the figure itself.

The data therefore cannot differ from the drawing. A series is a line, error bars, bars, dots or
an image with a label; a label that begins with an underscore stays out of the legend, and marks
without a label are no data.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import PathCollection
from matplotlib.container import BarContainer, ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, Formatter, FuncFormatter

_FOR_THE_EYE = re.compile(r"_(child|container)\d+|_nolegend_|")

ColumnValues = Sequence[float | str] | np.ndarray


class DaysAsDates(Formatter):
    """Dates in place of days since ``first``, with the time of day if ``hours``.

    Below an axis the time is above the date, so that neighbours have room in letters of full size.
    """

    def __init__(self, first: datetime, hours: bool):
        self._first, self._hours = first, hours

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the date of a tick or of a value."""
        moment = self._first + timedelta(days=float(x))
        date, time = f"{moment:%Y-%m-%d}", f"{moment:%H:%M}"
        if not self._hours:
            return date
        return f"{date} {time}" if pos is None else f"{time}\n{date}"


@dataclass(frozen=True)
class DrawnSeries:
    """Series of a figure: a column for each quantity, by its name with its unit."""

    panel: int  # of its figure, from 1
    label: str
    x_name: str
    y_name: str
    columns: dict[str, ColumnValues]  # x, y, half-widths of bars, then those behind the points
    points: Line2D | None  # where it is drawn as points, their artist
    title: str = ""  # of its panel

    @property
    def x(self) -> ColumnValues:
        """Along the abscissa."""
        return self.columns[self.x_name]

    @property
    def y(self) -> ColumnValues:
        """Along the ordinate."""
        return self.columns[self.y_name]


def behind(artist: Artist | ErrorbarContainer, columns: Mapping[str, ColumnValues]) -> None:
    """Put more columns behind the points of ``artist``, such as the trials of each mean."""
    artist.columns_behind = dict(columns)


def series_of(figure: Figure) -> tuple[DrawnSeries, ...]:
    """Return all series of ``figure``, panel by panel."""
    drawn: list[DrawnSeries] = []
    for panel, axes in enumerate(panels(figure), start=1):
        drawn += _series(panel, axes)
    return tuple(drawn)


def panels(figure: Figure) -> list[Axes]:
    """Return the axes of ``figure`` but for its colour bars."""
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def without_math(label: str) -> str:
    """Return a label without the marks of formulas: ``Load $F_{Lr}$`` as ``Load F_Lr``."""
    text = " ".join(label.split()).replace(r"\$", "\0")
    return re.sub(r"[${}]", "", text).replace("\0", "$")


def _series(panel: int, axes: Axes) -> Iterator[DrawnSeries]:
    for artist in _artists(axes):
        label = str(artist.get_label())
        if _FOR_THE_EYE.fullmatch(label):
            continue
        line = artist.lines[0] if isinstance(artist, ErrorbarContainer) else artist
        if isinstance(line, Line2D):
            x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        else:
            line, (x, y) = None, _OTHERS[type(artist)](artist)
        if not len(x):  # an entry of the legend
            continue
        x_name, y_name = _name(axes.xaxis, "x"), _name(axes.yaxis, "item")
        columns = {x_name: _named(axes.xaxis, x), y_name: _named(axes.yaxis, y)}
        columns |= _half_widths(artist, x_name, y_name) | getattr(artist, "columns_behind", {})
        has_points = line is not None and line.get_marker() not in ("None", "", " ", None)
        title = without_math(axes.get_title("left"))
        label = without_math(label.removeprefix("_"))
        yield DrawnSeries(
            panel, label, x_name, y_name, columns, line if has_points else None, title
        )


def _artists(axes: Axes) -> Iterator[Artist]:
    """Yield error bars and bars, then lines that are no part of them."""
    bars = [c for c in axes.containers if isinstance(c, ErrorbarContainer) and c.lines[0]]
    yield from bars
    yield from (c for c in axes.containers if isinstance(c, BarContainer))
    yield from (dots for dots in axes.collections if isinstance(dots, PathCollection))
    yield from axes.images
    artists = {id(artist) for c in bars for artist in (c.lines[0], *c.lines[1])}
    yield from (line for line in axes.lines if id(line) not in artists)


def _dots(dots: PathCollection) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.ma.filled(dots.get_offsets().astype(float), np.nan).T
    return x, y


def _cells(image: AxesImage) -> tuple[np.ndarray, np.ndarray]:
    rows, columns = np.indices(image.get_array().shape[:2])
    return columns.ravel().astype(float), rows.ravel().astype(float)


def _bars(bars: BarContainer) -> tuple[np.ndarray, np.ndarray]:
    along = [bar.get_y() + bar.get_height() / 2 for bar in bars]
    return np.array([bar.get_width() for bar in bars]), np.array(along)


# Readers of the values of artists that are not lines.
_OTHERS = {BarContainer: _bars, PathCollection: _dots, AxesImage: _cells}


def _half_widths(artist: Artist, x_name: str, y_name: str) -> dict[str, ColumnValues]:
    """Return half of each error bar, by the name of its quantity; they are symmetric."""
    if not isinstance(artist, ErrorbarContainer):
        return {}
    kinds = [(x_name, 0)] * artist.has_xerr + [(y_name, 1)] * artist.has_yerr
    return {
        f"± {name}": np.array(
            [np.ptp(ends[:, side]) / 2 if len(ends) else np.nan for ends in bars.get_segments()]
        )
        for (name, side), bars in zip(kinds, artist.lines[2], strict=True)
    }


def _name(axis: Axis, otherwise: str) -> str:
    """Return the label of an axis or, where axes are shared, of the one that has it."""
    label = axis.get_label_text()
    if not label and axis.axis_name == "x":
        siblings = axis.axes.get_shared_x_axes().get_siblings(axis.axes)
        label = next(filter(None, (sibling.get_xlabel() for sibling in siblings)), "")
    first = label.partition("\n")[0]  # with its unit; a second line is a remark
    return without_math(first if "(" in first else label) or otherwise


def _named(axis: Axis, values: np.ndarray) -> ColumnValues:
    """Return ``values``, or the words of an axis of dates or of named ticks, the nearest."""
    locator, formatter = axis.get_major_locator(), axis.get_major_formatter()
    if isinstance(formatter, DaysAsDates):
        return [formatter(value) for value in values]
    if not isinstance(locator, FixedLocator) or not isinstance(formatter, FuncFormatter):
        return values
    ticks = np.asarray(locator.locs, dtype=float)
    labels = [without_math(word) for word in formatter.format_ticks(ticks)]
    return [labels[int(np.argmin(np.abs(ticks - value)))] for value in values]
