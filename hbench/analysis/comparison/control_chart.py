"""Control charts for individual values: moving ranges, EWMA, patterns, and a step of the mean.

    sigma = mean |x_i - x_(i-1)| / 1.128,   limits x_mean ± 3 sigma,   moving range to 3.267 MR_mean

(ISO 7870-2; Montgomery, Introduction to Statistical Quality Control, section 6.4; d_2 = 1.128 and
D_4 = 3.267 for two values). The rules are those of ``run_rules``; ``ewma`` and ``change_point`` use
the same centre and sigma, which are estimated from the charted values: their false alarms are more
frequent than with known ones.

Where several cylinders were measured three times or more, the chart shows the measurement, not the
cylinders: the deviation from the mean of the cylinder's n campaigns, times sqrt(n / (n - 1)), which
has the variance of a single campaign, plus the mean of all (a chart of deviations from nominal,
Montgomery, section 10.2).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.comparison.change_point import change_point
from hbench.analysis.comparison.ewma import WEIGHT, WIDTH, ewma
from hbench.analysis.comparison.run_rules import run_rules
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


def control_chart(
    quantity: Quantity,
    direction: Side,
    at: np.ndarray,
    x: np.ndarray,
    cylinders: np.ndarray,
    names: Callable[[np.ndarray], list[str]],
) -> ControlChart | None:
    """Return the chart of x (n,) over the days ``at`` (n,); None with too few campaigns.

    ``cylinders`` (n,) are numbers, -1 if not known. ``names`` returns the names of campaigns by
    their positions in x.
    """
    if len(x) < FEWEST_CAMPAIGNS:
        return None
    values, rows = _within_cylinders(x, cylinders)
    of_cylinders = len(values) >= FEWEST_CAMPAIGNS and len(np.unique(cylinders)) > 1
    if not of_cylinders:
        values, rows = x, np.arange(len(x))
    order = np.argsort(at[rows], kind="stable")
    values, rows = values[order], rows[order]
    ranges = np.abs(np.diff(values))
    centre, sigma = centre_and_sigma(values)
    outside = np.flatnonzero(np.abs(values - centre) > 3 * sigma)
    averages = ewma(values, centre, sigma)
    signals: dict[str, np.ndarray] = {}
    if sigma > 0:
        signals = run_rules((values - centre) / sigma) | {EWMA_RULE: averages.signals}
    step = change_point(values)
    last = slice(-_DRAWN, None)
    return ControlChart(
        quantity=quantity,
        direction=direction,
        n=len(values),
        centre=centre,
        sigma=sigma,
        of_cylinders=of_cylinders,
        at=tuple(at[rows][last].tolist()),
        values=tuple(values[last].tolist()),
        names=tuple(names(rows[last])),
        outside=tuple(names(rows[outside[:_NAMED]])),
        beyond=len(outside),
        moved=int((ranges > _D4 * ranges.mean()).sum()),
        ewma=tuple(averages.values[last].tolist()),
        ewma_low=tuple(averages.low[last].tolist()),
        ewma_high=tuple(averages.high[last].tolist()),
        signals=tuple(
            ChartSignal(rule, int(found.sum()), tuple(names(rows[np.flatnonzero(found)[:_NAMED]])))
            for rule, found in signals.items()
            if found.any()
        ),
        step=None
        if step is None
        else ChartStep(
            names(rows[step.first : step.first + 1])[0],
            float(at[rows[step.first]]),
            step.before,
            step.after,
            step.ci95,
            step.p,
            step.p,
        ),
    )


def centre_and_sigma(values: np.ndarray) -> tuple[float, float]:
    """Return the mean of values (n,) in their order, and sigma from their moving ranges."""
    return float(np.mean(values)), float(np.abs(np.diff(values)).mean()) / _D2


def with_corrected_steps(charts: Sequence[ControlChart]) -> tuple[ControlChart, ...]:
    """Return the charts with the p values of their steps after Holm."""
    steps = [chart.step for chart in charts if chart.step is not None]
    corrected = iter(holm([step.p for step in steps]).tolist() if steps else ())
    return tuple(
        chart
        if chart.step is None
        else replace(chart, step=replace(chart.step, p_holm=next(corrected)))
        for chart in charts
    )


def _within_cylinders(x: np.ndarray, cylinders: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the scaled deviations (k,) of cylinders measured often, and their rows."""
    _, inverse, counts = np.unique(cylinders, return_inverse=True, return_counts=True)
    means = np.bincount(inverse, x) / counts
    rows = np.flatnonzero((counts[inverse] >= _OFTEN) & (cylinders >= 0))
    if not len(rows):
        return x[:0], rows
    n = counts[inverse[rows]]
    return x[rows].mean() + np.sqrt(n / (n - 1)) * (x[rows] - means[inverse[rows]]), rows
