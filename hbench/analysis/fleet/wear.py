"""Wear: a cylinder's friction over its travelled distance and its friction work.

Distance and work are cumulated over the cylinder's campaigns in the order of their dates, up to the
middle of each. A straight line by least squares has Student's interval for n - 2 degrees of
freedom; p values are corrected after Holm for the number of lines.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.analysis.statistics.holm import holm
from hbench.analysis.statistics.line import straight_line
from hbench.records import Quantity, Side, WearTrend

FEWEST = 4  # campaigns of a cylinder
WEARING = ("friction_n", "breakaway_n", "half_band_n")  # quantities that wear may change
_LISTED = 20  # trends


def cumulated(amount: np.ndarray, cylinders: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the sums (n,) of each cylinder's ``amount`` (n,) up to the middle of a campaign.

    In the order of the times ``at`` (n,); NaN after a campaign whose amount is not known.
    """
    total = np.full(len(amount), np.nan)
    for rows in _of_each_cylinder(np.lexsort((at, cylinders)), cylinders):
        total[rows] = np.cumsum(amount[rows]) - amount[rows] / 2
    return total


def _of_each_cylinder(order: np.ndarray, cylinders: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the rows of each cylinder with enough campaigns; ``order`` (n,) sorts by cylinder."""
    starts = 1 + np.flatnonzero(np.diff(cylinders[order]))
    ends = np.append(starts, len(order))
    starts = np.insert(starts, 0, 0)
    for i in np.flatnonzero(ends - starts >= FEWEST):
        yield order[starts[i] : ends[i]]


def wear_trends(
    quantity: Quantity,
    direction: Side,
    x: np.ndarray,
    over: dict[Literal["distance_m", "friction_work_j"], np.ndarray],
    cylinders: np.ndarray,
    names: Sequence[str],
) -> Iterator[WearTrend]:
    """Yield the lines of x (n,) over each cumulated amount (n,), without Holm's correction.

    ``cylinders`` (n,) are positions in ``names``.
    """
    for rows in _of_each_cylinder(np.argsort(cylinders, kind="stable"), cylinders):
        for amount, sums in over.items():
            used = rows[np.isfinite(sums[rows]) & np.isfinite(x[rows])]
            if len(used) < FEWEST:
                continue
            if not is_constant(sums[used]) and not is_constant(x[used]):
                used = used[np.argsort(sums[used])]
                name = names[cylinders[used[0]]]
                yield _trend(quantity, direction, name, amount, sums[used], x[used])


def corrected(trends: Sequence[WearTrend]) -> tuple[WearTrend, ...]:
    """Return the trends with p values after Holm, the most significant ones."""
    with_p = zip(trends, holm([trend.p for trend in trends]).tolist(), strict=True)
    found = [replace(trend, p_holm=p) for trend, p in with_p]
    return tuple(sorted(found, key=lambda trend: trend.p)[:_LISTED])


def _trend(
    quantity: Quantity,
    direction: Side,
    specimen: str,
    over: Literal["distance_m", "friction_work_j"],
    t: np.ndarray,
    x: np.ndarray,
) -> WearTrend:
    line = straight_line(t, x)
    return WearTrend(
        quantity=quantity,
        direction=direction,
        specimen=specimen,
        over=over,
        x=tuple(t.tolist()),
        values=tuple(x.tolist()),
        slope=line.slope,
        low=line.slope - line.half,
        high=line.slope + line.half,
        intercept=line.intercept,
        p=line.p,
        p_holm=line.p,
    )
