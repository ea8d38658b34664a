"""Loads and pressures that logs contain, without a load that the plan states."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.reconcile.practice.working_point import _nearest_point
from hbench.reconcile.separation.logged_loads import has_second_load, has_second_pressure
from hbench.reconcile.separation.missing_data import missing_experiments
from hbench.records import Run, RunPlan, Specimen

BORE, ANNULUS = 20e-4, 12e-4  # m^2
LOAD_AREAS = 20e-4, 14e-4
FRICTION = 700.0


def cycles(load_n, label, **channels):
    """Return a log that moves out and in at 80 mm/s against a load, with friction of 700 N."""
    t = 0.01 * np.arange(400)
    v = np.where(np.sin(2 * np.pi * t / 2.0) > 0, 0.08, -0.08)
    x = 0.1 + np.cumsum(v) * 0.01
    plan = RunPlan("0001", "verification", 1, 0.08, Specimen(BORE, ANNULUS), label=label)
    p_tr = np.full(400, 12e5)
    p_tp = (load_n + FRICTION * np.sign(v) + p_tr * ANNULUS) / BORE
    return Run(plan, t, x, p_tp_pa=p_tp, p_tr_pa=p_tr, **channels)


def with_load_cylinder(run, load_n):
    """Its rod side is at 8 bar; friction drives or brakes it by 400 N."""
    p_lr = np.full(400, 8e5)
    way = np.sign(np.gradient(run.x_m))
    return replace(
        run, p_lr_pa=p_lr, p_lp_pa=(load_n - 400.0 * way + p_lr * LOAD_AREAS[1]) / LOAD_AREAS[0]
    )


def test_the_test_cylinders_pressures_show_two_loads_though_friction_is_large():
    assert has_second_load([cycles(3000.0, "40 bar"), cycles(5000.0, "70 bar")])
    assert not has_second_load([cycles(3000.0, "day 1"), cycles(3150.0, "day 2")])


def test_strokes_of_unequal_length_are_no_second_load():
    """Twice as long in one direction: the median force is that with or against friction."""

    def mostly(run, way):
        moving = np.sign(np.gradient(run.x_m)) == way
        kept = moving | (np.arange(400) < 200)
        channels = {name: getattr(run, name)[kept] for name in ("x_m", "p_tp_pa", "p_tr_pa")}
        return replace(run, t_s=0.01 * np.arange(kept.sum()), **channels)

    out, back = mostly(cycles(1000.0, "out"), 1), mostly(cycles(1000.0, "back"), -1)
    medians = [np.median(run.p_tp_pa * BORE - run.p_tr_pa * ANNULUS) for run in (out, back)]
    assert abs(np.diff(medians)[0]) > 0.5 * max(medians)
    assert not has_second_load([out, back])


def test_the_load_cylinders_pressures_decide_before_those_of_the_test_cylinder():
    runs = [with_load_cylinder(cycles(3000.0, f"{n:g}"), n) for n in (3000.0, 5000.0)]
    assert has_second_load(runs, LOAD_AREAS) and not has_second_load(runs)
    assert "loads" in missing_experiments(runs)
    assert "loads" not in missing_experiments(runs, LOAD_AREAS)


def test_a_load_cell_decides_before_any_pressure():
    same = [
        replace(with_load_cylinder(cycles(n, f"{n:g}"), n), f_applied_n=np.full(400, 2000.0))
        for n in (3000.0, 5000.0)
    ]
    assert not has_second_load(same, LOAD_AREAS)


def test_without_areas_and_without_a_load_cell_no_load_is_known():
    rotary = [
        replace(run, plan=replace(run.plan, specimen=Specimen(0.0, 0.0)))
        for run in (cycles(3000.0, "a"), cycles(5000.0, "b"))
    ]
    assert not has_second_load(rotary)


def test_one_load_at_two_pressures_is_seen_without_a_load_cell():
    def steady(level_pa, load_n):
        run = cycles(load_n, f"{level_pa:g}")
        p_lp = (load_n + level_pa * LOAD_AREAS[1]) / LOAD_AREAS[0]
        return replace(
            run,
            plan=replace(run.plan, kind="steady"),
            p_lr_pa=np.full(400, level_pa),
            p_lp_pa=np.full(400, p_lp),
        )

    assert has_second_pressure([steady(8e5, 3000.0), steady(40e5, 3000.0)], LOAD_AREAS)
    assert not has_second_pressure([steady(8e5, 3000.0), steady(40e5, 6000.0)], LOAD_AREAS)


@pytest.mark.filterwarnings("error")
def test_the_working_point_of_a_bench_without_load_cell_is_found_by_the_other_signals():
    point, speed = np.repeat([0, 1, 2], 4), np.repeat([0.02, 0.05, 0.09], 4)
    unmeasured, chosen = np.full(12, np.nan), np.ones(12, bool)
    assert _nearest_point(point, [speed, unmeasured], chosen) == 1
