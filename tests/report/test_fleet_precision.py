"""A fleet whose campaigns form a plan: its page, its text and its JSON."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.fleet.precision import Tolerance
from hbench.report.fleet.figures import draw_fleet
from hbench.report.fleet.page import fleet_page
from hbench.report.fleet.precision import limit_sentences
from hbench.report.fleet.terminal import fleet_text
from hbench.report.fleet.text import fleet_json
from hbench.report.fleet.verdict import fleet_verdict
from tests.support.report.made_fleet import summary_of
from tests.support.report.made_plan import SIGMA_N, WEAR_N_M, plan_rows, write_plan
from tests.support.report.spaces import ordinary_spaces


def summary(folder, rows, tolerance=None):
    return summary_of(write_plan(folder, rows), tolerance)


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    rows = plan_rows(cylinders=10, seed=2)
    return summary(tmp_path_factory.mktemp("plan"), rows, Tolerance(150.0, "N"))


def study(fleet, direction="extend"):
    return next(
        p for p in fleet.precision if (p.quantity.name, p.direction) == ("friction_n", direction)
    )


def test_the_sources_of_a_plan_are_found(fleet):
    """Drawn from Laplace's and Student's distributions.

    One cylinder of ten wears by 50 N over its six mountings, which adds 35 N^2 to their variance.
    """
    found = study(fleet)
    sigmas = {source.name: source.variance for source in found.sources}
    assert list(sigmas) == [
        "cylinder",
        "operator",
        "mounting",
        "day",
        "cylinder × operator",
        "trials",
    ]
    for name, sigma in (SIGMA_N | {"mounting": math.sqrt(SIGMA_N["mounting"] ** 2 + 35)}).items():
        high = math.inf if sigmas[name].high is None else sigmas[name].high
        assert sigmas[name].low < sigma**2 * 1.5 and high > sigma**2 / 1.5
    assert (found.campaigns, found.cylinders, round(found.trials, 6)) == (60, 10, 3.0)
    assert found.tolerance == 150.0
    efficiency = next(p for p in fleet.precision if p.quantity.name == "efficiency")
    assert efficiency.tolerance is None


@pytest.mark.usefixtures("wide_terminal")
def test_the_page_states_limits_tolerance_and_what_they_mean(fleet, undrawn):
    page = ordinary_spaces(fleet_page(fleet, draw_fleet(fleet)))
    limits = " ".join(limit_sentences(fleet))
    r, limit = study(fleet).limits
    assert f"repeatability limit {r:.0f} N, reproducibility limit {limit:.0f} N" in limits
    share = f"{100 * study(fleet).share_of_tolerance:.0f} % of the tolerance"
    assert all(each in page for each in limit_sentences(fleet))
    assert "repeatability limit" not in fleet_verdict(fleet)
    assert share in limits and "Variance components" in page and "ISO 5725-6" in page
    text = fleet_text(fleet)
    assert text.isascii() and "mounting, in a cylinder" in text


def test_control_charts_show_the_measurement_and_the_wear_of_the_cylinder_that_wears(fleet):
    assert all(chart.of_cylinders and chart.n == 60 for chart in fleet.charts)
    worn = {t.specimen: t for t in fleet.wear if t.over == "distance_m" and t.direction == "extend"}
    first = worn["C-001"]
    assert first.low < WEAR_N_M < first.high and first.p == min(t.p for t in worn.values())
    document = json.loads(fleet_json(fleet))
    (shown,) = [
        p
        for p in document["precision"]
        if (p["quantity"]["name"], p["direction"]) == ("friction_n", "extend")
    ]
    assert shown["limit_R"] == pytest.approx(2.8 * shown["reproducibility"]["value"])
    assert document["charts"][0]["limits"][0] < document["charts"][0]["centre"]


def test_a_fleet_without_repeats_says_why_there_are_no_limits(tmp_path):
    rows = plan_rows(cylinders=12, operators=1, mountings=1)
    once = summary(tmp_path / "once", rows)
    assert (
        once.precision == ()
        and "Each of the 12 cylinders was measured once" in (once.plan_notes[0])
    )
    assert once.plan_notes[0] in fleet_page(once, ())
    unnamed = summary(tmp_path / "unnamed", [replace(row, specimen="") for row in rows])
    assert "specimen.serial" in fleet_text(unnamed)


def test_figures_have_their_data(fleet, undrawn):
    drawings = {drawing.name: drawing for drawing in draw_fleet(fleet)}
    for name in ("components-friction-n", "control-friction-n-extend", "wear-friction-n-extend"):
        assert drawings[name].csv.count(b"\n") > 5 and len(drawings[name].seen) > 40
    values = np.array(study(fleet).sources[0].variance.value)
    assert f"{math.sqrt(values):.3g}".encode()[:3] in drawings["components-friction-n"].csv
