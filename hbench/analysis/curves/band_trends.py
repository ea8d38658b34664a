"""Dependence of friction bands on chamber pressure: straight lines of half band and middle.

    y_i = a + b p_i + d_i       y_i the mean of the trials at pressure i = 1 ... m

by least squares with equal weights. The half-width of the 95 % interval of a and of b is the root
sum of squares of two:

    pressures   from the residuals, s^2 = sum d_i^2 / (m - 2)             m - 2 degrees of freedom
    trials      from the n lines through each trial's own values          n - 1

The residuals contain what differs from one pressure to the next: curvature, and a set-up that is
made once at each pressure, which the strokes of a file repeat without change. The lines of the
trials contain what a trial has at all pressures alike, such as a seal mounted anew: it shifts or
turns the line and leaves no residual. Scatter of single values is in both. In simulated bands both
together contained the slope in 95 to 99.7 %, either alone in as few as 4 % where the other source
dominates.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from hbench.analysis.rounding import distinct
from hbench.analysis.statistics.student import degrees_of_freedom, student_factor
from hbench.records import Band, BandTrend, PressureLine

FEWEST = 3  # pressures of a line


def band_trends(bands: Iterable[Band]) -> tuple[BandTrend, ...]:
    """Return the trend of each series of bands with at least three pressures."""
    trends = []
    for series in band_series(bands):
        known = [(band.p_tp_pa, band) for band in series if band.p_tp_pa is not None]
        known.sort(key=lambda pair: pair[0])
        if len(distinct(np.array([p for p, _ in known]))) >= FEWEST:
            trends.append(_trend([band for _, band in known], np.array([p for p, _ in known])))
    return tuple(trends)


def band_series(bands: Iterable[Band]) -> tuple[list[Band], ...]:
    """Return the bands of each series, in their order.

    Bands of a series have the same kind, label, cylinder and rod-side pressure. Where a load has
    bands at two speeds, slow and fast ones are a series each.
    """
    bands = tuple(bands)
    speeds: dict[tuple, list[float]] = defaultdict(list)
    for band in bands:
        speeds[*_key(band), band.f_load_n].append(band.v_m_s)
    series: dict[tuple, list[Band]] = defaultdict(list)
    for band in bands:
        rank = sorted(speeds[*_key(band), band.f_load_n]).index(band.v_m_s)
        series[*_key(band), rank].append(band)
    return tuple(series.values())


def weights(pressures_pa: np.ndarray) -> np.ndarray:
    """Return the weights (m,) [1/Pa] of values at pressures (m,) in the slope of their line."""
    p = pressures_pa - pressures_pa.mean()
    return p / (p @ p)


def _key(band: Band) -> tuple:
    return band.kind, band.label, band.specimen, band.p_lr_ref_pa


def _trend(bands: Sequence[Band], pressures_pa: np.ndarray) -> BandTrend:
    halves = [dict(zip(b.trials, b.trials_half_n, strict=True)) for b in bands]
    middles = [dict(zip(b.trials, b.trials_middle_n, strict=True)) for b in bands]
    first = bands[0]
    return BandTrend(
        kind=first.kind,
        label=first.label,
        specimen=first.specimen,
        p_lr_ref_pa=first.p_lr_ref_pa,
        pressures_pa=tuple(pressures_pa.tolist()),
        bands=tuple(bands),
        half=pressure_line(pressures_pa, [band.half_n for band in bands], halves),
        middle=pressure_line(pressures_pa, [band.middle_n for band in bands], middles),
    )


def pressure_line(
    p_pa: np.ndarray, means_n: Sequence[float], trials_n: Sequence[dict[int, float]]
) -> PressureLine:
    """Return the line through the means (m,) over pressure (m,), m >= 3.

    ``trials_n`` (m,) are the values of each pressure by their trials' numbers. Only trials that all
    pressures have form lines.
    """
    m = len(p_pa)
    slope_weights = weights(p_pa)
    rows = np.array([slope_weights, 1 / m - p_pa.mean() * slope_weights])
    slope, intercept = rows @ means_n
    residuals = np.asarray(means_n) - intercept - slope * p_pa
    s2 = float(residuals @ residuals) / (m - 2)
    common = set.intersection(*map(set, trials_n))
    lines = rows @ np.array([[values[trial] for trial in common] for values in trials_n])
    slope_error, intercept_error = (
        _error(math.sqrt(s2 * (row @ row)), m - 2, of_trials)
        for row, of_trials in zip(rows, lines, strict=True)
    )
    return PressureLine(
        slope_n_pa=float(slope),
        slope_ci95_n_pa=slope_error.ci95,
        slope_se_n_pa=slope_error.se,
        slope_dof=slope_error.dof,
        intercept_n=float(intercept),
        intercept_ci95_n=intercept_error.ci95,
    )


class _Error(NamedTuple):
    ci95: float  # half-width of the 95 % interval
    se: float
    dof: float  # Student's factor for it is the ratio of both


def _error(se: float, dof: float, of_trials: np.ndarray) -> _Error:
    """Combine a standard error of the residuals with the scatter of the trials' values (n,)."""
    ci95, n = student_factor(dof) * se, len(of_trials)
    if n < 2:
        return _Error(ci95, se, dof)
    se_trials = float(np.std(of_trials, ddof=1)) / math.sqrt(n)
    total = math.hypot(se, se_trials)
    if total == 0.0:
        return _Error(0.0, 0.0, dof)
    ci95 = math.hypot(ci95, student_factor(n - 1) * se_trials)
    return _Error(ci95, total, degrees_of_freedom(ci95 / total))
