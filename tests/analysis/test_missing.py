"""A bench with one pressure or none: what can be computed is, the rest is named once."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.curves.average import curves
from hbench.analysis.screening.limitations import not_computed
from hbench.analysis.screening.screen import screen
from hbench.analysis.uncertainty.efficiency import efficiency_curve
from hbench.records import Specimen


def verdict(runs, rules):
    screened = [screen(run, rules) for run in runs]
    found = [efficiency_curve(curve, None) for curve in curves(screened)]
    return screened, found, not_computed(screened, found, None)


def trials(make_run, **changes):
    return [make_run(trial=trial, seed=trial, noise=1.0, **changes) for trial in (1, 2, 3)]


@pytest.mark.parametrize(
    ("missing", "remedy"),
    [
        (("p_tr_pa",), "chamber"),
        (("p_tp_pa", "p_tr_pa"), "chamber"),
        (("f_applied_n",), "weight"),
    ],
)
def test_what_lacks_for_friction_is_named_once_and_speed_and_the_rest_are_there(
    make_run, rules, missing, remedy
):
    runs = [replace(run, **dict.fromkeys(missing)) for run in trials(make_run, v_m_s=0.05)]
    screened, _, notes = verdict(runs, rules)
    assert len(notes) == 1 and "3 of 3 runs" in notes[0]
    assert f": {', '.join(missing)} " in notes[0] and remedy in notes[0]
    for one in screened:
        assert one.reasons[0].startswith("missing_channel: ")
        assert one.means.v_m_s == pytest.approx(0.05, rel=1e-3)
        assert one.means.friction_n is None and one.means.efficiency is None
        assert (one.means.f_test_n is None) == ("p_tr_pa" in missing)
        if "f_applied_n" not in missing:
            assert one.means.f_applied_n == pytest.approx(2000, abs=10)
        for name in {"p_tp_pa", "p_tr_pa"} - set(missing):
            assert getattr(one.means, name) == pytest.approx(np.mean(getattr(one.run, name)), 1e-3)


def test_one_pressure_and_a_rod_side_open_to_the_air_give_friction(make_run, rules):
    runs = trials(make_run, friction_n=300, p_tr_pa=0.0)
    (curve,) = curves(screen(replace(run, p_tr_pa=0 * run.t_s), rules) for run in runs)
    assert curve.points[0].friction_n == pytest.approx(300, abs=5)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_passive_cylinder_with_open_ports_gives_friction_but_no_efficiency(
    make_run, rules, direction
):
    # pulled or pushed by the load cell: F_friction = -F_applied
    area = Specimen(1.25e-3, 0.75e-3, 0.4)
    made = trials(make_run, v_m_s=0.05 * direction, f_applied_n=-260.0 * direction)
    runs = [
        replace(r, p_tp_pa=0 * r.t_s, p_tr_pa=0 * r.t_s, plan=replace(r.plan, specimen=area))
        for r in made
    ]
    screened, found, notes = verdict(runs, rules)
    assert all(one.accepted for one in screened)
    (point,) = curves(screened)[0].points
    assert point.friction_n == pytest.approx(260 * direction, abs=5)
    assert found[0].points[0].efficiency is None
    assert "efficiency" in notes[0] and found[0].points[0].reason in notes[0]
    assert "bench file" in notes[1]


def test_a_weight_stands_in_for_the_load_cell(make_run, rules):
    runs = trials(make_run, friction_n=300, f_applied_n=981.0)
    runs = [replace(run, f_applied_n=np.full(len(run.t_s), 981.0)) for run in runs]
    (curve,) = curves(screen(run, rules) for run in runs)
    assert curve.points[0].friction_n == pytest.approx(300, abs=5)


def test_nothing_is_named_where_nothing_lacks(make_run, rules, bench):
    screened, found, _ = verdict(trials(make_run), rules)
    assert not_computed(screened, found, bench.instruments) == ()
