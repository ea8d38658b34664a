"""Figures of gaps, their regions, candidates and refitted values."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from hbench.records import BeforeAfter, Candidate, Diagnosis, Region
from hbench.records.reconcile.diagnosis import LEAST_EXPLAINED
from hbench.report.diagnosis.figures.colour_scales import GAPS
from hbench.report.diagnosis.names import (
    AXES,
    DisplayName,
    also_words,
    balance,
    compared_model,
    in_words,
    mathtext,
    models_of,
    of_the_mass,
    share,
    shown,
    signal,
    steps_of,
    value_words,
)
from hbench.report.diagnosis.tables.gap_tables import with_total
from hbench.report.diagnosis.words.candidate import too_small
from hbench.report.render import style
from hbench.report.render.numbers import number, short, significant
from hbench.report.render.series import behind
from hbench.sentences import capital

BEFORE, AFTER, MEASURED = style.COLOURS[1], style.COLOURS[0], "#9ca3af"
BALANCES, CLOSED_LOOP, OPEN_LOOP = "Flows and forces", "Signals, closed loop", "Signals, open loop"
_LEAST_IN = 3.0  # height of a figure with a colour bar, whose label is as long
_ROW_IN, _HEAD_IN = 0.27, 1.6  # of a figure with a row for each thing
_LOOKS: dict[str, dict[str, Any]] = {
    "before": {"marker": "o", "color": style.QUIET, "markerfacecolor": "white"},
    "refitted": {"marker": "D", "color": BEFORE},
    "after": {"marker": "o", "color": AFTER},
    "floor": {"marker": "|", "color": "black", "markersize": 13, "markeredgewidth": 2},
}
_LEAST = 0.3  # gap that is drawn; below, runs are closer than trials by chance
_LEAST_SCALE = 10.0  # largest gap of the colour scale at least: small gaps stay light
_MOST_CANDIDATES = 12  # that are drawn


def gap_figures(diagnosis: Diagnosis) -> dict[str, Figure]:
    """Draw the held-out gaps of balances, and of signals in closed and open loop.

    A single gap has no figure: the first sentence of its section has it.
    """
    table = diagnosis.gap_heldout
    groups: tuple[tuple[str, Mapping[str, BeforeAfter], Callable[[str], DisplayName]], ...] = (
        (BALANCES, with_total(table), balance),
        (CLOSED_LOOP, table.signals, signal),
        (OPEN_LOOP, table.open_loop, signal),
    )
    return {
        title: _gaps(diagnosis, title, values, display_name)
        for title, values, display_name in groups
        if len(values) > 1
    }


def _gaps(
    diagnosis: Diagnosis,
    title: str,
    values: Mapping[str, BeforeAfter],
    display_name: Callable[[str], DisplayName],
) -> Figure:
    figure = style.new_figure(height_in=_HEAD_IN + _ROW_IN * len(values))
    axes = figure.subplots()
    steps = (steps_of if title == BALANCES else models_of)(diagnosis)
    rows = np.arange(len(values))
    every = {
        step: np.maximum([getattr(gap, step) for gap in values.values()], _LEAST) for step in steps
    }
    across = [every[step] for step in steps if step != "floor"]
    axes.hlines(rows, np.min(across, 0), np.max(across, 0), color="#d1d5db", linewidth=2.5)
    for step, label in steps.items():
        axes.plot(every[step], rows, linestyle="none", label=label, **_LOOKS[step])
    axes.axvline(1, color="#374151", linewidth=0.9)
    _log_gaps(axes)
    _rows(axes, [mathtext(display_name(name).title) for name in values])
    style.head(axes, title, diagnosis)
    style.legend_above(figure, axes, columns=2)
    return figure


def loads_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the force errors of the models of strokes at each held-out load."""
    loads = diagnosis.held_out_loads
    steps = models_of(diagnosis)
    also = list(loads[0].also)
    figure = style.new_figure(height_in=_HEAD_IN + 1.6 * _ROW_IN * len(loads))
    axes = figure.subplots()
    rows = np.arange(len(loads))
    for step, label in steps.items():
        errors = [getattr(load, step) for load in loads]
        axes.plot(errors, rows, linestyle="none", label=label, **_LOOKS[step])
    for name, marker, colour in zip(also, "^vPX", style.COLOURS[2:], strict=False):
        look = {"linestyle": "none", "marker": marker, "color": colour}
        axes.plot(
            [load.also[name] for load in loads], rows, label=also_words(diagnosis, name), **look
        )
    axes.set_xlim(left=0)
    axes.set_xlabel("Force error (N)")
    _rows(axes, [f"{number(load.load_n, 0)} N" for load in loads])
    style.head(axes, "Force error at each load", diagnosis)
    style.legend_above(figure, axes, columns=1)
    return figure


def _log_gaps(axes: Axes) -> None:
    axes.set_xscale("log")
    low, high = axes.get_xlim()
    axes.set_xlim(max(min(low, 0.7), 0.9 * _LEAST), max(high, 3))
    style.plain_log(axes.xaxis)
    axes.set_xlabel("Gap, runs outside the fit (× repeatability)")


def _rows(axes: Axes, names: list[str]) -> None:
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")


