"""Differences between the friction bands of two campaigns, and between their slopes.

Bands match at equal loads or pressures if the speeds of both directions agree. A slope is compared
where three of its pressures match; its standard errors and their degrees of freedom are combined as
those of means are (Welch, Satterthwaite).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.comparison.difference_tests import (
    NO_SCATTER,
    CampaignValue,
    Contributions,
    InstrumentPair,
    corrected,
    tested,
    untested,
    weighted,
    welch,
)
from hbench.analysis.comparison.matching import (
    Distinction,
    SetPoint,
    distinction,
    matching_key,
    nearest_set_point,
)
from hbench.analysis.curves.band_trends import FEWEST
from hbench.analysis.statistics.line_of_trials import slope_weights
from hbench.analysis.statistics.student import satterthwaite
from hbench.analysis.uncertainty.budget import friction_contributions
from hbench.config.sensors import Instruments
from hbench.records import (
    Band,
    BandDifference,
    BandTrend,
    BandTrendDifference,
    Difference,
    PressureLine,
    Results,
)

OfInstruments = tuple[Contributions, Contributions] | None  # to a and to b; None: not known

_HALF, _MIDDLE = (0.5, -0.5), (0.5, 0.5)  # shares of extending and retracting


def band_differences(
    a: Results, b: Results, instruments: InstrumentPair, tolerance: float
) -> tuple[BandDifference, ...]:
    """Compare the bands that both campaigns have, in the order of A.

    ``tolerance`` is the largest relative difference of two speeds that count as the same.
    """
    distinct, found = distinction(a, b), list[BandDifference]()
    for band in a.bands:
        other = _partner(band, b.bands, distinct, tolerance)
        if other is None:
            continue
        half = _of_instruments((band, other), _HALF, instruments)
        middle = _of_instruments((band, other), _MIDDLE, instruments)
        found.append(
            BandDifference(
                a=band,
                b=other,
                half_n=_difference(band, other, "half_n", half, instruments),
                middle_n=_difference(band, other, "middle_n", middle, instruments),
                energy_j=None
                if band.energy_j is None or other.energy_j is None
                else _difference(
                    band, other, "energy_j", _of_energy((band, other), half), instruments
                ),
            )
        )
    halves = corrected([each.half_n for each in found])
    middles = corrected([each.middle_n for each in found])
    energies = corrected([each.energy_j for each in found if each.energy_j])
    return tuple(
        replace(
            each,
            half_n=next(halves),
            middle_n=next(middles),
            energy_j=next(energies) if each.energy_j else None,
        )
        for each in found
    )


def trend_differences(
    a: Results,
    b: Results,
    bands: Sequence[BandDifference],
    instruments: InstrumentPair,
) -> tuple[BandTrendDifference, ...]:
    """Compare the slopes over pressure of series with at least three compared ``bands``."""
    found = list[BandTrendDifference]()
    for trend in a.band_trends:
        for other in b.band_trends:
            common = [d for d in bands if d.a in trend.bands and d.b in other.bands]
            if len(common) < FEWEST:
                continue
            half, middle = (
                _slope_parts((trend, other), shares, instruments) for shares in (_HALF, _MIDDLE)
            )
            found.append(
                BandTrendDifference(
                    a=trend,
                    b=other,
                    half_slope_n_pa=_slope(trend.half, other.half, half, instruments),
                    middle_slope_n_pa=_slope(trend.middle, other.middle, middle, instruments),
                )
            )
    halves = corrected([each.half_slope_n_pa for each in found])
    middles = corrected([each.middle_slope_n_pa for each in found])
    return tuple(
        replace(each, half_slope_n_pa=next(halves), middle_slope_n_pa=next(middles))
        for each in found
    )


def _partner(
    band: Band, others: Sequence[Band], distinct: Distinction, tolerance: float
) -> Band | None:
    """Return the band of the same series, set-point and speeds."""
    same = {
        number: SetPoint(other.f_load_n, other.p_tp_pa)
        for number, other in enumerate(others)
        if matching_key(other, distinct) == matching_key(band, distinct)
        and all(
            abs(abs(theirs.v_m_s) - abs(ours.v_m_s)) <= tolerance * abs(ours.v_m_s)
            for ours, theirs in ((band.extend, other.extend), (band.retract, other.retract))
        )
    }
    number = nearest_set_point(SetPoint(band.f_load_n, band.p_tp_pa), same)
    return None if number is None else others[number]


def _difference(
    a: Band, b: Band, name: str, both: OfInstruments, instruments: InstrumentPair
) -> Difference:
    """Return the difference of a number of two bands, such as ``half_n``."""
    error = welch([(-1.0, getattr(a, f"trials_{name}")), (1.0, getattr(b, f"trials_{name}"))])
    if error is None:
        return untested(getattr(a, name), getattr(b, name), NO_SCATTER)
    values = getattr(a, name), getattr(b, name)
    return tested(*_with_instruments(values, both), *error, instruments)


def _slope(
    a: PressureLine, b: PressureLine, both: OfInstruments, instruments: InstrumentPair
) -> Difference:
    se, dof = satterthwaite([a.slope_se_n_pa**2, b.slope_se_n_pa**2], [a.slope_dof, b.slope_dof])
    if se == 0.0:
        return untested(a.slope_n_pa, b.slope_n_pa, "no scatter")
    values = a.slope_n_pa, b.slope_n_pa
    return tested(*_with_instruments(values, both), se, dof, instruments)


def _with_instruments(
    values: tuple[float, float], both: OfInstruments
) -> tuple[CampaignValue, CampaignValue]:
    of_a, of_b = both or (None, None)
    return CampaignValue(values[0], of_a), CampaignValue(values[1], of_b)


def _of_instruments(
    bands: tuple[Band, Band], shares: tuple[float, float], instruments: InstrumentPair
) -> OfInstruments:
    """Return the instruments' contributions to half bands or middles, if known for both."""
    a, b = (
        _contributions(band, shares, known)
        for band, known in zip(bands, instruments.both, strict=True)
    )
    return (a, b) if a and b else None


def _of_energy(bands: tuple[Band, Band], half: OfInstruments) -> OfInstruments:
    """Return the contributions to the energies, which change as the half bands do."""
    if half is None:
        return None
    a, b = (
        weighted([((band.energy_j or 0.0) / band.half_n, of_half)])
        for band, of_half in zip(bands, half, strict=True)
    )
    return a, b


def _slope_parts(
    trends: tuple[BandTrend, BandTrend], shares: tuple[float, float], instruments: InstrumentPair
) -> OfInstruments:
    a, b = (
        weighted(
            zip(
                slope_weights(np.array(trend.pressures_pa)).tolist(),
                [_contributions(band, shares, known) for band in trend.bands],
                strict=True,
            )
        )
        for trend, known in zip(trends, instruments.both, strict=True)
    )
    return (a, b) if a and b else None


def _contributions(
    band: Band, shares: tuple[float, float], instruments: Instruments | None
) -> Contributions:
    if instruments is None:
        return {}
    directions = (band.extend, band.retract)
    parts = [friction_contributions(point, band.specimen, instruments) for point in directions]
    return weighted(zip(shares, parts, strict=True))
