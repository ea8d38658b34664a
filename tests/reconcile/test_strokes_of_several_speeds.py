"""Strokes at several set speeds: the mean friction is not that at the mean speed."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.config.sensors import Instruments
from hbench.config.stroke_model import parse_strokes
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.strokes.pairs import repeats, stroke_pairs
from hbench.reconcile.strokes.series import MeasuredStrokes
from hbench.reconcile.strokes.stroke_diagnosis import StrokeTask, diagnose_strokes
from hbench.records import Provenance, Run, RunPlan, ScreenedRun, SteadyMeans
from tests.reconcile.test_strokes import AREA, SPECIMEN
from tests.reconcile.test_strokes import MODEL as OTHER

FRICTION = {
    "law": "tustin",
    "coulomb": "180 N",
    "stiction": "320 N",
    "stribeck_velocity": "15 mm/s",
    "viscous": "900 N s/m",
}
MODEL = OTHER | {"friction": {"test": FRICTION}}
INSTRUMENTS = Instruments.model_validate(
    {
        "force": {"tolerance": "0.5 %", "of": "full_scale", "full_scale": "10 kN"},
        "pressure": {"tolerance": "0.5 %", "of": "full_scale", "full_scale": "100 bar"},
    }
)  # 50 N; 0.5 bar, which are 63 N on the piston
# The pump is too small for the fast strokes at the large loads.
SPEEDS_MM_S = {5: (10, 40, 100, 160), 15: (10, 40, 100, 160), 30: (10, 40, 100), 45: (10, 40)}


def friction_n(v_m_s):
    return np.sign(v_m_s) * (180 + 140 * np.exp(-abs(v_m_s) / 0.015)) + 900 * v_m_s


def stroke(number, bar, v_m_s, trial, share=1.0, offset_n=0.0):
    f_test = bar * 1e5 * AREA
    lost = share * friction_n(v_m_s) + offset_n
    plan = RunPlan(f"{number}", "steady", trial, v_m_s, SPECIMEN, f_load_n=f_test)
    means = SteadyMeans(0.0, 1.0, 100, v_m_s, lost, f_test, f_test - lost, bar * 1e5, 0.0)
    t = np.linspace(0.0, 1.0, 101)
    run = Run(
        plan,
        t,
        v_m_s * t,
        p_tp_pa=np.full(len(t), bar * 1e5),
        f_applied_n=f_test - lost + 0.1 * np.sin(9 * t),
    )
    return ScreenedRun(run, (), means)


def campaign(speeds=SPEEDS_MM_S, offset_n=0.0):
    rng = np.random.default_rng(0)
    plans = [
        (bar, way * 1e-3 * speed, trial)
        for trial in (1, 2, 3)
        for bar, of_load in speeds.items()
        for speed in of_load
        for way in (1, -1)
    ]
    return tuple(
        stroke(i, *plan, 1 + 0.005 * rng.standard_normal(), offset_n)
        for i, plan in enumerate(plans)
    )


def diagnosed(runs, instruments=None):
    task = StrokeTask(
        provenance=Provenance("made", "imported", "", "", "2026-01-01", "2026-01-01"),
        model="model.yaml",
        plant_data=MODEL,
        plant=parse_strokes(MODEL, "model"),
        series={"one": runs},
        instruments=instruments,
    )
    return diagnose_strokes(task)


def test_an_exact_model_agrees_at_each_load_whatever_speeds_it_was_measured_at():
    """With the mean of a load's speeds as its speed the given model was 15 to 23 N off."""
    found = diagnosed(campaign())
    assert found.verdict == "none"
    assert max(load.before for load in found.held_out_loads) < 2.0  # newtons
    for name in ("coulomb", "viscous"):
        factor = found.refitted[f"friction.test.{name}"]
        assert factor.value == pytest.approx(1.0, abs=0.05)
        assert factor.ci95[0] < 1.0 < factor.ci95[1]


def test_a_speed_without_a_second_trial_is_left_out_and_not_taken_as_a_repeat_of_another():
    runs = [run for run in campaign() if run.run.plan.trial == 1]
    assert not repeats(stroke_pairs(runs))
    second = [run for run in campaign({15: (40, 100)}) if run.run.plan.trial == 2]
    (of_load,) = repeats(stroke_pairs([*runs, *second])).values()
    assert [[pair.speed_m_s for pair in run] for run in of_load] == [[0.04, 0.1]] * 2


def test_speeds_that_nobody_set_belong_together_by_their_rank():
    """Retraction was 3 % slower; with a speed in one direction alone they count as one."""
    measured = [
        replace(run, run=replace(run.run, plan=replace(plan, v_ref_m_s=v, speed_is_measured=True)))
        for run in campaign()
        for plan in [run.run.plan]
        for v in [plan.v_ref_m_s * (1 if plan.v_ref_m_s > 0 else 0.97)]
    ]
    of_loads = repeats(stroke_pairs(measured)).values()
    assert [len(runs[0]) for runs in of_loads] == [4, 4, 3, 2]
    assert {pair.speed_m_s for run in of_loads for pairs in run for pair in pairs} == {
        0.01, 0.04, 0.1, 0.16,
    }  # fmt: skip
    without = [run for run in measured if run.run.plan.v_ref_m_s != -0.04 * 0.97]
    assert {len(run) for runs in repeats(stroke_pairs(without)).values() for run in runs} == {1}


def test_an_offset_within_the_tolerance_of_the_instruments_is_fitted_and_not_named():
    """Without instruments 40 N were an offset to look for, in either sensor."""
    found = diagnosed(campaign(dict.fromkeys(SPEEDS_MM_S, (40,)), offset_n=40.0), INSTRUMENTS)
    assert found.verdict == "none" and not found.alternatives
    assert max(load.refitted for load in found.held_out_loads) < 2.0  # newtons
    assert set(found.within_tolerance) <= set(found.revised["effects"])
    assert found.zero_tolerances["f_applied"] == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("slope_n_bar", "words"),
    [(1.0, ""), (9.0, r"it would be 405 N of friction where 2\d\d N were .*45 bar.*")],
)
def test_a_friction_of_seals_larger_than_all_that_was_measured_is_ruled_out(slope_n_bar, words):
    strokes = MeasuredStrokes(parse_strokes(MODEL, "model"), stroke_pairs(campaign()))
    name = "seal_pressure_friction"
    effect = Hypothesis(effects={name: {"test_piston": slope_n_bar / 1e5, "test_rod": 0.0}})
    assert re.fullmatch(words, strokes.excess_friction(effect, name))
