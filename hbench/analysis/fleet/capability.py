"""Capability of a fleet against limits (ISO 22514-2 for normal values; interval after Bissell).

    Ppk = min(T_U - mean, mean - T_L) / (3 s)
    Cpk = min(T_U - mean, mean - T_L) / (3 s_w),    s_w = mean moving range / 1.128
    95 % interval: P -+ 1.96 sqrt(1 / (9 n) + P^2 / (2 nu))    (Bissell 1990)

s is the standard deviation of all campaigns' numbers, with nu = n - 1; s_w that from one campaign
to the next in the order of their dates, with nu = 0.605 (n - 1), by the efficiency of the mean
moving range. Steps and drifts increase s, and hardly s_w. The scatter of the measurement counts in
both. A limit of all loads at the working speed applies to the numbers of the fleet's table. The
values of every other limit are those that ``hbench accept`` measured in each campaign.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.conformity.series import Series, checks_by_series
from hbench.analysis.fleet.control_chart import centre_and_sigma
from hbench.records import FEWEST_CAMPAIGNS, QUANTITIES, Estimate, Quantity, Side
from hbench.records.conformity.acceptance import ConformityCheck, Measurement, Requirement
from hbench.records.fleet.process_control import Capability
from hbench.records.numbers import NORMAL_95

_QUANTITIES = {"friction": "friction_n", "breakaway": "breakaway_n", "efficiency": "efficiency"}
_NEAR = 0.2  # relative distance from the working speed
_EFFICIENCY = 0.605  # of the mean moving range, in degrees of freedom per campaign

Values = Callable[[Quantity, Side], np.ndarray]  # (n,) over the compared campaigns, in order
Decided = Sequence[Sequence[ConformityCheck]]  # of the compared campaigns


def capabilities(
    values: Values,
    decided: Decided,
    requirements: Iterable[Requirement],
    v_m_s: float | None,
    by_date: bool = True,
) -> Iterator[Capability]:
    """Yield the capability of each requirement, in each of its series.

    ``values`` are those of the fleet's table, means over the loads at the working speed ``v_m_s``;
    ``decided`` are the checks of the campaigns' acceptances. Both are in the order of the dates if
    ``by_date``; otherwise there is no Cpk. At least ``FEWEST_CAMPAIGNS`` campaigns are needed.
    """
    by_name = {quantity.name: quantity for quantity in QUANTITIES}
    for requirement in requirements:
        if _reason(requirement, v_m_s):
            yield from _of_decisions(decided, requirement, by_date)
            continue
        quantity = by_name[_QUANTITIES[requirement.quantity]]
        for side in quantity.sides:
            if requirement.direction in (None, side):
                series = Measurement(math.nan, None, direction=side, v_m_s=v_m_s)
                yield from _capability(requirement, series, values(quantity, side), by_date)


def without_capability(
    decided: Decided, requirements: Iterable[Requirement], v_m_s: float | None, campaigns: int
) -> Iterator[tuple[Requirement, str]]:
    """Yield each requirement that has no capability, and the reason; see ``capabilities``."""
    for requirement in requirements:
        reason = _reason(requirement, v_m_s)
        if campaigns < FEWEST_CAMPAIGNS:
            reason = f"at least {FEWEST_CAMPAIGNS} campaigns of a kind are needed"
        elif reason:
            n = max(map(len, _by_series(decided, requirement).values()), default=0)
            reason += (
                f"; hbench accept measures what it limits, and Ppk needs {FEWEST_CAMPAIGNS} "
                f"campaigns decided by it ({n} so far)"
            )
            reason = "" if n >= FEWEST_CAMPAIGNS else reason
        if reason:
            yield requirement, reason


def _of_decisions(
    decided: Decided, requirement: Requirement, by_date: bool
) -> Iterator[Capability]:
    for checks in _by_series(decided, requirement).values():
        x = np.array([check.value for check in checks])
        yield from _capability(requirement, replace(checks[-1], u95=None, dof=None), x, by_date)


def _by_series(decided: Decided, requirement: Requirement) -> dict[Series, list[Measurement]]:
    """Return what was measured for a requirement, by series, over the campaigns."""
    found: dict[Series, list[Measurement]] = {}
    for checks in decided:
        same = [check for check in checks if check.requirement == requirement]
        for series, check in checks_by_series(same).items():
            if check.measurement is not None:
                found.setdefault(series, []).append(check.measurement)
    return found


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
    requirement: Requirement, series: Measurement, x: np.ndarray, by_date: bool
) -> Iterator[Capability]:
    """Yield the capability of values (n,), if they suffice."""
    if len(x) < FEWEST_CAMPAIGNS or np.ptp(x) == 0:
        return
    mean, s, n = float(x.mean()), float(x.std(ddof=1)), len(x)
    low, high = requirement.low, requirement.high
    margins = [mean - low] if low is not None else []
    margins += [high - mean] if high is not None else []
    within = centre_and_sigma(x)[1] if by_date else None
    outside = (x < (-np.inf if low is None else low)) | (x > (np.inf if high is None else high))
    yield Capability(
        requirement=requirement,
        series=replace(series, value=mean),
        n=n,
        sigma=s,
        ppk=_index(min(margins) / (3 * s), n, n - 1),
        sigma_within=within,
        cpk=_index(min(margins) / (3 * within), n, _EFFICIENCY * (n - 1)) if within else None,
        outside=int(outside.sum()),
    )


def _index(index: float, n: int, dof: float) -> Estimate:
    """Return an index of ``n`` values, whose standard deviation has ``dof`` degrees of freedom."""
    half = NORMAL_95 * math.sqrt(1 / (9 * n) + index**2 / (2 * dof))
    return Estimate(index, index - half, index + half)
