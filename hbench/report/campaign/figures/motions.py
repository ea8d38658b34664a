"""Hysteresis loops, steps, leakage, breakaway, and friction over velocity and load."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import DIRECTION_WORDS, DIRECTIONS, SIGNS, Results, Surface
from hbench.report.campaign.motion_rows import series_words
from hbench.report.campaign.series_words import TITLES, within_title
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
            for rising, branch_name in ((True, "velocity rises"), (False, "velocity falls")):
                branch = np.where((np.gradient(v) > 0) == rising, friction, np.nan)
                colour = style.COLOURS[0 if rising else 1]
                label = branch_name if axes is over_v else f"_{branch_name}"
                axes.plot(1e3 * abscissa, branch, color=colour, label=label, zorder=3)
            axes.plot(1e3 * abscissa[closed], friction[closed], color="#9ca3af", linewidth=0.8)
            axes.axhline(0, color="#374151", linewidth=0.9, zorder=1)
            axes.set_ylabel("Friction F (N)")
        over_v.set_xlabel("Velocity v (mm/s)")
        over_x.set_xlabel("Position x (mm)")
        name = series_words(loop.series)
        title = f"{name[:1].upper()}{name[1:]}" or "Hysteresis"
        if [other.series for other in results.motions.loops].count(loop.series) > 1:
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
    series = list(dict.fromkeys(level.series for level in results.motions.levels))
    for rank, of in enumerate(series):
        steps = [level for level in results.motions.levels if level.series == of]
        positions = np.array([level.number for level in steps]) + 0.12 * (
            rank - (len(series) - 1) / 2
        )
        look = style.series_style(rank)
        after = np.array([level.after_n for level in steps])
        interval = [np.nan if level.after_ci95_n is None else level.after_ci95_n for level in steps]
        bars = axes.errorbar(
            positions, after, interval, label=series_words(of), **look, **style.POINTS
        )
        over = [np.nan if level.overshoot_n is None else level.overshoot_n for level in steps]
        runs = [" ".join(level.runs) for level in steps]
        behind(bars, {"overshoot (N)": over, "runs": runs})
        for x, level in zip(positions, steps, strict=True):
            if level.overshoot_n is not None:
                way = np.sign(level.after_n - (level.before_n or 0.0)) * level.overshoot_n
                axes.plot([x, x], [level.after_n, level.after_n + way], color=look["color"], lw=1.2)
                axes.plot(x, level.after_n + way, "_", color=look["color"], markersize=9)
    first = [level for level in results.motions.levels if level.series == series[0]]
    ticks = [f"{level.number}\n{short(1e3 * level.v_to_m_s)}" for level in first]
    axes.set_xticks([level.number for level in first], ticks)
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
    """Draw the oil that left each side: flow [ml/min] by hold, volume [ml] over time.

    The course over time is that of the load at which the pressure of the side is highest.
    """
    figure = style.new_figure(height_in=5.6)
    flows, volumes = figure.subplots(2)
    decays = [decay for leak in results.motions.leakages for decay in leak.decays]
    sides = (("piston side", "p_p_pa", "out_p_m3_s"), ("rod side", "p_r_pa", "out_r_m3_s"))
    for rank, (side, pressure, flow) in enumerate(sides):
        p = [from_si(getattr(decay, pressure), "bar") for decay in decays]
        q = [from_si(getattr(decay, flow), "ml/min") for decay in decays]
        look = style.series_style(rank)
        bars = flows.errorbar(p, q, label=side, **look, **style.POINTS)
        behind(bars, {"run": [decay.run for decay in decays]})
        highest = max(decays, key=lambda decay: getattr(decay, pressure)).series
        traces = [decay.trace for decay in decays if decay.series == highest and decay.trace]
        _draw_lost(volumes, list(map(np.array, traces)), 1 + rank, look["color"])
    for axes in (flows, volumes):
        axes.axhline(0, color="#374151", linewidth=0.9, zorder=1)
    flows.set(xlabel="Pressure of the side (bar)", ylabel="Oil that leaves (ml/min)")
    volumes.set(xlabel="Time (s)", ylabel="Oil that has left (ml)")
    style.head(flows, "Leakage with all valves closed", results)
    style.read_as(figure, "Lines: means of the trials at the highest pressure; shaded: range.")
    style.legend_above(figure, flows)
    return {"": figure}


def _draw_lost(axes: Axes, traces: Sequence[np.ndarray], column: int, color: str) -> None:
    """Draw the oil [ml] that left a side over time: mean and range of the trials of a load."""
    if not traces:
        return
    t_s = min(traces, key=lambda trace: trace[-1, 0])[:, 0]
    lost = 1e6 * np.array([np.interp(t_s, trace[:, 0], trace[:, column]) for trace in traces])
    axes.plot(t_s, lost.mean(axis=0), color=color)
    axes.fill_between(t_s, lost.min(axis=0), lost.max(axis=0), color=color, alpha=0.15, linewidth=0)


def has_breakaways(results: Results) -> bool:
    """Return whether runs of the kind breakaway gave more values than one a direction."""
    return len(results.motions.breakaways) > len(DIRECTIONS)


def breakaways(results: Results) -> dict[str, Figure]:
    """Draw breakaway [N] over the time at rest [s] with the better law, or load by load."""
    figure = style.new_figure(height_in=3.8)
    axes = figure.add_subplot()
    measured = results.motions.breakaways
    series = list(dict.fromkeys((each.series, each.direction) for each in measured))
    over_time = len({each.dwell_s for each in measured if each.dwell_s}) > 1
    for rank, of in enumerate(series):
        points = [each for each in measured if (each.series, each.direction) == of]
        if over_time:
            points = [each for each in points if each.dwell_s]
        aside = 1.04 ** (rank - (len(series) - 1) / 2)  # of points that would cover each other
        x = [(each.dwell_s or 0.0) * aside if over_time else float(rank) for each in points]
        friction = [each.breakaway_n for each in points]
        interval = [np.nan if each.ci95_n is None else each.ci95_n for each in points]
        look = style.series_style(rank)
        name = f"{series_words(of[0])}, {DIRECTION_WORDS[of[1]]}" if over_time else "_breakaway"
        bars = axes.errorbar(x, friction, interval, label=name, **look, **style.POINTS)
        behind(bars, {"runs": [" ".join(each.runs) for each in points]})
        laws = [law for law in results.motions.dwell_laws if (law.series, law.direction) == of]
        for law in laws[:1]:
            t = np.geomspace(min(x), max(x), 50)
            decades = law.growth * np.log10(t)
            line = law.f_1s_n + decades if law.law == "logarithmic" else law.f_1s_n * 10**decades
            axes.plot(t, line, color=look["color"], lw=1.0, label=f"_{name}, {law.law}")
    if over_time:
        axes.set_xscale("log")
        style.plain_log(axes.xaxis)
        axes.set_xlabel("Time at rest (s)")
    else:
        ticks = [f"{series_words(of)}\n{DIRECTION_WORDS[direction]}" for of, direction in series]
        axes.set_xticks(range(len(series)), ticks)
        axes.margins(x=0.2)
    axes.set_ylabel("Breakaway (N)")
    style.head(axes, "Breakaway", results)
    lines = "; lines: the law with the smaller error" if over_time else ""
    style.read_as(figure, f"Bars: 95 % Student intervals of the trials{lines}.")
    style.legend_above(figure, axes, columns=2)
    return {"": figure}


def has_surfaces(results: Results) -> bool:
    """Return whether a surface of friction over velocity and load exists."""
    return bool(results.motions.surfaces)


def surfaces(results: Results) -> dict[str, Figure]:
    """Draw |F| [N] over speed [mm/s] and load [kN] as a filled contour with the measured points.

    All maps have the same axes, with loads that oppose the motion upwards, and the same scale of
    colours.
    """
    figures = {}
    maps = results.motions.surfaces
    levels = style.common_levels([np.array(surface.friction_n) for surface in maps])
    speeds = style.common_limits([1e3 * np.array(surface.v_m_s) for surface in maps])
    loads = style.common_limits([_against_motion(surface) for surface in maps])
    for surface in maps:
        figure = style.new_figure(height_in=4.0)
        axes = figure.add_subplot()
        v, load = np.array(surface.v_m_s) * 1e3, _against_motion(surface)
        friction = np.array(surface.friction_n)
        filled = axes.contourf(v, load, friction, levels=levels, cmap="cividis")
        lines = axes.contour(
            v, load, friction, levels=filled.levels, colors=style.ON_MAPS, linewidths=0.5
        )
        points = np.array([(speed, force) for force in load for speed in v])
        (dots,) = axes.plot(*points.T, label="_measured", **style.DOTS)
        behind(dots, {"Friction |F| (N)": friction.ravel()})
        axes.set(xlabel="Speed |v| (mm/s)", ylabel="Load against the motion (kN)")
        axes.set(xlim=speeds, ylim=loads)
        style.label_contours(axes, lines)
        axes.grid(visible=False)
        figure.colorbar(filled, ax=axes, label="Friction |F| (N)")
        name = ", ".join(filter(None, (surface.label, TITLES[surface.direction])))
        if len(results.motions.surfaces) > 2 and surface.p_lr_ref_pa is not None:
            name += f", {short(from_si(surface.p_lr_ref_pa, 'bar'))} bar"
        style.head(axes, f"Friction map, {within_title(name)}", results)
        style.read_as(figure, style.OF_MAPS)
        figures[name] = figure
    return figures


def _against_motion(surface: Surface) -> np.ndarray:
    """Return the loads [kN], positive where they oppose the motion."""
    return SIGNS[surface.direction] * np.array(surface.f_load_n) / 1e3
