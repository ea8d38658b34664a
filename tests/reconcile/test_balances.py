"""Balances of a motion that is made up: signals are closed forms, commands are what they need.

Nothing of the plant's code makes these logs. What a balance lacks is put in, and must come out.
"""

from dataclasses import replace

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.errors import DataError
from hbench.reconcile.measured.balances import (
    BALANCE_UNITS,
    BALANCES,
    balance_model,
    residuals,
)
from hbench.records import Run, RunPlan, Specimen

FINE_S, RECORD = 1e-5, 1000
A_P, A_R = np.pi / 4 * 0.04**2, np.pi / 4 * (0.04**2 - 0.025**2)
BETA, GAIN, OMEGA = 7e7, 7.43e-7 * np.sqrt(2 / 870), 2 * np.pi * 90
P_S, P_T, MASS, LAG = 150e5, 2e5, 5.0, 2.05e-3
NAMES = ("tp", "tr", "lp", "lr")
COULOMB, VISCOUS = 300.0, 2000.0
LEAK = (2e-7, -3e-7, 1e-7, 4e-7)  # into each chamber, m^3/s

STATIC = {
    "law": "tustin",
    "coulomb": f"{COULOMB} N",
    "stiction": f"{COULOMB} N",
    "stribeck_velocity": "30 mm/s",
    "viscous": f"{VISCOUS} N s/m",
}


@pytest.fixture(scope="module")
def known(bench, bench_data):
    return balance_model(
        bench, parse_plant(bench_data, {"friction": {"test": STATIC, "load": STATIC}}, "")
    )


def logged(y):
    return y.reshape(-1, RECORD).mean(axis=1)


def slope(y):
    return np.gradient(y, FINE_S, edge_order=2)


def command(volume, pressure, swelling, leak, side):
    """Volts that give a chamber the flow its continuity needs, less the leak."""
    flow = volume / BETA * slope(pressure) + swelling - leak
    drop = np.where(flow >= 0, P_S - pressure, pressure - P_T)
    spool = side * flow / (GAIN * np.sqrt(drop))
    return spool + 2 / OMEGA * slope(spool) + slope(slope(spool)) / OMEGA**2


