"""Control charts for individual values: moving ranges, EWMA, patterns, and a step of the mean.

    sigma = mean |x_i - x_(i-1)| / 1.128,   limits x_mean ± 3 sigma,   moving range to 3.267 MR_mean

(ISO 7870-2; Montgomery, Introduction to Statistical Quality Control, section 6.4; d_2 = 1.128 and
D_4 = 3.267 for two values). The rules are those of ``run_rules``; ``ewma`` and ``change_point`` use
the same centre and sigma, which are estimated from the charted values: their false alarms are more
frequent than with known ones. Where the mean has a significant step, they are estimated from the
values before it: limits of all values would assume a constant mean.

Where several cylinders were measured three times or more, the chart shows the measurement, not the
cylinders: the deviation from the mean of the cylinder's n campaigns, times sqrt(n / (n - 1)), which
has the variance of a single campaign, plus the mean of all (a chart of deviations from nominal,
Montgomery, section 10.2).
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from hbench.analysis.fleet.change_point import StepChange, change_point
from hbench.analysis.fleet.ewma import WEIGHT, WIDTH, ewma
from hbench.analysis.fleet.run_rules import run_rules
from hbench.analysis.statistics.holm import holm
from hbench.records import (
    FEWEST_CAMPAIGNS,
    ChartSignal,
    ChartStep,
    ControlChart,
    Quantity,
    Side,
)

_D2, _D4 = 1.128, 3.267
_OFTEN = 3  # campaigns of a cylinder
_DRAWN = 150  # the last campaigns
_NAMED = 3  # campaigns outside of the limits
EWMA_RULE = f"EWMA, λ = {WEIGHT:g}, L = {WIDTH:g}"


class Charted(NamedTuple):
    """A number of the campaigns over their dates.

    ``cylinders`` (n,) are numbers, -1 if not known. ``names`` returns the names of campaigns by
    their positions in x.
    """

    quantity: Quantity
    direction: Side
    at: np.ndarray  # (n,) days
    x: np.ndarray  # (n,)
    cylinders: np.ndarray  # (n,) int
    names: Callable[[np.ndarray], list[str]]


class _Ordered(NamedTuple):
    """Values in the order of their dates, with the most likely step of their mean."""

    values: np.ndarray  # (k,)
    rows: np.ndarray  # (k,) positions in the number's x
    of_cylinders: bool
    step: StepChange | None


def control_charts(numbers: Iterable[Charted]) -> tuple[ControlChart, ...]:
    """Return a chart of each number that has enough campaigns.

    Mean and sigma are those of the campaigns before a significant step of the mean, or of all.
    The p values of the steps are corrected for the number of charts after Holm.
    """
    ordered = [(each, _ordered(each)) for each in numbers if len(each.x) >= FEWEST_CAMPAIGNS]
    steps = [values.step for _, values in ordered if values.step is not None]
    p_holm = iter(holm([step.p for step in steps]).tolist() if steps else ())
    return tuple(
        _chart(each, values, None if values.step is None else next(p_holm))
        for each, values in ordered
    )


def _ordered(number: Charted) -> _Ordered:
    values, rows = _within_cylinders(number.x, number.cylinders)
    several = len(np.unique(number.cylinders)) > 1
    of_cylinders = len(values) >= FEWEST_CAMPAIGNS and several
    if not of_cylinders:
        values, rows = number.x, np.arange(len(number.x))
    order = np.argsort(number.at[rows], kind="stable")
    values, rows = values[order], rows[order]
    return _Ordered(values, rows, of_cylinders, change_point(values))


def _chart(number: Charted, ordered: _Ordered, p_holm: float | None) -> ControlChart:
    values, rows, of_cylinders, found = ordered
    at, names = number.at, number.names
    step = None
    if found is not None and p_holm is not None:
        first = rows[found.first : found.first + 1]
        means = found.before, found.after, found.ci95
        step = ChartStep(names(first)[0], float(at[first[0]]), *means, found.p, p_holm)
    real = found is not None and step is not None and step.real
    of = values[: found.first] if found is not None and real else values
    centre, sigma = centre_and_sigma(of)
    outside = np.flatnonzero(np.abs(values - centre) > 3 * sigma)
    averages = ewma(values, centre, sigma)
    signals: dict[str, np.ndarray] = {}
    if sigma > 0:
        signals = run_rules((values - centre) / sigma) | {EWMA_RULE: averages.signals}
    last = slice(-_DRAWN, None)
    return ControlChart(
        quantity=number.quantity,
        direction=number.direction,
        n=len(values),
        n_limits=len(of),
        centre=centre,
        sigma=sigma,
        of_cylinders=of_cylinders,
        at=tuple(at[rows][last].tolist()),
        values=tuple(values[last].tolist()),
        names=tuple(names(rows[last])),
        outside=tuple(names(rows[outside[:_NAMED]])),
        beyond=len(outside),
        moved=int((np.abs(np.diff(values)) > _D4 * _D2 * sigma).sum()),
        ewma=tuple(averages.values[last].tolist()),
        ewma_low=tuple(averages.low[last].tolist()),
        ewma_high=tuple(averages.high[last].tolist()),
        signals=tuple(
            ChartSignal(rule, int(found.sum()), tuple(names(rows[np.flatnonzero(found)[:_NAMED]])))
            for rule, found in signals.items()
            if found.any()
        ),
        step=step,
    )


def centre_and_sigma(values: np.ndarray) -> tuple[float, float]:
    """Return the mean of values (n,) in their order, and sigma from their moving ranges."""
    return float(np.mean(values)), float(np.abs(np.diff(values)).mean()) / _D2


def _within_cylinders(x: np.ndarray, cylinders: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the scaled deviations (k,) of cylinders measured often, and their rows."""
    _, inverse, counts = np.unique(cylinders, return_inverse=True, return_counts=True)
    means = np.bincount(inverse, x) / counts
    rows = np.flatnonzero((counts[inverse] >= _OFTEN) & (cylinders >= 0))
    if not len(rows):
        return x[:0], rows
    n = counts[inverse[rows]]
    return x[rows].mean() + np.sqrt(n / (n - 1)) * (x[rows] - means[inverse[rows]]), rows
