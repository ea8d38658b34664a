"""Figures of an identification: each law's motion over the verification profile, and its errors."""

import re
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import Followed, Identification, LawsAlongCurve, Trace
from hbench.records.identification import MEMORY_M, PARTS
from hbench.report.campaign.fit_tables import law_words
from hbench.report.campaign.series_words import TITLES, load_words
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches
from hbench.report.render.numbers import force, number, span

_STEADY = (
    "Measured points with the 95 % Student interval of their {trials} alone, and each identified "
    "law at the measured chamber pressures."
)
_FOLLOWED = (
    "Friction, its difference (model minus measurement) and velocity over the verification "
    "profile; measured: grey, model with the law: coloured. Shaded: the first "
    f"{1e3 * MEMORY_M:.0f} mm, not counted, since friction depends there on how the piston came to "
    "rest before the log began. The ends of a log, where a derivative is one-sided, are not drawn."
)
STEADY = "steady"  # section of the figures of steady friction
_LINES: tuple[dict[str, Any], ...] = (
    {"linestyle": "-"},
    {"linestyle": "--"},
    {"linestyle": "-."},
    {"linestyle": "-", "linewidth": 5.0, "alpha": 0.45, "zorder": 1.5},  # behind a similar law
    {"linestyle": ":", "linewidth": 2.2},  # on a similar law
)
_SERIES = (0, 1, 2, 3, 5)  # of the palette; its orange is too close to the second colour
_ERRORS = (
    "Root mean square errors of friction and velocity over all verification runs, by part of the "
    "profile. Dashed: the scatter between the trials."
)


def draw_identification(identification: Identification) -> tuple[Drawing, ...]:
    """Draw the errors of all laws, then each verified law over each load's profile."""
    sketches = []
    for i, along in enumerate(identification.steady, start=1):
        with rc_context(style.RC):
            figure = _steady(along, identification)
        title = figure.axes[0].get_title("left")
        counts = [point.n for point in along.curve.points]
        trials = f"{span(counts)} trials" if counts else "trials"
        caption = _STEADY.format(trials=trials)
        sketches.append(Sketch(f"steady-{i}", STEADY, title, caption, figure))
    if sketches:
        style.share_limits(sketch.figure.axes[0] for sketch in sketches)
    if any(law.errors for law in identification.laws):
        with rc_context(style.RC):
            figure = _errors(identification)
        sketches.append(Sketch("errors", "errors", "Errors by law", _ERRORS, figure))
    for index, law in enumerate(identification.laws):
        for followed in identification.followed:
            if law.law not in followed.modelled:
                continue
            load = force(followed.f_load_n)
            title = f"{law_words(law.law)}, {load}"
            with rc_context(style.RC):
                figure = _followed_figure(
                    title, index, followed, followed.modelled[law.law], identification
                )
            name = re.sub(r"[^a-z0-9]+", "-", f"{law.law} {followed.run}".lower())
            title = f"{title}, run {followed.run}"
            sketches.append(Sketch(name, law.law, title, _FOLLOWED, figure))
    return draw_sketches(sketches)


def _steady(along: LawsAlongCurve, identification: Identification) -> Figure:
    """Draw |F| [N] over |v| [mm/s]: the measured points and the identified laws."""
    figure = style.new_figure(height_in=4.2)
    axes = figure.add_subplot()
    curve, sign = along.curve, along.curve.against_motion
    v, friction, interval = style.columns(curve)
    look = {"color": "#000000", "marker": "o", **style.POINTS}
    axes.errorbar(1e3 * np.abs(v), sign * friction, interval, label="measured", **look)
    for index, law in enumerate(identification.laws):
        if law.law in along.friction_n:
            colour = style.COLOURS[_SERIES[index]]
            axes.plot(
                1e3 * np.abs(along.v_m_s),
                sign * along.friction_n[law.law],
                color=colour,
                label=law_words(law.law),
                **_LINES[index],
            )
    axes.set(xlabel="Speed |v| (mm/s)", ylabel="Friction |F| (N)")
    load = load_words(curve.f_load_n, curve.p_lr_ref_pa)
    style.head(axes, ", ".join(filter(None, (TITLES[curve.direction], load))), identification)
    style.legend_above(figure, axes, columns=3)
    return figure