def region_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the gap of each balance in each region as tables of colours, in one scale.

    Where something was added to the model, the gaps with it are drawn below those without it.
    """
    names = [gap.name for gap in diagnosis.where]
    after = models_of(diagnosis).get("after")
    sides = {compared_model(diagnosis): diagnosis.regions}
    sides |= {after: diagnosis.regions_after} if after else {}
    every = [gap for side in sides.values() for region in side for gap in region.gaps.values()]
    norm = LogNorm(1, float(np.nanmax([_LEAST_SCALE, *every])))
    regions_of = Counter(region.axis for region in diagnosis.regions)
    axes_names = [name for name, number_of in regions_of.items() if number_of > 1]
    count = [regions_of[name] for name in axes_names]
    height_in = max(_LEAST_IN, 1.0 + (0.4 + 0.3 * len(names)) * len(sides))
    figure = style.new_figure(height_in=height_in, wide=True)
    panels = figure.subplots(
        len(sides), len(axes_names), sharex="col", sharey=True, width_ratios=count, squeeze=False
    )
    for row, (title, side) in zip(panels, sides.items(), strict=True):
        for axes, name in zip(row, axes_names, strict=True):
            group = [region for region in side if region.axis == name]
            image = _region_cells(axes, group, names, norm)
        style.head(row[0], capital(title), diagnosis, row[-1])
    for axes, name in zip(panels[-1], axes_names, strict=True):
        axis = AXES[name]
        axes.set_xlabel(f"{axis.title} ({axis.unit})" if axis.unit else axis.title)
    _rows(panels[0, 0], [balance(name).title for name in names])
    panels[0, 0].set_ylim(len(names) - 0.5, -0.5)
    figure.colorbar(
        image, ax=panels, label="Gap, all runs (× repeatability)", pad=0.01
    ).ax.yaxis.set_major_formatter(lambda value, _: short(value))
    return figure


def _region_cells(
    axes: Axes, group: Sequence[Region], names: Sequence[str], norm: LogNorm
) -> AxesImage:
    """Draw the regions of one axis, a column each, with the gaps as numbers."""
    gaps = np.array([[region.gaps.get(name, np.nan) for region in group] for name in names])
    look = {"norm": norm, "cmap": GAPS, "label": "_gaps"}
    image = axes.imshow(np.maximum(gaps, 1.0), aspect="auto", **look)
    behind(image, {"Gap (× repeatability)": gaps.ravel()})
    for (row, column), value in np.ndenumerate(gaps):
        axes.text(
            column,
            row,
            number(value, 1 if value < 99.95 else 0),
            ha="center",
            va="center",
            fontsize=9,
        )
    axes.set_xticks(range(len(group)), [_bounds(region) for region in group], fontsize=8.5)
    axes.grid(visible=False)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return image


def _bounds(region: Region) -> str:
    if region.label:
        return region.label
    axis = AXES[region.axis]
    low, high = (shown(value, axis) for value in (region.low, region.high))
    decimals = 1 if axis.unit in ("kN", "s") else 0
    ends = [number(end, decimals) for end in (low, high)]
    if ends[0] == ends[1]:  # a narrow stretch, as of strokes at one load
        ends = list(dict.fromkeys(significant(end, 3) for end in (low, high)))
    return "\nto\n".join(ends)


def ranking_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the scores of the best candidates, with their thresholds."""
    chosen = diagnosis.ranking[:_MOST_CANDIDATES]
    figure = style.new_figure(height_in=_HEAD_IN + _ROW_IN * len(chosen))
    axes = figure.subplots()
    top = max(max(candidate.threshold, candidate.score) for candidate in chosen)
    named = {effect.name for effect in diagnosis.effects} | {
        candidate.name for candidate in diagnosis.alternatives
    }
    for row, candidate in enumerate(chosen):
        colour = AFTER if candidate.name in named else "#9ca3af"
        look = {"color": colour} if candidate.tried == "full" else {"facecolor": "white"}
        look["label"] = f"_{candidate.tried}"
        axes.barh(row, candidate.score, height=0.62, edgecolor=colour, linewidth=1.4, **look)
        axes.annotate(
            _remark(candidate),
            (max(candidate.score, candidate.threshold), row),
            (4, 0),
            va="center",
            fontsize=9,
            textcoords="offset points",
        )
    needed = [candidate.threshold for candidate in chosen]
    axes.plot(
        needed,
        range(len(chosen)),
        linestyle="none",
        label="score needed",
        **_LOOKS["floor"],
    )
    axes.set_xlim(
        min(0.0, max(-0.1 * top, min(candidate.score for candidate in chosen))), 1.65 * top
    )
    axes.set_xlabel("Gain of log-likelihood, cross-validated (nats)")
    _rows(axes, [in_words(candidate.name) for candidate in chosen])
    style.head(axes, "Candidates", diagnosis)
    style.legend_above(figure, axes)
    return figure


def _remark(candidate: Candidate) -> str:
    score = round(candidate.score, 1)
    if score <= 0:
        return f"{short(score)}: no gain"
    if candidate.score <= candidate.threshold and candidate.explained < LEAST_EXPLAINED:
        return short(score)
    small = "; too small" if too_small(candidate) == ["size"] else ""
    return f"{short(score)}; explains {share(candidate.explained)}{small}"


def refitted_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the factors on the model's values with their intervals."""
    names = list(diagnosis.refitted)
    figure = style.new_figure(height_in=_HEAD_IN + _ROW_IN * len(names))
    axes = figure.subplots()
    axes.axvline(1, color="#374151", linewidth=0.9)
    for row, factor in enumerate(diagnosis.refitted.values()):
        if factor.ci95 is not None:
            axes.hlines(row, *factor.ci95, color=BEFORE, linewidth=1.4)
        face = "white" if factor.ci95 is None or factor.at_bound else BEFORE
        look = {"color": BEFORE, "markerfacecolor": face, "label": "_factor"}
        (mark,) = axes.plot(factor.value, row, "D", **look)
        if factor.ci95 is not None:
            behind(mark, {"from": [factor.ci95[0]], "to": [factor.ci95[1]]})
    axes.set_xlabel("Factor on the model's value (1)")
    _rows(axes, [of_the_mass(diagnosis, value_words(name)) for name in names])
    style.head(axes, "Refitted values", diagnosis)
    return figure