def made_up(chamber=0, leak=0.0, drag_test=0.0, drag_load=0.0, lag=LAG, sag=0.0):
    """A run of 1.6 s at 60 to 100 mm/s; one of the test cylinder's chambers rules its valve.

    Also returns the force [N] that the load side's balance lacks, which nothing closes here.
    """
    t = np.arange(0, 1.6, FINE_S)
    w, b = 2 * np.pi * 0.8, 0.02 / (2 * np.pi * 0.8)
    x = 0.1 + 0.08 * t + b * np.sin(w * t)
    v, a = 0.08 + b * w * np.cos(w * t), -b * w**2 * np.sin(w * t)
    p = [
        70e5 + 3e5 * np.sin(7 * t),
        30e5 + 2e5 * np.cos(5 * t),
        60e5 + 3e5 * np.cos(6 * t),
        20e5 + 2e5 * np.sin(4 * t),
    ]
    volumes = (
        251.2e-6 + A_P * x,
        251.2e-6 + A_R * (0.4 - x),
        199.3e-6 + A_P * (0.4 - 0.02 - x),
        112.7e-6 + A_R * (x + 0.02),
    )
    swelling = (A_P * v, -A_R * v, -A_P * v, A_R * v)
    sides = (1, -1, 1, 1)
    u = [
        command(volumes[i], p[i], swelling[i], leak if i == chamber else 0.0, sides[i])
        for i in range(4)
    ]
    friction = COULOMB + VISCOUS * v
    f_applied = p[0] * A_P - p[1] * A_R - friction - drag_test - MASS * a
    board = v - lag * a - lag**2 * b * w**3 * np.cos(w * t)  # v + lag v' = x' to third order
    run = Run(
        plan=RunPlan("0001", "steady", 1, 0.08, Specimen(A_P, A_R)),
        t_s=(np.arange(len(t) // RECORD) + 0.5) * 0.01,
        x_m=logged(x),
        v_m_s=logged(board),
        **{f"p_{name}_pa": logged(own) for name, own in zip(NAMES, p, strict=True)},
        p_s_pa=P_S - sag + 0.5 * (-1.0) ** np.arange(len(t) // RECORD),  # no constant: measured
        f_applied_n=logged(f_applied),
        u_t_v=logged(u[1] if chamber == 1 else u[0]),
        u_l1_v=logged(u[3]),
        u_l2_v=logged(u[2]),
    )
    f_load = p[2] * A_P - p[3] * A_R
    return run, logged(f_applied - f_load - friction - drag_load - MASS * a)


def of(run, known, name):
    found = residuals(run, known)
    return found.values[3:-1, BALANCES.index(name)]  # a valve's start and 20 mm are left out


@pytest.mark.parametrize("chamber", range(4))
def test_a_leak_into_a_chamber_is_what_its_continuity_lacks(known, chamber):
    """Within 0.05 % of the flow of 1e-4 m^3/s, with a leak and without."""
    name = BALANCES[chamber]
    for leak in (0.0, LEAK[chamber]):
        run, _ = made_up(chamber, leak)
        assert np.abs(of(run, known, name) - leak).max() < 5e-8


def test_a_drag_on_the_test_side_is_what_its_force_balance_lacks(known):
    run, _ = made_up(drag_test=25.0)
    assert np.abs(of(run, known, "force_test") - 25.0).max() < 0.2


def test_a_drag_on_the_load_side_is_what_its_force_balance_lacks(known):
    run, elsewhere = made_up(drag_load=-40.0)
    balanced = replace(run, f_applied_n=run.f_applied_n - elsewhere)
    assert np.abs(of(balanced, known, "force_load") + 40.0).max() < 0.2


def test_kinematics_lack_the_lag_that_the_model_does_not_know(known):
    run, _ = made_up()
    assert np.abs(of(run, known, "kinematics")).max() < 1e-6
    slower, _ = made_up(lag=LAG + 3e-3)
    found = residuals(slower, known)
    a = slope(np.interp(np.arange(0, 1.6, FINE_S), slower.t_s, slower.v_m_s))
    expected = 3e-3 * np.interp(found.t_s, np.arange(0, 1.6, FINE_S), a)
    off = found.values[:, BALANCES.index("kinematics")] - expected
    assert np.abs(off[1:-1]).max() < 0.05 * np.abs(expected).max()


def test_a_sagging_supply_is_below_the_models(known):
    run, _ = made_up(sag=3e5)
    assert of(run, known, "supply") == pytest.approx(-3e5)


def test_a_missing_channel_leaves_out_what_needs_it(known):
    run, _ = made_up()
    found = residuals(replace(run, p_lp_pa=None), known)
    seen = dict(zip(BALANCES, np.isfinite(found.values).any(axis=0).tolist(), strict=True))
    assert seen == dict.fromkeys(BALANCE_UNITS, False) | dict.fromkeys(
        ("flow_tp", "flow_tr", "force_test", "kinematics", "supply"), True
    )
    assert np.isnan(found.load_n).all()


def test_a_supply_pressure_that_is_a_known_constant_is_not_compared(known):
    run, _ = made_up()
    found = residuals(replace(run, p_s_pa=np.full(len(run.t_s), P_S)), known)
    seen = dict(zip(BALANCES, np.isfinite(found.values).any(axis=0).tolist(), strict=True))
    assert seen == dict.fromkeys(BALANCES, True) | {"supply": False}


@pytest.mark.parametrize(("name", "flow"), [("p_tp_pa", "flow_tp"), ("p_tr_pa", "flow_tr")])
def test_a_chamber_open_to_the_air_is_fed_by_no_valve(known, name, flow):
    """The map states 0 bar. What a valve of the model would draw for it is not drawn."""
    run, _ = made_up()
    found = residuals(replace(run, **{name: np.zeros(len(run.t_s))}), known)
    seen = dict(zip(BALANCES, np.isfinite(found.values).any(axis=0).tolist(), strict=True))
    assert seen == dict.fromkeys(BALANCES, True) | {flow: False, "supply": False}


def test_uneven_samples_are_refused(known):
    run, _ = made_up()
    t = run.t_s.copy()
    t[50:] += 0.02
    with pytest.raises(DataError, match=r"run 0001: .*0\.01 to 0\.03 s"):
        residuals(replace(run, t_s=t), known)


@pytest.mark.parametrize(
    ("effects", "channel", "reading"),
    [
        ({"pressure_gain": {"p_tp": "2 %"}}, "p_tp_pa", lambda p: 1.02 * p),
        ({"pressure_offset": {"p_lr": "-0.8 bar"}}, "p_lr_pa", lambda p: p - 0.8e5),
        ({"pressure_gain": {"p_s": "-1 %"}}, "p_s_pa", lambda p: 0.99 * p),
        ({"load_cell_gain": {"error": "3 %"}}, "f_applied_n", lambda f: 1.03 * f),
        ({"load_cell_offset": {"force": "-20 N"}}, "f_applied_n", lambda f: f - 20.0),
    ],
)
def test_readings_are_corrected_for_the_errors_of_their_sensors(
    known, bench, bench_data, effects, channel, reading
):
    """With the effect in the model all balances are those of the true values."""
    right = balance_model(
        bench,
        parse_plant(
            bench_data, {"friction": {"test": STATIC, "load": STATIC}, "effects": effects}, ""
        ),
    )
    run, _ = made_up()
    wrong = replace(run, **{channel: reading(getattr(run, channel))})
    true, corrected, raw = (
        residuals(*pair).values for pair in ((run, known), (wrong, right), (wrong, known))
    )
    scale = np.array([*[1e-4] * 4, 1e3, 1e3, 0.1, 150e5])
    assert np.abs((corrected - true) / scale).max() < 1e-9
    assert np.abs((raw - true) / scale).max() > 1e-3


def test_logs_that_are_rounded_have_the_resolution_of_their_words(known):
    run, _ = made_up()
    resolution = dict(zip(BALANCES, residuals(run, known).resolution, strict=True))
    assert set(known.word_steps) >= {"p_s", "f_applied", "x"}
    assert resolution["flow_tp"] == 0.0
