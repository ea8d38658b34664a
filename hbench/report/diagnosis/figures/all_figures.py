"""All figures of a diagnosis, by the section of the page."""

import re
from collections.abc import Iterator

from matplotlib import rc_context
from matplotlib.figure import Figure

from hbench.records import Diagnosis
from hbench.report.diagnosis.figures.gap_figures import (
    BALANCES,
    CLOSED_LOOP,
    OPEN_LOOP,
    gap_figures,
    loads_figure,
    ranking_figure,
    refitted_figure,
    region_figure,
)
from hbench.report.diagnosis.figures.law_figures import law_figure
from hbench.report.diagnosis.figures.overlay_figures import overlay_figures
from hbench.report.diagnosis.figures.residual_figures import (
    has_loads,
    maps_figure,
    shape_figure,
    shown_balances,
)
from hbench.report.diagnosis.names import (
    added_words,
    balance,
    compared_model,
    models_of,
    of_strokes,
)
from hbench.report.diagnosis.tables.run_gaps import plan_words
from hbench.report.diagnosis.words.law import law_title
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches

_GAPS = {
    BALANCES: (
        "Root mean square of measurement less model, along the logs of the runs outside the fit. "
        "Line at 1: repeatability of the bench."
    ),
    CLOSED_LOOP: (
        "Root mean square of measured less simulated signals of the runs outside the fit. The "
        "schedule is simulated with the firmware in closed loop, where errors of all values add "
        "up."
    ),
    OPEN_LOOP: (
        "Root mean square of measured less simulated signals of the runs outside the fit. The "
        "simulation follows the measured commands without feedback."
    ),
}
_LOADS = (
    "Root mean square of measured less predicted force in both directions. Each load is predicted "
    "with values that were fitted to the other loads."
)
_REGIONS = (
    "Gap of each quantity by region of operation, all runs: root mean square of measurement less "
    "model, in multiples of the repeatability. Gaps below 1 have the colour of 1. All tables share "
    "the colour scale."
)
_MAPS = (
    "Residuals (measurement less model) of the quantities that deviate most over {over}, all "
    "runs, in multiples of the repeatability. A dot is the mean of neighbouring windows; its size "
    "grows with their number. All panels share the colour scale."
)
_SHAPE = (
    "Measurement less model, all runs, in multiples of the repeatability (grey band: ±1). A point "
    "is the mean over a window of 0.16 s. Triangles: medians of equal numbers of points, "
    "extending (▶) and retracting (◀); none where the median lies between groups of points. Points "
    "beyond the axis are drawn at its edge."
)
_SHAPE_OF_STROKES = (
    "Measured less modelled force. A point is the mean of the pairs of strokes at one load."
)
_LAW = (
    "A table that was fitted to what no effect of the catalogue explains, with 95 % intervals of "
    "its values. It is linear between its points and constant beyond them. It predicts runs "
    "outside the fit better; it does not state a cause."
)
_STAGES = " Before: the {model}; after: with the {added}."
_HELD_OUT = " Coloured: runs outside the fit; grey: runs of the fit."
_OVERLAY = (
    "A run outside the fit as measured, and as simulated with the same firmware in closed loop. "
    "Right: simulated less measured; points: means over 0.16 s, by which signals are compared. The "
    "limits above which a deviation matters are not those of these signals, but of the flows and "
    "forces over all runs."
)
_OPEN_LOOP = (
    "The run outside the fit with the largest position error of the final model: as measured, and "
    "as simulated under the measured drive force from its first sample. Nothing corrects this "
    "motion. Right: simulated less measured; points: means over 0.16 s."
)
_ONE_RUN = " Each signal is shown in one run outside the fit."
_SHRUNK = f"{_ONE_RUN} What is added to the model reduces its gap there."
_NONE_SHRANK = f"{_ONE_RUN} What is added to the model reduces the gap of none."
_RANKING = (
    "Score of each candidate by cross-validation (each fifth of the operating points predicted "
    "from the others), and the share of the gap beyond the repeatability that it explains in the "
    "quantities that it changes. No gain: it predicts these points no better. Vertical line: the "
    "score that is needed; for a candidate that could be named it is determined from residuals "
    "drawn at random. Filled: fitted in full; hollow: evaluated by its linear signature alone. "
    "Blue: named, or not distinguishable."
)
_REFITTED = (
    "Factors on poorly known values of the model{fitted}, with their 95 % intervals. Hollow: at a "
    "bound of the fit, or not determined."
)


