"""Learned laws in words and as figures."""

from dataclasses import replace

from hbench.records import (
    UnnamedLaw,
)
from hbench.report.diagnosis.figures.law_figures import law_figure
from hbench.report.diagnosis.words.law import law_title
from tests.support.report.summarised import summary


def test_an_unknown_effect_with_a_learned_law_has_its_size_and_that_it_is_unnamed(compared):
    law = UnnamedLaw(
        "friction_test", ("force_test",), "N", ("position",), ("mm",), ((0.0, 100.0, 200.0),),
        (-2.0, 31.4, 5.0), (-3.0, 30.0, 4.0), (-1.0, 33.0, 6.0), 9.5, 2.1, 40.0, 12.0, 0.001,
    )  # fmt: skip
    says = (
        "The revised model contains an unnamed law, fitted as a table: dry friction of −2.0 to "
        "31 N over position (force of test cylinder; gap of runs outside the fit 9.50 before, 2.10 "
        "after). A table reproduces a deviation but does not show its cause."
    )
    text = summary(replace(compared, verdict="unknown", unnamed=(law,)))
    assert says in text
    assert "model.yaml reproduces a part of this deviation by its unnamed law" in text
    assert says in summary(replace(compared, verdict="unknown", unnamed=(law,)))


def test_quantities_of_a_learned_law_have_the_symbols_of_its_chamber(compared):
    values = (0.0, 0.1, 0.2, 0.4)
    law = UnnamedLaw(
        "flow_lp", ("flow_lp",), "l/min", ("rod_pressure", "opening"), ("bar", "V"),
        ((40.0, 140.0), (-2.0, 2.0)), values, values, values, 3.0, 1.1, 40.0, 12.0, 0.001,
    )  # fmt: skip
    assert " over rod pressure P_Lr and opening u_L2" in law_title(law)
    (axes,) = law_figure(compared, law).axes
    assert axes.get_xlabel() == "Rod pressure $P_{Lr}$ (bar)"
    assert [text.get_text() for text in axes.get_legend().texts] == [
        "opening $u_{L2}$ = −2 V",
        "opening $u_{L2}$ = 2 V",
    ]


def test_the_curves_of_a_learned_law_all_differ_in_colour_or_marker(compared):
    knots = (-2.0, 2.0), tuple(float(position) for position in range(40, 360, 40))
    values = (0.1,) * 16
    law = UnnamedLaw(
        "flow_tr", ("flow_tr",), "l/min", ("velocity", "position"), ("mm/s", "mm"), knots, values,
        values, values, 3.0, 1.1, 40.0, 12.0, 0.001,
    )  # fmt: skip
    (axes,) = law_figure(compared, law).axes
    looks = {(line.get_color(), line.get_marker()) for line in axes.get_legend().get_lines()}
    assert len(looks) == len(knots[1]) == 8
