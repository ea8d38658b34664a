"""Plan of a schedule: every run with its references, checked before anything moves."""

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from random import Random

from hbench.config.bench import Bench
from hbench.config.experiments import ExperimentBase, LoadedExperiment, Steady
from hbench.config.schedule import Schedule, Screening
from hbench.config.velocities import AdaptiveSpeeds
from hbench.errors import ConfigError
from hbench.experiment.adaptive import SpeedFriction, next_speed
from hbench.experiment.motions import Reference, ideal_path, references, steady_reference
from hbench.records import KINDS, RunPlan, Specimen

MIN_SLOPE_M_S2 = 1e-4  # smaller steps in one tick are lost in single precision
MAX_RUNS = 9999  # a run's number has four digits
_LAG_S = 0.05  # of the velocity loop and its settling; lengthens the path


@dataclass(frozen=True)
class Plan:
    """Runs of a schedule: those decided, and those that adaptive velocities may still change."""

    runs: tuple[RunPlan, ...]
    # Where adaptive velocities still wait for friction: the runs of the smallest steps, which are
    # the most runs possible.
    undecided: tuple[RunPlan, ...] = ()


def load_pressure(bench: Bench, f_load_n: float, p_lr_pa: float) -> float:
    """Return the piston-side reference P_Lp = (A_r/A_p) P_Lr + F_L/A_p (4.24, sign corrected)."""
    cylinder = bench.load_cylinder
    return (cylinder.area_rod_m2 * p_lr_pa + f_load_n) / cylinder.area_piston_m2


def plan_runs(
    schedule: Schedule,
    bench: Bench,
    source: str,
    friction: Mapping[RunPlan, float | None] | None = None,
) -> Plan:
    """Return the runs of a schedule in order.

    ``friction`` [N] of the runs made so far, None for a rejected one, decides adaptive velocities.
    The same friction gives the same plan. Raises ``ConfigError`` naming ``source`` and the key
    where the bench can't make a run.
    """
    planner = _Planner(bench, friction or {}, source)
    # By trial, for order: passes and order: random.
    passes: dict[int, list[tuple[ExperimentBase, Reference, float | None]]] = defaultdict(list)
    after = 1 + max(experiment.trials for experiment in schedule.experiments)
    for number, experiment in enumerate(schedule.experiments):
        key = f"{source}: experiments.{number}"
        if isinstance(experiment, LoadedExperiment):
            for applied in experiment.loads:
                _check_load(applied, experiment.p_lr, bench, key)
        if isinstance(experiment, Steady) and isinstance(experiment.velocities, AdaptiveSpeeds):
            planner.follow(experiment, experiment.velocities, schedule.screening, key)
            continue
        in_order = references(experiment, schedule.screening, bench, key)
        # The fastest first, so that the message names the worst.
        for reference in sorted(in_order, key=lambda reference: -abs(reference.v_ref_m_s)):
            _check_motion(reference, bench, key)
        if schedule.order != "experiments" and KINDS[experiment.kind].needs_supply_off:
            # Before all passes or after them: the supply is switched off by hand.
            in_pass = passes[after if passes else -1]
            in_pass += [(experiment, each, None) for each in in_order] * experiment.trials
            continue
        if schedule.order != "experiments":
            pairs = product(_loads(experiment), in_order)
            one_pass = [(experiment, reference, load) for load, reference in pairs]
            for number in range(experiment.trials):
                passes[number] += one_pass
            continue
        for load, reference in _in_order(experiment, in_order):
            planner.add(experiment, reference, load)
    random = Random(schedule.seed)
    for number in sorted(passes):
        in_pass = passes[number]
        if schedule.order == "random":
            # Python guarantees the sequence of random() for a seed, but not that of shuffle().
            in_pass = sorted(in_pass, key=lambda run: random.random())
        for run in in_pass:
            planner.add(*run)
    runs = tuple(planner.runs)
    return Plan(runs[: planner.decided], runs[planner.decided :])


