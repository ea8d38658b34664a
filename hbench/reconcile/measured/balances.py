"""Residuals of the bench's eight balances on a logged run, in weak form.

Residual of each balance, by name and unit; P, V, Q of the chamber, V_0 its volume at the window:

    flow_tp, flow_tr, flow_lp, flow_lr   m^3/s
                   V_0 (<(P / beta + ln V)'> - <Q / V>): inflow that the model does not explain
    force_test     N     <F_T - F_applied - F_fT> - m_T <x''>: force against extension
    force_load     N     <F_applied - F_L - F_fL> - m_L <x''>: force against extension
    kinematics     m/s   <x'> - <v> - tau <v'>, x the reading that the board differentiates, v its
                         velocity, tau its filter's lag
    supply         Pa    measured supply pressure less the source's

Continuity P'/beta + V'/V = Q/V (2.1 to 2.8) contains the derivative of ln V(x), so neither pressure
nor position is differentiated. Flows and friction are those of the laws along the log
(``along.py``), with the effects of the model; readings are corrected for the errors of its sensors.
Within a record a signal is a parabola with the record's mean. A balance is nan where a channel is
missing.

The flow balance of a pump (see ``model/supply.py``) is divided by its regulation slope
Q_max / band.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.config.bench import Bench, Controllers, Plant
from hbench.config.sensors import Sensors
from hbench.model.build import plant_parameters
from hbench.model.effects.catalogue import (
    EFFECTS,
    changed_by,
    read_effects,
    with_all_effects,
)
from hbench.model.effects.learned import corrected_motion
from hbench.model.friction.laws import steady_friction
from hbench.model.parameters import PlantParameters
from hbench.model.sensors import (
    FRACTION,
    SENSORS,
    SensorParameters,
    ideal_sensors,
    sensor_gains,
    sensor_parameters,
)
from hbench.model.states import P_TP, P_TR
from hbench.reconcile.measured.along import ALL_PARTS, STEP_S, AlongLog, acting, along
from hbench.reconcile.measured.disturbances import ALL_COMMANDS, POSITION, Ripples
from hbench.reconcile.measured.integration import Parts, Starts
from hbench.reconcile.measured.session import COMMANDS, PRESSURES, VELOCITY, Session, sessions
from hbench.reconcile.measured.sources import pump_flow
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
FLOWS, FORCES = BALANCES[:4], BALANCES[4:6]
_SUPPLY = 6  # index of the supply pressure among the driving signals
_WITH_LAWS = slice(6)  # flows and forces; the others are linear in the signals
CHAMBERS = PRESSURES[:4]
_TEST_FORCES = ("p_tp_pa", "p_tr_pa", "f_applied_n")
CHANNELS_OF = {  # the test valve alone feeds the test cylinder: no load cylinder is needed
    **dict.fromkeys(FLOWS[:2], ("p_s_pa", *CHAMBERS[:2], COMMANDS[0])),
    **dict.fromkeys(FLOWS[2:], ("p_s_pa", *CHAMBERS, *COMMANDS)),
    "force_test": _TEST_FORCES,
    "force_load": (*_TEST_FORCES, "p_lp_pa", "p_lr_pa"),
    "kinematics": ("v_m_s",),
    "supply": ("p_s_pa",),
}

OF_LOAD_CYLINDER = (*FLOWS[2:], "force_load")

_STATES = [row.states for row in EFFECTS.values()]
# Of the effects' states, those that go on from one log to the next, and those that start with the
# measured friction.
_BUILDS_UP = np.repeat([row.builds_up for row in EFFECTS.values()], _STATES)
_DEFLECTS = np.repeat([row.deflects for row in EFFECTS.values()], _STATES)


@dataclass(frozen=True)
class BalanceModel:
    """Model of a bench for the balances: the plant with its effects, and how it is measured."""

    par: PlantParameters  # with effects
    sensors: Mapping[str, tuple[float, float]]  # a, b by channel: reading = a * value + b
    velocity_lag_s: float | None  # of the logged velocity; None: not known
    word_steps: Mapping[str, float]  # resolution of the sensors' log words, by channel, in SI
    drifts: Mapping[str, float] = field(default_factory=dict)  # [SI] of sensors, by channel
    delays_s: Mapping[str, float] = field(default_factory=dict)  # of sensors, and of commands
    levels: tuple[float, float] = (1.0, 1.0)  # of dry friction, test and load cylinder
    ripples: Ripples | None = None  # of dry friction, along the stroke
    step_s: float = STEP_S  # of the laws' states
    parts: Parts = ALL_PARTS  # laws that are evaluated


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


def balance_model(bench: Bench | None, plant: Plant) -> BalanceModel:
    """Return the model of a plant, measured by a bench; None: a bench whose board is unknown.

    The board computes D.11 from the position of the last tick, so its velocity lags by tau_c and
    half a tick, by the half tick alone with an accelerometer. Raises ``ConfigError`` for effects
    that are not in the catalogue.
    """
    effects = read_effects(plant.effects)
    bare = plant_parameters(plant.model_copy(update={"effects": {}, "learned": ()}))
    par = with_all_effects(bare, effects, plant.learned)
    if bench is None:
        return BalanceModel(par, sensor_maps(ideal_sensors(), ideal_sensors(), effects), None, {})
    board: Controllers = changed_by("board", bench.controllers, effects)
    steps = {name: gain / FRACTION for name, (gain, _) in sensor_gains(bench.sensors).items()}
    maps = sensor_maps(
        sensor_parameters(_sensors(plant, bench)), sensor_parameters(bench.sensors), effects
    )
    lag = 0.0 if bench.sensors.accelerometer else board.velocity_filter
    return BalanceModel(par, maps, lag + 0.5 / board.rate, steps)


def _sensors(plant: Plant, bench: Bench) -> Sensors:
    return plant.sensors or bench.sensors


def sensor_maps(
    own: SensorParameters, assumed: SensorParameters, effects: Mapping[str, Mapping[str, float]]
) -> dict[str, tuple[float, float]]:
    """Return each channel's reading as a * value + b: (a, b), by channel."""
    actual = changed_by("sensors", own, effects)
    return {
        name: (actual.per_unit[i] / assumed.per_unit[i],
               (actual.zero[i] - assumed.zero[i]) / assumed.per_unit[i])
        for i, name in enumerate(SENSORS)
    }  # fmt: skip


