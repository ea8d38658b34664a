"""Efficiency over speed, with its expanded uncertainty and the trials' spread."""

from math import floor

import numpy as np
from matplotlib.figure import Figure

from hbench.records import DIRECTION_WORDS, EfficiencyCurve, Results
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.figures.friction import (
    BANDS,
    by_direction,
    by_load,
    is_band,
    load_legend,
    load_ranks,
    load_style,
    points_words,
)
from hbench.report.campaign.series_words import load_words
from hbench.report.render import style
from hbench.report.render.series import behind

_STEP = 10.0  # %: the axis begins at a multiple of it, below all bands


def efficiency(results: Results) -> dict[str, Figure]:
    """Draw efficiency [%] over |v| [mm/s], one figure a direction.

    The band is the expanded uncertainty of trials and instruments, as that of friction; the bars
    are the 95 % interval of the trials.
    """
    curves = without_common_rod_pressure(
        curve for curve in results.efficiency if _has_values(curve)
    )
    ranks = load_ranks(curves)
    figures: dict[str, Figure] = {}
    for direction, chosen in by_direction(curves):
        figure = figures[direction] = style.new_figure(height_in=3.9)
        axes = figure.add_subplot()
        for curve in by_load(chosen):
            look = load_style(curve, ranks)
            speed, value, band, bar = _columns(curve)
            axes.fill_between(
                speed, value - band, value + band, color=look["color"], alpha=0.22, linewidth=0
            )
            label = load_words(curve.f_load_n, curve.p_lr_ref_pa) or "_efficiency"
            bars = axes.errorbar(speed, value, style.bars(bar), label=label, **look, **style.POINTS)
            behind(bars, {"U with instruments (%)": band})
        axes.set(xlabel="Speed |v| (mm/s)", ylabel="Efficiency (%)")
        style.start_at_zero(axes)
        low, high = axes.get_ylim()
        axes.set_ylim(_STEP * floor(low / _STEP), max(high, 100))
        style.head(axes, f"Efficiency, {DIRECTION_WORDS[direction]}", results)
        style.read_as(figure, _read(chosen))
        load_legend(figure, axes, chosen)
    style.share_limits(figure.axes[0] for figure in figures.values())
    return figures


def has_efficiency(results: Results) -> bool:
    """Return whether a curve has efficiencies at two speeds or more."""
    return any(_has_values(curve) for curve in results.efficiency)


def _has_values(curve: EfficiencyCurve) -> bool:
    return sum(point.efficiency is not None for point in curve.points) >= 2


def _read(curves: list[EfficiencyCurve]) -> str:
    """Return how to read the points, and the bars and bands where there are any."""
    points = [point for curve in curves for point in curve.points]
    bands = any(is_band([point.u95 for point in curve.points]) for curve in curves)
    words = points_words([point.ci95 for point in points if point.efficiency is not None])
    return f"{words}\n{BANDS}" if bands else words


def _columns(curve: EfficiencyCurve) -> tuple[np.ndarray, ...]:
    def column(name: str) -> np.ndarray:
        values = [getattr(point, name) for point in curve.points]
        return np.array([np.nan if value is None else value for value in values], dtype=float)

    percent = 100 * np.array([column("efficiency"), column("u95"), column("ci95")])
    return 1e3 * np.abs(column("v_m_s")), *percent
