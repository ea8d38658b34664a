"""Channels that a bench lacks narrow the catalogue, and the diagnosis says by what."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.reconcile.nuisance import BACKGROUND
from hbench.reconcile.separation.observable import observable_effects
from hbench.records import Run, RunPlan, Specimen

CHANNELS = (
    *("v_m_s", "p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa", "f_applied_n"),
    *("u_t_v", "u_l1_v", "u_l2_v"),
)
FLOW = {"internal_leakage", "external_leakage", "valve_lag", "valve_deadband", "entrained_air"}
FRICTION = {"seal_pressure_friction", "load_friction", "direction_asymmetry", "friction_lag"}
ON_THE_TEST_SIDE = {"presliding", "position_friction", "end_cushion"}


def run(*lacking):
    plan = RunPlan("0001", "steady", 1, 0.1, Specimen(1e-3, 6e-4))
    zeros = np.zeros(3)
    whole = Run(plan, zeros, zeros, **dict.fromkeys(CHANNELS, zeros))
    return replace(whole, **dict.fromkeys(lacking))


@pytest.mark.parametrize(
    ("lacking", "gone", "kept", "balance"),
    [
        ((), set(), FLOW | FRICTION | ON_THE_TEST_SIDE | {"supply_droop"}, ""),
        (("f_applied_n",), FRICTION | ON_THE_TEST_SIDE | {"load_cell_gain"}, FLOW, "force_test"),
        (("p_s_pa",), FLOW | {"supply_droop"}, FRICTION | {"load_cell_gain"}, ""),
        (("p_lp_pa", "p_lr_pa"), set(), FLOW | FRICTION | ON_THE_TEST_SIDE | {"supply_droop"}, ""),
        (("u_t_v",), FLOW, FRICTION | ON_THE_TEST_SIDE | {"supply_droop"}, "flow_tp"),
        (("u_l1_v", "u_l2_v"), {"supply_droop"}, FLOW | FRICTION, "supply"),
        (("u_l1_v", "u_l2_v", "p_lp_pa", "p_lr_pa"), set(), FLOW | FRICTION | {"supply_droop"}, ""),
        (("v_m_s",), {"velocity_filter_lag"}, FLOW | FRICTION, "kinematics"),
    ],
)
def test_effects_that_the_channels_cannot_tell_are_left_out_with_the_reason(
    bench, lacking, gone, kept, balance
):
    told, not_tried = observable_effects([run(*lacking)], bench)
    assert kept <= set(told)
    assert gone <= set(not_tried)
    assert not set(told) & set(not_tried)
    assert all(balance in not_tried[name] for name in gone)


def test_effects_that_only_tell_benches_apart_are_refitted_and_never_tried(bench):
    told, not_tried = observable_effects([run()], bench)
    assert BACKGROUND == {"valve_trim"}
    assert BACKGROUND <= set(not_tried) and not BACKGROUND & set(told)
    assert all("refitted" in not_tried[name] for name in BACKGROUND)
