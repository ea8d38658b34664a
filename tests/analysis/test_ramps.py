"""Friction curves of ramps, against the law and the mass that the runs were made of."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hbench.analysis.curves.ramps import ramp_curves, sliding
from hbench.records import ScreenedRun
from tests.support.analysis.moving import SPECIMEN, moving_run, ramp_velocity

MASS_KG = 40.0  # heavy, so that its inertia shows


def law(v):
    return 120 + 260 * np.exp(-v / 0.06) + 2400 * v


def ramp(a, level=1.0, trial=1, run="0001", sign=1.0, **changes):
    v = ramp_velocity(a, 0.2)
    plan = {"a_ref_m_s2": a, "trial": trial, "run": run}
    return moving_run(
        "ramp", sign * v, sign * level * law(v), MASS_KG, plan=plan, x0=0.2 - sign * 0.15, **changes
    )


def screened(runs, reasons=()):
    return [ScreenedRun(run, tuple(reasons), None) for run in runs]


@pytest.mark.parametrize("sign,direction", [(1.0, "extend"), (-1.0, "retract")])
def test_points_lie_on_the_law_and_the_test_sides_inertia_is_taken_off(sign, direction):
    runs = [ramp(a, sign=sign) for a in (0.05, 0.1)]
    (slow, fast), notes = ramp_curves(screened(runs), MASS_KG)
    assert notes == () and (slow.a_ref_m_s2, fast.a_ref_m_s2) == (0.05, 0.1)
    for curve in (slow, fast):
        assert (curve.kind, curve.direction, len(curve.points)) == ("ramp", direction, 19)
        v = np.abs([point.v_m_s for point in curve.points])
        # A bin's mean lies above the law by F'' h^2 / 24: 0.3 N at most.
        friction = [sign * point.friction_n for point in curve.points]
        assert friction == pytest.approx(law(v), abs=0.6)
    (with_inertia,), _ = ramp_curves(screened(runs[1:]), 0.0)
    pairs = zip(with_inertia.points, fast.points, strict=True)
    extra = [sign * (p.friction_n - q.friction_n) for p, q in pairs]
    assert extra == pytest.approx(np.full(19, MASS_KG * 0.1), abs=0.05)


def test_the_applied_force_is_the_load_cells_own_and_holds_no_inertia():
    (curve,), _ = ramp_curves(screened([ramp(0.1), ramp(0.1, trial=2)]), MASS_KG)
    for point in curve.points:
        assert point.f_applied_n == pytest.approx(2000.0, abs=1e-9)
        inertia = point.f_test_n - point.f_applied_n - point.friction_n
        assert inertia == pytest.approx(MASS_KG * 0.1, abs=0.05)


def test_a_plunger_needs_no_rod_side_pressure():
    run = ramp(0.1)
    specimen = replace(run.plan.specimen, area_rod_m2=0.0)
    area, rod = SPECIMEN.area_piston_m2, SPECIMEN.area_rod_m2
    force = run.p_tp_pa * area - run.p_tr_pa * rod
    plunger = replace(
        run, plan=replace(run.plan, specimen=specimen), p_tp_pa=force / area, p_tr_pa=None
    )
    (curve,), notes = ramp_curves(screened([plunger]), MASS_KG)
    (cylinder,), _ = ramp_curves(screened([run]), MASS_KG)
    assert notes == () and {point.p_tr_pa for point in curve.points} == {None}
    friction = [point.friction_n for point in cylinder.points]
    assert [point.friction_n for point in curve.points] == pytest.approx(friction)


def test_accelerations_rise_in_whatever_order_they_were_run():
    runs = [ramp(a, sign=sign) for a in (0.1, 0.05, 0.2) for sign in (1.0, -1.0)]
    found, _ = ramp_curves(screened(runs), MASS_KG)
    order = [(curve.direction, curve.a_ref_m_s2) for curve in found]
    assert order == [(way, a) for way in ("extend", "retract") for a in (0.05, 0.1, 0.2)]


def test_intervals_are_students_over_trials_and_not_over_samples():
    levels = [0.97, 1.0, 1.06]
    runs = [ramp(0.1, level, trial) for trial, level in enumerate(levels, start=1)]
    (curve,), _ = ramp_curves(screened(runs), MASS_KG)
    for point in curve.points[::6]:
        assert point.n == 3 and point.trials == (1, 2, 3)
        low, high = stats.t.interval(
            0.95, 2, np.mean(point.trials_n), stats.sem(np.array(point.trials_n))
        )
        assert point.ci95_n == pytest.approx((high - low) / 2)
        assert np.array(point.trials_n) / point.trials_n[1] == pytest.approx(levels, rel=1e-3)


def test_a_rejected_ramp_and_one_that_can_not_be_followed_are_left_out():
    good, gapped = ramp(0.1), ramp(0.1, trial=2, run="0002")
    keep = np.arange(len(gapped.t_s)) != 40
    arrays = {k: v[keep] for k, v in vars(gapped).items() if isinstance(v, np.ndarray)}
    found, notes = ramp_curves(
        [*screened([good, replace(gapped, **arrays)]), *screened([ramp(0.1)], ["aborted: x"])],
        MASS_KG,
    )
    assert [curve.points[0].n for curve in found] == [1]
    assert len(notes) == 1 and "run 0002" in notes[0] and "evenly spaced" in notes[0]


def test_presliding_is_cut_off_at_breakaway_and_nothing_after_20_mm_is():
    v = ramp_velocity(0.05, 0.2)
    way = v**2 / 0.1
    rising = law(v) * (1 - np.exp(-way / 1e-3))  # bristles of 1 mm
    run = moving_run("ramp", v, rising, plan={"a_ref_m_s2": 0.05})
    (curve,), _ = ramp_curves(screened([run]), 0.0)
    cut = sliding(curve)
    early = [p for p in curve.points if p.v_m_s**2 / 0.1 < 0.02]
    assert cut.points[0].friction_n == max(p.friction_n for p in early)
    assert 0 < len(curve.points) - len(cut.points) <= len(early)
    monotonic = replace(
        curve, points=tuple(replace(p, friction_n=2e3 * p.v_m_s) for p in curve.points)
    )
    assert sliding(monotonic).points[0].v_m_s ** 2 / 0.1 < 0.02, "20 mm at the latest"
