"""Steady valve openings, pressures and flow that a schedule needs, by the bench file's friction."""

from collections.abc import Iterable
from dataclasses import dataclass

from hbench.config.bench import Bench
from hbench.control.linearisation import OperatingPoint, steady_point
from hbench.errors import ConfigError
from hbench.experiment.plan import load_pressure
from hbench.model.build import plant_parameters
from hbench.model.friction.laws import steady_friction
from hbench.model.parameters import PlantParameters
from hbench.records import KINDS, RunPlan

_CHAMBERS = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa")


@dataclass(frozen=True)
class SteadyDemand:
    """Largest demands of a schedule's steady states; None for a schedule without motion."""

    valve_v: float  # largest opening of a valve
    valve_limit_v: float
    v_m_s: float  # at this velocity and load
    f_load_n: float
    p_lowest_pa: float  # of all chambers
    p_highest_pa: float
    flow_m3_s: float  # largest that the supply delivers to both cylinders
    points: int  # steady states
    # Of runs with changing velocity: what supply or valves can't hold, with numbers.
    not_held: tuple[str, ...] = ()


def steady_demand(plans: Iterable[RunPlan], bench: Bench, source: str) -> SteadyDemand | None:
    """Return what the steady states of the runs need.

    Raises ``ConfigError`` for one of constant speed that supply or valves can't hold. In runs with
    changing velocity a load pressure may be off its reference for a while.
    """
    par, middle = plant_parameters(bench), 0.5 * (bench.limits.travel_min + bench.limits.travel_max)
    points: dict[tuple, OperatingPoint] = {}
    not_held: dict[tuple, str] = {}
    for plan in plans:
        load, p_lr = plan.f_load_n, plan.p_lr_ref_pa
        if plan.motion is None or load is None or p_lr is None:
            continue
        for v in {segment.v_m_s for segment in plan.motion.segments} - {0.0}:
            if (v, load, p_lr) not in points:
                try:
                    hydraulic = load - _compensated(bench, par, v, load, p_lr)
                    points[v, load, p_lr] = steady_point(par, middle, v, hydraulic, p_lr)
                except ConfigError as error:
                    if not KINDS[plan.kind].has_constant_speed:
                        not_held[v, load, p_lr] = f"{plan.kind}: {error.message}"
                        continue
                    raise ConfigError(
                        f"{source}: {plan.kind} runs: {error.message} (steady state, with the "
                        "friction of the bench file)",
                        "Lower the speed or the load, or choose another p_lr.",
                    ) from None
    if not points:
        return None
    worst = max(points, key=lambda key: _opening(points[key]))
    pressures = [getattr(point, name) for point in points.values() for name in _CHAMBERS]
    return SteadyDemand(
        valve_v=_opening(points[worst]),
        valve_limit_v=bench.valve.limit,
        v_m_s=worst[0],
        f_load_n=worst[1],
        p_lowest_pa=min(pressures),
        p_highest_pa=max(pressures),
        flow_m3_s=max(_flow(point, bench) for point in points.values()),
        points=len(points),
        not_held=tuple(not_held.values()),
    )


def _compensated(
    bench: Bench, par: PlantParameters, v_m_s: float, f_load_n: float, p_lr_pa: float
) -> float:
    """Return the load cylinder's friction that its pressures don't add to the load [N]."""
    if bench.controllers.load.by == "pressures":
        return 0.0
    p_lp = load_pressure(bench, f_load_n, p_lr_pa)
    return float(steady_friction(v_m_s, p_lp, p_lr_pa, par.load.friction))


def _opening(point: OperatingPoint) -> float:
    return max(abs(point.u_t_v), abs(point.u_l1_v), abs(point.u_l2_v))


def _flow(point: OperatingPoint, bench: Bench) -> float:
    """Return the flow into the chambers that grow: one of each cylinder."""
    test, load = bench.test_cylinder, bench.load_cylinder
    if point.v_m_s >= 0:
        return point.v_m_s * (test.area_piston_m2 + load.area_rod_m2)
    return -point.v_m_s * (test.area_rod_m2 + load.area_piston_m2)
