"""Hysteresis loops, steps, leakage, and friction over velocity and load."""

import numpy as np
from matplotlib.figure import Figure

from hbench.records import Results
from hbench.report.campaign.motion_rows import series_words
from hbench.report.render import style
from hbench.report.render.numbers import short
from hbench.report.render.series import behind
from hbench.units import from_si


def has_loops(results: Results) -> bool:
    """Return whether a triangle was accepted."""
    return bool(results.motions.loops)


def loops(results: Results) -> dict[str, Figure]:
    """Draw mean loops: friction [N] over velocity [mm/s] and over position [mm]."""
    figures = {}
    for loop in results.motions.loops:
        x, v, friction = np.array(loop.trace).T
        closed = [*range(len(x)), 0]
        figure = style.new_figure(height_in=5.2)
        over_v, over_x = figure.subplots(2)
        for axes, abscissa in ((over_v, v), (over_x, x)):
            for rising, words in ((True, "velocity rises"), (False, "velocity falls")):
                own = np.where((np.gradient(v) > 0) == rising, friction, np.nan)
                colour = style.COLOURS[0 if rising else 1]
                label = words if axes is over_v else f"_{words}"
                axes.plot(1e3 * abscissa, own, color=colour, label=label, zorder=3)
            axes.plot(1e3 * abscissa[closed], friction[closed], color="#9ca3af", linewidth=0.8)
            axes.axhline(0, color="#374151", linewidth=0.9, zorder=1)
            axes.set_ylabel("Friction F (N)")
        over_v.set_xlabel("Velocity v (mm/s)")
        over_x.set_xlabel("Position x (mm)")
        name = series_words(loop.series)
        title = f"{name[:1].upper()}{name[1:]}" or "Hysteresis"
        if [one.series for one in results.motions.loops].count(loop.series) > 1:
            title += f", to {short(1e3 * loop.v_top_m_s)} mm/s"
        style.head(over_v, title, results)
        style.read_as(figure, "Mean of all cycles but the first.")
        style.legend_above(figure, over_v)
        figures[f"{name}-{short(1e3 * loop.v_top_m_s)}"] = figure
    return figures


def has_levels(results: Results) -> bool:
    """Return whether a run of steps was accepted."""
    return bool(results.motions.levels)


def levels(results: Results) -> dict[str, Figure]:
    """Draw settled friction [N] of each level in turn, and the overshoot before it settled."""
    figure = style.new_figure(height_in=3.8)
    axes = figure.add_subplot()
    series = list(dict.fromkeys(one.series for one in results.motions.levels))
    for rank, of in enumerate(series):
        found = [one for one in results.motions.levels if one.series == of]
        place = np.array([one.number for one in found]) + 0.12 * (rank - (len(series) - 1) / 2)
        look = style.series_style(rank)
        after = np.array([one.after_n for one in found])
        interval = [np.nan if one.after_ci95_n is None else one.after_ci95_n for one in found]
        bars = axes.errorbar(place, after, interval, label=series_words(of), **look, **style.POINTS)
        over = [np.nan if one.overshoot_n is None else one.overshoot_n for one in found]
        runs = [" ".join(one.runs) for one in found]
        behind(bars, {"overshoot (N)": over, "runs": runs})
        for at, one in zip(place, found, strict=True):
            if one.overshoot_n is not None:
                way = np.sign(one.after_n - (one.before_n or 0.0)) * one.overshoot_n
                axes.plot([at, at], [one.after_n, one.after_n + way], color=look["color"], lw=1.2)
                axes.plot(at, one.after_n + way, "_", color=look["color"], markersize=9)
    first = [level for level in results.motions.levels if level.series == series[0]]
    ticks = [f"{one.number}\n{short(1e3 * one.v_to_m_s)}" for one in first]
    axes.set_xticks([one.number for one in first], ticks)
    axes.set(xlabel="Level, and its velocity (mm/s)", ylabel="Friction F (N)")
    axes.axhline(0, color="#374151", linewidth=0.9, zorder=1)
    style.head(axes, "Friction of velocity steps", results)
    style.read_as(figure, "Points: settled; bars: 95 % intervals of trials; lines: overshoot.")
    style.legend_above(figure, axes)
    return {"": figure}


def has_leakage(results: Results) -> bool:
    """Return whether a hold was accepted."""
    return bool(results.motions.leakages)


def leakage(results: Results) -> dict[str, Figure]:
    """Draw the oil that left each side [mm^3/s] against its pressure [bar], a point a hold."""
    figure = style.new_figure(height_in=3.6)
    axes = figure.add_subplot()
    sides = (("piston side", "p_p_pa", "out_p_m3_s"), ("rod side", "p_r_pa", "out_r_m3_s"))
    for rank, (words, pressure, flow) in enumerate(sides):
        decays = [decay for found in results.motions.leakages for decay in found.decays]
        p = [from_si(getattr(decay, pressure), "bar") for decay in decays]
        q = [1e9 * getattr(decay, flow) for decay in decays]
        look = style.series_style(rank)
        bars = axes.errorbar(p, q, label=words, **look, **style.POINTS)
        behind(bars, {"run": [decay.run for decay in decays]})
    axes.axhline(0, color="#374151", linewidth=0.9, zorder=1)
    axes.set(xlabel="Pressure of the side (bar)", ylabel="Oil that leaves (mm³/s)")
    style.head(axes, "Leakage with all valves closed", results)
    style.read_as(figure, "A point is a hold; negative: oil came in.")
    style.legend_above(figure, axes)
    return {"": figure}


def has_surfaces(results: Results) -> bool:
    """Return whether a surface of friction over velocity and load exists."""
    return bool(results.motions.surfaces)


def surfaces(results: Results) -> dict[str, Figure]:
    """Draw |F| [N] over speed [mm/s] and load [kN] as a filled contour with the measured points."""
    figures = {}
    for found in results.motions.surfaces:
        figure = style.new_figure(height_in=4.0)
        axes = figure.add_subplot()
        v, load = np.array(found.v_m_s) * 1e3, np.array(found.f_load_n) / 1e3
        friction = np.array(found.friction_n)
        filled = axes.contourf(v, load, friction, levels=12, cmap="cividis")
        lines = axes.contour(
            v, load, friction, levels=filled.levels, colors=style.ON_MAPS, linewidths=0.5
        )
        axes.clabel(lines, list(lines.levels)[1::2], fontsize=8, fmt="%g")
        points = np.array([(speed, one) for one in load for speed in v])
        (dots,) = axes.plot(*points.T, label="_measured", **style.DOTS)
        behind(dots, {"Friction |F| (N)": friction.ravel()})
        axes.set(xlabel="Speed |v| (mm/s)", ylabel="Load $F_L$ (kN)")
        axes.grid(visible=False)
        figure.colorbar(filled, ax=axes, label="Friction |F| (N)")
        words = ", ".join(filter(None, (found.label, style.TITLES[found.direction])))
        if len(results.motions.surfaces) > 2 and found.p_lr_ref_pa is not None:
            words += f", {short(from_si(found.p_lr_ref_pa, 'bar'))} bar"
        style.head(axes, f"Friction map, {words[0].lower()}{words[1:]}", results)
        style.read_as(figure, style.OF_MAPS)
        figures[words] = figure
    return figures
