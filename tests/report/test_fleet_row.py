"""A campaign as a row of a fleet's table says what its own report says."""

import math
from dataclasses import replace
from datetime import UTC, datetime
from statistics import fmean

import numpy as np
import pytest

from hbench.analysis.summary.fleet_numbers import fleet_numbers
from hbench.analysis.summary.headline import planned_speed_m_s
from hbench.report.fleet.row import fleet_row as fleet_row_of
from hbench.store.fleet.table import cells_of
from tests.support.report.made_page import summarized


def at_planned_speed(results, speed_m_s=None):
    planned = planned_speed_m_s(run.run.plan for run in results.runs)
    return summarized(results, speed_m_s or planned)


def fleet_row(path, results, speed_m_s=None):
    results = at_planned_speed(results, speed_m_s)
    return fleet_row_of(path, results, fleet_numbers(results))


def of(results, series):
    """The curve that headline numbers are of."""
    key = series.direction, series.f_load_n
    return next(c for c in results.curves if (c.direction, c.f_load_n) == key)


@pytest.fixture
def one_load(stribeck):
    """The same with the lowest load alone, in both directions."""
    return replace(
        stribeck,
        runs=tuple(one for one in stribeck.runs if abs(one.run.plan.f_load_n) == 500.0),
        curves=tuple(one for one in stribeck.curves if abs(one.f_load_n) == 500.0),
        efficiency=tuple(one for one in stribeck.efficiency if abs(one.f_load_n) == 500.0),
    )


def test_a_row_has_the_reports_friction_and_its_fits_parameters(one_load):
    row = fleet_row("/a", one_load)
    results = at_planned_speed(one_load)
    assert len(results.headline.series) == 2
    for one in results.headline.series:
        curve = of(one_load, one)
        found = row.numbers["friction_n", one.direction]
        assert found.value == one.friction_n.value
        assert found.high - found.value == pytest.approx(one.friction_n.u95)
        (point,) = [p for p in curve.points if abs(p.v_m_s) == one.v_m_s]
        trials = np.array(point.trials_n)
        assert found.se == pytest.approx(trials.std(ddof=1) / math.sqrt(len(trials)))
        fitted = curve.fits[0].parameters["b_viscous_n_s_m"]
        found = row.numbers["b_viscous_n_s_m", one.direction]
        assert (found.value, found.low, found.high) == (fitted.value, *fitted.ci95)
        assert found.se == fitted.se
    worst = [c.name for c in results.quality.checks if c.grade == results.quality.grade]
    assert row.quality != "good" and row.weak == ", ".join(worst).replace("_", " ")
    assert row.quality == results.quality.grade and row.runs == len(one_load.runs)
    assert row.accepted == sum(run.accepted for run in one_load.runs)
    assert row.missing == ""


def test_a_fitted_parameter_without_a_standard_error_is_no_number_of_the_row(one_load):
    first, *others = one_load.curves
    fit = first.fits[0]
    at_bound = replace(fit.parameters["b_viscous_n_s_m"], se=None, at_bound="lower")
    fit = replace(fit, parameters=fit.parameters | {"b_viscous_n_s_m": at_bound})
    changed = replace(one_load, curves=(replace(first, fits=(fit, *first.fits[1:])), *others))
    lost = fleet_row("/a", one_load).numbers.keys() - fleet_row("/a", changed).numbers.keys()
    assert lost == {("b_viscous_n_s_m", first.direction)}


def test_a_parameter_that_the_report_says_is_not_determined_is_no_number_of_the_row(one_load):
    first, *others = one_load.curves
    fit = first.fits[0]
    wide = replace(fit.parameters["v_stribeck_m_s"], wide=True)
    assert wide.determination == "not determined" and wide.se is not None
    fit = replace(fit, parameters=fit.parameters | {"v_stribeck_m_s": wide})
    changed = replace(one_load, curves=(replace(first, fits=(fit, *first.fits[1:])), *others))
    lost = fleet_row("/a", one_load).numbers.keys() - fleet_row("/a", changed).numbers.keys()
    assert lost == {("v_stribeck_m_s", first.direction)}


