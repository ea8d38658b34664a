"""From a schedule to the plan: every run with its references, checked before anything moves."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from hbench.config.bench import Bench
from hbench.config.schedule import Schedule, Screening, Steady, Velocities
from hbench.errors import ConfigError
from hbench.records import Motion, RunPlan, Specimen

_LAG_S = 0.05  # of the velocity loop and its settling, to be added to the way to brake


def polynomial_speeds(velocities: Velocities) -> np.ndarray:
    """Return v_i = a i + b i^2, i = 1..count, from ``first`` to ``last`` [m/s] (section 5.3)."""
    n = velocities.count
    b = (velocities.last - n * velocities.first) / (n * (n - 1))
    a = velocities.first - b
    i = np.arange(1, n + 1)
    return a * i + b * i**2


def load_pressure(bench: Bench, f_load_n: float, p_lr_pa: float) -> float:
    """Return the piston-side reference P_Lp = (A_r/A_p) P_Lr + F_L/A_p (4.24, sign corrected)."""
    cylinder = bench.load_cylinder
    return (cylinder.area_rod_m2 * p_lr_pa + f_load_n) / cylinder.area_piston_m2


def plan_runs(schedule: Schedule, bench: Bench, source: str) -> tuple[RunPlan, ...]:
    """Return all runs of a schedule in order, trials in a row.

    Raises ``ConfigError`` (naming ``source`` and the key) where the bench can't make a run.
    """
    plans: list[RunPlan] = []
    trials: Counter[tuple] = Counter()
    for number, experiment in enumerate(schedule.experiments):
        key = f"{source}: experiments.{number}"
        _check_travel(experiment, bench, key)
        for load in experiment.loads:
            p_lp = load_pressure(bench, load, experiment.p_lr)
            _check_pressures(load, experiment.p_lr, p_lp, bench, key)
            for speed in _speeds(experiment):
                plan = _steady(experiment, schedule.screening, float(speed), bench, key)
                reference = (experiment.kind, plan["v_ref_m_s"], load, experiment.p_lr)
                for _ in range(experiment.trials):
                    trials[reference] += 1  # goes on where an experiment is listed again
                    plans.append(
                        RunPlan(
                            run=f"{len(plans) + 1:04d}",
                            kind=experiment.kind,
                            trial=trials[reference],
                            f_load_n=load,
                            p_lr_ref_pa=experiment.p_lr,
                            p_lp_ref_pa=p_lp,
                            **plan,
                        )
                    )
    if len(plans) > 9999:
        raise ConfigError(f"{source}: {len(plans)} runs; at most 9999 fit one campaign")
    return tuple(plans)


def trials_in_a_row(plans: Sequence[RunPlan]) -> list[list[RunPlan]]:
    """Group consecutive runs that differ in nothing but their trial: one step of the board each."""

    def references(plan: RunPlan) -> tuple:
        return (plan.kind, plan.v_ref_m_s, plan.f_load_n, plan.p_lr_ref_pa, plan.motion)

    steps: list[list[RunPlan]] = []
    for plan in plans:
        before = steps[-1][-1] if steps else None
        follows = before is not None and int(plan.run) == int(before.run) + 1
        if follows and references(plan) == references(before):
            steps[-1].append(plan)
        else:
            steps.append([plan])
    return steps


def estimate_seconds(plans: Sequence[RunPlan], bench: Bench) -> float:
    """Return about how long the runs take on the bench: returns, holds and motions."""
    control = bench.controllers
    total, x = 0.0, None
    for plan in plans:
        motion = plan.motion
        way = abs(motion.x_end_m - motion.x_start_m)
        duration = min(motion.duration_s, way / abs(plan.v_ref_m_s) + 0.2)
        back = 0.0 if x is None else abs(x - motion.x_start_m) / control.return_speed + 1.0
        total += back + motion.hold_s + duration
        x = motion.x_start_m + np.sign(plan.v_ref_m_s) * min(way, duration * abs(plan.v_ref_m_s))
    return total


def _speeds(experiment: Steady) -> np.ndarray:
    if isinstance(experiment.velocities, Velocities):
        return polynomial_speeds(experiment.velocities)
    return np.array(experiment.velocities)


def _steady(
    experiment: Steady, screening: Screening, speed: float, bench: Bench, key: str
) -> dict[str, object]:
    travel, a = experiment.travel, experiment.acceleration
    ramp_s, ramp_m = speed / a, speed**2 / (2 * a)
    settle_s = max(screening.settle_time, screening.settle_travel / speed)
    window_s = min(experiment.window, (travel.end - travel.start - ramp_m) / speed - settle_s)
    if window_s < screening.min_window + 2 / bench.controllers.log_rate:  # records are whole
        raise ConfigError(
            f"{key}: at {1e3 * speed:.4g} mm/s the travel leaves a steady window of "
            f"{max(window_s, 0):.2f} s; at least {screening.min_window:g} s is needed",
            "Give more travel, a larger acceleration or a lower top speed.",
        )
    if speed > 0.9 * bench.limits.speed_max:
        raise ConfigError(
            f"{key}: {1e3 * speed:.4g} mm/s is above 90 % of limits.speed_max "
            f"({1e3 * bench.limits.speed_max:.4g} mm/s)"
        )
    extends = experiment.direction == "extend"
    cylinder = bench.test_cylinder
    return {
        "v_ref_m_s": speed if extends else -speed,
        "a_ref_m_s2": a,
        "specimen": Specimen(cylinder.area_piston_m2, cylinder.area_rod_m2, cylinder.stroke),
        "motion": Motion(
            x_start_m=travel.start if extends else travel.end,
            x_end_m=travel.end if extends else travel.start,
            hold_s=experiment.hold,
            duration_s=ramp_s + settle_s + window_s,
        ),
    }


def _check_travel(experiment: Steady, bench: Bench, key: str) -> None:
    limits, top = bench.limits, max(_speeds(experiment))
    brake = top**2 / (2 * bench.controllers.acceleration) + _LAG_S * top
    low, high = limits.travel_min, limits.travel_max
    if experiment.direction == "extend":
        high -= brake
    else:
        low += brake
    if not (low <= experiment.travel.start and experiment.travel.end <= high):
        raise ConfigError(
            f"{key}.travel: {1e3 * experiment.travel.start:.4g} to "
            f"{1e3 * experiment.travel.end:.4g} mm does not lie within {1e3 * low:.4g} to "
            f"{1e3 * high:.4g} mm (limits.travel, less {1e3 * brake:.3g} mm to brake from "
            f"{1e3 * top:.4g} mm/s)"
        )


def _check_pressures(load: float, p_lr: float, p_lp: float, bench: Bench, key: str) -> None:
    low, high = bench.supply.tank, bench.supply.pressure
    for name, pressure in (("p_lr", p_lr), ("P_Lp", p_lp)):
        if not low < pressure < high:
            raise ConfigError(
                f"{key}: the load of {load:g} N needs {name} = {pressure / 1e5:.4g} bar, not "
                f"between tank ({low / 1e5:.4g} bar) and supply ({high / 1e5:.4g} bar)",
                "P_Lp = (A_r/A_p) P_Lr + F_L/A_p; choose another load or p_lr.",
            )
