"""Why the source's simulation went unstable: its fits of tables 6.2 to 6.5 as friction laws.

Eigenvalues at constant velocity, and the firmware in closed loop with the nonlinear bench.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from hbench.analysis.screening.screen import screen
from hbench.config.bench import Bench, parse_bench, parse_plant
from hbench.config.schedule import Screening
from hbench.control.linearisation import linear_coefficients, state_space, steady_point
from hbench.control.sampled import Pi, modulus, sample_plant
from hbench.control.stability import friction_slope, loop_eigenvalues, plant_eigenvalues
from hbench.experiment.closed_loop import record
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters, PlantParameters
from hbench.records import Run
from hbench.records.friction_laws import FRICTION_LAWS


class PrintedFit(NamedTuple):
    """A column of tables 6.2 to 6.5."""

    coulomb_n: float  # printed as "about 0": 1 N here
    stiction_n: float
    stribeck_velocity_m_s: float
    viscous_n_s_m: float


FITS = {
    "6.2 steady": PrintedFit(1.0, 616.0, 0.10, 1341.0),
    "6.3 steady": PrintedFit(1.0, 647.0, 0.11, 1381.0),
    "6.4 steady": PrintedFit(1.0, 634.0, 0.10, 1611.0),
    "6.5 steady": PrintedFit(1.0, 651.0, 0.13, 2331.0),
    "6.2 ramp": PrintedFit(1.0, 518.0, 0.06, 537.0),
    "6.3 ramp": PrintedFit(1.0, 590.0, 0.07, 676.0),
    "6.4 ramp": PrintedFit(1.0, 603.0, 0.07, 469.0),
    "6.5 ramp": PrintedFit(67.0, 566.0, 0.20, 0.0),
}
SIGMA_0 = 1e5  # N/m
SPEEDS_M_S = (0.01, 0.05, 0.101, 0.197)
X_M, LOAD_N, P_LR_PA = 0.17, 5000.0, 15e5


def with_fit(par: PlantParameters, fit: PrintedFit, law: str) -> PlantParameters:
    """Return the plant with a fit in both cylinders, as ``tustin`` or ``lugre`` (sigma_0 1e5)."""
    friction = FrictionParameters(
        law=LAWS[law].code,
        coulomb=fit.coulomb_n,
        stiction=fit.stiction_n,
        stribeck_velocity=fit.stribeck_velocity_m_s,
        viscous=fit.viscous_n_s_m,
        bristle_stiffness=SIGMA_0,
    )
    return _with_friction(par, friction)


def _with_friction(par: PlantParameters, friction: FrictionParameters) -> PlantParameters:
    return par._replace(
        test=par.test._replace(friction=friction), load=par.load._replace(friction=friction)
    )


class Fastest(NamedTuple):
    """Slope of friction [N s/m] and largest real parts [1/s] of eigenvalues, at one speed."""

    slope: float
    plant: float  # static law, commands held
    loop: float  # static law, loops closed
    tenth: float  # static law, a tenth of the velocity loop's gain
    lugre: float  # LuGre, loops closed


def fastest(par: PlantParameters, fit: PrintedFit, speed_m_s: float, loops: list[Pi]) -> Fastest:
    """Return the growth rates at a steady speed; a positive rate means instability."""
    static, lugre = with_fit(par, fit, "tustin"), with_fit(par, fit, "lugre")
    point = steady_point(static, X_M, speed_m_s, LOAD_N, P_LR_PA)
    (gain, tau), *others = loops
    return Fastest(
        friction_slope(static, point),
        plant_eigenvalues(static, point).real.max(),
        loop_eigenvalues(static, point, loops).real.max(),
        loop_eigenvalues(static, point, [(0.1 * gain, tau), *others]).real.max(),
        loop_eigenvalues(lugre, point, loops).real.max(),
    )


def _viscous(par: PlantParameters, total_n_s_m: float) -> PlantParameters:
    friction = FrictionParameters(law=LAWS["tustin"].code, viscous=0.5 * total_n_s_m)
    return _with_friction(par, friction)


def least_slope(par: PlantParameters, loops: list[Pi], filters_s: tuple[float, float]) -> float:
    """Return the slope of friction [N s/m] of both cylinders that the loops need at 50 mm/s.

    ``filters_s``: of velocity and pressures on the board; (0, 0) takes the loops in continuous
    time, without sampling.
    """

    def excess(slope: float) -> float:
        damped = _viscous(par, slope)
        point = steady_point(damped, X_M, 0.05, LOAD_N, P_LR_PA)
        if filters_s == (0.0, 0.0):
            return loop_eigenvalues(damped, point, loops).real.max()
        sampled = sample_plant(*state_space(linear_coefficients(damped, point), damped), *filters_s)
        return modulus(sampled, loops) - 1.0

    return float(brentq(excess, 500.0, 10_000.0, xtol=0.1))


def _friction(fit: PrintedFit, law: str) -> dict[str, Any]:
    known = {
        "bristle_stiffness": f"{SIGMA_0} N/m",
        "coulomb": f"{fit.coulomb_n} N",
        "stiction": f"{fit.stiction_n} N",
        "stribeck_velocity": f"{fit.stribeck_velocity_m_s} m/s",
        "viscous": f"{fit.viscous_n_s_m} N s/m",
    }
    keys = FRICTION_LAWS[law].keys
    return {"law": law} | {key: value for key, value in known.items() if key in keys}


@dataclass(frozen=True)
class FirmwareRun:
    """Steady run of the firmware in closed loop with the simulated bench."""

    run: Run
    fault: str  # why it does not hold its speed; empty if it does


def tried(
    bench_data: dict[str, Any],
    fit: PrintedFit,
    law: str,
    speed_m_s: float,
    load_viscous_n_s_m: float | None = None,
    start: str = "200 mm",
) -> FirmwareRun:
    """Run the firmware from rest to a steady speed, extending from the middle of the stroke.

    From another ``start`` the piston goes there first, at the bench's return speed.

    With ``load_viscous_n_s_m`` the fit is in the test cylinder alone, and the load cylinder has
    300 N Coulomb and that viscous friction.
    """
    test = load = _friction(fit, law)
    if load_viscous_n_s_m is not None:
        load = _friction(PrintedFit(300.0, 300.0, 0.1, load_viscous_n_s_m), "tustin")
    plant = parse_plant(bench_data, {"friction": {"test": test, "load": load}}, "fit")
    experiment = {
        "kind": "steady",
        "direction": "extend",
        "p_lr": f"{P_LR_PA} Pa",
        "loads": [f"{LOAD_N} N"],
        "velocities": [f"{speed_m_s} m/s"],
        "trials": 1,
        "travel": {"start": start, "end": "340 mm"},
        "acceleration": "1 m/s^2",
        "hold": "1 s",
        "window": "3 s",
    }
    bench = _patient(parse_bench(bench_data, "bench"))
    done = record(bench, {"name": "instability", "experiments": [experiment]}, plant)
    verdict = screen(done.runs[0], Screening())
    fault = done.stopped.partition("itself: ")[2] or "; ".join(verdict.reasons)
    return FirmwareRun(done.runs[0], fault)


def _patient(bench: Bench) -> Bench:
    """Return the bench with a board that lets a run far off its reference go on, at 250 Hz."""
    limits = bench.limits.model_copy(
        update={"speed_error": 0.6, "speed_error_time": 10.0, "speed_max": 0.6}
    )
    controllers = bench.controllers.model_copy(update={"log_rate": 250.0})
    return bench.model_copy(update={"limits": limits, "controllers": controllers})


def ripple(run: Run) -> float:
    """Return the velocity's standard deviation [m/s] in the last half of a run at its reference."""
    at = np.flatnonzero(run.channel("at_reference"))
    late = at[len(at) // 2 :]
    return float(run.channel("v_m_s")[late].std()) if len(late) else np.nan
