"""Measured and simulated signals, as means over the windows of the balances.

Closed loop: measured runs against runs that the same firmware made with the model. Open loop: the
model under the measured valve commands and supply pressure, from the run's first record on; what is
compared is how far it goes astray, for measured and for simulated runs alike. Both sides go to
``gap.gaps``, so the unit is the trials' scatter.
"""

from dataclasses import replace

import numpy as np

from hbench.analysis.screening.calibrate import FIELDS
from hbench.model.compiled import compiled
from hbench.model.friction.laws import deflection_under
from hbench.model.parameters import PlantParameters
from hbench.model.plant import (
    P_LP,
    P_LR,
    P_S,
    P_TP,
    P_TR,
    SPOOL_L1,
    SPOOL_L2,
    SPOOL_T,
    TICK_S,
    Z_L,
    Z_T,
    V,
    X,
    n_states,
    new_work,
    step,
)
from hbench.model.sensing import sensed
from hbench.model.sensors import CHANNELS, N_CHANNELS
from hbench.reconcile.measured.balances import Model, Prepared, Windowed, windowed
from hbench.records import Run

# Signals that are logged, by their channel: fields of Run.
_FIELDS = {name: field for name, field in FIELDS.items() if name != "v_ref"}
_PRESSURES = ("p_tp", "p_tr", "p_lp", "p_lr")  # that the open loop begins with
INPUTS = ("p_s", "u_t", "u_l1", "u_l2")  # of the open loop
NEEDED = (*_PRESSURES, *INPUTS)  # for the open loop
SIGNALS = (*_FIELDS, "friction")
FOLLOWED = tuple(name for name in SIGNALS if name not in INPUTS)


def signal_field(name: str) -> str | None:
    """Return the field of ``Run`` that holds a signal; None for friction, which is not logged."""
    return _FIELDS.get(name)


def signals(log: Prepared, known: Model) -> Windowed:
    """Return the means of ``SIGNALS`` in SI; friction is 2.12 with the weak acceleration."""
    return _windowed(log, known, SIGNALS, _means(log, known, SIGNALS))


def astray(log: Prepared, known: Model) -> Windowed:
    """Return measured less open-loop means of ``FOLLOWED``; nan without commands and pressures."""
    if any(getattr(log.run, _FIELDS[name]) is None for name in NEEDED):
        return _windowed(log, known, FOLLOWED, _nan(log, FOLLOWED))
    followed = replace(log, run=open_loop(log.run, known))
    off = _means(log, known, FOLLOWED) - _means(followed, known, FOLLOWED)
    return _windowed(log, known, FOLLOWED, off)


def open_loop(run: Run, known: Model) -> Run:
    """Simulate a run's signals under its commands and supply pressure, without noise or scatter.

    Inputs are held over each record. It begins with the first record's motion and pressures, the
    spools at their commands, and bristles (LuGre's) that carry the measured forces.
    """
    par = known.par
    ticks = max(1, round(float(np.median(np.diff(run.t_s))) / TICK_S))
    inputs = np.array([getattr(run, _FIELDS[name]) for name in INPUTS])
    out = np.zeros((N_CHANNELS + 1, len(run.t_s)))
    state = _first_state(run, known)
    memory = np.concatenate([state[V : V + 1], np.zeros(3)])
    _follow(
        par, state, inputs, ticks, TICK_S / known.velocity_lag_s, memory, np.ones(2),
        np.zeros(N_CHANNELS), new_work(par), out,
    )  # fmt: skip
    found = {_FIELDS[name]: row for name, row in zip(CHANNELS, out[:-1], strict=True)}
    return replace(run, **found, v_m_s=out[-1])


def _first_state(run: Run, known: Model) -> np.ndarray:
    par, state = known.par, np.zeros(n_states(known.par))
    state[X] = run.x_m[0]
    state[V] = 0.0 if run.v_m_s is None else run.v_m_s[0]
    pressures = [getattr(run, _FIELDS[name])[0] for name in _PRESSURES]
    state[[P_TP, P_TR, P_LP, P_LR]] = pressures
    state[P_S] = run.p_s_pa[0]
    state[[SPOOL_T, SPOOL_L1, SPOOL_L2]] = run.u_t_v[0], run.u_l1_v[0], run.u_l2_v[0]
    if run.f_applied_n is not None:
        p_tp, p_tr, p_lp, p_lr = pressures
        f_test = p_tp * par.test.area_piston_m2 - p_tr * par.test.area_rod_m2
        f_load = p_lp * par.load.area_piston_m2 - p_lr * par.load.area_rod_m2
        state[Z_T] = deflection_under(f_test - run.f_applied_n[0], state[V], par.test.friction)
        state[Z_L] = deflection_under(run.f_applied_n[0] - f_load, state[V], par.load.friction)
    return state


@compiled
def _follow(
    par: "PlantParameters",
    state: np.ndarray,
    inputs: np.ndarray,
    ticks: int,
    gain: float,
    memory: np.ndarray,
    levels: np.ndarray,
    values: np.ndarray,
    work: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write each record's means of the sensors and, last, the board's velocity into ``out``.

    ``memory`` holds that velocity and, after it, the commands.
    """
    for k in range(inputs.shape[1]):
        for j in range(3):
            memory[1 + j] = inputs[1 + j, k]
        for _ in range(ticks):
            state[P_S] = inputs[0, k]
            sensed(state, levels, par, values, work)
            memory[0] += gain * (state[V] - memory[0])
            for j in range(len(values)):
                out[j, k] += values[j] / ticks
            out[len(values), k] += memory[0] / ticks
            step(state, memory[1:], levels, par, TICK_S, work)


def _means(log: Prepared, known: Model, names: tuple[str, ...]) -> np.ndarray:
    columns = [_mean(log, known, name) for name in names]
    return np.column_stack(columns)


def _mean(log: Prepared, known: Model, name: str) -> np.ndarray:
    run, one, par = log.run, log.one, known.par
    if name != "friction":
        signal = getattr(run, _FIELDS[name])
        return _nan(log, (name,))[:, 0] if signal is None else one.mean(signal)
    if log.motion is None:
        return _nan(log, (name,))[:, 0]
    f_test = run.p_tp_pa * par.test.area_piston_m2 - run.p_tr_pa * par.test.area_rod_m2
    return one.mean(f_test - run.f_applied_n) - par.mass_test_kg * one.second(run.x_m)


def _nan(log: Prepared, names: tuple[str, ...]) -> np.ndarray:
    return np.full((log.one.count(len(log.run.t_s)), len(names)), np.nan)


def _windowed(log: Prepared, known: Model, names: tuple[str, ...], values: np.ndarray) -> Windowed:
    rounding = np.array([known.word_steps.get(name, 0.0) for name in names]) / np.sqrt(12)
    return windowed(log.run, names, values, rounding, log.one, known.par.load)
