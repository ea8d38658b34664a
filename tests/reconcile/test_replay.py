"""Runs of the virtual rig, made again by models under the commands that its log tells."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.experiment.closed_loop import record
from hbench.reconcile.measured.replay import replay_runs, signal_errors

PLAN = {
    "name": "replay",
    "experiments": [
        {
            "kind": "triangle",
            "p_lr": "15 bar",
            "loads": ["500 N"],
            "speed": "100 mm/s",
            "cycles": 1,
            "trials": 1,
            "travel": {"start": "120 mm", "end": "280 mm"},
            "hold": "0.2 s",
        }
    ],
}
# An effect of each place, and the signal in which it stands.
HIDDEN = {
    "p_tp": {"internal_leakage": {"test": "0.01 l/min/bar"}},
    "p_tr": {"pressure_offset": {"p_tr": "3 bar"}},
    "f_applied": {"load_cell_gain": {"error": "20 %"}},
    "v": {"velocity_filter_lag": {"time": "20 ms"}},
    "p_lr": {"pressure_offset": {"p_s": "-8 bar"}},
}


@pytest.mark.parametrize("signal", HIDDEN)
def test_a_model_with_the_benchs_own_effect_follows_what_one_without_it_does_not(
    bench, bench_data, signal
):
    plants = [parse_plant(bench_data, {"effects": own}, "it") for own in (HIDDEN[signal], {})]
    runs = record(bench, PLAN, plants[0], seed=3).runs
    own, other = (
        {one.signal: one for one in signal_errors(runs, replay_runs(runs, bench, plant)[0])}
        for plant in plants
    )
    print({name: (round(own[name].off, 3), round(other[name].off, 3)) for name in own})
    assert other[signal].off > 3 * own[signal].off
    assert own["x"].off < 0.5 and own["p_tp"].off < 0.5 and own["f_applied"].off < 40


def test_what_is_off_is_the_root_mean_square_over_samples_in_a_benchs_units(bench):
    """0.1 mm and 1 bar by construction; the worse of two runs is told."""
    (run,) = record(bench, PLAN, seed=3).runs
    second = replace(run, plan=replace(run.plan, run="0002"))
    moved = replace(second, x_m=run.x_m + 2e-4, p_tp_pa=run.p_tp_pa - 1e5)
    found = {one.signal: one for one in signal_errors((run, second), (run, moved))}
    assert (found["x"].unit, found["x"].worst_run) == ("mm", "0002")
    assert found["x"].worst == pytest.approx(0.2)
    assert found["x"].off == pytest.approx(0.2 / np.sqrt(2))
    assert found["p_tp"].off == pytest.approx(1 / np.sqrt(2)) and found["p_tp"].unit == "bar"
    assert found["p_tr"].off == 0


def test_runs_without_commands_or_with_uneven_samples_are_left_out_with_the_reason(bench):
    (run,) = record(bench, PLAN, seed=3).runs
    uneven = replace(run, t_s=run.t_s**1.1)
    lacking = replace(run, u_l2_v=None, p_s_pa=None)
    made, left_out = replay_runs((run, uneven, lacking), bench, bench)
    assert [one.plan.run for one in made] == [run.plan.run]
    assert len(left_out) == 2 and all(run.plan.run in text for text in left_out)
    assert left_out[1].endswith("p_s_pa, u_l2_v")
