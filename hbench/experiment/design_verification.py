"""Check of proposed gains in the nonlinear closed loop, on the bench and on variants of it.

The firmware makes steady runs at the grid's slow, middle and fast speed, every load and both
directions, over as much of the stroke as 6 s and the braking distance allow. A speed for which the
stroke is too short is lowered. Each run is screened as by ``hbench analyze``, with the second half
of its constant speed as the window. In the first half the pressure level of the test cylinder
settles, from that of the return stroke. It takes a travel that depends on the oil and the valve and
on no gain, and the friction of the seals follows it.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from hbench.analysis.screening.screen import screen
from hbench.analysis.screening.steady_window import at_reference
from hbench.config.bench import Bench, Plant
from hbench.config.scaling import replaced, scaled
from hbench.config.schedule import Screening
from hbench.control.grid import Grid, conditions
from hbench.control.linearisation import OperatingPoint
from hbench.control.loops import LOOPS
from hbench.control.propose import propose
from hbench.control.sampled import Pi
from hbench.experiment.closed_loop import ClosedLoopRuns, record
from hbench.experiment.progress import Report, report_of_part
from hbench.model.build import plant_parameters
from hbench.records import Check, Proposal, Run

OVERSHOOT = 0.5  # of limits.speed_error, at which the board stops
PRESSURE_ERROR = 0.01  # of the supply pressure; mean error of a load pressure
_LAG_S, _WINDOW_S, _SPARE_M = 0.06, 6.0, 2e-3
_SHORTEST_S, _SLOWER = 0.5, 0.8  # steady window, and the factor by which a speed is lowered for it
_SLOWEST_M_S = 1e-3
_LIMIT = re.compile(r"limits\.(\w+)")


def proposal(
    bench: Bench, ratio: float, point: OperatingPoint, grid: Grid, report: Report
) -> Proposal:
    """Propose gains for ``bench``, designed at ``point``, and check them with the firmware.

    ``ratio`` is the ratio of neighbouring bandwidths. Raises ``ConfigError``, ``ConvergenceError``.
    """
    found = propose(bench, ratio, point, grid)
    names = [name for name, *_ in LOOPS]
    ordered = zip(found.order, found.bandwidths_rad_s, strict=True)
    return Proposal(
        gains=dict(zip(names, found.loops, strict=True)),
        bandwidths_rad_s={names[loop]: width for loop, width in ordered},
        feedforward=found.feedforward,
        ratio=ratio,
        points=found.points,
        left_out=found.left_out,
        margins=found.checks,
        closed_loop=verify(with_gains(bench, found.loops), report),
    )


def plants(bench: Bench) -> dict[str, dict[str, float]]:
    """Return the plants of the check: the bench's own, and two with uncertain values off by 20 %.

    Each is a mapping from the dotted path of a value to its factor. Viscous friction is varied
    where the law has it.
    """
    laws = [s for s in ("test", "load") if hasattr(getattr(bench.friction, s), "viscous")]
    viscous = [f"friction.{side}.viscous" for side in laws]
    masses = ["moving_mass.test", "moving_mass.load"]
    return {
        "bench": {},
        "softer": {
            "oil.bulk_modulus": 0.8,
            **dict.fromkeys(masses, 1.2),
            **dict.fromkeys(viscous, 0.8),
        },
        "stiffer": {
            "oil.bulk_modulus": 1.2,
            **dict.fromkeys(masses, 0.8),
            **dict.fromkeys(viscous, 1.2),
            "valve.gain": 1.2,
            "valve.bandwidth": 0.8,
        },
    }


def _constant(value: float) -> Callable[[float], float]:
    return lambda _: value


def with_gains(bench: Bench, loops: Sequence[Pi]) -> Bench:
    """Return the bench with other K_c and tau_c: velocity, rod and piston pressure."""
    names = ("velocity", "rod_pressure", "piston_pressure")
    for name, (gain, tau) in zip(names, loops, strict=True):
        for key, value in (("gain", gain), ("time_constant", tau)):
            path = ["controllers", name, key]
            bench = replaced(bench, path, _constant(value))
    return bench


def verify(bench: Bench, report: Report) -> tuple[Check, ...]:
    """Make the runs with the bench's gains on each of ``plants``, and check them.

    Raises ``ConfigError`` where the bench can't make the runs at all.
    """
    rules, motions = Screening(), schedule(bench)
    checks: list[Check] = []
    variants = plants(bench)
    for number, (name, factors) in enumerate(variants.items()):
        of_variant = report_of_part(report, number, len(variants), len(motions["experiments"]))
        recorded = record(bench, motions, _physics(bench, factors), of_variant)
        checks += judge(recorded, bench, rules, name)
    return tuple(checks)


def _physics(bench: Bench, factors: Mapping[str, float]) -> Plant:
    changed = scaled(bench, factors)
    return Plant.model_construct(**{key: getattr(changed, key) for key in Plant.model_fields})


def schedule(bench: Bench) -> dict[str, Any]:
    """Return the schedule of the check, in the form of a schedule file."""
    brake = bench.controllers.acceleration
    experiments = []
    for condition in conditions(bench, plant_parameters(bench))[0]:
        speed = abs(condition.v_m_s)
        while (travel := _travel(bench, speed)) is None:
            speed *= _SLOWER
        low, high = travel
        experiments.append(
            {
                "kind": "steady",
                "direction": "extend" if condition.direction > 0 else "retract",
                "p_lr": f"{condition.p_lr_pa} Pa",
                "loads": [f"{condition.f_load_n} N"],
                "velocities": [f"{speed} m/s"],
                "trials": 1,
                "travel": {"start": f"{low} m", "end": f"{high} m"},
                "acceleration": f"{brake} m/s^2",
                "hold": "0.5 s",
                "window": f"{_WINDOW_S} s",
            }
        )
    return {"name": "design", "experiments": experiments}


def _travel(bench: Bench, speed: float) -> tuple[float, float] | None:
    """Return a travel for a steady run; None where it leaves too short a window."""
    limits, brake, rules = bench.limits, bench.controllers.acceleration, Screening()
    ramp = speed**2 / (2 * brake)
    spare = _LAG_S * speed + ramp + _SPARE_M
    low, high = limits.travel_min + spare, limits.travel_max - spare
    steady = (high - low - ramp) / speed - max(rules.settle_time, rules.settle_travel / speed)
    # Below this speed the error of the plan states what is missing.
    return (low, high) if steady >= _SHORTEST_S or speed < _SLOWEST_M_S else None


def judge(recorded: ClosedLoopRuns, bench: Bench, rules: Screening, plant: str) -> Iterator[Check]:
    """Yield the checks on the runs against one plant."""
    whole, stop = sum(not run.aborted for run in recorded.runs), recorded.stopped
    ended = [run for run in recorded.runs if run.aborted]
    stop = f"{_where(ended[-1])}: {_with_limits(stop, bench)}" if ended and stop else stop
    cut = max(recorded.planned - whole, 1 if stop else 0)
    yield Check(f"{plant}: runs cut short", cut, 0, "runs", not cut, stop)
    verdicts = [screen(run, _second_half(run, rules)) for run in recorded.runs]
    rejected = [verdict for verdict in verdicts if not verdict.accepted]
    others = [verdict for verdict in rejected if not verdict.run.aborted]
    why = f"{_where(others[0].run)}: {others[0].reasons[0]}" if others else stop if rejected else ""
    yield Check(f"{plant}: rejected runs", len(rejected), 0, "runs", not rejected, why)

    rows_of_check: dict[tuple[str, str], list[tuple[float, float, str]]] = {}
    for verdict in verdicts:
        run, means = verdict.run, verdict.means
        if means is None:
            continue  # rejected, so counted above
        p_lp, p_lr, v = run.p_lp_pa, run.p_lr_pa, run.v_m_s
        assert p_lp is not None and p_lr is not None and v is not None  # the board logs them all
        v_ref, window = run.plan.v_ref_m_s, _window(run, means.t_start_s, means.t_stop_s)
        over = max(0.0, (np.sign(v_ref) * v).max() - abs(v_ref))
        off = max(
            abs(p_lr[window].mean() - run.plan.p_lr_ref_pa),
            abs(p_lp[window].mean() - run.plan.p_lp_ref_pa),
        )
        error, beyond = abs(means.v_m_s - v_ref), OVERSHOOT * bench.limits.speed_error
        for what, unit, value, limit in (
            ("mean speed error", "mm/s", 1e3 * error, 1e3 * rules.speed_limit(v_ref)),
            ("speed ripple", "mm/s", 1e3 * v[window].std(), 1e3 * rules.ripple_limit(v_ref)),
            ("overshoot", "mm/s", 1e3 * over, 1e3 * beyond),
            ("load pressure error", "bar", off / 1e5, PRESSURE_ERROR * bench.supply.pressure / 1e5),
        ):
            rows_of_check.setdefault((what, unit), []).append((float(value), limit, _where(run)))
    for (what, unit), rows in rows_of_check.items():
        value, limit, where = max(rows, key=lambda row: row[0] / row[1])
        yield Check(f"{plant}: {what}", value, limit, unit, value <= limit, where)


def _second_half(run: Run, rules: Screening) -> Screening:
    """Return the rules with the first half of the constant speed as time to settle."""
    t = run.t_s[at_reference(run)]
    half_s = float(t[-1] - t[0]) / 2 if len(t) else 0.0
    return rules.model_copy(update={"settle_time": max(rules.settle_time, half_s)})


def _window(run: Run, start_s: float, stop_s: float) -> np.ndarray:
    return (run.t_s >= start_s) & (run.t_s <= stop_s)


def _with_limits(fault: str, bench: Bench) -> str:
    """Return a fault of the board in words with the bench's limits in place of their keys."""
    limits = bench.limits
    values = {
        "travel": f"{1e3 * limits.travel_min:g} to {1e3 * limits.travel_max:g} mm",
        "pressure_max": f"{limits.pressure_max / 1e5:g} bar",
        "speed_max": f"{1e3 * limits.speed_max:g} mm/s",
        "speed_error": f"{1e3 * limits.speed_error:g} mm/s",
        "speed_error_time": f"{limits.speed_error_time:g} s",
    }
    return _LIMIT.sub(lambda found: values.get(found[1], found[0]), fault)


def _where(run: Run) -> str:
    plan = run.plan
    return f"{1e3 * plan.v_ref_m_s:+.4g} mm/s, {plan.f_load_n:.0f} N"
