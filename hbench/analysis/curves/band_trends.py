"""Dependence of friction bands on chamber pressure: straight lines of half band and middle.

The lines are those of ``statistics/line_of_trials.py``, through the means of the pressures.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np

from hbench.analysis.rounding import distinct
from hbench.analysis.statistics.line_of_trials import line_of_trials
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
    bands at two speeds, slow and fast ones are a series each. A load with one of them belongs to
    the series whose mean speed is the nearest.
    """
    bands = tuple(bands)
    speeds: dict[tuple, dict[float | None, list[float]]] = defaultdict(lambda: defaultdict(list))
    for band in bands:
        speeds[_key(band)][band.f_load_n].append(band.v_m_s)
    series: dict[tuple, list[Band]] = defaultdict(list)
    for band in bands:
        of_loads = speeds[_key(band)]
        most = max(map(len, of_loads.values()))
        own = sorted(of_loads[band.f_load_n])
        if len(own) == most:
            rank = own.index(band.v_m_s)
        else:
            complete = [sorted(each) for each in of_loads.values() if len(each) == most]
            rank = int(np.argmin(np.abs(np.mean(complete, axis=0) - band.v_m_s)))
        series[*_key(band), rank].append(band)
    return tuple(series.values())


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
        half=_line(pressures_pa, [band.half_n for band in bands], halves),
        middle=_line(pressures_pa, [band.middle_n for band in bands], middles),
    )


def _line(
    p_pa: np.ndarray, means_n: Sequence[float], trials_n: Sequence[dict[int, float]]
) -> PressureLine:
    line = line_of_trials(p_pa, means_n, trials_n)
    return PressureLine(
        slope_n_pa=line.slope,
        slope_ci95_n_pa=line.slope_ci95,
        slope_se_n_pa=line.slope_se,
        slope_dof=line.slope_dof,
        intercept_n=line.intercept,
        intercept_ci95_n=line.intercept_ci95,
    )
