"""Capability of a fleet against limits (ISO 22514-2 for normal values; interval after Bissell).

    Cpk = min(T_U - mean, mean - T_L) / (3 s)
    its 95 % interval: Cpk -+ 1.96 sqrt(1 / (9 n) + Cpk^2 / (2 (n - 1)))    (Bissell 1990)

s is the standard deviation of the campaigns' numbers, so that the scatter of the measurement counts
as well.
"""

import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from hbench.analysis.comparison.population import FEWEST
from hbench.records import QUANTITIES, Estimate, Quantity, Side
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
    or other speed, and those in bar, have none. At least ``FEWEST`` campaigns are needed.
    """
    by_name = {quantity.name: quantity for quantity in QUANTITIES}
    for requirement in requirements:
        name = _QUANTITIES.get(requirement.quantity)
        if name is None or not _of_all(requirement, v_m_s):
            continue
        quantity = by_name[name]
        for side in quantity.sides:
            if requirement.direction not in (None, side):
                continue
            x = values(quantity, side)
            if len(x) >= FEWEST and np.ptp(x) > 0:
                yield _capability(quantity, side, x, requirement)


def _of_all(requirement: Requirement, v_m_s: float | None) -> bool:
    speed = requirement.v_m_s
    return (
        requirement.label is None
        and requirement.f_load_n is None
        and not requirement.is_pressure
        and (speed is None or (v_m_s is not None and abs(speed - v_m_s) <= _NEAR * v_m_s))
    )


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