class _Planner:
    """Numbers runs and trials; counts the runs that are decided."""

    def __init__(self, bench: Bench, friction: Mapping[RunPlan, float | None], source: str):
        self.runs: list[RunPlan] = []
        self.decided = 0
        self._open = False  # an earlier speed depends on friction that is not measured yet
        self._bench = bench
        self._friction = friction
        self._source = source
        self._trials: Counter[tuple] = Counter()

    def add(self, experiment: ExperimentBase, reference: Reference, load: float | None) -> RunPlan:
        """Append the next trial of a reference."""
        same = (experiment.kind, experiment.label, reference, load, _p_lr(experiment))
        self._trials[same] += 1  # goes on where an experiment is listed again
        trial, number = self._trials[same], len(self.runs) + 1
        if number > MAX_RUNS:
            raise ConfigError(
                f"{self._source}: more than {MAX_RUNS} runs, the limit of a campaign",
                "Split the schedule. Adaptive velocities count with their smallest steps."
                if self._open
                else "Split the schedule.",
            )
        plan = _plan(number, experiment, reference, load, trial, self._bench)
        self.runs.append(plan)
        self.decided += not self._open
        return plan

    def follow(
        self, experiment: Steady, rule: AdaptiveSpeeds, screening: Screening, key: str
    ) -> None:
        """Append an adaptive experiment: speeds from friction so far, then the smallest steps."""
        for load in experiment.loads:
            measured: list[SpeedFriction] = []
            speed: float | None = rule.first
            while speed is not None:
                reference = steady_reference(experiment, speed, screening, self._bench, key)
                _check_motion(reference, self._bench, key)
                plans = [self.add(experiment, reference, load) for _ in range(experiment.trials)]
                frictions = [self._friction.get(plan) for plan in plans]
                self._open = self._open or any(plan not in self._friction for plan in plans)
                trials = () if self._open else tuple(f for f in frictions if f is not None)
                measured.append(SpeedFriction(speed, trials))
                speed = next_speed(rule, measured)


def trials_in_a_row(plans: Sequence[RunPlan]) -> list[list[RunPlan]]:
    """Group consecutive runs that differ only in their trial; each group is a step of the board."""
    steps: list[list[RunPlan]] = []
    for plan in plans:
        before = steps[-1][-1] if steps else None
        follows = before is not None and int(plan.run) == int(before.run) + 1
        if before and follows and plan.operating_point == before.operating_point:
            steps[-1].append(plan)
        else:
            steps.append([plan])
    return steps


def run_seconds(plans: Sequence[RunPlan], bench: Bench) -> dict[str, float]:
    """Return the approximate duration [s] of each run on the bench: return, hold and motion."""
    control = bench.controllers
    seconds, x = {}, None
    for plan in plans:
        motion = plan.planned_motion
        path = ideal_path(motion, control.acceleration)
        back = 0.0 if x is None else abs(x - motion.x_start_m) / control.return_speed + 1.0
        seconds[plan.run] = back + motion.hold_s + path.seconds + 0.2
        x = path.x_end_m
    return seconds


def _loads(experiment: ExperimentBase) -> tuple[float | None, ...]:
    return experiment.loads if isinstance(experiment, LoadedExperiment) else (None,)


def _in_order(
    experiment: ExperimentBase, in_order: Sequence[Reference]
) -> Iterator[tuple[float | None, Reference]]:
    """Yield each load and reference as often as there are trials, in the experiment's order."""
    pairs = list(product(_loads(experiment), in_order))
    if experiment.order == "row":
        return (pair for pair in pairs for _ in range(experiment.trials))
    return (pair for _ in range(experiment.trials) for pair in pairs)


def _plan(
    number: int,
    experiment: ExperimentBase,
    reference: Reference,
    load: float | None,
    trial: int,
    bench: Bench,
) -> RunPlan:
    cylinder, p_lr = bench.test_cylinder, _p_lr(experiment)
    return RunPlan(
        run=f"{number:04d}",
        kind=experiment.kind,
        trial=trial,
        v_ref_m_s=reference.v_ref_m_s,
        specimen=Specimen(cylinder.area_piston_m2, cylinder.area_rod_m2, cylinder.stroke),
        a_ref_m_s2=reference.a_ref_m_s2,
        f_load_n=load,
        p_lr_ref_pa=p_lr,
        p_lp_ref_pa=None if load is None or p_lr is None else load_pressure(bench, load, p_lr),
        label=experiment.label,
        motion=reference.motion,
        force_rate_n_s=reference.motion.segments[0].force_rate_n_s or None,
        dwell_s=reference.motion.hold_s if KINDS[experiment.kind].raises_force else None,
        level=reference.level,
    )


def _p_lr(experiment: ExperimentBase) -> float | None:
    return experiment.p_lr if isinstance(experiment, LoadedExperiment) else None