def draw_diagnosis(diagnosis: Diagnosis) -> tuple[Drawing, ...]:
    """Draw every figure that applies, in the order of the page."""
    with rc_context(style.RC):
        sketches = [
            Sketch(_slug(name), section, title, caption, figure)
            for section, name, title, caption, figure in _figures(diagnosis)
        ]
    return draw_sketches(sketches)


def _figures(diagnosis: Diagnosis) -> Iterator[tuple[str, str, str, str, Figure]]:
    """Yield each figure with its section, name, title and caption."""
    strokes = of_strokes(diagnosis)
    for i, law in enumerate(diagnosis.unnamed):
        title = f"Unnamed law: {law_title(law)}"
        yield "unnamed", f"law {i} {law.adds_to}", title, _LAW, law_figure(diagnosis, law)
    if diagnosis.where:
        stages = _stages(diagnosis)
        over = "velocity and load" if has_loads(diagnosis) else "velocity and position"
        title = f"Residuals over {over}"
        if strokes:
            shape = _SHAPE_OF_STROKES + stages
        else:
            maps = _MAPS.format(over=over) + stages
            yield "where", "maps", title, maps, maps_figure(diagnosis)
            shape = _SHAPE + stages + (_HELD_OUT if diagnosis.confirmed else "")
        for name in shown_balances(diagnosis):
            title = f"Residual: {balance(name).title}"
            yield "shape", f"shape {name}", title, shape, shape_figure(diagnosis, name)
    if diagnosis.where and diagnosis.regions and not strokes:  # those of strokes are its loads
        yield "where", "regions", "Gap by region, all runs", _REGIONS, region_figure(diagnosis)
    if diagnosis.held_out_loads:
        title = "Force error at each load outside the fit"
        yield "gap", "loads", title, _LOADS, loads_figure(diagnosis)
    for title, figure in ({} if strokes else gap_figures(diagnosis)).items():
        yield "gap", f"gap {title}", f"Gaps: {title.lower()}", _GAPS[title], figure
    plans = {run_gap.plan.run: run_gap.plan for run_gap in diagnosis.gap_runs}
    for run, figure in overlay_figures(diagnosis).items():
        title = f"Run {run}: {plan_words(plans[run])}" if run in plans else f"Run {run}"
        yield "overlay", f"run {run}", title, _overlay_caption(diagnosis), figure
    if diagnosis.ranking:
        yield "ranking", "ranking", "Candidates", _RANKING, ranking_figure(diagnosis)
    if diagnosis.refitted:
        fitted = ", fitted together with the effects" if diagnosis.confirmed else ""
        caption = _REFITTED.format(fitted=fitted)
        yield "refitted", "refitted", "Refitted values", caption, refitted_figure(diagnosis)


def _stages(diagnosis: Diagnosis) -> str:
    """Return what the residuals before and after are those of; empty where nothing was added."""
    added = added_words(diagnosis)
    return _STAGES.format(model=compared_model(diagnosis), added=added) if added else ""


def _overlay_caption(diagnosis: Diagnosis) -> str:
    """Return how these signals of held-out runs were simulated, and why they are shown."""
    return _OPEN_LOOP if diagnosis.errors else _OVERLAY + _chosen(diagnosis)


def _chosen(diagnosis: Diagnosis) -> str:
    if "after" not in models_of(diagnosis):
        return _ONE_RUN
    return _SHRUNK if all(each.shrank for each in diagnosis.overlays) else _NONE_SHRANK


def _slug(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
