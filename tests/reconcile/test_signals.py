"""The open loop against the bench's equations of steady motion, solved here."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve

from hbench.config.bench import parse_plant
from hbench.reconcile.measured.balances import balance_model
from hbench.reconcile.measured.window_signals import (
    OPEN_LOOP_SIGNALS,
    SIGNALS,
    open_loop,
    open_loop_errors,
    signals,
)
from hbench.records import Run, RunPlan, Specimen

A_P, A_R = np.pi / 4 * 0.04**2, np.pi / 4 * (0.04**2 - 0.025**2)
GAIN, P_T = 7.43e-7 * np.sqrt(2 / 870), 2e5
STATIC = {
    "law": "tustin",
    "coulomb": "300 N",
    "stiction": "300 N",
    "stribeck_velocity": "30 mm/s",
    "viscous": "2000 N s/m",
}
U_T, U_L1, U_L2 = 0.9, 0.5, -1.2


def steady(p_s):
    """Velocity and pressures Tp, Tr, Lp, Lr at constant commands: 2.13, 2.14, 2.17, 2.18, 2.10."""

    def lacks(y):
        v, p_tp, p_tr, p_lp, p_lr = y * np.array([0.1, 1e7, 1e7, 1e7, 1e7])
        force = (p_tp - p_lp) * A_P - (p_tr - p_lr) * A_R - 2 * (300 + 2000 * v)
        return [
            (GAIN * U_T) ** 2 * (p_s - p_tp) / (A_P * 0.1) ** 2 - (v / 0.1) ** 2,
            (GAIN * U_T) ** 2 * (p_tr - P_T) / (A_R * 0.1) ** 2 - (v / 0.1) ** 2,
            (GAIN * U_L2) ** 2 * (p_lp - P_T) / (A_P * 0.1) ** 2 - (v / 0.1) ** 2,
            (GAIN * U_L1) ** 2 * (p_s - p_lr) / (A_R * 0.1) ** 2 - (v / 0.1) ** 2,
            force / 1e3,
        ]

    y, _, found, why = fsolve(lacks, [0.5, 0.9, 0.2, 0.2, 0.3], full_output=True)
    assert found == 1, why
    return y * np.array([0.1, 1e7, 1e7, 1e7, 1e7])


def logged(p_s, seconds=4.0):
    """A log with constant commands and supply that begins near the steady motion."""
    n = round(seconds / 0.01)
    v, p_tp, p_tr, p_lp, p_lr = steady(p_s)
    t = (np.arange(n) + 0.5) * 0.01
    return Run(
        plan=RunPlan("0001", "steady", 1, v, Specimen(A_P, A_R)),
        t_s=t,
        x_m=0.05 + v * t,
        v_m_s=np.full(n, 0.9 * v),
        p_tp_pa=np.full(n, 0.9 * p_tp),
        p_tr_pa=np.full(n, p_tr),
        p_lp_pa=np.full(n, p_lp),
        p_lr_pa=np.full(n, p_lr),
        p_s_pa=np.full(n, p_s),
        f_applied_n=np.full(n, p_lp * A_P - p_lr * A_R + 300 + 2000 * v),
        u_t_v=np.full(n, U_T),
        u_l1_v=np.full(n, U_L1),
        u_l2_v=np.full(n, U_L2),
    )


@pytest.fixture(scope="module")
def known(bench, bench_data):
    return balance_model(
        bench, parse_plant(bench_data, {"friction": {"test": STATIC, "load": STATIC}}, "")
    )


@pytest.mark.parametrize("p_s", [150e5, 110e5])
def test_under_constant_commands_it_settles_at_the_steady_motion_of_the_measured_supply(known, p_s):
    run = logged(p_s)
    found = open_loop(run, known)
    v, *pressures = steady(p_s)
    assert found.v_m_s[-20:].mean() == pytest.approx(v, rel=2e-3)
    assert np.diff(found.x_m)[-20:].mean() / 0.01 == pytest.approx(v, rel=2e-3)
    for name, pressure in zip(("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa"), pressures, strict=True):
        assert getattr(found, name)[-20:].mean() == pytest.approx(pressure, abs=3e-3 * p_s)
    f_load = pressures[2] * A_P - pressures[3] * A_R
    assert found.f_applied_n[-20:].mean() == pytest.approx(f_load + 300 + 2000 * v, rel=2e-2)


def test_signals_are_means_and_friction_is_what_force_leaves(known):
    run = logged(150e5)
    found = signals(run, known)
    column = dict(zip(SIGNALS, found.values.T, strict=True))
    v, p_tp, p_tr, p_lp, p_lr = steady(150e5)
    friction = 0.9 * p_tp * A_P - p_tr * A_R - (p_lp * A_P - p_lr * A_R + 300 + 2000 * v)
    assert column["friction"] == pytest.approx(friction)
    assert column["u_l2"] == pytest.approx(U_L2)
    assert np.diff(column["x"]) == pytest.approx(0.08 * v)


def test_without_commands_nothing_can_be_followed(known):
    run = replace(logged(150e5), u_l1_v=None)
    assert np.isnan(open_loop_errors(run, known).values).all()
    found = signals(run, known)
    seen = dict(zip(SIGNALS, np.isfinite(found.values).all(axis=0).tolist(), strict=True))
    assert seen == dict.fromkeys(SIGNALS, True) | {"u_l1": False}
    assert set(OPEN_LOOP_SIGNALS) < set(SIGNALS)
