"""Figures of a phenomenon: one a panel, simulated points beside lines of theory."""

from matplotlib import rc_context
from matplotlib.figure import Figure

from hbench.records import Panel, Phenomenon
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches


def draw_phenomenon(phenomenon: Phenomenon) -> tuple[Drawing, ...]:
    """Draw every panel of a phenomenon by itself."""
    sketches = []
    for panel in phenomenon.panels:
        name = f"{phenomenon.name}-{panel.name}"
        with rc_context(style.RC):
            figure = draw_panel(panel)
        sketches.append(Sketch(name, phenomenon.name, panel.title, "", figure))
    return draw_sketches(sketches)


def draw_panel(panel: Panel) -> Figure:
    """Draw one panel; a series of points has the colour of the line before it."""
    figure = style.new_figure(height_in=3.8)
    axes = figure.add_subplot()
    colour = -1
    for index, line in enumerate(panel.lines):
        beside = line.points and index > 0 and not panel.lines[index - 1].points
        colour += not beside
        look = style.series_style(colour, hollow=True)
        if line.points:
            axes.plot(line.x, line.y, linestyle="none", label=line.label, **look)
        else:
            axes.plot(line.x, line.y, color=look["color"], label=line.label)
    axes.set(xlabel=panel.x_label, ylabel=panel.y_label)
    axes.set_xscale("log" if panel.x_log else "linear")
    axes.set_yscale("log" if panel.y_log else "linear")
    for axis, is_log in ((axes.xaxis, panel.x_log), (axes.yaxis, panel.y_log)):
        if is_log:
            style.plain_log(axis)
    for x, text in panel.marks:
        axes.axvline(x, color=style.QUIET, linewidth=0.9, linestyle=":", zorder=1)
        axes.annotate(
            text,
            (x, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(4, -12),
            textcoords="offset points",
            color=style.QUIET,
            fontsize=10,
        )
    for x, y, text in panel.names:
        axes.annotate(text, (x, y), xytext=(4, -12), textcoords="offset points", fontsize=11)
    axes.set_title(panel.title)
    style.mark_sources(axes, ["simulated"], "")
    style.legend_above(figure, axes, columns=2)
    return figure
