"""Figures as files and as parts of a page: drawn once, with their data and a text alternative."""

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple
from xml.etree import ElementTree

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hbench.parallel.forked import map_forked
from hbench.report.render.figure_text import alternative_text, data_csv, point_notes
from hbench.report.render.series import DrawnSeries, series_of, without_math
from hbench.report.render.style import RC, WIDTH_IN

PNG_DPI = 200
_PNG = {"compress_level": 1}  # a tenth larger than at 6, in a quarter of the time
POINT = "point"  # class of the marks with a note

SVG = "{http://www.w3.org/2000/svg}"
ElementTree.register_namespace("", SVG[1:-1])
ElementTree.register_namespace("xlink", "http://www.w3.org/1999/xlink")


@dataclass(frozen=True)
class Drawing:
    """A figure as drawn. ``name`` is fit for a file name and unique in a campaign."""

    name: str
    section: str
    title: str
    caption: str
    svg: bytes
    png: bytes = b""  # for a PDF only
    wide: bool = False  # over the page's whole width
    narrow: bool = False  # fits a phone
    csv: bytes = b""  # its data
    seen: str = ""  # its text alternative
    read: str = ""  # how to read it, which the figure has in small letters


class Sketch(NamedTuple):
    """A figure that is yet to be drawn; the names are those of ``Drawing``."""

    name: str
    section: str
    title: str
    caption: str
    figure: Figure


def draw_sketches(sketches: Sequence[Sketch], png: bool = False) -> tuple[Drawing, ...]:
    """Return the figures as drawings, each with its data and its text alternative.

    ``png`` draws them as PNG too, which takes as long as the SVG.
    """
    return tuple(map_forked(partial(_draw_sketch, png=png), sketches))


def _draw_sketch(sketch: Sketch, png: bool) -> Drawing:
    name, section, title, caption, figure = sketch
    series = series_of(figure)
    svg = as_svg(figure)
    pixels = as_png(figure) if png else b""
    csv = data_csv(series).encode() if series else b""
    width_in = figure.get_figwidth()
    wide, narrow = width_in > WIDTH_IN, width_in < WIDTH_IN
    seen = alternative_text(title, series)
    read = without_math(figure.get_supxlabel())
    return Drawing(name, section, title, caption, svg, pixels, wide, narrow, csv, seen, read)


def of_section(drawings: Iterable[Drawing], section: str) -> tuple[Drawing, ...]:
    """Return the drawings of a section."""
    return tuple(drawing for drawing in drawings if drawing.section == section)


def figure_files(drawings: Iterable[Drawing]) -> dict[str, bytes]:
    """Return the files of drawings, SVG, any PNG and their data as CSV, by their paths."""
    files = {}
    for drawing in drawings:
        for kind in ("svg", "png", "csv"):
            if content := getattr(drawing, kind):
                files[f"figures/{drawing.name}.{kind}"] = content
    return files


def as_svg(figure: Figure) -> bytes:
    """Return ``figure`` as SVG; the same figure gives the same bytes.

    Each point of a series shows its numbers under the pointer.
    """
    svg = io.BytesIO()
    marked = [(series, series.points) for series in series_of(figure) if series.points is not None]
    for number, (_, points) in enumerate(marked):
        points.set_gid(f"series{number}")
    with rc_context(RC):
        FigureCanvasSVG(figure).print_svg(svg, metadata={"Date": None, "Creator": None})
    return _with_notes(svg.getvalue(), marked)


def as_png(figure: Figure) -> bytes:
    """Return ``figure``, already drawn as SVG, as PNG; the same figure gives the same bytes."""
    png = io.BytesIO()
    with rc_context(RC):
        figure.set_layout_engine("none")  # it is laid out; once more takes as long as drawing
        figure.set_dpi(PNG_DPI)
        FigureCanvasAgg(figure).print_png(png, metadata={"Software": None}, pil_kwargs=_PNG)
    return png.getvalue()


def _with_notes(svg: bytes, marked: list[tuple[DrawnSeries, Line2D]]) -> bytes:
    """Wrap the mark of each point with its note as a title."""
    root = ElementTree.fromstring(svg)
    groups = {group.get("id"): group for group in root.iter(f"{SVG}g")}
    for number, (series, points) in enumerate(marked):
        notes = [
            note
            for note, x, y in zip(point_notes(series), *points.get_data(), strict=True)
            if abs(x) + abs(y) < float("inf")
        ]
        marks = [
            (parent, mark)
            for parent in groups[f"series{number}"].iter(f"{SVG}g")
            for mark in parent.findall(f"{SVG}use")
        ]
        if len(marks) != len(notes):  # a point lies off the figure: no note may be misplaced
            continue
        for (parent, mark), note in zip(marks, notes, strict=True):
            at = list(parent).index(mark)
            parent.remove(mark)
            point = ElementTree.Element(f"{SVG}g", {"class": POINT})
            ElementTree.SubElement(point, f"{SVG}title").text = note
            point.append(mark)
            parent.insert(at, point)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
