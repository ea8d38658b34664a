"""Adaptive speeds: the next one from the friction measured so far (5.6.1, third suggestion).

The source would step in small steps where friction is steep, in large ones where it is flat, and
would look at the second derivative so as not to take small steps in the fully developed viscous
regime, which is steep but straight. So a step h may be as long as one of the two allows:

    |F'| h <= tolerance           friction hardly changes (to first order)
    |F''| h^2 / 8 <= tolerance    friction is a straight line (error of linear interpolation)

    h = max(tolerance / D1, sqrt(8 tolerance / D2)), within min_step..max_step

F' and F'' at the last speed are those of the parabola through the trials of the last five
references (least squares). The trials' scatter gives their standard errors, and

    D1 = |F'| + se(F'),    D2 = |F''| + se(F''),

which is about the upper limit that the trials allow. So speeds rise in small steps while noise
dominates; with each step the five references span more, se(F'') falls with the square of the span,
and steps grow until the curvature of friction limits them.

A pure function of the measured means: the same friction gives the same speeds.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hbench.config.velocities import AdaptiveSpeeds

_REFERENCES = 5  # of the parabola: two more than its coefficients
_LEAST = 3  # references


@dataclass(frozen=True)
class SpeedFriction:
    """Reference speed with the friction of its accepted trials; empty: rejected, or not made."""

    speed_m_s: float
    trials_n: tuple[float, ...]


def next_speed(rule: AdaptiveSpeeds, measured: Sequence[SpeedFriction]) -> float | None:
    """Return the speed [m/s] after the last one of ``measured``; None after ``rule.last``.

    After a reference without accepted trials the step is the smallest.
    """
    speed = measured[-1].speed_m_s
    remaining = rule.last - speed
    if remaining <= 0:
        return None
    step = _step(rule, measured) if measured[-1].trials_n else rule.min_step
    if remaining >= step + rule.min_step:
        return speed + step
    return rule.last if remaining <= rule.max_step else rule.last - rule.min_step


def _step(rule: AdaptiveSpeeds, measured: Sequence[SpeedFriction]) -> float:
    slope, curvature = _steepest(measured)
    longest = max(
        rule.tolerance / slope if slope else np.inf,
        np.sqrt(8 * rule.tolerance / curvature) if curvature else np.inf,
    )
    return float(np.clip(longest, rule.min_step, rule.max_step))


def _steepest(measured: Sequence[SpeedFriction]) -> tuple[float, float]:
    """Return D1 [N s/m] and D2 [N s^2/m^2] at the last speed; inf with too few trials."""
    last = [point for point in measured if point.trials_n][-_REFERENCES:]
    trials = [np.array(point.trials_n) for point in last]
    n = np.array([len(values) for values in trials])
    dof = np.sum(n - 1)
    if len(last) < _LEAST or dof == 0:
        return np.inf, np.inf
    variance = sum(np.sum((values - values.mean()) ** 2) for values in trials) / dof
    v = np.array([point.speed_m_s for point in last]) - last[-1].speed_m_s
    weight = np.sqrt(n)  # of a mean of n trials
    inverse = np.linalg.pinv(weight[:, None] * np.vander(v, 3, increasing=True))
    parabola = inverse @ (weight * [values.mean() for values in trials])
    se = np.sqrt(variance * np.sum(inverse**2, axis=1))
    upper = np.abs(parabola) + se
    return float(upper[1]), float(2 * upper[2])
