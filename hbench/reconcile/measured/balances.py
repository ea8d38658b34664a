"""The eight balances of the bench, as residuals of a logged run, in weak form.

What a balance lacks, by its name and unit; P, V, Q of the chamber, V_0 its volume at the window:

    flow_tp, flow_tr, flow_lp, flow_lr   m^3/s
                   V_0 (<(P / beta + ln V)'> - <Q / V>): oil that comes in, unknown to the model
    force_test     N     <F_T - F_applied - F_fT> - m_T <x''>: force against extension
    force_load     N     <F_applied - F_L - F_fL> - m_L <x''>: force against extension
    kinematics     m/s   <x'> - <v> - tau <v'>, v the board's velocity, tau its filter's lag
    supply         Pa    pressure above what the source gives

Continuity P'/beta + V'/V = Q/V (2.1 to 2.8) has the derivative of ln V(x), so neither pressure nor
position is differentiated. Q is made of the valve's spool, which follows the logged command (2.16),
and the measured pressures. Within a record signals are parabolas with the record's mean. Friction
follows the measured motion; until the piston has gone 20 mm it depends on the unknown beginning,
and force balances are not compared (nan), as where a channel is missing.

A pump's balance in flow (see ``model/supply.py``) is divided by its regulation slope Q_max / band.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.identification.driven_law import friction_along
from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.config.bench import Bench, Plant
from hbench.model.build import plant_parameters
from hbench.model.parameters import CylinderParameters, PlantParameters
from hbench.model.sensors import FRACTION, sensor_gains
from hbench.reconcile.measured.orifices import chamber_flows, pump_flow
from hbench.reconcile.measured.weak import Window, sampling, window
from hbench.records import Run, RunPlan

UNITS = {
    "flow_tp": "m^3/s",
    "flow_tr": "m^3/s",
    "flow_lp": "m^3/s",
    "flow_lr": "m^3/s",
    "force_test": "N",
    "force_load": "N",
    "kinematics": "m/s",
    "supply": "Pa",
}
BALANCES = tuple(UNITS)
FLOWS = BALANCES[:4]
CHAMBERS = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa")
_COMMANDS = ("u_t_v", "u_l1_v", "u_l2_v")
_CHANNELS = {
    **dict.fromkeys(FLOWS, ("p_s_pa", *CHAMBERS, *_COMMANDS)),
    "force_test": ("p_tp_pa", "p_tr_pa", "f_applied_n"),
    "force_load": ("p_tp_pa", "p_tr_pa", "f_applied_n", "p_lp_pa", "p_lr_pa"),
    "kinematics": ("v_m_s",),
    "supply": ("p_s_pa",),
}


@dataclass(frozen=True)
class Model:
    """What the balances take of a bench: the plant, and how its board measures."""

    par: PlantParameters
    velocity_lag_s: float
    word_steps: Mapping[str, float]  # of the sensors' log words, by channel, in SI


@dataclass(frozen=True)
class Windowed:
    """One run's windows: values (m, names), nan where not compared, and the operating points."""

    plan: RunPlan
    names: tuple[str, ...]
    values: np.ndarray  # (m, names)
    t_s: np.ndarray  # (m,) middle of the window, since the run's start
    x_m: np.ndarray  # (m,)
    v_m_s: np.ndarray  # (m,)
    load_n: np.ndarray  # (m,) F_L; nan where the load cylinder's pressures are missing
    resolution: np.ndarray  # (names,) standard deviation that the log's rounding leaves


@dataclass(frozen=True)
class Prepared:
    """A run with what no model changes: its window, and its motion where force is known."""

    run: Run
    one: Window
    motion: LoggedMotion | None


def prepared(run: Run) -> Prepared:
    """Prepare a run for its balances. Raises ``DataError`` for uneven samples."""
    one = window(sampling(run))
    known = _has(run, "p_tp_pa", "p_tr_pa", "f_applied_n") and one.count(len(run.t_s))
    return Prepared(run, one, logged_motion(run, 0.0) if known else None)


def model(bench: Bench, plant: Plant | None = None) -> Model:
    """Return the model of a bench; ``plant`` stands in for its physics.

    D.11 as the board computes it, from the last tick's position, lags by tau_c and half a tick.
    """
    lag = bench.controllers.velocity_filter + 0.5 / bench.controllers.rate
    steps = {name: gain / FRACTION for name, (gain, _) in sensor_gains(bench.sensors).items()}
    return Model(plant_parameters(plant or bench), lag, steps)


def windowed(
    run: Run,
    names: tuple[str, ...],
    values: np.ndarray,
    resolution: np.ndarray,
    one: Window,
    load: CylinderParameters,
) -> Windowed:
    """Return windows with their operating points; ``load`` is the load cylinder."""
    n = len(run.t_s)
    f_load = np.full(one.count(n), np.nan)
    if run.p_lp_pa is not None and run.p_lr_pa is not None:
        f_load = one.mean(run.p_lp_pa * load.area_piston_m2 - run.p_lr_pa * load.area_rod_m2)
    return Windowed(
        plan=run.plan,
        names=names,
        values=values,
        t_s=one.mean(run.t_s) - run.t_s[0],
        x_m=one.mean(run.x_m),
        v_m_s=one.rate(run.x_m),
        load_n=f_load,
        resolution=resolution,
    )


