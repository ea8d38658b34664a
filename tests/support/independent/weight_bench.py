"""A single cylinder that lifts and lowers weights, simulated with equations of its own.

What differs from ``hbench.model``, beside every size: edges of the valve that are not equal, whose
flow coefficients fall at small pressure drops, friction with 1 / (1 + (v / v_s)^1.5), a power of
the speed and Dahl's bristles, whose level wanders from run to run and has a ripple along the bore,
compressibility with free air after a power of the pressure, transducers with offset, gain and
drift within their class, a position controller with feedforward, and a logger of 200 Hz. The load
cell is between rod and weight. Runs are made in random order. Steps of 20 us, semi-implicit Euler.
"""

import math
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from numba import njit

BAR = 1e5
DT_S, CONTROL_TICKS, LOG_TICKS = 2e-5, 50, 250
SUPPLY_PA, TANK_PA, STROKE_M = 160 * BAR, 3 * BAR, 0.5
A_P = math.pi * 0.063**2 / 4
A_R = A_P - math.pi * 0.036**2 / 4
DEAD_P_M3, DEAD_R_M3 = 2.6e-4, 1.9e-4
BULK_PA, FLOW_GAIN, SPOOL_RAD_S, NULL_V = 1.15e9, 1.8e-8, 2 * math.pi * 75, 0.02
EDGES = (1.0, 0.975, 1.03, 0.99)  # P to A, A to T, P to B, B to T
TEST_KG, G = 14.0, 9.81
BRISTLES_N_M, VISCOUS = 2.5e6, 2600.0
REST_S, RAMP_S, TURN_M, STEP_S = 0.6, 0.15, 0.03, 0.6
STEPS = (0.3, 1.0, 0.0, -0.4, -1.1, 0.0)  # of the nominal speed
STROKES, TRIANGLES, STEPPED = 0, 1, 2
WEIGHTS_N, SPEEDS_MM_S, TRIALS = (600, 2000, 3500, 5000), (15, 40, 100), 2
_ATMOSPHERE_PA = 1.013e5

MODEL: dict[str, Any] = {
    "test_cylinder": {
        "piston_diameter": "63 mm",
        "rod_diameter": "36 mm",
        "stroke": "500 mm",
        "dead_volume_piston": "230 cm^3",
        "dead_volume_rod": "230 cm^3",
    },
    "moving_mass": {"test": "12 kg"},
    "oil": {"bulk_modulus": "9000 bar", "density": "870 kg/m^3"},
    "supply": {"pressure": "160 bar", "tank": "2 bar"},
    "valve": {"gain": "4e-7 m^2/V", "bandwidth": "75 Hz", "damping": 0.75, "limit": "10 V"},
    "friction": {
        "test": {
            "law": "lugre",
            "coulomb": "230 N",
            "stiction": "400 N",
            "stribeck_velocity": "20 mm/s",
            "stribeck_exponent": 1,
            "viscous": "2200 N s/m",
            "bristle_stiffness": "2e6 N/m",
            "bristle_damping": "0 N s/m",
        }
    },
    "end_stop": {"stiffness": "2e7 N/m", "damping": "2e4 N s/m"},
}
_CYLINDER = {"piston_diameter": "63 mm", "rod_diameter": "36 mm", "stroke": "500 mm"}
MAP = {
    "name": "weight bench",
    "kind": "triangle",
    "columns": {
        "t_s": {"column": "t", "unit": "s"},
        "x_m": {"column": "x", "unit": "mm"},
        "p_tp_pa": {"column": "pA", "unit": "bar"},
        "p_tr_pa": {"column": "pB", "unit": "bar"},
        "p_s_pa": {"column": "pP", "unit": "bar"},
        "f_applied_n": {"column": "F", "unit": "kN"},
        "u_t_v": {"column": "Y", "unit": "V", "scale": 0.1},  # percent of 10 V
    },
    "series": [
        {"label": "strokes", "kind": "steady", "cut": "reversals"},
        {"label": "triangles"},
        {"label": "steps"},
    ],
    "instruments": {
        "force": {"tolerance": "0.1 %", "of": "full_scale", "full_scale": "10 kN"},
        "pressure": {"tolerance": "0.1 %", "of": "full_scale", "full_scale": "250 bar"},
    },
}
for _series in MAP["series"]:
    _series |= {"files": _series["label"] + "_{load}N_{speed}_{trial}.csv", "cylinder": _CYLINDER}


