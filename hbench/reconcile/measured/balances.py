"""Residuals of the bench's eight balances on a logged run, in weak form.

Residual of each balance, by name and unit; P, V, Q of the chamber, V_0 its volume at the window:

    flow_tp, flow_tr, flow_lp, flow_lr   m^3/s
                   V_0 (<(P / beta + ln V)'> - <Q / V>): inflow that the model does not explain
    force_test     N     <F_T - F_applied - F_fT> - m_T <x''>: force against extension
    force_load     N     <F_applied - F_L - F_fL> - m_L <x''>: force against extension
    kinematics     m/s   <x'> - <v> - tau <v'>, v the board's velocity, tau its filter's lag
    supply         Pa    measured supply pressure less the source's

Continuity P'/beta + V'/V = Q/V (2.1 to 2.8) contains the derivative of ln V(x), so neither pressure
nor position is differentiated. Q follows from the measured pressures and the valve's spool, which
is computed from the logged command (2.16). Within a record a signal is a parabola with the record's
mean. Friction follows the measured motion. Over the first 20 mm it depends on the unknown initial
state, so force balances are nan there, as they are where a channel is missing.

The flow balance of a pump (see ``model/supply.py``) is divided by its regulation slope
Q_max / band.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.identification.driven_law import driven_friction
from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.config.bench import Bench, Plant
from hbench.model.build import plant_parameters
from hbench.model.parameters import CylinderParameters, PlantParameters
from hbench.model.sensors import FRACTION, sensor_gains
from hbench.reconcile.measured.orifices import chamber_flows, pump_flow
from hbench.reconcile.measured.weak import Window, sampling, window
from hbench.records import Run, RunPlan

BALANCE_UNITS = {
    "flow_tp": "m^3/s",
    "flow_tr": "m^3/s",
    "flow_lp": "m^3/s",
    "flow_lr": "m^3/s",
    "force_test": "N",
    "force_load": "N",
    "kinematics": "m/s",
    "supply": "Pa",
}
BALANCES = tuple(BALANCE_UNITS)
FLOWS = BALANCES[:4]
CHAMBERS = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa")
_TEST_FORCES = ("p_tp_pa", "p_tr_pa", "f_applied_n")
_COMMANDS = ("u_t_v", "u_l1_v", "u_l2_v")
_CHANNELS = {
    **dict.fromkeys(FLOWS, ("p_s_pa", *CHAMBERS, *_COMMANDS)),
    "force_test": _TEST_FORCES,
    "force_load": (*_TEST_FORCES, "p_lp_pa", "p_lr_pa"),
    "kinematics": ("v_m_s",),
    "supply": ("p_s_pa",),
}


@dataclass(frozen=True)
class BalanceModel:
    """Model of a bench for the balances: the plant's parameters, and how the board measures."""

    par: PlantParameters
    velocity_lag_s: float
    word_steps: Mapping[str, float]  # resolution of the sensors' log words, by channel, in SI


@dataclass(frozen=True)
class WindowedRun:
    """Window values of one run, with the operating conditions of each window."""

    plan: RunPlan
    names: tuple[str, ...]
    values: np.ndarray  # (m, names); nan where not compared
    t_s: np.ndarray  # (m,) centre of the window, since the run's start
    x_m: np.ndarray  # (m,)
    v_m_s: np.ndarray  # (m,)
    load_n: np.ndarray  # (m,) F_L; nan where the load cylinder's pressures are missing
    resolution: np.ndarray  # (names,) standard deviation that the log's rounding causes


@dataclass(frozen=True)
class PreparedRun:
    """Run with its model-independent quantities: the window, and the motion if force is known."""

    run: Run
    window: Window
    motion: LoggedMotion | None

    def channels(self, *names: str) -> list[np.ndarray] | None:
        """Return the channels with these names, in order; None if any is missing."""
        return run_channels(self.run, *names)


def prepare(run: Run) -> PreparedRun:
    """Prepare a run for its balances. Raises ``DataError`` for uneven samples."""
    run_window = window(sampling(run))
    known = run_channels(run, *_TEST_FORCES) and run_window.count(len(run.t_s))
    return PreparedRun(run, run_window, logged_motion(run, 0.0) if known else None)


def balance_model(bench: Bench, plant: Plant | None = None) -> BalanceModel:
    """Return the model of a bench; ``plant`` replaces its physics.

    The board computes D.11 from the position of the last tick, so its velocity lags by tau_c and
    half a tick.
    """
    lag = bench.controllers.velocity_filter + 0.5 / bench.controllers.rate
    steps = {name: gain / FRACTION for name, (gain, _) in sensor_gains(bench.sensors).items()}
    return BalanceModel(plant_parameters(plant or bench), lag, steps)


def windowed_run(
    log: PreparedRun,
    names: tuple[str, ...],
    values: np.ndarray,
    resolution: np.ndarray,
    load: CylinderParameters,
) -> WindowedRun:
    """Return window values with their operating conditions; ``load`` is the load cylinder."""
    run, win = log.run, log.window
    f_load = np.full(win.count(len(run.t_s)), np.nan)
    if run.p_lp_pa is not None and run.p_lr_pa is not None:
        f_load = win.mean(run.p_lp_pa * load.area_piston_m2 - run.p_lr_pa * load.area_rod_m2)
    return WindowedRun(
        plan=run.plan,
        names=names,
        values=values,
        t_s=win.mean(run.t_s) - run.t_s[0],
        x_m=win.mean(run.x_m),
        v_m_s=win.rate(run.x_m),
        load_n=f_load,
        resolution=resolution,
    )