def test_a_row_counts_what_the_plan_has_and_the_campaign_has_not(small):
    complete = replace(small.quality.completeness, planned=60, not_completed=("0059", "0060"))
    broken = replace(small, quality=replace(small.quality, completeness=complete))
    row = fleet_row_of("/a", broken, {})
    assert row.missing.startswith("2 of 60 planned runs were not completed")


def test_a_row_names_what_a_plan_varies_and_counts_its_trials(one_load):
    settings = {
        "specimen": {"serial": "17"},
        "test": {"operator": "J. Doe", "mounting": "2", "date": "2026-02-27"},
    }
    provenance = replace(one_load.provenance, settings=settings)
    row = fleet_row("/a", replace(one_load, provenance=provenance))
    stated = row.specimen, row.operator, row.mounting, row.day
    assert stated == ("17", "J. Doe", "2", "2026-02-27")
    assert row.started == datetime.fromisoformat(provenance.started)
    imported = replace(provenance, source="imported")
    row = fleet_row("/a", replace(one_load, provenance=imported))
    assert row.started == datetime(2026, 2, 27, tzinfo=UTC)
    assert row.numbers["friction_n", "extend"].trials == 3
    assert row.numbers["friction_n", "extend"].dof == pytest.approx(2.0)


def test_several_loads_give_their_mean_with_an_interval_that_is_no_narrower_than_needed(stribeck):
    row = fleet_row("/a", stribeck)
    series = at_planned_speed(stribeck).headline.series
    own = [one.friction_n for one in series if one.direction == "extend"]
    assert len(own) > 1
    found = row.numbers["friction_n", "extend"]
    assert found.value == pytest.approx(fmean(one.value for one in own))
    assert found.high - found.value == pytest.approx(fmean(one.u95 for one in own))
    assert found.se == pytest.approx(math.sqrt(sum(one.se**2 for one in own)) / len(own))


def test_a_load_that_is_missing_leaves_no_mean_of_the_others(stribeck):
    gone = next(curve for curve in stribeck.curves if curve.direction == "extend")
    curves = tuple(curve for curve in stribeck.curves if curve is not gone)
    row = fleet_row("/a", replace(stribeck, curves=curves))
    assert ("friction_n", "extend") not in row.numbers
    assert ("friction_n", "retract") in row.numbers
    assert row.protocol == fleet_row("/a", stribeck).protocol


def test_the_working_speed_is_that_of_the_schedule_whatever_was_rejected(small):
    runs = tuple(
        replace(one, reasons=("lost: x",)) if abs(one.run.plan.v_ref_m_s) > 0.1 else one
        for one in small.runs
    )
    speed = fleet_row("/a", small).v_m_s
    assert fleet_row("/a", replace(small, runs=runs)).v_m_s == speed
    assert fleet_row("/a", small, 0.123).v_m_s == 0.123


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("2026-03-01T12:00:00+02:00", datetime(2026, 3, 1, 10, tzinfo=UTC)),
        ("2026-03-01", datetime(2026, 3, 1, tzinfo=UTC)),
        ("yesterday", None),
        ("9999-12-31T23:59:59-23:00", None),
    ],
)
def test_a_moment_that_is_none_is_left_out(small, written, read):
    row = fleet_row("/a", replace(small, provenance=replace(small.provenance, started=written)))
    assert row.started == read


def test_long_or_odd_words_of_a_campaign_become_a_line(small):
    made = replace(
        small.provenance, name="a\x1b[31m\n" + "b" * 500, bench="x", details={"seed": 2**80}
    )
    row = fleet_row("/a", replace(small, provenance=made))
    assert len(row.name) == 200 and "\x1b" not in row.name and "\n" not in row.name
    assert row.seed is None
    assert cells_of(row)[0] == "/a"