class Effects(NamedTuple):
    """What the model does not contain; 0 is without it."""

    leak: float = 0.0  # l/min/bar across the piston
    rod_leak: float = 0.0  # l/min/bar out of the rod side
    cap_leak: float = 0.0  # l/min/bar out of the piston side
    lag_s: float = 0.0  # of the spool, beside its bandwidth
    play_v: float = 0.0
    overlap_v: float = 0.0
    uneven: float = 0.0  # the valve opens further by this share for positive commands
    tank: float = 0.0  # bar min/l in the return line
    droop: float = 0.0  # bar min/l of the supply
    seal: float = 0.0  # N/bar with the pressures of both sides
    guide: float = 0.0  # share of the pressure force
    film_s: float = 0.0  # dry friction follows the speed with this lag
    bore: float = 0.0  # share of dry friction, with a period of 0.4 m
    mass_kg: float = 0.0
    warming: float = 0.0  # share of viscous friction lost over the campaign
    cell_gain: float = 0.0
    cell_offset_n: float = 0.0
    offset_bar: float = 0.0  # of the piston side's transducer
    gain: float = 0.0  # of the rod side's transducer


NONE = Effects()


@njit
def _flow(opening, drop):
    root = math.sqrt(abs(drop)) * (1.0 - math.exp(-abs(drop) / 2e5))
    return FLOW_GAIN * opening * math.copysign(root, drop)


@njit
def _reference(kind, v_m_s, travel_m, t):
    """Return the speed at a time after the first rest."""
    if t < 0.0:
        return 0.0
    if kind == STROKES:
        move_s = travel_m / v_m_s + RAMP_S
        way = 1.0
        if t > move_s:
            t, way = t - move_s - 0.8, -1.0
        return way * v_m_s * max(min(t / RAMP_S, (move_s - t) / RAMP_S, 1.0), 0.0)
    if kind == TRIANGLES:
        turn = int(t / (TURN_M / v_m_s))
        return 0.0 if turn >= 6 else v_m_s * (1.0 if turn % 2 == 0 else -1.0)
    step = int(t / STEP_S)
    return v_m_s * STEPS[step] if step < len(STEPS) else 0.0


@njit
def _compliance(pressure):
    """Return 1 / K of oil with a little free air."""
    air = (_ATMOSPHERE_PA / (max(pressure, 0.0) + _ATMOSPHERE_PA)) ** 1.7
    return 1.0 / BULK_PA + 2e-4 / _ATMOSPHERE_PA * air


