"""Drift of friction over a campaign, in words and as a table."""

import math

from hbench.records import Drift
from hbench.records.numbers import SIGNIFICANCE
from hbench.report.render.numbers import (
    NONE,
    number,
    p_equation,
    p_words,
    with_interval,
)
from hbench.report.render.word_tables import Cell, Table

_HOUR_S = 3600.0


def drift_fact(drift: Drift | None) -> str:
    """State a drift that is significant or not separated from speed; empty otherwise."""
    if drift is None or drift.separated and not drift.significant:
        return ""
    finding = drift_finding(drift) if drift.significant else _not_excluded(drift)
    return " ".join(filter(None, (f"{finding}.", drift_advice(drift))))


def drift_words(drift: Drift) -> str:
    """Return the drift, its test, and whether the plan separates it from speed, as a clause."""
    change = with_interval(drift.change_percent, drift.change_percent_ci95)
    how = "significant" if drift.significant else "not significant"
    if not drift.has_size:
        return (
            f"an unknown amount: it drifts between the trials ({how}, {p_equation(drift.p)}), but "
            "no times of the runs are known"
        )
    basis = "" if drift.basis == "time" else ", by their order since no times are known"
    text = f"{change} % from the first to the last steady run{basis} ({how}, {p_equation(drift.p)})"
    if drift.separated:
        apart = ", separated from speed by the order of the runs"
        return f"{text}{apart if drift.several_speeds else ''}"
    text = f"{text}, not separated from speed by the order of the runs"
    if drift.significant:
        return text
    return f"{text}: up to {possible_words(drift)} is possible"


def drift_finding(drift: Drift) -> str:
    """Return what the data shows of a drift, in one sentence without its full stop."""
    if not drift.significant:
        text = _not_excluded(drift)
        return text if drift.separated else f"{text}, and would appear as an effect of speed"
    if drift.of_unknown_size:
        return (
            f"Friction drifts between the trials ({p_equation(drift.p)}); its change over the "
            "campaign is not known, since no times of the runs are"
        )
    change = with_interval(drift.change_percent, drift.change_percent_ci95)
    text = f"Friction changed by {change} % over the campaign"
    return text if drift.separated else f"{text}, which the order of the runs mixes with speed"


def _not_excluded(drift: Drift) -> str:
    return f"A drift of up to {possible_words(drift)} over the campaign cannot be excluded"


def possible_words(drift: Drift) -> str:
    """Write the largest drift that the trials do not exclude: change and interval as written."""
    change, half = with_interval(drift.change_percent, drift.change_percent_ci95).split(" ± ")
    return f"{math.ceil(float(change.strip('−')) + float(half))} %"


def drift_reserve(drift: Drift | None) -> str:
    """State a drift that U does not contain and that no check of the data grades; else empty.

    That is a large one that cannot be excluded, or a significant one that is mixed with speed,
    where only the order of the runs is known.
    """
    if drift is None or not drift.of_unknown_size:
        return ""
    if drift.hidden:
        most = possible_words(drift)
        return f"A drift of up to {most} cannot be excluded, and U does not contain it."
    return "U does not contain the drift between the trials." if drift.significant else ""


def drift_outside_u(drift: Drift | None) -> str:
    """State that U and the probabilities of a decision do not contain such a drift; or empty."""
    if not drift_reserve(drift) or drift is None:
        return ""
    text = "U and the probabilities of conformity do not contain a drift of friction"
    if drift.significant:
        return f"{text} between the trials ({p_equation(drift.p)}), whose size is not known"
    return f"{text} of up to {possible_words(drift)}, which cannot be excluded"


def drift_with_oil(drift: Drift) -> str:
    """Return the oil's change of temperature, and how friction goes with it, as a sentence.

    Empty if it was not measured. A change over an order that may be that of names is not stated.
    """
    if drift.temp_change_k is None:
        return ""
    rose = "rose" if drift.temp_change_k >= 0 else "fell"
    change = f"Meanwhile the oil temperature {rose} by {number(abs(drift.temp_change_k), 1)} K"
    known = drift.has_temp_change
    if drift.temp_correlation is None or drift.temp_p is None:
        return f"{change}." if known else ""
    beginning = f"{change}; within" if known else "Within"
    which = f"correlation {number(drift.temp_correlation, 2)}, {p_equation(drift.temp_p)}"
    oil = "it" if known else "the oil temperature"
    if drift.temp_p >= SIGNIFICANCE:
        way = f"does not correlate with {oil}"
    else:
        way = f"falls as {oil} rises" if drift.temp_correlation < 0 else f"rises with {oil}"
    return f"{beginning} the points, friction {way} ({which})."


def drift_advice(drift: Drift) -> str:
    """Return what a drift, or a plan that does not separate it, means for the numbers."""
    if drift.separated:
        if not drift.significant:
            return ""
        return (
            "The trials of each point are spread over the campaign, so the curves show its mean "
            "friction, and the intervals of the points include the drift."
        )
    if drift.of_unknown_size:
        return (
            "U does not contain it. The order of imported runs may be that of their files and not "
            "that in time: map a column of date-times as t_s if the files have one. Measure the "
            "operating points of the next campaign in random order."
        )
    repeat = "Repeat the campaign with order: random in the schedule."
    if drift.significant:
        return (
            "Differences between speeds contain the drift: fitted parameters such as the viscous "
            f"friction are biased, and their intervals do not include this. {repeat}"
        )
    return f"A drift would appear as an effect of speed, and is not part of U. {repeat}"


def drift_table(drift: Drift) -> Table:
    """Return the estimate with its interval, the test and the plan's separation, as one row."""
    percent = drift.scale == "relative"
    scale, unit = (100.0, "%") if percent else (1.0, "N")
    per_hour: tuple[str, ...] = ()
    if drift.per_hour is not None and (drift.span_s or 0.0) >= _HOUR_S:  # else extrapolated
        rate = with_interval(scale * drift.per_hour, scale * (drift.per_hour_ci95 or 0.0))
        per_hour = (f"{rate} {unit}/h",)
    head = (
        *(
            "Change over the campaign",
            *["Per hour"] * len(per_hour),
            "Span",
            "p",
            "Points",
            "Trials",
        ),
        *("VIF of time by speed", "Share between speeds (%)", "Separated from speed"),
    )
    change = f"{with_interval(scale * drift.change, scale * drift.change_ci95)} {unit}"
    row = (
        change if drift.has_size else "not known",
        *per_hour,
        f"{drift.trials} trials" if drift.span_s is None else _minutes(drift.span_s),
        p_words(drift.p),
        str(drift.points),
        str(drift.trials),
        number(drift.speed_vif if drift.several_speeds else None),
        number(100 * drift.speed_share if drift.several_speeds else None, 0),
        ("yes" if drift.separated else "no") if drift.several_speeds else NONE,
    )
    words = frozenset({"Separated from speed"})
    return Table(
        head,
        (tuple(map(Cell, row)),),
        words,
        title="Size, significance and separation of the drift",
    )


def _minutes(seconds: float) -> str:
    return f"{number(seconds / 60)} min"