def residuals(
    log: PreparedRun, model: BalanceModel, names: tuple[str, ...] = BALANCES
) -> WindowedRun:
    """Return the residuals of the balances in ``names``.

    A constant supply pressure is logged as a constant word, so averaging does not reduce its
    rounding error. The noise of the other signals dithers theirs.
    """
    values: dict[str, np.ndarray] = {}
    for balances, compute in _BALANCE_FUNCTIONS:
        if set(balances) & set(names):
            values |= compute(log, model)
    missing = np.full(log.window.count(len(log.run.t_s)), np.nan)
    columns = np.column_stack([values.get(name, missing) for name in names])
    step = model.word_steps["p_s"]
    rounding = np.where(np.array(names) == "supply", step / np.sqrt(12), 0.0)
    return windowed_run(log, names, columns, rounding, model.par.load)


def channels_missing(run: Run, balance: str) -> tuple[str, ...]:
    """Return the channels of a balance that a run does not have."""
    return tuple(name for name in _CHANNELS[balance] if getattr(run, name) is None)


def run_channels(run: Run, *names: str) -> list[np.ndarray] | None:
    """Return the channels of a run with these names, in order; None if any is missing."""
    channels = [getattr(run, name) for name in names]
    return None if any(channel is None for channel in channels) else channels


def incomplete_reason(run: Run) -> str:
    """Return why a run's log is incomplete; empty for a complete one."""
    inside = f"{run.missing_records} records are missing inside the log"
    return run.truncated or (inside if run.missing_records else "")


def _flows_and_supply(log: PreparedRun, model: BalanceModel) -> dict[str, np.ndarray]:
    run, win, par = log.run, log.window, model.par
    values: dict[str, np.ndarray] = {}
    p_s = run.p_s_pa
    if p_s is not None and not par.supply.has_pump:
        values["supply"] = win.mean(p_s) - par.supply.pressure_pa
    chambers, valves = log.channels(*CHAMBERS), log.channels(*_COMMANDS)
    if p_s is None or chambers is None or valves is None:
        return values
    pressures, commands = np.array(chambers), np.array(valves)
    flows = chamber_flows(run.x_m, pressures, p_s, commands, win.dt_s, par)
    for i, name in enumerate(FLOWS):
        swelling = win.rate(pressures[i] / par.bulk_modulus_pa + flows.log_volume[i])
        volume = np.exp(win.mean(flows.log_volume[i]))
        values[name] = volume * (swelling - win.mean(flows.per_volume[i]))
    if par.supply.has_pump:
        source = par.supply
        delivered = pump_flow(p_s, win.dt_s, source)
        relief = source.relief_gain * np.maximum(p_s - source.relief_pa, 0.0)
        net = win.mean(delivered - flows.drawn - relief - source.leakage * p_s)
        residual = source.capacity * win.rate(p_s) - net
        values["supply"] = residual * source.band_pa / source.flow_m3_s
    return values


def _force_test(log: PreparedRun, model: BalanceModel) -> dict[str, np.ndarray]:
    par, test = model.par, model.par.test
    channels = log.channels(*_TEST_FORCES)
    if log.motion is None or channels is None:
        return {}
    p_tp, p_tr, f_applied = channels
    f_test = p_tp * test.area_piston_m2 - p_tr * test.area_rod_m2
    friction = driven_friction(log.motion, test.friction)
    unbalanced = f_test - f_applied - friction
    return {"force_test": _force_residual(log, log.motion, unbalanced, par.mass_test_kg)}


def _force_load(log: PreparedRun, model: BalanceModel) -> dict[str, np.ndarray]:
    par, load = model.par, model.par.load
    channels = log.channels("f_applied_n", "p_lp_pa", "p_lr_pa")
    if log.motion is None or channels is None:
        return {}
    f_applied, p_lp, p_lr = channels
    f_load = p_lp * load.area_piston_m2 - p_lr * load.area_rod_m2
    friction = driven_friction(replace(log.motion, p_p_pa=p_lp, p_r_pa=p_lr), load.friction)
    unbalanced = f_applied - f_load - friction
    return {"force_load": _force_residual(log, log.motion, unbalanced, par.mass_load_kg)}


def _force_residual(
    log: PreparedRun, motion: LoggedMotion, unbalanced_n: np.ndarray, mass_kg: float
) -> np.ndarray:
    win = log.window
    residual = win.mean(unbalanced_n) - mass_kg * win.second(log.run.x_m)
    return np.where(motion.compared[win.starts(len(unbalanced_n))], residual, np.nan)


def _kinematics(log: PreparedRun, model: BalanceModel) -> dict[str, np.ndarray]:
    run, win, lag = log.run, log.window, model.velocity_lag_s
    if run.v_m_s is None:
        return {}
    return {"kinematics": win.rate(run.x_m) - win.mean(run.v_m_s) - lag * win.rate(run.v_m_s)}


_BALANCE_FUNCTIONS = (
    ((*FLOWS, "supply"), _flows_and_supply),
    (("force_test",), _force_test),
    (("force_load",), _force_load),
    (("kinematics",), _kinematics),
)
