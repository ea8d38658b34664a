"""Flows of the modelled valves and pump at a log's commands and pressures.

The spool (2.16) follows the limited logged command by the exact solution of its equation over a
step. Each record has ten steps, in which all signals are parabolas with the record's mean, so that
means of products such as u sqrt(dP) are correct.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from hbench.analysis.identification.driven_law import within
from hbench.model.compiled import compiled
from hbench.model.cylinders import extending_volumes, retracting_volumes
from hbench.model.parameters import PlantParameters, SupplyParameters, ValveParameters
from hbench.model.valves import clamp, port_flow

_STEPS = 10  # of a record
_SPOOLS = (0, 0, 2, 1)  # the valve of Tp, Tr, Lp, Lr: test, test, load 2, load 1
_SIDES = (1.0, -1.0, 1.0, 1.0)  # the test valve's other port opens the other way


class RecordFlows(NamedTuple):
    """Mean flows over each record, for the chambers Tp, Tr, Lp, Lr."""

    per_volume: np.ndarray  # (4, n) Q / V [1/s]
    log_volume: np.ndarray  # (4, n) ln(V / 1 m^3)
    drawn: np.ndarray  # (n,) flow from the supply line [m^3/s]


def chamber_flows(
    x_m: np.ndarray,
    pressures_pa: np.ndarray,
    p_supply_pa: np.ndarray,
    commands_v: np.ndarray,
    dt_s: float,
    par: PlantParameters,
) -> RecordFlows:
    """Return the valves' flows over a log of n records.

    ``pressures_pa`` (4, n) are the chambers' pressures, ``commands_v`` (3, n) the commands of the
    valves T, L1, L2. The spools start at rest at their first command.
    """
    n = len(x_m)
    signals = np.ascontiguousarray(np.vstack([x_m, pressures_pa, p_supply_pa, commands_v]))
    out = np.zeros((9, n))
    spools = np.zeros((3, 2))
    spools[:, 0] = np.clip(commands_v[:, 0], -par.valve.limit_v, par.valve.limit_v)
    _integrate(signals, _spool_step(par.valve, dt_s / _STEPS), par, spools, np.zeros(9), out)
    return RecordFlows(out[:4], out[4:8], out[8])


@cache
def _spool_step(valve: ValveParameters, h: float) -> np.ndarray:
    """Return the transition matrix (2, 2) of the spool over ``h`` [s] at a constant command.

    Its states are the position less the command, and the rate.
    """
    from scipy.linalg import expm

    omega = valve.natural_frequency_rad_s
    return expm(h * np.array([[0.0, 1.0], [-(omega**2), -2 * valve.damping * omega]]))


@compiled
def _integrate(
    signals: np.ndarray,
    a: np.ndarray,
    par: "PlantParameters",
    spools: np.ndarray,
    now: np.ndarray,
    out: np.ndarray,
) -> None:
    last, p_t = signals.shape[1] - 1, par.supply.tank_pa
    for k in range(signals.shape[1]):
        before, after = max(k - 1, 0), min(k + 1, last)
        for i in range(_STEPS):
            s = (i + 0.5) / _STEPS
            for j in range(9):
                now[j] = within(signals[j, before], signals[j, k], signals[j, after], s)
            for j in range(3):
                command = clamp(now[6 + j], par.valve.limit_v)
                off, rate = spools[j, 0] - command, spools[j, 1]
                spools[j, 0] = command + a[0, 0] * off + a[0, 1] * rate
                spools[j, 1] = a[1, 0] * off + a[1, 1] * rate
                now[6 + j] = 0.5 * (off + command + spools[j, 0])
            v_tp, v_tr = extending_volumes(now[0], par.test)
            v_lp, v_lr = retracting_volumes(now[0], par.load)
            volumes = (v_tp, v_tr, v_lp, v_lr)
            for j in range(4):
                spool = _SIDES[j] * now[6 + _SPOOLS[j]]
                flow = port_flow(spool, now[1 + j], now[5], p_t, par.valve)
                out[j, k] += flow / volumes[j] / _STEPS
                out[4 + j, k] += np.log(volumes[j]) / _STEPS
                if spool > 0.0:
                    out[8, k] += flow / _STEPS


def pump_flow(p_supply_pa: np.ndarray, dt_s: float, source: SupplyParameters) -> np.ndarray:
    """Return the flow [m^3/s] (n,) of a pump with compensator and swash at these pressures.

    Both lags have their exact solution for an input that is constant over each record, and start
    at steady state.
    """
    demanded = source.flow_m3_s * (source.cut_off_pa - p_supply_pa) / source.band_pa
    flow = np.clip(demanded, 0.0, source.flow_m3_s)
    for lag in (source.compensator_lag_s, source.swash_lag_s):
        flow = _lagged(flow, dt_s, lag)
    return flow


def _lagged(y: np.ndarray, dt_s: float, lag_s: float) -> np.ndarray:
    """Return the records' means of y after a first-order lag; y is constant over each record.

    The lag starts at steady state.
    """
    out, state, decay = np.empty_like(y), y[0], np.exp(-dt_s / lag_s)
    for k, value in enumerate(y):
        out[k] = value + (state - value) * (1 - decay) * lag_s / dt_s
        state = value + (state - value) * decay
    return out
