"""Friction bands of a comparison: tables, JSON and verdict."""

from typing import Any

from hbench.records import (
    BandDifference,
    BandTrendDifference,
    CampaignDifferences,
    WordTable,
)
from hbench.report.campaign.series_words import load_words
from hbench.report.comparison.cells import (
    cells,
    difference_table,
    label_of,
    numbers,
    percent,
    signed,
)
from hbench.report.render.numbers import force, in_mm_s, number, span
from hbench.units import from_si

_PER_BAR = 1 / from_si(1.0, "bar")


def band_verdict(differences: CampaignDifferences) -> str:
    """Return the significant differences of half bands and of their slopes; empty without bands."""
    if not differences.bands:
        return ""
    real = [band for band in differences.bands if band.half_n.real]
    count = len(differences.bands)
    sentences = ["The half band does not differ significantly at any pressure."]
    if real:
        each = "; ".join(
            f"{_where(band)}: {signed(band.half_n)} N ({percent(band.half_n)})" for band in real
        )
        sentences = [f"The half band differs at {len(real)} of {count} pressures: {each}."]
    for trend in differences.band_trends:
        if trend.half_slope_n_pa.real:
            slope = signed(trend.half_slope_n_pa, _PER_BAR)
            sentences.append(f"Its slope over pressure differs by {slope} N/bar.")
    return " ".join(sentences)


def band_table(differences: CampaignDifferences) -> WordTable:
    """Return half bands, middles and energies of both."""
    rows = []
    for words, name in (
        ("half band (N)", "half_n"),
        ("middle (N)", "middle_n"),
        ("energy of a cycle (J)", "energy_j"),
    ):
        for band in differences.bands:
            difference = getattr(band, name)
            if difference is not None:
                speeds = [in_mm_s(each.v_m_s) for each in (band.a, band.b)]
                rows.append((words, _where(band), *speeds, *cells(difference, 1.0)))
    return difference_table("Friction bands", ("Quantity", "At", "A (mm/s)", "B (mm/s)"), rows)


def slope_table(differences: CampaignDifferences) -> WordTable:
    """Return the slopes of half bands and middles over pressure."""
    rows = [
        (words, _of_trend(trend), *cells(getattr(trend, name), _PER_BAR))
        for words, name in (
            ("half band (N/bar)", "half_slope_n_pa"),
            ("middle (N/bar)", "middle_slope_n_pa"),
        )
        for trend in differences.band_trends
    ]
    return difference_table("Slopes over pressure", ("Slope of", "Over"), rows)


def _where(band: BandDifference) -> str:
    """Write label, load and pressure of a band, such as ``O-ring, 1.00 bar``."""
    pressure = band.a.p_tp_pa
    at = force(band.a.f_load_n) if pressure is None else f"{number(_bar(pressure), 2)} bar"
    return ", ".join(filter(None, (label_of(band), load_words(None, band.a.p_lr_ref_pa), at)))


def _of_trend(trend: BandTrendDifference) -> str:
    bars = span([_bar(p) for p in trend.a.pressures_pa])
    speeds = span([1e3 * band.v_m_s for band in trend.a.bands])
    rod_side = load_words(None, trend.a.p_lr_ref_pa)
    words = (label_of(trend), rod_side, f"{bars} bar", f"{speeds} mm/s")
    return ", ".join(filter(None, words))


def _bar(pressure_pa: float) -> float:
    return from_si(pressure_pa, "bar")


def bands_document(differences: CampaignDifferences) -> dict[str, Any]:
    """Return the sections of bands and of their slopes in ``comparison.json``."""
    return {
        "bands": [
            {
                **_of_both(band),
                "f_load_n_a": band.a.f_load_n,
                "f_load_n_b": band.b.f_load_n,
                "p_tp_pa_a": band.a.p_tp_pa,
                "p_tp_pa_b": band.b.p_tp_pa,
                "v_m_s_a": band.a.v_m_s,
                "v_m_s_b": band.b.v_m_s,
                "half_n": numbers(band.half_n),
                "middle_n": numbers(band.middle_n),
                "energy_j": numbers(band.energy_j),
            }
            for band in differences.bands
        ],
        "band_trends": [
            {
                **_of_both(trend),
                "half_slope_n_pa": numbers(trend.half_slope_n_pa),
                "middle_slope_n_pa": numbers(trend.middle_slope_n_pa),
            }
            for trend in differences.band_trends
        ],
    }


def _of_both(pair: BandDifference | BandTrendDifference) -> dict[str, Any]:
    return {
        "kind": pair.a.kind,
        "label_a": pair.a.label,
        "label_b": pair.b.label,
        "p_lr_ref_pa": pair.a.p_lr_ref_pa,
    }
