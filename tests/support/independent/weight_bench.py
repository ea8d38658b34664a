"""A single cylinder that lifts and lowers weights, simulated with equations of its own.

Valve with square-root flow and a lag, Coulomb, Stribeck and viscous friction, no load cylinder.
The load cell is between rod and weight. Steps of 20 us, semi-implicit Euler, a log of 100 Hz.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numba import njit

BAR = 1e5
DT_S, CONTROL_TICKS, LOG_TICKS = 2e-5, 50, 500
SUPPLY_PA, TANK_PA, STROKE_M, DEAD_M3 = 140 * BAR, 2 * BAR, 0.4, 2e-4
A_P = math.pi * 0.063**2 / 4
A_R = A_P - math.pi * 0.036**2 / 4
BULK_PA, GAIN, SPOOL_RAD_S = 9e8, 7e-8, 377.0
TEST_KG, G = 12.0, 9.81
WEIGHTS_N, SPEEDS_MM_S, TRIALS = (500, 5000), (20, 50, 100), 2
_TRAVEL_M, _ACCELERATION, _REST_S = 0.25, 0.5, 0.6

MODEL: dict[str, Any] = {
    "test_cylinder": {
        "piston_diameter": "63 mm",
        "rod_diameter": "36 mm",
        "stroke": "400 mm",
        "dead_volume_piston": "200 cm^3",
        "dead_volume_rod": "200 cm^3",
    },
    "moving_mass": {"test": f"{TEST_KG} kg"},
    "oil": {"bulk_modulus": "9000 bar", "density": "870 kg/m^3"},
    "supply": {"pressure": "140 bar", "tank": "2 bar"},
    "valve": {"gain": "1.4e-6 m^2/V", "bandwidth": "60 Hz", "damping": 0.8, "limit": "10 V"},
    "friction": {
        "test": {
            "law": "lugre",
            "coulomb": "200 N",
            "stiction": "380 N",
            "stribeck_velocity": "15 mm/s",
            "stribeck_exponent": 1,
            "viscous": "2500 N s/m",
            "bristle_stiffness": "3e6 N/m",
            "bristle_damping": "0 N s/m",
        }
    },
    "end_stop": {"stiffness": "2e7 N/m", "damping": "2e4 N s/m"},
}

MAP = {
    "name": "weight bench",
    "kind": "steady",
    "columns": {
        "t_s": {"column": "t", "unit": "s"},
        "x_m": {"column": "x", "unit": "mm"},
        "p_tp_pa": {"column": "pA", "unit": "bar"},
        "p_tr_pa": {"column": "pB", "unit": "bar"},
        "p_s_pa": {"column": "pP", "unit": "bar"},
        "f_applied_n": {"column": "F", "unit": "N"},
        "u_t_v": {"column": "Y", "unit": "V", "scale": 0.1},  # percent of 10 V
    },
    "series": [
        {
            "label": "weights",
            "files": "{load}N_v{speed}_{trial}_*.csv",
            "cylinder": {"piston_diameter": "63 mm", "rod_diameter": "36 mm", "stroke": "400 mm"},
        }
    ],
    "instruments": {
        "force": {"tolerance": "0.1 %", "of": "full_scale", "full_scale": "10 kN"},
        "pressure": {"tolerance": "0.1 %", "of": "full_scale", "full_scale": "250 bar"},
    },
}


@njit
def _flow(u, p):
    drop = SUPPLY_PA - p if u >= 0.0 else p - TANK_PA
    return GAIN * u * math.copysign(math.sqrt(abs(drop)), drop)


@njit
def stroke(weight_n, start_m, v_m_s, leak, level):
    """Move by the travel at a signed speed; return the log (n, 7): t, x, p_A, p_B, p_P, F, u."""
    mass = weight_n / G
    ramp_s = abs(v_m_s) / _ACCELERATION
    move_s = _TRAVEL_M / abs(v_m_s) + ramp_s
    count = int((move_s + 2 * _REST_S) / DT_S)
    out = np.zeros((count // LOG_TICKS, 7))
    x, v, x_ref, error, u, spool, rate = start_m, 0.0, start_m, 0.0, 0.0, 0.0, 0.0
    p_a = 40 * BAR
    p_b = (p_a * A_P - weight_n) / A_R
    for tick in range(count):
        if tick % CONTROL_TICKS == 0:
            h, t = DT_S * CONTROL_TICKS, tick * DT_S - _REST_S
            v_ref = v_m_s * max(min(t / ramp_s, (move_s - t) / ramp_s, 1.0), 0.0)
            x_ref += v_ref * h
            error += (x_ref - x) * h
            area = A_P if v_m_s > 0 else A_R
            u = 0.9 * v_ref * area / (GAIN * math.sqrt(60 * BAR)) + 60 * (x_ref - x) + 60 * error
        rate += DT_S * (SPOOL_RAD_S**2 * (u - spool) - 1.6 * SPOOL_RAD_S * rate)
        spool += DT_S * rate
        dry = 200.0 + 180.0 * math.exp(-abs(v) / 0.015)
        friction = level * dry * math.tanh(v / 2e-4) + 2500.0 * v
        a = (p_a * A_P - p_b * A_R - friction - weight_n) / (mass + TEST_KG)
        v += DT_S * a
        x += DT_S * v
        across = leak * (p_a - p_b)
        into_a = _flow(spool, p_a) - across - A_P * v
        into_b = _flow(-spool, p_b) + across + A_R * v
        p_a += DT_S * BULK_PA / (DEAD_M3 + A_P * x) * into_a
        p_b += DT_S * BULK_PA / (DEAD_M3 + A_R * (STROKE_M - x)) * into_b
        if tick % LOG_TICKS == 0 and tick // LOG_TICKS < len(out):
            force = weight_n + mass * a
            out[tick // LOG_TICKS] = (tick * DT_S, x, p_a, p_b, SUPPLY_PA, force, u)
    return out


def write_weight_campaign(out: Path, leak_l_min_bar: float, seed: int) -> None:
    """Write ``logs/``, ``map.yaml`` and ``model.yaml`` of a campaign with an internal leak."""
    rng = np.random.default_rng([seed, 6])
    (out / "logs").mkdir(parents=True)
    scatter = [0.0, 2e-6, 0.02 * BAR, 0.02 * BAR, 0.02 * BAR, 2.0, 0.0]
    units = np.array([1.0, 1e3, 1 / BAR, 1 / BAR, 1 / BAR, 1.0, 10.0])
    leak = leak_l_min_bar * 1e-3 / 60 / BAR
    for weight_n in WEIGHTS_N:
        for speed in SPEEDS_MM_S:
            for trial in range(1, TRIALS + 1):
                for way, start_m, v in (("up", 0.05, speed), ("dn", 0.32, -speed)):
                    level = 1 + 0.01 * rng.standard_normal()
                    log = stroke(float(weight_n), start_m, 1e-3 * v, leak, level)
                    log = (log + scatter * rng.standard_normal(log.shape)) * units
                    name = f"{weight_n}N_v{speed}_{trial}_{way}.csv"
                    np.savetxt(
                        out / "logs" / name,
                        log,
                        fmt="%.6g",
                        delimiter=",",
                        header="t,x,pA,pB,pP,F,Y",
                        comments="",
                    )
    (out / "map.yaml").write_text(yaml.safe_dump(MAP))
    (out / "model.yaml").write_text(yaml.safe_dump(MODEL))
