"""From a schedule to the plan: every run with its references, checked before anything moves."""

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import product

from hbench.config.bench import Bench
from hbench.config.experiments import Loaded
from hbench.config.schedule import Schedule
from hbench.errors import ConfigError
from hbench.experiment.motions import Reference, references, way
from hbench.records import RunPlan, Specimen

MAX_RUNS = 9999  # that a run's number has digits for
_LAG_S = 0.05  # of the velocity loop and its settling, to be added to the way


def load_pressure(bench: Bench, f_load_n: float, p_lr_pa: float) -> float:
    """Return the piston-side reference P_Lp = (A_r/A_p) P_Lr + F_L/A_p (4.24, sign corrected)."""
    cylinder = bench.load_cylinder
    return (cylinder.area_rod_m2 * p_lr_pa + f_load_n) / cylinder.area_piston_m2


def plan_runs(schedule: Schedule, bench: Bench, source: str) -> tuple[RunPlan, ...]:
    """Return all runs of a schedule in order.

    Raises ``ConfigError`` (naming ``source`` and the key) where the bench can't make a run.
    """
    plans: list[RunPlan] = []
    trials: Counter[tuple] = Counter()
    for number, experiment in enumerate(schedule.experiments):
        key = f"{source}: experiments.{number}"
        found = references(experiment, schedule.screening, bench, key)
        for reference in found:
            _check_motion(reference, bench, key)
        for load in experiment.loads:
            _check_pressures(load, experiment.p_lr, bench, key)
        for load, reference in _in_order(experiment, found):
            same = (experiment.kind, experiment.label, reference, load, experiment.p_lr)
            trials[same] += 1  # goes on where an experiment is listed again
            plans.append(_plan(len(plans) + 1, experiment, reference, load, trials[same], bench))
    if len(plans) > MAX_RUNS:
        raise ConfigError(f"{source}: {len(plans)} runs; at most {MAX_RUNS} fit one campaign")
    return tuple(plans)


def trials_in_a_row(plans: Sequence[RunPlan]) -> list[list[RunPlan]]:
    """Group consecutive runs that differ in nothing but their trial: one step of the board each."""

    def same(plan: RunPlan) -> tuple:
        return (plan.kind, plan.label, plan.f_load_n, plan.p_lr_ref_pa, plan.motion)

    steps: list[list[RunPlan]] = []
    for plan in plans:
        before = steps[-1][-1] if steps else None
        follows = before is not None and int(plan.run) == int(before.run) + 1
        if follows and same(plan) == same(before):
            steps[-1].append(plan)
        else:
            steps.append([plan])
    return steps


def estimate_seconds(plans: Sequence[RunPlan], bench: Bench) -> float:
    """Return about how long the runs take on the bench: returns, holds and motions."""
    control = bench.controllers
    total, x = 0.0, None
    for plan in plans:
        gone = way(plan.motion, control.acceleration)
        back = 0.0 if x is None else abs(x - plan.motion.x_start_m) / control.return_speed + 1.0
        total += back + plan.motion.hold_s + gone.seconds + 0.2
        x = gone.x_end_m
    return total


def _in_order(experiment: Loaded, found: Sequence[Reference]) -> Iterator[tuple[float, Reference]]:
    """Yield each load and reference as often as there are trials, in the experiment's order."""
    pairs = list(product(experiment.loads, found))
    if experiment.order == "row":
        return (pair for pair in pairs for _ in range(experiment.trials))
    return (pair for _ in range(experiment.trials) for pair in pairs)


def _plan(
    number: int, experiment: Loaded, reference: Reference, load: float, trial: int, bench: Bench
) -> RunPlan:
    cylinder = bench.test_cylinder
    return RunPlan(
        run=f"{number:04d}",
        kind=experiment.kind,
        trial=trial,
        v_ref_m_s=reference.v_ref_m_s,
        specimen=Specimen(cylinder.area_piston_m2, cylinder.area_rod_m2, cylinder.stroke),
        a_ref_m_s2=reference.a_ref_m_s2,
        f_load_n=load,
        p_lr_ref_pa=experiment.p_lr,
        p_lp_ref_pa=load_pressure(bench, load, experiment.p_lr),
        label=experiment.label,
        motion=reference.motion,
    )


def _check_motion(reference: Reference, bench: Bench, key: str) -> None:
    limits, top = bench.limits, abs(reference.v_ref_m_s)
    if top > 0.9 * limits.speed_max:
        raise ConfigError(
            f"{key}: {1e3 * top:.4g} mm/s is above 90 % of limits.speed_max "
            f"({1e3 * limits.speed_max:.4g} mm/s)"
        )
    gone = way(reference.motion, bench.controllers.acceleration)
    lag = _LAG_S * top
    low = gone.x_low_m - (lag if gone.x_low_m < reference.motion.x_start_m else 0.0)
    high = gone.x_high_m + (lag if gone.x_high_m > reference.motion.x_start_m else 0.0)
    if not (limits.travel_min <= low and high <= limits.travel_max):
        raise ConfigError(
            f"{key}.travel: at up to {1e3 * top:.4g} mm/s the piston would move between "
            f"{1e3 * low:.4g} and {1e3 * high:.4g} mm, way to brake included; limits.travel are "
            f"{1e3 * limits.travel_min:.4g} to {1e3 * limits.travel_max:.4g} mm",
            "Give a smaller travel or a lower speed.",
        )


def _check_pressures(load: float, p_lr: float, bench: Bench, key: str) -> None:
    low, high = bench.supply.tank, bench.supply.pressure
    p_lp = load_pressure(bench, load, p_lr)
    for name, pressure in (("p_lr", p_lr), ("P_Lp", p_lp)):
        if not low < pressure < high:
            raise ConfigError(
                f"{key}: the load of {load:g} N needs {name} = {pressure / 1e5:.4g} bar, not "
                f"between tank ({low / 1e5:.4g} bar) and supply ({high / 1e5:.4g} bar)",
                "P_Lp = (A_r/A_p) P_Lr + F_L/A_p; choose another load or p_lr.",
            )