def residuals(log: Prepared, known: Model, names: tuple[str, ...] = BALANCES) -> Windowed:
    """Return the residuals of the balances in ``names``.

    A supply that stays the same is logged as the same word: its rounding is no noise that a mean
    lessens. The other signals' noise makes it one.
    """
    run, one = log.run, log.one
    found: dict[str, np.ndarray] = {}
    for made, make in _MAKERS:
        if set(made) & set(names):
            found |= make(log, known)
    missing = np.full(one.count(len(run.t_s)), np.nan)
    values = np.column_stack([found.get(name, missing) for name in names])
    step = known.word_steps["p_s"]
    rounding = np.where(np.array(names) == "supply", step / np.sqrt(12), 0.0)
    return windowed(run, names, values, rounding, one, known.par.load)


def lacking_channels(run: Run, name: str) -> tuple[str, ...]:
    """Return the channels of a balance that a run does not have."""
    return tuple(channel for channel in _CHANNELS[name] if not _has(run, channel))


def incomplete(run: Run) -> str:
    """Tell what a run's log lacks at its end or inside; empty for a whole one."""
    inside = f"{run.missing_records} records are missing inside the log"
    return run.truncated or (inside if run.missing_records else "")


def _has(run: Run, *names: str) -> bool:
    return all(getattr(run, name) is not None for name in names)


def _flows_and_supply(log: Prepared, known: Model) -> dict[str, np.ndarray]:
    run, one, found, par = log.run, log.one, {}, known.par
    if _has(run, "p_s_pa") and not par.supply.has_pump:
        found["supply"] = one.mean(run.p_s_pa) - par.supply.pressure_pa
    if not _has(run, "p_s_pa", *CHAMBERS, *_COMMANDS):
        return found
    pressures = np.array([getattr(run, name) for name in CHAMBERS])
    commands = np.array([getattr(run, name) for name in _COMMANDS])
    flows = chamber_flows(run.x_m, pressures, run.p_s_pa, commands, one.dt_s, par)
    for i, name in enumerate(FLOWS):
        swelling = one.rate(pressures[i] / par.bulk_modulus_pa + flows.log_volume[i])
        volume = np.exp(one.mean(flows.log_volume[i]))
        found[name] = volume * (swelling - one.mean(flows.per_volume[i]))
    if par.supply.has_pump:
        source = par.supply
        given = pump_flow(run.p_s_pa, one.dt_s, source)
        relief = source.relief_gain * np.maximum(run.p_s_pa - source.relief_pa, 0.0)
        net = one.mean(given - flows.drawn - relief - source.leakage * run.p_s_pa)
        lacking = source.capacity * one.rate(run.p_s_pa) - net
        found["supply"] = lacking * source.band_pa / source.flow_m3_s
    return found


def _force_test(log: Prepared, known: Model) -> dict[str, np.ndarray]:
    run, par, test = log.run, known.par, known.par.test
    if log.motion is None:
        return {}
    f_test = run.p_tp_pa * test.area_piston_m2 - run.p_tr_pa * test.area_rod_m2
    friction = friction_along(log.motion, test.friction)
    return {"force_test": _force(log, f_test - run.f_applied_n - friction, par.mass_test_kg)}


def _force_load(log: Prepared, known: Model) -> dict[str, np.ndarray]:
    run, par, load = log.run, known.par, known.par.load
    if log.motion is None or not _has(run, "p_lp_pa", "p_lr_pa"):
        return {}
    f_load = run.p_lp_pa * load.area_piston_m2 - run.p_lr_pa * load.area_rod_m2
    motion = replace(log.motion, p_p_pa=run.p_lp_pa, p_r_pa=run.p_lr_pa)
    friction = friction_along(motion, load.friction)
    return {"force_load": _force(log, run.f_applied_n - f_load - friction, par.mass_load_kg)}


def _force(log: Prepared, lacking_n: np.ndarray, mass_kg: float) -> np.ndarray:
    left = log.one.mean(lacking_n) - mass_kg * log.one.second(log.run.x_m)
    return np.where(log.motion.compared[log.one.starts(len(lacking_n))], left, np.nan)


def _kinematics(log: Prepared, known: Model) -> dict[str, np.ndarray]:
    run, one, lag = log.run, log.one, known.velocity_lag_s
    if run.v_m_s is None:
        return {}
    return {"kinematics": one.rate(run.x_m) - one.mean(run.v_m_s) - lag * one.rate(run.v_m_s)}


_MAKERS = (
    ((*FLOWS, "supply"), _flows_and_supply),
    (("force_test",), _force_test),
    (("force_load",), _force_load),
    (("kinematics",), _kinematics),
)
