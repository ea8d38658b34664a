"""Measured and simulated signals as means over the windows of the balances.

Closed loop: measured runs are compared with runs of the same firmware and the model. Open loop: the
model runs under the measured valve commands and supply pressure, from the run's first record; its
error is compared between measured and simulated runs. Both go to ``gap_map.gaps``, so the unit is
the scatter of the trials.
"""

from dataclasses import replace

import numpy as np

from hbench.analysis.screening.calibrate import OPTIONAL_INPUTS, RUN_FIELDS
from hbench.errors import DataError
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
    forces,
    n_states,
    new_work,
    step,
)
from hbench.model.sensing import sensed
from hbench.model.sensors import N_CHANNELS, N_SENSED, SENSORS
from hbench.reconcile.measured.balances import (
    BalanceModel,
    WindowedRun,
    operating_conditions,
)
from hbench.reconcile.measured.session import Session, sessions
from hbench.records import Run

# Fields of a run by channel.
_NO_SIGNALS = ("v_ref", *OPTIONAL_INPUTS)
_FIELDS = {name: field for name, field in RUN_FIELDS.items() if name not in _NO_SIGNALS}
_PRESSURES = ("p_tp", "p_tr", "p_lp", "p_lr")  # initial state of the open loop
INPUTS = ("p_s", "u_t", "u_l1", "u_l2")  # of the open loop
OPEN_LOOP_CHANNELS = (*_PRESSURES, *INPUTS)  # required for the open loop
SIGNALS = (*_FIELDS, "friction")
OPEN_LOOP_SIGNALS = tuple(name for name in SIGNALS if name not in INPUTS)  # predicted by it


def signal_field(name: str) -> str | None:
    """Return the field of ``Run`` that holds a signal; None for friction, which is not logged."""
    return _FIELDS.get(name)


def signals(run: Run, model: BalanceModel) -> WindowedRun:
    """Return the means of ``SIGNALS`` in SI; friction is 2.12 with the weak acceleration."""
    (session,) = sessions([run])
    return _windowed(session, model, SIGNALS, _means(session, model, SIGNALS))


def open_loop_errors(run: Run, model: BalanceModel) -> WindowedRun:
    """Return measured less open-loop means of ``OPEN_LOOP_SIGNALS``.

    nan without commands and pressures.
    """
    names = OPEN_LOOP_SIGNALS
    (session,) = sessions([run])
    values = _means(session, model, names)
    if _channels(run, *(_FIELDS[name] for name in OPEN_LOOP_CHANNELS)) is None:
        return _windowed(session, model, names, values * np.nan)
    (predicted,) = sessions([open_loop(run, model)])
    return _windowed(session, model, names, values - _means(predicted, model, names))


def open_loop(run: Run, model: BalanceModel) -> Run:
    """Simulate a run's signals under its commands and supply pressure, without noise or scatter.

    Inputs are constant over each record. The initial state is the motion and the pressures of the
    first record, the spools at their commands, and bristles (LuGre) that carry the measured forces.
    Raises ``DataError`` where a channel is missing.
    """
    par = model.par
    pressures = _channels(run, *(_FIELDS[name] for name in _PRESSURES))
    channels = _channels(run, *(_FIELDS[name] for name in INPUTS))
    if pressures is None or channels is None:
        raise DataError(
            f"run {run.plan.run}: the open loop needs {', '.join(OPEN_LOOP_CHANNELS)}",
            "Leave the run out.",
        )
    ticks = max(1, round(float(np.median(np.diff(run.t_s))) / TICK_S))
    inputs = np.array(channels)
    out = np.zeros((N_CHANNELS + 1, len(run.t_s)))
    state = _first_state(run, par, [pressure[0] for pressure in pressures], inputs[:, 0])
    memory = np.concatenate([state[V : V + 1], np.zeros(3)])
    _simulate(
        par, state, inputs, ticks, TICK_S / (model.velocity_lag_s or TICK_S), memory, np.ones(2),
        np.zeros(N_SENSED), new_work(par), out,
    )  # fmt: skip
    simulated = {_FIELDS[name]: row for name, row in zip(SENSORS, out[:-1], strict=True)}
    return replace(run, **simulated, v_m_s=out[-1])


def _first_state(
    run: Run, par: PlantParameters, pressures: list[float], inputs: np.ndarray
) -> np.ndarray:
    """Return the state at a run's first record, whose ``inputs`` (4,) are those of ``INPUTS``."""
    state = np.zeros(n_states(par))
    state[X] = run.x_m[0]
    state[V] = 0.0 if run.v_m_s is None else run.v_m_s[0]
    state[[P_TP, P_TR, P_LP, P_LR]] = pressures
    state[[P_S, SPOOL_T, SPOOL_L1, SPOOL_L2]] = inputs
    if run.f_applied_n is not None:
        p_tp, p_tr, p_lp, p_lr = pressures
        f_test = p_tp * par.test.area_piston_m2 - p_tr * par.test.area_rod_m2
        f_load = p_lp * par.load.area_piston_m2 - p_lr * par.load.area_rod_m2
        state[Z_T] = deflection_under(f_test - run.f_applied_n[0], state[V], par.test.friction)
        state[Z_L] = deflection_under(run.f_applied_n[0] - f_load, state[V], par.load.friction)
    return state


@compiled
def _simulate(
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

    ``memory`` holds this velocity, then the commands.
    """
    for k in range(inputs.shape[1]):
        for j in range(3):
            memory[1 + j] = inputs[1 + j, k]
        for _ in range(ticks):
            state[P_S] = inputs[0, k]
            on_masses = forces(state, levels, par, work[0])
            sensed(state, on_masses, par, values)
            memory[0] += gain * (state[V] - memory[0])
            for j in range(N_CHANNELS):
                out[j, k] += values[j] / ticks
            out[N_CHANNELS, k] += memory[0] / ticks
            step(state, memory[1:], on_masses, levels, par, TICK_S, work)


def _means(session: Session, model: BalanceModel, names: tuple[str, ...]) -> np.ndarray:
    return np.column_stack([_mean(session, model, name) for name in names])


def _mean(session: Session, model: BalanceModel, name: str) -> np.ndarray:
    (run,), par, channels = session.runs, model.par, session.channels
    missing = np.full(int(session.counts.sum()), np.nan)
    if name != "friction":
        field = _FIELDS[name]
        return missing if getattr(run, field) is None else session.mean(channels[field])
    if _channels(run, "p_tp_pa", "p_tr_pa", "f_applied_n") is None:
        return missing
    f_test = channels["p_tp_pa"] * par.test.area_piston_m2
    f_test = f_test - channels["p_tr_pa"] * par.test.area_rod_m2
    unbalanced = session.mean(f_test - channels["f_applied_n"])
    return unbalanced - par.mass_test_kg * session.second(channels["x_m"])


def _windowed(
    session: Session, model: BalanceModel, names: tuple[str, ...], values: np.ndarray
) -> WindowedRun:
    steps = np.array([model.word_steps.get(name, 0.0) for name in names])
    conditions = operating_conditions(session, model)
    return WindowedRun(session.runs[0].plan, names, values, *conditions, steps / np.sqrt(12))


def _channels(run: Run, *names: str) -> list[np.ndarray] | None:
    """Return the channels of a run with these names, in order; None if any is missing."""
    channels = [getattr(run, name) for name in names]
    return None if any(channel is None for channel in channels) else channels
