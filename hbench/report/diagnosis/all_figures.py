"""All figures of a diagnosis, by the section of the page that they stand in."""

import re
from collections.abc import Iterator

from matplotlib import rc_context
from matplotlib.figure import Figure

from hbench.records import Diagnosis
from hbench.report.diagnosis.gap_figures import (
    gap_figures,
    ranking_figure,
    refitted_figure,
    region_figure,
)
from hbench.report.diagnosis.names import balance
from hbench.report.diagnosis.overlay_figures import overlay_figures
from hbench.report.diagnosis.residual_figures import maps_figure, shape_figure, worst
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, drawn

_MOST_SHAPES = 4

_GAPS = (
    "Gaps of held-out runs, which took no part in the choice; 1 is as good as the bench repeats "
    "itself. Floor: what a model that is right would have, as uncertain as its parameters are. "
    "Gaps below 0.3 stand at 0.3."
)
_REGIONS = (
    "Gap of each balance in parts of the bench's operation, refitted model, all runs. Below 1 the "
    "colour is that of 1."
)
_MAPS = (
    "What the worst balances lack over velocity and load, with its sign, in units of the trials' "
    "scatter: measured less simulated. A dot is the mean of windows that lie close, larger where "
    "they are more. One scale of colours for all."
)
_SHAPE = (
    "What this balance lacks, measured less simulated, one point a window of 0.16 s, in units of "
    "the trials' scatter (grey band: one either way). Black: medians of parts with as many windows "
    "each, extending (>) and retracting (<). Points beyond the axis stand at its edge."
)
_HELD_OUT = " Coloured: held-out runs; grey: runs that the model was fitted to."
_OVERLAY = (
    "A held-out run as measured, and as the same firmware makes it with the model: closed loop. "
    "Right: simulated less measured."
)
_RANKING = (
    "Score of each candidate on operating points left out, and the share of the excess gap that it "
    "explains there. Upright line: its threshold; where it was simulated and could be named, drawn "
    "by chance from what it leaves. Filled: simulated with the effect; hollow: judged by its "
    "signature alone. Blue: named or in the ambiguous set."
)
_REFITTED = (
    "Factors on values of the model that are known badly, fitted before effects are sought, with "
    "their 95 % intervals. Hollow: at a bound of the fit, or not determined."
)


def draw_diagnosis(found: Diagnosis) -> tuple[Drawing, ...]:
    """Draw every figure that applies, in the order of the page."""
    with rc_context(style.RC):
        sketches = [
            Sketch(_slug(name), section, title, caption, figure)
            for section, name, title, caption, figure in _figures(found)
        ]
    return drawn(sketches)


def _figures(found: Diagnosis) -> Iterator[tuple[str, str, str, str, Figure]]:
    """Yield each figure with its section, name, title and caption."""
    if found.where:
        yield "where", "maps", "Residuals over velocity and load", _MAPS, maps_figure(found)
        shape = _SHAPE + (_HELD_OUT if found.effects else "")
        for name in worst(found)[:_MOST_SHAPES]:
            title = f"Residual: {balance(name).says}"
            yield "shape", f"shape {name}", title, shape, shape_figure(found, name)
    if found.where and found.regions:
        yield "where", "regions", "Gap by region", _REGIONS, region_figure(found)
    for title, figure in gap_figures(found).items():
        yield "gap", f"gap {title}", f"Gaps: {title.lower()}", _GAPS, figure
    for run, figure in overlay_figures(found).items():
        yield "overlay", f"run {run}", f"Run {run}", _OVERLAY, figure
    if found.ranking:
        yield "ranking", "ranking", "Candidates", _RANKING, ranking_figure(found)
    if found.refitted:
        yield "refitted", "refitted", "Refitted values", _REFITTED, refitted_figure(found)


def _slug(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
