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

from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.along import friction_along
from hbench.analysis.logged_motion import logged_motion
from hbench.config.bench import Bench, Plant
from hbench.model.parameters import CylinderParameters, PlantParameters, plant_parameters
from hbench.model.sensors import FRACTION, sensor_gains
from hbench.reconcile.orifices import chamber_flows, pump_flow
from hbench.reconcile.weak import Window, sampling, window
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
CHAMBERS = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa")
_COMMANDS = ("u_t_v", "u_l1_v", "u_l2_v")


@dataclass(frozen=True)
class Model:
    """What the balances take of a bench: the plant, and how its board measures."""

    par: PlantParameters
    velocity_lag_s: float
    pressure_step_pa: float  # of a log word


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


def model(bench: Bench, plant: Plant | None = None) -> Model:
    """Return the model of a bench; ``plant`` stands in for its physics.

    D.11 as the board computes it, from the last tick's position, lags by tau_c and half a tick.
    """
    lag = bench.controllers.velocity_filter + 0.5 / bench.controllers.rate
    step = sensor_gains(bench.sensors)["p_s"][0] / FRACTION
    return Model(plant_parameters(plant or bench), lag, step)


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


def residuals(run: Run, known: Model) -> Windowed:
    """Return the residuals of ``BALANCES``. Raises ``DataError`` for uneven samples.

    A supply that stays the same is logged as the same word: its rounding is no noise that a mean
    lessens. The other signals' noise makes it one.
    """
    one = window(sampling(run))
    found = {
        **_flows_and_supply(run, known.par, one),
        **_forces(run, known.par, one),
        **_kinematics(run, known.velocity_lag_s, one),
    }
    missing = np.full(one.count(len(run.t_s)), np.nan)
    values = np.column_stack([found.get(name, missing) for name in BALANCES])
    rounding = np.where(np.array(BALANCES) == "supply", known.pressure_step_pa / np.sqrt(12), 0.0)
    return windowed(run, BALANCES, values, rounding, one, known.par.load)


def _has(run: Run, *names: str) -> bool:
    return all(getattr(run, name) is not None for name in names)


def _flows_and_supply(run: Run, par: PlantParameters, one: Window) -> dict[str, np.ndarray]:
    found = {}
    if _has(run, "p_s_pa") and not par.supply.has_pump:
        found["supply"] = one.mean(run.p_s_pa) - par.supply.pressure_pa
    if not _has(run, "p_s_pa", *CHAMBERS, *_COMMANDS):
        return found
    pressures = np.array([getattr(run, name) for name in CHAMBERS])
    commands = np.array([getattr(run, name) for name in _COMMANDS])
    flows = chamber_flows(run.x_m, pressures, run.p_s_pa, commands, one.dt_s, par)
    for i, name in enumerate(BALANCES[:4]):
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


def _forces(run: Run, par: PlantParameters, one: Window) -> dict[str, np.ndarray]:
    found = {}
    if not _has(run, "p_tp_pa", "p_tr_pa", "f_applied_n"):
        return found
    motion = logged_motion(run, par.mass_test_kg)
    compared = motion.compared[one.starts(len(run.t_s))]
    inertia = one.second(run.x_m)
    test, load = par.test, par.load
    f_test = run.p_tp_pa * test.area_piston_m2 - run.p_tr_pa * test.area_rod_m2
    friction = friction_along(motion, test.friction)
    lacking = one.mean(f_test - run.f_applied_n - friction) - par.mass_test_kg * inertia
    found["force_test"] = np.where(compared, lacking, np.nan)
    if _has(run, "p_lp_pa", "p_lr_pa"):
        f_load = run.p_lp_pa * load.area_piston_m2 - run.p_lr_pa * load.area_rod_m2
        moved = replace(motion, p_p_pa=run.p_lp_pa, p_r_pa=run.p_lr_pa)
        friction = friction_along(moved, load.friction)
        lacking = one.mean(run.f_applied_n - f_load - friction) - par.mass_load_kg * inertia
        found["force_load"] = np.where(compared, lacking, np.nan)
    return found


def _kinematics(run: Run, lag_s: float, one: Window) -> dict[str, np.ndarray]:
    if run.v_m_s is None:
        return {}
    return {"kinematics": one.rate(run.x_m) - one.mean(run.v_m_s) - lag_s * one.rate(run.v_m_s)}
