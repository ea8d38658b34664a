"""Two cylinders against each other, simulated with equations that hbench does not use.

What differs from ``hbench.model``, beside every size: flow coefficients that fall at small pressure
drops (1 - exp(-sqrt(dP / 0.7 bar))), a bulk modulus that falls at low pressure, Stribeck friction
with 1 / (1 + (v / v_s)^2), Dahl's bristles with an exponent of 1.5, ripple of friction along both
bores, cavitation, a supply with droop and a pump's ripple, unequal valves with unequal edges and
nulls of their own, a position controller with feedforward, transducers with offset, drift and 14
bits, a logger of 250 Hz behind filters of 100 Hz. Steps of 20 us, semi-implicit Euler.

The supply's droop of 0.06 bar min/l, with a lag of 30 ms, is in every campaign, not in ``MODEL``.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

BAR = 1e5
DT_S, CONTROL_TICKS, LOG_TICKS = 2e-5, 20, 200
REST_S = 0.5  # before the motion, of which the first 0.3 s are not logged
SKIPPED_S = 0.3
TANK_PA, SUPPLY_PA = 1.5 * BAR, 120 * BAR
STROKE_M = 0.5
MASS_TEST_KG, MASS_LOAD_KG = 19.0, 23.0
DROOP_PA_S_M3 = 0.6 * BAR / (10e-3 / 60)
DROOP_LAG_S = 0.03


def _area(diameter_m: float) -> float:
    return math.pi * diameter_m**2 / 4


A_TP, A_LP = _area(0.063), _area(0.08)
A_TR, A_LR = A_TP - _area(0.045), A_LP - _area(0.05)


class Bench(NamedTuple):
    """What differs from one bench to the next, in SI; valves are T, L1 (rod) and L2 (piston)."""

    gains: tuple[float, float, float]  # m^3 / (s V sqrt(Pa))
    nulls_v: tuple[float, float, float]
    edges: tuple[float, float]  # more gain of the negative side of L1 and L2
    volumes_m3: tuple[float, float, float, float]  # dead, of Tp, Tr, Lp, Lr
    spool_rad_s: float
    bulk_modulus_pa: float


class Effects(NamedTuple):
    """Hidden effects; 0 is none."""

    leak: float = 0.0  # m^3/s at 50 bar across the test piston, with dP^0.85
    rod_leak: float = 0.0  # m^3/s at 50 bar out of the test rod chamber, with P^0.9
    seal_n: float = 0.0  # of the test piston at 50 bar across it, with dP^0.8
    overlap_v: float = 0.0  # of all spools
    uneven: float = 0.0  # more gain of the test valve's positive side
    lag_s: float = 0.0  # of all openings
    tank: float = 0.0  # Pa / (m^3/s)^1.6 in the return line
    cell_gain: float = 0.0
    offset_pa: float = 0.0  # of the transducer of the test piston chamber
    pressure_gain: float = 0.0  # of the same transducer
    stick_v: float = 0.0  # that dry friction of all spools takes from their drive


@njit
def _port(u, upstream, downstream, gain):
    drop = upstream - downstream
    size = math.sqrt(abs(drop)) * (1.0 - math.exp(-math.sqrt(abs(drop) / 0.7e5) - 0.02))
    return gain * abs(u) * math.copysign(size, drop)


@njit
def _chamber_flow(u, p, p_s, p_t, gain):
    return _port(u, p_s, p, gain) if u >= 0.0 else -_port(u, p, p_t, gain)


@njit
def _opening(u, overlap, gain, null):
    u = gain * u + null
    if overlap > 0.0:  # about the spool's middle
        beyond = 0.5 * (abs(u) - overlap + math.sqrt((abs(u) - overlap) ** 2 + 0.05**2))
        u = math.copysign(beyond, u)
    return u


@njit
def _friction(v, z, sliding, static, v_s, viscous, z_max):
    """Return the force, and the rate of the bristles."""
    level = sliding + (static - sliding) / (1.0 + (v / v_s) ** 2)
    return level * z / z_max + viscous * v, v - abs(v) * z / z_max * math.sqrt(abs(z) / z_max)


@njit
def _stiffness(p, bulk_modulus):
    return bulk_modulus * (1.0 - 0.05 * math.exp(-p / 15e5))


@njit
def stroke(bench, effects, start_m, end_m, speed, p_lp_ref, p_lr_ref, levels, duration_s):
    """Move from start to end; return the log (n, 12): t, x, v, 4 pressures, P_s, F, 3 commands."""
    k_t, k_1, k_2 = bench.gains
    null_t, null_1, null_2 = bench.nulls_v
    v_tp, v_tr, v_lp, v_lr = bench.volumes_m3
    omega, beta = bench.spool_rad_s, bench.bulk_modulus_pa
    x, v, z_t, z_l = start_m, 0.0, 0.0, 0.0
    p_tp, p_tr, p_lp, p_lr, p_s = 30 * BAR, 40 * BAR, p_lp_ref, p_lr_ref, SUPPLY_PA
    spool, rate, u, opening = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    error_x, error_lp, error_lr = 0.0, 0.0, 0.0
    sign = 1.0 if end_m > start_m else -1.0
    x_ref, v_ref, v_logged = start_m, 0.0, 0.0
    shown = np.array([p_tp, p_tr, p_lp, p_lr, p_s, 0.0])
    out = np.zeros((int((duration_s - SKIPPED_S) / (DT_S * LOG_TICKS)), 12))
    row = 0
    for tick in range(int(duration_s / DT_S)):
        t = tick * DT_S
        if tick % CONTROL_TICKS == 0:
            h = DT_S * CONTROL_TICKS
            if t > REST_S:
                braking = math.sqrt(0.6 * max(abs(end_m - x_ref) - 0.5e-3, 0.0))
                v_ref += max(min(min(speed, braking) - v_ref, 0.3 * h), -0.3 * h)
                x_ref += sign * v_ref * h
            error_x += (x_ref - x) * h
            error_lp += (p_lp_ref - p_lp) / BAR * h
            error_lr += (p_lr_ref - p_lr) / BAR * h
            u[0] = 120.0 * (x_ref - x) + 150.0 * error_x + 22.0 * sign * v_ref
            u[1] = 0.06 * (p_lr_ref - p_lr) / BAR + error_lr
            u[2] = 0.06 * (p_lp_ref - p_lp) / BAR + error_lp
            for i in range(3):
                u[i] = min(max(u[i], -10.0), 10.0)
        for i in range(3):
            drive = u[i] - spool[i]
            drive -= max(min(drive, effects.stick_v), -effects.stick_v)
            rate[i] += DT_S * (omega * omega * drive - 1.4 * omega * rate[i])
            spool[i] += DT_S * rate[i]
            if effects.lag_s > 0.0:
                opening[i] += DT_S * (spool[i] - opening[i]) / effects.lag_s
            else:
                opening[i] = spool[i]
        uneven = 1.0 + (effects.uneven if opening[0] > 0.0 else 0.0)
        o_t = _opening(opening[0], effects.overlap_v, uneven, null_t)
        edge_1 = 1.0 if opening[1] > 0.0 else 1.0 + bench.edges[0]
        edge_2 = 1.0 if opening[2] > 0.0 else 1.0 + bench.edges[1]
        o_1 = _opening(opening[1], effects.overlap_v, edge_1, null_1)
        o_2 = _opening(opening[2], effects.overlap_v, edge_2, null_2)

        p_t, drawn = TANK_PA, 0.0
        q_tp, q_tr, q_lp, q_lr = 0.0, 0.0, 0.0, 0.0
        for _ in range(2):  # the return line's pressure depends on the flows
            q_tp = _chamber_flow(o_t, p_tp, p_s, p_t, k_t)
            q_tr = _chamber_flow(-o_t, p_tr, p_s, p_t, k_t)
            q_lr = _chamber_flow(o_1, p_lr, p_s, p_t, k_1)
            q_lp = _chamber_flow(o_2, p_lp, p_s, p_t, k_2)
            drawn = (q_tp if o_t >= 0.0 else q_tr) + (q_lr if o_1 >= 0.0 else 0.0)
            drawn += q_lp if o_2 >= 0.0 else 0.0
            returned = drawn - (q_tp + q_tr + q_lp + q_lr)
            p_t = TANK_PA + effects.tank * max(returned, 0.0) ** 1.6
        across = p_tp - p_tr
        leak = effects.leak * math.copysign((abs(across) / 50e5) ** 0.85, across)
        outside = effects.rod_leak * (max(p_tr, 0.0) / 50e5) ** 0.9

        ripple_t = levels[0] * (1.0 + 0.015 * math.sin(2 * math.pi * x / 0.31 + 1.0))
        ripple_l = levels[1] * (1.0 + 0.012 * math.sin(2 * math.pi * x / 0.19))
        seal = effects.seal_n * (abs(across) / 50e5) ** 0.8
        f_ft, z_rate_t = _friction(
            v, z_t, 150.0 * ripple_t + seal, 340.0 * ripple_t + seal, 0.035, 3200.0, 4e-4
        )
        f_fl, z_rate_l = _friction(v, z_l, 220.0 * ripple_l, 330.0 * ripple_l, 0.05, 2600.0, 5e-4)
        f_t, f_l = A_TP * p_tp - A_TR * p_tr, A_LP * p_lp - A_LR * p_lr
        a = (f_t - f_l - f_ft - f_fl) / (MASS_TEST_KG + MASS_LOAD_KG)
        force = f_l + f_fl + MASS_LOAD_KG * a
        v += DT_S * a
        x += DT_S * v
        z_t += DT_S * z_rate_t
        z_l += DT_S * z_rate_l
        out_of_tp = q_tp - leak - A_TP * v
        p_tp += DT_S * _stiffness(p_tp, beta) / (v_tp + A_TP * x) * out_of_tp
        into_tr = q_tr + leak - outside + A_TR * v
        p_tr += DT_S * _stiffness(p_tr, beta) / (v_tr + A_TR * (STROKE_M - x)) * into_tr
        into_lp = q_lp + A_LP * v
        p_lp += DT_S * _stiffness(p_lp, beta) / (v_lp + A_LP * (STROKE_M - x)) * into_lp
        into_lr = q_lr - A_LR * v
        p_lr += DT_S * _stiffness(p_lr, beta) / (v_lr + A_LR * x) * into_lr
        p_tp, p_tr, p_lp, p_lr = (
            max(p_tp, -0.9e5), max(p_tr, -0.9e5), max(p_lp, -0.9e5), max(p_lr, -0.9e5)
        )  # fmt: skip
        p_s += DT_S * (SUPPLY_PA - DROOP_PA_S_M3 * drawn - p_s) / DROOP_LAG_S
        p_s += DT_S * 0.4e5 * 18 * math.pi * math.cos(18 * math.pi * t)  # the pump's ripple

        truth = (p_tp, p_tr, p_lp, p_lr, p_s, force)
        for i in range(6):
            shown[i] += DT_S * 2 * math.pi * 100.0 * (truth[i] - shown[i])
        v_logged += DT_S * (v - v_logged) / 0.003
        if tick % LOG_TICKS == 0 and t >= SKIPPED_S and row < len(out):
            out[row, 0], out[row, 1], out[row, 2] = t - SKIPPED_S, x, v_logged
            for i in range(6):
                out[row, 3 + i] = shown[i]
            for i in range(3):
                out[row, 9 + i] = u[i]
            row += 1
    return out[:row]
