"""What stands behind a figure: its data, what is seen in it, what its points tell."""

import csv
import io
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from hbench.report.campaign.figures.all_figures import draw_all
from hbench.report.render import style
from hbench.report.render.figures import Sketch, draw_sketches, figure_files
from hbench.report.render.series import behind

SVG = "{http://www.w3.org/2000/svg}"


def rows(drawing):
    return list(csv.DictReader(io.StringIO(drawing.csv.decode())))


def titles(drawing):
    root = ElementTree.fromstring(drawing.svg)
    points = [group for group in root.iter(f"{SVG}g") if group.get("class") == "point"]
    return [point.findtext(f"{SVG}title") for point in points]


def plot(draw):
    figure = style.new_figure(height_in=3)
    axes = figure.add_subplot()
    axes.set(xlabel="Time (s)", ylabel="Force $F_{L}$ (N)")
    draw(axes)
    (drawing,) = draw_sketches([Sketch("one", "section", "One figure", "caption", figure)])
    return drawing


def test_every_figure_of_a_campaign_has_its_points_as_data(small, drawings):
    drawings = {drawing.name: drawing for drawing in drawings}
    assert all(drawing.csv for drawing in drawings.values())
    shown = [row for row in rows(drawings["stribeck-retract"]) if row["series"] == "−5000 N"]
    shown = [row for row in shown if row["panel"] == "1"]
    curve = next(c for c in small.curves if (c.direction, c.f_load_n) == ("retract", -5000.0))
    for row, point in zip(shown, curve.points, strict=True):
        assert float(row["Speed |v| (mm/s)"]) == pytest.approx(-1e3 * point.v_m_s, rel=1e-5)
        assert float(row["Friction |F| (N)"]) == pytest.approx(-point.friction_n, rel=1e-5)
        assert float(row["± Friction |F| (N)"]) == pytest.approx(point.ci95_n, rel=1e-5)
        assert row["runs"] == " ".join(point.runs)


def test_each_point_tells_its_own_trials(small, drawings):
    (drawing,) = (d for d in drawings if d.name == "stribeck-extend")
    told = titles(drawing)
    points = [p for c in small.curves if c.direction == "extend" for p in c.points]
    assert len(told) == 2 * len(points)  # and once more among the residuals
    for text, point in zip(told, points, strict=False):
        assert f"runs: {' '.join(point.runs)}" in text
        assert f"Friction |F| (N): {point.friction_n:.1f} ± " in text
        assert ", ".join(f"{f:.1f}" for f in point.trials_n).replace("-", "−") in text


def test_a_gap_in_a_series_moves_no_note_to_another_point():
    look = {"label": "a", "marker": "o", **style.POINTS}

    def draw(axes):
        bars = axes.errorbar([1, 2, 3], [5, np.nan, 7], [1, 1, np.nan], **look)
        behind(bars, {"run": ["x", "y", "z"]})

    drawing = plot(draw)
    first, last = titles(drawing)
    assert "Time (s): 1" in first and "5.000 ± 1.0" in first and "run: x" in first
    assert "Time (s): 3" in last and "±" not in last and "run: z" in last
    assert [row["run"] for row in rows(drawing)] == ["x", "y", "z"]
    assert rows(drawing)[1]["Force F_L (N)"] == ""


def test_what_is_there_for_the_eye_alone_is_no_data():
    drawing = plot(lambda axes: (axes.axhline(0), axes.plot([0, 1], [2, 3], label="_own")))
    assert [row["series"] for row in rows(drawing)] == ["own", "own"]


@pytest.mark.parametrize(
    "y,words",
    [
        ([5, 2, 9], "3 5 1 falls 2 2 rises 9 3"),
        ([5, 5.1, 9], "3 5 1 rises 9 3"),
        ([9, 5, 5.1], "3 9 1 falls 5 2 stays 5.1 3"),
    ],
)
def test_the_words_for_those_who_do_not_see_a_figure_say_how_it_goes(y, words):
    """The number of points, then y and x of the ends and turns."""
    seen = plot(lambda axes: axes.plot([1, 2, 3], y, "o", label="a")).seen
    names, _, course = seen.partition(" a: ")
    assert all(name in names for name in ("One figure.", "Force F_L (N)", "Time (s)"))
    assert re.findall(r"\d+(?:\.\d+)?|falls|rises|stays", course) == words.split()


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t", "\r"])
def test_no_cell_of_a_figures_data_is_a_formula(small, start, undrawn):
    label = f'{start}HYPERLINK("http://evil")'
    curves = tuple(replace(c, f_load_n=None, label=label) for c in small.curves[:1])
    steps = replace(small, curves=curves, efficiency=())
    own = plot(lambda axes: axes.plot([1], [2], "o", label=label))
    for drawing in (*draw_all(steps), own):
        for row in csv.reader(io.StringIO(drawing.csv.decode())):
            for cell in row:
                number = cell.lstrip("+-").replace(".", "").isdigit()
                assert number or not cell.startswith(("=", "+", "-", "@", "\t", "\r"))
    assert "HYPERLINK" in rows(own)[0]["series"]


def test_the_files_of_a_figure_are_its_svg_its_data_and_for_a_pdf_its_png(drawings):
    pixels = replace(drawings[0], name="pixels", csv=b"")
    drawing = replace(drawings[0], png=b"")
    files = figure_files([drawing, replace(drawing, name="bare", csv=b""), pixels])
    assert files[f"figures/{drawing.name}.csv"] == drawing.csv
    assert set(files) == {
        *(f"figures/{drawing.name}.{kind}" for kind in ("svg", "csv")),
        "figures/bare.svg",
        "figures/pixels.svg",
        "figures/pixels.png",
    }


def test_dots_and_images_have_their_values_as_data():
    def draw(axes):
        dots = axes.scatter([1, 2], [3, 4], c=[5, 6], label="_dots")
        behind(dots, {"value": [5.0, 6.0]})

    assert [row["value"] for row in rows(plot(draw))] == ["5", "6"]

    def table(axes):
        image = axes.imshow([[1, 2], [3, 4]], label="_cells")
        axes.set_xticks([0, 1], ["a", "b"])
        behind(image, {"gap": np.array([1.0, 2.0, 3.0, 4.0])})

    cells = [(row["Time (s)"], row["Force F_L (N)"], row["gap"]) for row in rows(plot(table))]
    assert cells == [("a", "0", "1"), ("b", "0", "2"), ("a", "1", "3"), ("b", "1", "4")]