@njit
def _run(kind, weight_n, v_m_s, level, part, e):
    """Return the log (n, 7): t, x, p_A, p_B, p_P, F, u; ``part`` of the campaign is over."""
    mass = weight_n / G
    start_m = 0.15 if kind else 0.08
    travel_m = 0.3
    moving_s = 2 * (travel_m / v_m_s + RAMP_S) + 0.8
    if kind == TRIANGLES:
        moving_s = 6 * TURN_M / v_m_s
    elif kind == STEPPED:
        moving_s = len(STEPS) * STEP_S
    out = np.zeros((int((moving_s + 2 * REST_S) / DT_S) // LOG_TICKS, 7))
    per_bar = 1e-3 / 60 / BAR  # l/min/bar in m^3/s/Pa
    x, v, x_ref, error, u, v_ref = start_m, 0.0, start_m, 0.0, 0.0, 0.0
    spool, rate, lagged, played, bristles, film = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    p_a, p_s = 45 * BAR, SUPPLY_PA
    p_b = (p_a * A_P - weight_n) / A_R
    for tick in range(len(out) * LOG_TICKS):
        if tick % CONTROL_TICKS == 0:
            h = DT_S * CONTROL_TICKS
            wanted = _reference(kind, v_m_s, travel_m, tick * DT_S - REST_S)
            v_ref = v_ref + (wanted - v_ref) * h / 0.03 if kind == STEPPED else wanted
            x_ref += v_ref * h
            error += (x_ref - x) * h
            area = A_P if v_ref > 0 else A_R
            u = 0.85 * v_ref * area / (FLOW_GAIN * math.sqrt(60 * BAR))
            u = min(max(u + 90 * (x_ref - x) + 120 * error, -10.0), 10.0)
        rate += DT_S * (SPOOL_RAD_S**2 * (u + NULL_V - spool) - 1.5 * SPOOL_RAD_S * rate)
        spool += DT_S * rate
        lagged = lagged + DT_S / e.lag_s * (spool - lagged) if e.lag_s else spool
        played = min(max(played, lagged - e.play_v), lagged + e.play_v)
        y = math.copysign(max(abs(played) - e.overlap_v, 0.0), played)
        if y > 0.0:
            y *= 1.0 + e.uneven
            into_a = EDGES[0] * _flow(y, p_s - p_a)
            back = EDGES[3] * _flow(y, p_b - TANK_PA)
            into_b = -EDGES[3] * _flow(y, p_b - TANK_PA - back * e.tank / per_bar)
            drawn = into_a
        else:
            into_b = EDGES[2] * _flow(-y, p_s - p_b)
            back = EDGES[1] * _flow(-y, p_a - TANK_PA)
            into_a = -EDGES[1] * _flow(-y, p_a - TANK_PA - back * e.tank / per_bar)
            drawn = into_b
        p_s += DT_S / 0.02 * (SUPPLY_PA - e.droop / per_bar * drawn - p_s)
        across = (e.leak * per_bar + 3e-15) * (p_a - p_b)
        film = film + DT_S / e.film_s * (v - film) if e.film_s else v
        dry = 180.0 + 190.0 / (1.0 + (abs(film) / 0.012) ** 1.5)
        dry += e.seal * (p_a + p_b) / BAR + e.guide * abs(p_a * A_P - p_b * A_R)
        dry *= level * (1.0 + 0.01 * math.sin(x / 0.011) + e.bore * math.sin(x / 0.0637))
        bristles += DT_S * v * (1.0 - bristles * BRISTLES_N_M / dry * math.copysign(1.0, v))
        viscous = VISCOUS * (1.0 - e.warming * part) * abs(v) ** 0.95 * 0.1**0.05
        friction = BRISTLES_N_M * bristles + math.copysign(viscous, v)
        a = (p_a * A_P - p_b * A_R - friction - weight_n) / (mass + TEST_KG + e.mass_kg)
        v += DT_S * a
        x += DT_S * v
        into_a -= across + e.cap_leak * per_bar * p_a + A_P * v
        into_b += across - e.rod_leak * per_bar * p_b + A_R * v
        p_a += DT_S * into_a / (_compliance(p_a) * (DEAD_P_M3 + A_P * x))
        p_b += DT_S * into_b / (_compliance(p_b) * (DEAD_R_M3 + A_R * (STROKE_M - x)))
        if tick % LOG_TICKS == 0:
            force = weight_n + mass * a
            out[tick // LOG_TICKS] = (tick * DT_S, x, p_a, p_b, p_s, force, u)
    return out


def write_weight_campaign(
    out: Path,
    seed: int,
    effects: Effects = NONE,
    weights_n: Sequence[int] = WEIGHTS_N,
    speeds_mm_s: Sequence[int] = SPEEDS_MM_S,
    dated: bool = False,
) -> None:
    """Write ``logs/``, ``map.yaml`` and ``model.yaml`` of a campaign with hidden effects.

    At the lightest and the heaviest weight there are also triangles and steps of the speed. The
    times of ``dated`` logs have a date; a run begins each minute.
    """
    rng = np.random.default_rng([seed, 6])
    (out / "logs").mkdir(parents=True)
    offsets = [0.0, 0.0, *(0.06 * BAR * rng.standard_normal(3)), 2.0 * rng.standard_normal(), 0.0]
    gains = 1 + np.array(
        [0.0, 0.0, *(3e-4 * rng.standard_normal(3)), 2e-4 * rng.standard_normal(), 0.0]
    )
    offsets[2] += effects.offset_bar * BAR
    offsets[5] += effects.cell_offset_n
    gains[3] += effects.gain
    gains[5] += effects.cell_gain
    drift = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0]) * 0.05 * BAR
    scatter = np.array([0.0, 3e-6, 0.03 * BAR, 0.03 * BAR, 0.03 * BAR, 3.0, 0.0])
    units = np.array([1.0, 1e3, 1 / BAR, 1 / BAR, 1 / BAR, 1e-3, 10.0])
    ends, trials = (weights_n[0], weights_n[-1]), range(1, TRIALS + 1)
    runs = [
        *product([STROKES], weights_n, speeds_mm_s, trials),
        *product([TRIANGLES], ends, (20, 50), trials),
        *product([STEPPED], ends, (60,), trials),
    ]
    wander = 0.0
    for order, i in enumerate(rng.permutation(len(runs))):
        kind, weight_n, speed, trial = runs[i]
        wander, part = 0.8 * wander + 0.01 * rng.standard_normal(), order / len(runs)
        log = _run(kind, float(weight_n), 1e-3 * speed, 1 + wander, part, effects)
        log = log * gains + np.array(offsets) + part * drift
        log = (log + scatter * rng.standard_normal(log.shape)) * units
        path = out / "logs" / f"{MAP['series'][kind]['label']}_{weight_n}N_{speed}_{trial}.csv"
        head = "t,x,pA,pB,pP,F,Y"
        if dated:
            ms = np.round(1e3 * log[:, 0]).astype(int) + order * 60_000
            rows = [",".join(f"{value:.7g}" for value in row[1:]) for row in log]
            times = np.datetime64("2026-03-01T09:00:00.000") + ms.astype("timedelta64[ms]")
            lines = [f"{time},{row}" for time, row in zip(times, rows, strict=True)]
            path.write_text("\n".join([head, *lines, ""]))
        else:
            np.savetxt(path, log, fmt="%.7g", delimiter=",", header=head, comments="")
    columns = MAP["columns"] | ({"t_s": {"column": "t", "unit": "date-time"}} if dated else {})
    (out / "map.yaml").write_text(yaml.safe_dump(MAP | {"columns": columns}))
    (out / "model.yaml").write_text(yaml.safe_dump(MODEL))