def _followed_figure(
    title: str, index: int, followed: Followed, model: Trace, identification: Identification
) -> Figure:
    figure = style.new_figure(height_in=5.6)
    top, middle, bottom = figure.subplots(3, sharex=True, height_ratios=(3, 1.5, 2))
    colour = style.COLOURS[_SERIES[index]]
    real, n = followed.measured, min(len(followed.measured.t_s), len(model.t_s))
    for axes, name, factor in ((top, "friction_n", 1.0), (bottom, "v_m_s", 1e3)):
        mark = "" if axes is top else "_"  # one legend for both
        grey = {"color": "#9ca3af", "linewidth": 3, "label": f"{mark}measured"}
        coloured = {"color": colour, "linewidth": 1.1, "label": f"{mark}model"}
        axes.plot(real.t_s, factor * getattr(real, name), **grey)
        axes.plot(model.t_s, factor * getattr(model, name), **coloured)
    difference = model.friction_n[:n] - real.friction_n[:n]
    coloured["label"] = "_model − measured"
    middle.plot(real.t_s[:n], difference, **coloured)
    _scale_to_compared(middle, real.t_s[:n], difference, followed.compared_from_s)
    for axes in (top, middle, bottom):
        axes.axvspan(real.t_s[0], followed.compared_from_s, color="#9ca3af", alpha=0.2, linewidth=0)
    top.set_ylabel("Friction (N)")
    middle.set_ylabel("Difference\n(N)")
    bottom.set(xlabel="Time (s)", ylabel="Velocity (mm/s)")
    style.head(top, title, identification)
    figure.align_ylabels()
    style.legend_above(figure, top, columns=2)
    return figure


def _scale_to_compared(
    axes: Axes, t_s: np.ndarray, difference_n: np.ndarray, from_s: float
) -> None:
    """Scale to the differences (n,) that count, and write how far the others exceed the axis."""
    counted = difference_n[t_s >= from_s]
    if not len(counted):
        return
    half = 1.2 * float(np.abs(counted).max())
    axes.set_ylim(-half, half)
    before = difference_n[t_s < from_s]
    farthest = float(before[np.abs(before).argmax()]) if len(before) else 0.0
    if abs(farthest) > half:
        up = farthest > 0
        axes.annotate(
            f"{'↑' if up else '↓'} to {number(farthest, 0)} N",
            (0.01, 0.95 if up else 0.05),
            xycoords="axes fraction",
            verticalalignment="top" if up else "bottom",
        )


def _errors(identification: Identification) -> Figure:
    figure = style.new_figure(height_in=4.6)
    rows = figure.subplots(2, sharex=True)
    laws = [law for law in identification.laws if law.errors]
    width = 0.8 / len(laws)
    for axes, name, factor, axis_label in (
        (rows[0], "friction_n", 1.0, "Error of friction (N)"),
        (rows[1], "v_m_s", 1e3, "Error of velocity\n(mm/s)"),
    ):
        for i, law in enumerate(laws):
            positions = np.arange(len(PARTS)) + (i - (len(laws) - 1) / 2) * width
            heights = [factor * getattr(law.errors[part], name) for part in PARTS]
            look = style.series_style(_SERIES[identification.laws.index(law)])
            label = law_words(law.law) if axes is rows[0] else f"_{law_words(law.law)}"
            axes.plot(positions, heights, linestyle="none", label=label, **look)
        for i, part in enumerate(PARTS):
            if identification.scatter:
                floor = factor * getattr(identification.scatter[part], name)
                axes.hlines(floor, i - 0.42, i + 0.42, color="black", linestyle="--", linewidth=1.2)
        axes.set_yscale("log")
        style.plain_log(axes.yaxis)
        axes.set_ylabel(axis_label)
        axes.grid(False, axis="x")
    rows[1].set_xticks(range(len(PARTS)), PARTS)
    rows[1].set_xlabel("Part of the profile")
    style.read_as(figure, "Points: RMS errors; dashed: the trials' scatter.")
    style.head(rows[0], "Errors by law", identification)
    style.legend_above(figure, rows[0], columns=3)
    return figure
