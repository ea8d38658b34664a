"""Table of the figures of a campaign: names, sections, captions, conditions."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from matplotlib import rc_context
from matplotlib.figure import Figure

from hbench.records import KINDS, OilTemperature, Results
from hbench.records.numbers import SIGNIFICANCE
from hbench.report.campaign.figures.efficiency import efficiency, has_efficiency
from hbench.report.campaign.figures.efficiency_map import efficiency_map, has_efficiency_map
from hbench.report.campaign.figures.friction import (
    friction_magnitude,
    has_curves,
)
from hbench.report.campaign.figures.motions import (
    breakaways,
    has_breakaways,
    has_leakage,
    has_levels,
    has_loops,
    has_surfaces,
    leakage,
    levels,
    loops,
    surfaces,
)
from hbench.report.campaign.figures.oil import (
    friction_hersey,
    has_hersey,
    has_reduced,
    reduced_friction,
)
from hbench.report.campaign.figures.over_distance import has_over_distance, over_distance
from hbench.report.campaign.figures.pressure import friction_pressure, has_pressures
from hbench.report.campaign.figures.ramps import comparisons, has_comparisons, has_ramps, ramps
from hbench.report.campaign.figures.traces import has_traces, traces
from hbench.report.campaign.series_words import without_common_label
from hbench.report.render.figures import Drawing, Sketch, draw_sketches
from hbench.report.render.style import RC


@dataclass(frozen=True)
class FigureKind:
    """A row of the table of figures."""

    name: str
    section: str  # of the page
    caption: str
    applies: Callable[[Results], bool]
    draw: Callable[[Results], dict[str, Figure]]  # by the part of the name that differs
    each_series: bool = False  # drawn for the steady runs of each label by itself


def draw_all(results: Results, png: bool = False) -> tuple[Drawing, ...]:
    """Draw every figure that applies to ``results``, in the order of the page.

    ``png`` draws them as PNG too.
    """
    results, sketches = without_common_label(results), list[Sketch]()
    for kind in FIGURES:
        for series, label in _series(results) if kind.each_series else [(results, "")]:
            if kind.applies(series):
                with rc_context(RC):
                    figures = kind.draw(series)
                    for suffix, figure in figures.items():
                        name = _unique(
                            _slug(kind.name, suffix, label), {sketch.name for sketch in sketches}
                        )
                        heading = " ".join(figure.axes[0].get_title("left").split())
                        title = ", ".join(filter(None, (heading, label)))
                        sketches.append(Sketch(name, kind.section, title, kind.caption, figure))
    return draw_sketches(sketches, png)


def _series(results: Results) -> Iterator[tuple[Results, str]]:
    """Yield the steady part of each label, and the label."""
    steady = [curve for curve in results.curves if KINDS[curve.kind].has_constant_speed]
    for label in dict.fromkeys(curve.label for curve in steady):
        part = replace(
            results,
            curves=tuple(curve for curve in steady if curve.label == label),
            efficiency=tuple(curve for curve in results.efficiency if curve.label == label),
            oil_temperature=_of_label(results.oil_temperature, label),
        )
        yield part, label


def _of_label(oil: OilTemperature | None, label: str) -> OilTemperature | None:
    if oil is None or oil.reduction is None:
        return oil
    curves = tuple(curve for curve in oil.reduction.curves if curve.label == label)
    return replace(oil, reduction=replace(oil.reduction, curves=curves))


def _slug(*parts: str) -> str:
    syllables = re.findall(r"[a-z0-9]+", " ".join(parts).lower())
    return "-".join(syllables)[:60].strip("-")


def _unique(name: str, taken: set[str]) -> str:
    number, candidate = 1, name
    while candidate in taken:
        number += 1
        candidate = f"{name}-{number}"
    return candidate


FIGURES = (
    FigureKind(
        name="stribeck",
        section="friction",
        caption="Friction over speed, both as magnitudes. Residuals of several loads at one speed "
        "are drawn side by side. Both directions have the same axes.",
        applies=has_curves,
        draw=friction_magnitude,
        each_series=True,
    ),
    FigureKind(
        name="friction-pressure",
        section="friction",
        caption="Friction against chamber pressure, one point for each pressure and direction, "
        "with the 95 % Student interval of two trials or more. Below: half of the band, "
        "(F extending − F retracting) / 2 in each trial, which is free of a constant error in "
        "force, and its middle, (F extending + F retracting) / 2. Solid: lines by least squares, "
        "from three pressures on. Dotted lines guide the eye.",
        applies=has_pressures,
        draw=friction_pressure,
    ),
    FigureKind(
        name="surface",
        section="friction",
        caption="Friction over speed and load, steady runs. Dots: measured; the colour between "
        "them is linearly interpolated.",
        applies=has_surfaces,
        draw=surfaces,
    ),
    FigureKind(
        name="ramps",
        section="ramps",
        caption="Ramps of each acceleration at one load, with steady runs and levels of steps "
        "where there are any. Ramp points: means over a bin of velocity. Positive friction opposes "
        "the motion; before breakaway it may be negative, since the preceding stroke has deflected "
        "the seals. Lines and lower panel: from breakaway on.",
        applies=has_ramps,
        draw=ramps,
    ),
    FigureKind(
        name="differences",
        section="ramps",
        caption="Differences of friction over a range of speeds, with 95 % intervals over "
        f"the trials. Filled: significant (p < {SIGNIFICANCE:g} after Holm). Hollow: not "
        "significant.",
        applies=has_comparisons,
        draw=comparisons,
    ),
    FigureKind(
        name="hysteresis",
        section="hysteresis",
        caption="Friction over velocity and over position. "
        "The velocity is the derivative of the position, without a filter's lag.",
        applies=has_loops,
        draw=loops,
    ),
    FigureKind(
        name="steps",
        section="steps",
        caption="Settled friction of each level, in the order of the levels. Lines: overshoot "
        "of friction, where it exceeds the noise.",
        applies=has_levels,
        draw=levels,
    ),
    FigureKind(
        name="leakage",
        section="leakage",
        caption="Oil that left either chamber of the test cylinder, from the decay of its pressure "
        "and the stated bulk modulus and volumes. A point is a hold; negative: oil flowed "
        "in. U of the leaks, which can be larger than the scatter of the holds, is in the table.",
        applies=has_leakage,
        draw=leakage,
    ),
    FigureKind(
        name="breakaway",
        section="breakaway",
        caption="Largest friction while the force on the piston rises; means of the trials.",
        applies=has_breakaways,
        draw=breakaways,
    ),
    FigureKind(
        name="over-distance",
        section="over-distance",
        caption="Each measured value over the distance that the piston has travelled in the "
        "campaign, returns to the start included.",
        applies=has_over_distance,
        draw=over_distance,
    ),
    FigureKind(
        name="friction-reduced",
        section="temperature",
        caption="Friction over speed, reduced to a reference temperature of the oil. Points: mean "
        "of the reduced trials with the 95 % Student interval. Bands: expanded uncertainty, that "
        "of the correction included.",
        applies=has_reduced,
        draw=reduced_friction,
        each_series=True,
    ),
    FigureKind(
        name="friction-hersey",
        section="temperature",
        caption="Friction of each trial over its Hersey number η |v| / p: dynamic viscosity at its "
        "temperature, speed, and the higher of the two chamber pressures.",
        applies=has_hersey,
        draw=friction_hersey,
        each_series=True,
    ),
    FigureKind(
        name="efficiency",
        section="efficiency",
        caption="Efficiency over speed, means of the accepted trials. Both directions have the "
        "same axes.",
        applies=has_efficiency,
        draw=efficiency,
        each_series=True,
    ),
    FigureKind(
        name="efficiency-map",
        section="efficiency",
        caption="Efficiency over speed and load, and half of its 95 % interval by trials and "
        "instruments together. Dots: measured; the colour between them is linearly interpolated.",
        applies=has_efficiency_map,
        draw=efficiency_map,
    ),
    FigureKind(
        name="rejected",
        section="rejected",
        caption="",  # the section's paragraph describes all of them
        applies=has_traces,
        draw=traces,
    ),
)
