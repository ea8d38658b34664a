"""References of an experiment, each with the velocity profile that the board plays."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hbench.config.bench import Bench
from hbench.config.experiments import (
    Breakaway,
    Check,
    ExperimentBase,
    HeldExperiment,
    Hold,
    Ramp,
    Steady,
    Steps,
    Travel,
    Triangle,
    Verification,
)
from hbench.config.schedule import Screening
from hbench.config.velocities import AdaptiveSpeeds
from hbench.errors import ConfigError
from hbench.experiment.fixed_speeds import speeds
from hbench.records import KINDS, SIGNS, LevelReference, Motion, Segment

_TIME_MARGIN = 1.05  # of a segment that ends at a position, over its ideal time


@dataclass(frozen=True)
class Reference:
    """Reference of the runs of one operating point: top velocity, acceleration and motion."""

    v_ref_m_s: float  # signed; the profile's largest in magnitude
    a_ref_m_s2: float | None
    motion: Motion
    level: LevelReference | None = None


@dataclass(frozen=True)
class IdealPath:
    """Path of a piston that follows the reference exactly, final braking included."""

    seconds: float
    x_low_m: float
    x_high_m: float
    x_end_m: float


def references(
    experiment: ExperimentBase, screening: Screening, bench: Bench, key: str
) -> tuple[Reference, ...]:
    """Return the references of an experiment in order; its velocities must not be adaptive.

    Raises ``ConfigError`` naming ``key`` for a reference that can't be made.
    """
    return tuple(PROFILES[KINDS[experiment.kind].profile](experiment, screening, bench, key))


def ideal_path(motion: Motion, brake_m_s2: float) -> IdealPath:
    """Return the path of a piston that follows the reference exactly."""
    x, v, seconds, turns = motion.x_start_m, 0.0, 0.0, [motion.x_start_m]
    for segment in motion.segments * motion.cycles:
        end = motion.x_max_m if segment.v_m_s > 0 else motion.x_min_m
        for a, duration in _pieces(v, segment):
            until_end = _time_to(end - x, v, a, segment.v_m_s)
            duration = min(duration, until_end)
            if a and 0 < -v / a < duration:
                turns.append(x - v**2 / (2 * a))
            x += v * duration + 0.5 * a * duration**2
            v += a * duration
            seconds += duration
            turns.append(x)
            if duration == until_end:
                break
    x += v * abs(v) / (2 * brake_m_s2)
    return IdealPath(seconds, min(*turns, x), max(*turns, x), x)


def _pieces(v: float, segment: Segment) -> Iterator[tuple[float, float]]:
    """Yield acceleration and duration of a segment's two parts: accelerating, then constant."""
    if segment.closed or segment.vented or segment.force_rate_n_s:
        yield 0.0, segment.duration_s
        return
    slope = min(abs(segment.v_m_s - v) / segment.a_m_s2, segment.duration_s)
    if slope > 0:
        yield float(np.copysign(segment.a_m_s2, segment.v_m_s - v)), slope
    yield 0.0, segment.duration_s - slope


def _time_to(distance: float, v: float, a: float, target: float) -> float:
    """Return when the piston passes the travel end in the direction of ``target``; inf if never."""
    if target == 0.0:
        return np.inf
    sign = np.copysign(1.0, target)
    distance, v, a = sign * distance, sign * v, sign * a
    if v > 0.0 and distance <= 0.0:
        return 0.0
    squared = v**2 + 2 * a * distance  # of the speed there
    if v > 0.0:
        return 2 * distance / (v + np.sqrt(squared)) if squared >= 0.0 else np.inf
    if a <= 0.0:
        return np.inf
    # The piston turns first; if it turns beyond the end, it passes the end there.
    return (-v + np.sqrt(max(squared, 0.0))) / a


def _steady(
    experiment: Steady, screening: Screening, bench: Bench, key: str
) -> Iterator[Reference]:
    assert not isinstance(experiment.velocities, AdaptiveSpeeds)  # planned during the campaign
    for speed in speeds(experiment.velocities):
        yield steady_reference(experiment, float(speed), screening, bench, key)


def steady_reference(
    experiment: Steady, speed: float, screening: Screening, bench: Bench, key: str
) -> Reference:
    """Return the reference at one speed [m/s]. Raises ``ConfigError`` without a steady window."""
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
    segment = Segment(_signed(experiment, speed), a, ramp_s + settle_s + window_s)
    return _one_way(experiment, segment)


