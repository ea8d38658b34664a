"""Friction over Hersey number, and over speed at a reference temperature of the oil."""

from dataclasses import replace

from matplotlib.figure import Figure

from hbench.records import DIRECTION_WORDS, Curve, Results
from hbench.report.campaign.figures.friction import (
    by_direction,
    friction_magnitude,
    load_legend,
    load_ranks,
    load_style,
    over_velocity,
)
from hbench.report.campaign.series_words import load_words
from hbench.report.render import style
from hbench.units import from_si


def has_reduced(results: Results) -> bool:
    """Return whether reduced curves over velocity exist."""
    return bool(over_velocity(_reduced(results)))


def reduced_friction(results: Results) -> dict[str, Figure]:
    """Draw reduced |F| [N] over |v| [mm/s], one figure a direction."""
    oil = results.oil_temperature
    assert oil is not None and oil.reduction is not None, "has_reduced"
    celsius = round(from_si(oil.reduction.t_ref_k, "degC"), 1)
    return friction_magnitude(_reduced(results), f"Friction at {celsius:g} °C")


def has_hersey(results: Results) -> bool:
    """Return whether a curve over velocity has Hersey numbers."""
    return bool(_with_hersey(results))


def friction_hersey(results: Results) -> dict[str, Figure]:
    """Draw |F| [N] over the Hersey number [nm], one figure a direction."""
    curves = _with_hersey(results)
    ranks = load_ranks(curves)
    figures: dict[str, Figure] = {}
    for direction, chosen in by_direction(curves):
        figure = style.new_figure(height_in=3.8)
        axes = figure.add_subplot()
        for curve in chosen:
            points = curve.points
            axes.errorbar(
                [1e9 * hersey for point in points for hersey in point.trials_hersey_m],
                [curve.against_motion * force for point in points for force in point.trials_n],
                label=load_words(curve.f_load_n, curve.p_lr_ref_pa) or "_friction",
                **load_style(curve, ranks),
                **style.SMALL_POINTS,
            )
        axes.set_xscale("log")
        axes.set(xlabel="Hersey number η |v| / p (nm)", ylabel="Friction |F| (N)")
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        style.head(axes, f"Friction over Hersey number, {DIRECTION_WORDS[direction]}", results)
        style.read_as(figure, "Points: trials, each at its own temperature.")
        load_legend(figure, axes, chosen)
        figures[direction] = figure
    return figures


def _reduced(results: Results) -> Results:
    oil = results.oil_temperature
    curves = () if oil is None or oil.reduction is None else oil.reduction.curves
    return replace(results, curves=curves)


def _with_hersey(results: Results) -> tuple[Curve, ...]:
    return tuple(
        curve
        for curve in over_velocity(results)
        if all(point.trials_hersey_m for point in curve.points)
    )
