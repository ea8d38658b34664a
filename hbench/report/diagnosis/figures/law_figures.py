"""Figures of unnamed laws: the shape of what no effect of the catalogue explains."""

import numpy as np
from matplotlib.figure import Figure

from hbench.records import Diagnosis, UnnamedLaw
from hbench.report.diagnosis.names import mathtext
from hbench.report.diagnosis.words.law import balances_words, law_quantities, term
from hbench.report.render import style
from hbench.report.render.numbers import short
from hbench.report.render.series import behind
from hbench.sentences import capital

_HEIGHT_IN = 3.6


def law_figure(diagnosis: Diagnosis, law: UnnamedLaw) -> Figure:
    """Draw a law with its 95 % band; over two quantities a line for each knot of the second."""
    figure = style.new_figure(height_in=_HEIGHT_IN, wide=len(law.knots) == 2)
    axes = figure.subplots()
    shape = [len(knots) for knots in law.knots]
    columns = [np.reshape(each, (shape[0], -1)) for each in (law.values, law.low, law.high)]
    first, unit = np.array(law.knots[0]), law.quantity_units[0]
    first_name, *other_names = (
        f"{name} {mathtext(symbol)}" for name, symbol in law_quantities(law)
    )
    x_label = f"{capital(first_name.strip())} ({unit})"
    y_label = f"{term(law).capitalize()} ({law.unit})"
    for j, (value, low, high) in enumerate(zip(*(each.T for each in columns), strict=True)):
        series = style.series_style(j)
        label = None
        if len(law.knots) == 2:
            second = f"{short(law.knots[1][j])} {law.quantity_units[1]}"
            label = f"{other_names[0].strip()} = {second}"
        axes.fill_between(first, low, high, color=series["color"], alpha=0.15, linewidth=0)
        (line,) = axes.plot(first, value, **series, label=label)
        behind(line, {"low": low, "high": high})
    axes.axhline(0.0, color=style.QUIET, linewidth=0.8)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    style.head(axes, balances_words(law), diagnosis, axes)
    if len(law.knots) == 2:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    return figure