def _check_motion(reference: Reference, bench: Bench, key: str) -> None:
    limits, top = bench.limits, abs(reference.v_ref_m_s)
    if top > limits.highest_reference:
        raise ConfigError(
            f"{key}: {1e3 * top:.4g} mm/s is above 90 % of limits.speed_max "
            f"({1e3 * limits.speed_max:.4g} mm/s)"
        )
    for segment in reference.motion.segments:
        if segment.a_m_s2 < MIN_SLOPE_M_S2:
            raise ConfigError(
                f"{key}: slope of the velocity {segment.a_m_s2:.2g} m/s^2; the board's "
                f"least slope is {MIN_SLOPE_M_S2:g} m/s^2",
                "Give a higher speed or a smaller travel.",
            )
    path = ideal_path(reference.motion, bench.controllers.acceleration)
    if path.seconds < 2 / bench.controllers.log_rate:
        raise ConfigError(
            f"{key}: a run would last {path.seconds:.3g} s; two records of the log take "
            f"{2 / bench.controllers.log_rate:g} s",
            "Lengthen the run, or raise controllers.log_rate.",
        )
    lag = _LAG_S * top
    low = path.x_low_m - (lag if path.x_low_m < reference.motion.x_start_m else 0.0)
    high = path.x_high_m + (lag if path.x_high_m > reference.motion.x_start_m else 0.0)
    beyond = max(limits.travel_min - low, high - limits.travel_max)
    if beyond > 1e-9:  # more than rounding of the sums
        shorten = (
            f"Shorten the travel there by {math.ceil(1e3 * beyond - 1e-6)} mm, or lower the speed."
        )
        raise ConfigError(
            f"{key}.{'travel' if top else 'positions'}: at up to {1e3 * top:.4g} mm/s the piston "
            f"would move between {1e3 * low:.4g} and {1e3 * high:.4g} mm, braking included; "
            f"limits.travel are {1e3 * limits.travel_min:.4g} to {1e3 * limits.travel_max:.4g} mm",
            shorten if top else "Give positions inside the limits.",
        )


def _check_load(load: float, p_lr: float, bench: Bench, key: str) -> None:
    supply = bench.supply
    if load > 0:
        what, reach = "push", supply.pressure * bench.test_cylinder.area_piston_m2
        reach -= supply.tank * bench.test_cylinder.area_rod_m2
    else:
        what, reach = "pull", supply.pressure * bench.test_cylinder.area_rod_m2
        reach -= supply.tank * bench.test_cylinder.area_piston_m2
    if abs(load) >= reach:
        raise ConfigError(
            f"{key}.loads: {load:g} N is more than the test cylinder can {what} at "
            f"{supply.pressure / 1e5:.4g} bar, {reach:.0f} N without friction",
            "Choose a smaller load.",
        )
    lowest, highest = bench.sensors.force_range_n
    if not lowest < load < highest:
        raise ConfigError(
            f"{key}.loads: {load:g} N is outside the load cell's range, "
            f"{lowest:.0f} to {highest:.0f} N",
            "Choose a smaller load; the range follows from sensors.load_cell in the bench file.",
        )
    _check_pressures(load, p_lr, bench, key)


def _check_pressures(load: float, p_lr: float, bench: Bench, key: str) -> None:
    low, high = bench.supply.tank, bench.supply.pressure
    p_lp = load_pressure(bench, load, p_lr)
    for name, pressure, where in (("p_lr", p_lr, "p_lr"), ("P_Lp", p_lp, "loads")):
        if not low < pressure < high:
            raise ConfigError(
                f"{key}.{where}: the load of {load:g} N needs {name} = {pressure / 1e5:.4g} bar; "
                f"it must be above tank ({low / 1e5:.4g} bar) and below supply "
                f"({high / 1e5:.4g} bar)",
                _loads_at(p_lr, bench) if name == "P_Lp" else "Choose another p_lr.",
            )
        if pressure > bench.limits.pressure_max:
            raise ConfigError(
                f"{key}.{where}: the load of {load:g} N needs {name} = {pressure / 1e5:.4g} bar, "
                f"above limits.pressure_max ({bench.limits.pressure_max / 1e5:.4g} bar)",
                "Choose another load, p_lr or limit.",
            )


def _loads_at(p_lr: float, bench: Bench) -> str:
    cylinder, supply = bench.load_cylinder, bench.supply
    high = min(supply.pressure, bench.limits.pressure_max)
    lowest, highest = (
        cylinder.area_piston_m2 * p_lp - cylinder.area_rod_m2 * p_lr for p_lp in (supply.tank, high)
    )
    return (
        f"P_Lp = (A_r/A_p) P_Lr + F_L/A_p: at p_lr = {p_lr / 1e5:.4g} bar loads lie between "
        f"{lowest:.0f} and {highest:.0f} N; choose another load or p_lr."
    )