def residuals(run: Run, model: BalanceModel) -> WindowedRun:
    """Return the residuals of all balances of a single run. Raises ``DataError``."""
    (session,) = sessions([run])
    values = balance_values(session, model)
    return WindowedRun(
        run.plan, BALANCES, values, *operating_conditions(session, model), rounding_error(model)
    )


def rounding_error(model: BalanceModel) -> np.ndarray:
    """Return the standard deviation (8,) that the log's rounding causes in each balance.

    A constant supply pressure is logged as a constant word, so averaging does not reduce its
    rounding error. The noise of the other signals dithers theirs.
    """
    step = model.word_steps.get("p_s", 0.0)
    return np.where(np.array(BALANCES) == "supply", step / np.sqrt(12), 0.0)


def operating_conditions(
    session: Session, model: BalanceModel
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return time since the run's start, position, velocity and load of the windows, each (w,)."""
    starts = session.channels["t_s"][session.edges[:-1]][session.run_of_window]
    p_lp, p_lr = session.channels["p_lp_pa"], session.channels["p_lr_pa"]
    load = model.par.load
    f_load = session.mean(p_lp * load.area_piston_m2 - p_lr * load.area_rod_m2)
    measured = session.measured["p_lp_pa"]
    return (
        session.mean(session.channels["t_s"]) - starts,
        session.mean(session.channels["x_m"]),
        session.rate(session.channels["x_m"]),
        np.where(measured[session.run_of_window], f_load, np.nan),
    )


def balance_values(session: Session, model: BalanceModel) -> np.ndarray:
    """Return the residuals (w, 8) of all balances of a session.

    States of effects that build up over many runs go from one log to the next.
    """
    par = model.par
    signals = driving_signals(session, model)
    f_test, applied, f_load = _forces(session, signals, model)
    means = laws_along(session, signals, model, (f_test - applied, applied - f_load))
    swelling = session.rate(means.compression + means.log_volume)
    volume = np.exp(session.mean(means.log_volume))
    flows = volume * (swelling - session.mean(means.per_volume))
    acceleration = session.second(signals[0])
    test = session.mean(f_test - applied - means.friction_test) - par.mass_test_kg * acceleration
    load = session.mean(applied - f_load - means.friction_load) - par.mass_load_kg * acceleration
    x_read, v, lag = session.channels["x_m"], session.channels["v_m_s"], model.velocity_lag_s
    kinematics = session.rate(x_read) - session.mean(v) - (lag or 0.0) * session.rate(v)
    supply = _supply(signals[_SUPPLY], means, session, par)
    values = np.column_stack([*flows, test, load, kinematics, supply])
    compared = _compared(session, model)[session.run_of_window]
    compared &= ~session.with_gaps[:, None]
    compared[:, _WITH_LAWS] &= ~session.oscillating[:, None]
    compared[:, : len(FLOWS)] &= ~session.cavitating
    return np.where(compared, values, np.nan)


def _compared(session: Session, model: BalanceModel) -> np.ndarray:
    """Return which balances (r, 8) the channels of each run determine."""
    measured = session.measured
    has = np.column_stack(
        [np.all([measured[name] for name in CHANNELS_OF[each]], axis=0) for each in BALANCES]
    )
    constant = [is_constant(session.channels[name]) for name in ("p_s_pa", *CHAMBERS[:2])]
    has[:, BALANCES.index("supply")] &= not any(constant)  # of the map in all runs, not measured
    has[:, :2] &= ~np.array(constant[1:])  # open to the air: the valve feeds no such chamber
    if model.velocity_lag_s is None:
        has[:, BALANCES.index("kinematics")] = False
    if model.par.supply.has_pump:  # its flow is compared with that of the valves
        has[:, BALANCES.index("supply")] &= has[:, 0]
    of_load = measured["p_lp_pa"] & measured["p_lr_pa"]  # that cylinder draws from the supply too
    has[:, BALANCES.index("supply")] &= ~of_load | (measured["u_l1_v"] & measured["u_l2_v"])
    return has


def _forces(
    session: Session, signals: np.ndarray, model: BalanceModel
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the forces of the test cylinder's oil, the coupling and the load cylinder's oil."""
    p_tp, p_tr, p_lp, p_lr = signals[2:6]
    test, load = model.par.test, model.par.load
    f_test = p_tp * test.area_piston_m2 - p_tr * test.area_rod_m2
    f_load = p_lp * load.area_piston_m2 - p_lr * load.area_rod_m2
    return f_test, true_values(session, "f_applied_n", model, "f_applied"), f_load


def measured_laws(session: Session, model: BalanceModel) -> AlongLog:
    """Return the laws along all logs of a session."""
    signals = driving_signals(session, model)
    f_test, applied, f_load = _forces(session, signals, model)
    return laws_along(session, signals, model, (f_test - applied, applied - f_load))


def laws_along(
    session: Session, signals: np.ndarray, model: BalanceModel, forces: tuple[np.ndarray, ...]
) -> AlongLog:
    """Return the laws along all logs; ``forces`` are the measured frictions of both cylinders."""
    at_start, levels = starts(session, signals, model, forces), np.array(model.levels)[:, None]
    if model.ripples:
        levels = levels * model.ripples.along(signals[0])
    dt_s = session.window.dt_s
    return along(signals, dt_s, model.par, at_start, levels, model.step_s, model.parts)


def starts(
    session: Session, signals: np.ndarray, model: BalanceModel, forces: tuple[np.ndarray, ...]
) -> Starts:
    """Return what all logs start with; ``forces`` are the measured frictions of both cylinders.

    The friction is the mean over the first record: most logs start at rest, and a line through the
    means of the motion that follows would go beyond the friction at rest.
    """
    friction = np.column_stack([force[session.edges[:-1]] for force in forces])
    on = acting(model.par.effects or ())
    states = np.zeros((len(friction), len(_DEFLECTS)))
    if any(EFFECTS[name].deflects for name in on):
        share = _share_of_static(friction[:, 0], signals[:, session.edges[:-1]], model.par)
        states = share[:, None] * _DEFLECTS
    builds_up = _BUILDS_UP & np.repeat([name in on for name in EFFECTS], _STATES)
    return Starts(session.edges, friction, states, builds_up)


def _share_of_static(force: np.ndarray, signals: np.ndarray, par: PlantParameters) -> np.ndarray:
    """Return the test cylinder's friction (r,) in shares of its static friction, -1 to 1."""
    pressures = signals[[P_TP, P_TR]].T.tolist()
    static = np.abs([steady_friction(0.0, *pair, par.test.friction) for pair in pressures])
    shares = np.divide(force, static, out=np.zeros_like(force), where=static > 0)
    return np.clip(shares, -1.0, 1.0)


def driving_signals(session: Session, model: BalanceModel) -> np.ndarray:
    """Return what drives the laws (10, n), see ``along``."""
    pressures = [
        true_values(session, channel, model, name)
        for name, channel in zip(("p_tp", "p_tr", "p_lp", "p_lr", "p_s"), PRESSURES, strict=True)
    ]
    x = true_values(session, "x_m", model, "x")
    delay_s = model.delays_s.get(ALL_COMMANDS, 0.0)
    commands = [session.shifted(name, delay_s) for name in COMMANDS]
    late_s = model.delays_s.get(POSITION, 0.0)
    velocity = session.ahead(VELOCITY, late_s) if late_s else session.velocity_m_s
    signals = np.vstack([x, velocity, *pressures, *commands])
    if len(model.par.learned):
        corrected_motion(signals[0], signals[1], model.par.learned)
    return signals


def true_values(session: Session, channel: str, model: BalanceModel, sensor: str) -> np.ndarray:
    """Return the values (n,) that a sensor has shown, without its errors."""
    reading, (a, b) = session.channels[channel], model.sensors[sensor]
    if delay_s := model.delays_s.get(sensor, 0.0):
        reading = session.ahead(channel, delay_s)
    if drift := model.drifts.get(sensor, 0.0):
        reading = reading - session.drifting(drift)
    return reading if (a, b) == (1.0, 0.0) else (reading - b) / a


def _supply(p_s: np.ndarray, means: AlongLog, session: Session, par: PlantParameters) -> np.ndarray:
    source = par.supply
    if not source.has_pump:
        return session.mean(p_s - means.supply_pa)
    delivered = np.concatenate(
        [
            pump_flow(p_s[start:stop], session.window.dt_s, source)
            for start, stop in zip(session.edges[:-1], session.edges[1:], strict=True)
        ]
    )
    relief = source.relief_gain * np.maximum(p_s - source.relief_pa, 0.0)
    net = session.mean(delivered - means.drawn - relief - source.leakage * p_s)
    return (source.capacity * session.rate(p_s) - net) * source.band_pa / source.flow_m3_s


def channels_missing(run: Run, balance: str) -> tuple[str, ...]:
    """Return the channels of a balance that a run does not have."""
    needed = CHANNELS_OF[balance]
    if balance == "supply" and all(getattr(run, name) is not None for name in CHAMBERS[2:]):
        needed += COMMANDS[1:]
    return tuple(name for name in needed if getattr(run, name) is None)
