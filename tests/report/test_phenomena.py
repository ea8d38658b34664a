"""Pages, figures and data of phenomena, drawn from records alone."""

import csv
import io
import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.records import Finding, Line, Panel, Phenomenon, WordTable
from hbench.report.simulation.figures import draw_panel, draw_phenomenon
from hbench.report.simulation.page import phenomenon_page
from hbench.report.simulation.text import phenomenon_text

X = np.array([1.0, 2.0, 50.0])
PANEL = Panel(
    "a",
    "Force over speed",
    "Speed (mm/s)",
    "Force (N)",
    (Line("theory", X, X**2), Line("simulated", X, X**2 + 1, points=True), Line("other", X, X)),
    x_log=True,
    y_log=True,
    marks=((5.0, "III"),),
)
SHOWN = Phenomenon(
    "demo",
    "A <demo>",
    ("One & two.",),
    (PANEL, replace(PANEL, name="b", x_log=False)),
    (Finding("force", "N", 1.25, 1.0, "F = 1"), Finding("other", "N", 3.0, None)),
    (WordTable("Words", ("who", "what"), (("x", "<y>"),)),),
)


@pytest.fixture(scope="module")
def drawings():
    return draw_phenomenon(SHOWN)


def test_points_share_the_colour_of_the_line_that_they_belong_to():
    theory, simulated, other, *_ = draw_panel(PANEL).axes[0].lines
    assert simulated.get_linestyle() == "None" and theory.get_linestyle() == "-"
    assert simulated.get_color() == theory.get_color() != other.get_color()
    assert simulated.get_ydata() == pytest.approx(X**2 + 1)


def test_axes_carry_labels_scales_and_marks():
    axes = draw_panel(PANEL).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Speed (mm/s)", "Force (N)")
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert [text.get_text() for text in axes.texts] == ["III"]
    assert axes.get_title("right") == "simulated"


def test_the_same_phenomenon_gives_the_same_bytes(drawings):
    assert drawings == draw_phenomenon(SHOWN)
    assert [drawing.name for drawing in drawings] == ["demo-a", "demo-b"]


def test_the_data_of_a_figure_reads_back(drawings):
    rows = list(csv.reader(io.StringIO(drawings[0].csv.decode())))
    assert rows[0] == ["series", "Speed (mm/s)", "Force (N)"]
    assert [float(row[2]) for row in rows[1:] if row[0] == "simulated"] == [2.0, 5.0, 2501.0]


def test_the_table_has_found_beside_expected():
    text = phenomenon_text(SHOWN)
    assert re.search(r"force +N +1\.2500 +1\.0000 +F = 1", text)
    assert re.search(r"other +N +3\.0000 +-", text)


def test_the_page_needs_nothing_else_and_escapes_every_text(drawings):
    page = phenomenon_page(SHOWN, drawings)
    assert "A &lt;demo&gt;" in page and "One &amp; two" in page and "&lt;y&gt;" in page
    assert page.count('class="plot"') == 2
    assert not re.search(r'(src|href)="(?!data:|#)', page)
