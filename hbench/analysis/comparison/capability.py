"""Capability of a fleet against limits (ISO 22514-2 for normal values; interval after Bissell).

    Cpk = min(T_U - mean, mean - T_L) / (3 s)
    its 95 % interval: Cpk -+ 1.96 sqrt(1 / (9 n) + Cpk^2 / (2 (n - 1)))    (Bissell 1990)

s is the standard deviation of the campaigns' numbers, so that the scatter of the measurement counts
as well.
"""

import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from hbench.records import FEWEST_CAMPAIGNS, QUANTITIES, Estimate, Quantity, Side
from hbench.records.conformity.acceptance import Requirement
from hbench.records.fleet import Capability
from hbench.records.numbers import NORMAL_95

_QUANTITIES = {"friction": "friction_n", "breakaway": "breakaway_n", "efficiency": "efficiency"}
_NEAR = 0.2  # relative distance from the working speed

Values = Callable[[Quantity, Side], np.ndarray]  # (n,) over the compared campaigns


def capabilities(
    values: Values, requirements: Iterable[Requirement], v_m_s: float | None
) -> Iterator[Capability]:
    """Yield the capability of each required number that the fleet's table has.

    These are means over the loads at the working speed ``v_m_s``: requirements of one load, label
    or other speed, and those in bar, have none. At least ``FEWEST_CAMPAIGNS`` campaigns are needed.
    """
    by_name = {quantity.name: quantity for quantity in QUANTITIES}
    for requirement in requirements:
        if _reason(requirement, v_m_s):
            continue
        quantity = by_name[_QUANTITIES[requirement.quantity]]
        for side in quantity.sides:
            if requirement.direction not in (None, side):
                continue
            x = values(quantity, side)
            if len(x) >= FEWEST_CAMPAIGNS and np.ptp(x) > 0:
                yield _capability(quantity, side, x, requirement)


def without_capability(
    requirements: Iterable[Requirement], v_m_s: float | None, campaigns: int
) -> Iterator[tuple[str, str]]:
    """Yield name and reason of each requirement that has no capability; see ``capabilities``."""
    few = ""
    if campaigns < FEWEST_CAMPAIGNS:
        few = f"at least {FEWEST_CAMPAIGNS} campaigns of a kind are needed"
    for requirement in requirements:
        if reason := _reason(requirement, v_m_s) or few:
            yield requirement.name or requirement.quantity, reason


def _reason(requirement: Requirement, v_m_s: float | None) -> str:
    """Return why a requirement is of no number of the table; empty: it is of one."""
    speed = requirement.v_m_s
    if requirement.quantity not in _QUANTITIES:
        return "the fleet's table does not have this quantity"
    if requirement.label is not None:
        return "it applies to one series, whereas the numbers are means over all"
    if requirement.f_load_n is not None:
        return "it applies to one load, whereas the numbers are means over the loads"
    if requirement.is_pressure:
        return "it is in bar, whereas the numbers are forces"
    if speed is not None and (v_m_s is None or abs(speed - v_m_s) > _NEAR * v_m_s):
        return f"it applies to {1e3 * speed:.3g} mm/s; choose this speed with --speed"
    return ""


def _capability(
    quantity: Quantity, side: Side, x: np.ndarray, requirement: Requirement
) -> Capability:
    mean, s, n = float(x.mean()), float(x.std(ddof=1)), len(x)
    low, high = requirement.low, requirement.high
    margins = [mean - low] if low is not None else []
    margins += [high - mean] if high is not None else []
    cpk = min(margins) / (3 * s)
    half = NORMAL_95 * math.sqrt(1 / (9 * n) + cpk**2 / (2 * (n - 1)))
    outside = (x < (-np.inf if low is None else low)) | (x > (np.inf if high is None else high))
    return Capability(
        quantity=quantity,
        direction=side,
        n=n,
        low=low,
        high=high,
        mean=mean,
        sigma=s,
        cpk=Estimate(cpk, cpk - half, cpk + half),
        outside=int(outside.sum()),
    )