def _ramp(experiment: Ramp, screening: Screening, bench: Bench, key: str) -> Iterator[Reference]:
    for a in experiment.accelerations:
        speed = experiment.speed
        yield _one_way(experiment, Segment(_signed(experiment, speed), a, speed / a))


def _signed(experiment: Steady | Ramp, speed: float) -> float:
    return SIGNS[experiment.direction] * speed


def _one_way(experiment: Steady | Ramp, segment: Segment) -> Reference:
    motion = _motion(experiment, experiment.travel, (segment,))
    return Reference(segment.v_m_s, segment.a_m_s2, motion)


def _triangle(
    experiment: Triangle, screening: Screening, bench: Bench, key: str
) -> Iterator[Reference]:
    v, travel = experiment.speed, experiment.travel
    a = v**2 / (travel.end - travel.start)
    # Segments end at the middle of the travel, so that nothing drifts; times only bound them.
    cycle = (
        Segment(v, a, _TIME_MARGIN * v / a),
        Segment(-v, a, 2 * _TIME_MARGIN * v / a),
        Segment(0.0, a, v / a),
    )
    until = experiment.until
    ending: dict[str, Any] = {"until": until.quantity, "within": until.within} if until else {}
    middle = 0.5 * (travel.start + travel.end)
    motion = Motion(
        travel.start, middle, middle, experiment.hold, cycle, cycles=experiment.cycles, **ending
    )
    yield Reference(v, a, motion)


def _steps(experiment: Steps, screening: Screening, bench: Bench, key: str) -> Iterator[Reference]:
    a = experiment.acceleration
    row = tuple(Segment(level, a, experiment.dwell) for level in experiment.levels)
    yield Reference(_largest(row), a, _motion(experiment, experiment.travel, row))


def _verification(
    experiment: Verification, screening: Screening, bench: Bench, key: str
) -> Iterator[Reference]:
    row = tuple(Segment(s.velocity, s.acceleration, s.duration) for s in experiment.profile)
    yield Reference(_largest(row), None, _motion(experiment, experiment.travel, row))


def _hold(experiment: Hold, screening: Screening, bench: Bench, key: str) -> Iterator[Reference]:
    is_closed = KINDS[experiment.kind].is_at_rest
    closed = Segment(0.0, bench.controllers.acceleration, experiment.duration, closed=is_closed)
    for x in experiment.positions:
        yield Reference(0.0, None, Motion(x, x, x, experiment.hold, (closed,)))


def _breakaway(
    experiment: Breakaway, screening: Screening, bench: Bench, key: str
) -> Iterator[Reference]:
    x, sign = experiment.position, SIGNS[experiment.direction]
    push = Segment(
        0.0,
        bench.controllers.acceleration,
        experiment.rise / experiment.rate,
        force_rate_n_s=sign * experiment.rate,
        displacement_m=experiment.displacement,
    )
    for dwell in experiment.dwells:
        yield Reference(0.0, None, Motion(x, x, x, dwell, (push,)))


def _check(experiment: Check, screening: Screening, bench: Bench, key: str) -> Iterator[Reference]:
    limits, a = bench.limits, bench.controllers.acceleration
    middle = 0.5 * (limits.travel_min + limits.travel_max)  # the piston stays where it is
    vent = Segment(0.0, a, experiment.vent, vented=True)
    closed = Segment(0.0, a, experiment.duration, closed=True)
    pressure = bench.supply.tank if experiment.pressure is None else experiment.pressure
    free = experiment.load_cell == "free"
    level = LevelReference(pressure, experiment.uncertainty, free)
    yield Reference(0.0, None, Motion(middle, middle, middle, 0.0, (vent, closed)), level)


def _largest(row: tuple[Segment, ...]) -> float:
    return max((segment.v_m_s for segment in row), key=abs)


def _motion(
    experiment: HeldExperiment, travel: Travel, row: tuple[Segment, ...], **ending: Any
) -> Motion:
    """Return a motion that starts at the end of the travel from which the first segment leads."""
    first = next((segment.v_m_s for segment in row if segment.v_m_s), 1.0)
    x_start = travel.start if first > 0 else travel.end
    return Motion(x_start, travel.start, travel.end, experiment.hold, row, **ending)


PROFILES: Mapping[str, Callable[..., Iterator[Reference]]] = {
    "constant_speed": _steady,
    "acceleration_ramp": _ramp,
    "triangle": _triangle,
    "velocity_steps": _steps,
    "stretches": _verification,
    "at_rest": _hold,
    "force_ramp": _breakaway,
    "levelled": _check,
}
