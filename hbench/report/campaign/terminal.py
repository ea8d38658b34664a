"""Results for a terminal: runs, reasons for rejection, and a line for each curve.

Intervals are half-widths at 95 %: of the trials, and U of trials and instruments.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from hbench.records import DIRECTION_WORDS, KINDS, Curve, Fit, FitParameter, Results, WordTable
from hbench.records.friction_laws import parameter_named
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.fit_tables import label_and_unit, law_words, parameter_cell
from hbench.report.campaign.motion_rows import motion_lines
from hbench.report.campaign.page_tables import balance_table, band_table, trend_table
from hbench.report.campaign.quality.verdict import quality_verdict
from hbench.report.campaign.reasons import aborted_words, reason_counts
from hbench.report.campaign.series_words import kind_words, load_words
from hbench.report.campaign.table_columns import BALANCE, OF_DIRECTIONS
from hbench.report.drift import drift_reserve, drift_words
from hbench.report.fit_intervals import fit_interval_words
from hbench.report.headline import headline_words, possible_drift_words
from hbench.report.next_step import next_step_words
from hbench.report.oil_words import temperature_words
from hbench.report.render.numbers import significant, span, with_interval
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import wrapped
from hbench.report.render.word_tables import Table
from hbench.sentences import counted

_REFERENCE = re.compile(r"; \[\[\w+\]\]")  # to a table of the page
_ANCHOR = re.compile(r"\[\[\w+\]\]")


def summary_text(results: Results, decision: str = "") -> str:
    """Return runs, reasons, the page's verdict, and a line for each curve.

    ``decision`` is that of the last acceptance, if there was one.
    """
    accepted = sum(run.accepted for run in results.runs)
    reasons = ", ".join(
        f"{n} {code.replace('_', ' ')}" for code, n in reason_counts(results).most_common()
    )
    rejected = f"{len(results.runs) - accepted} rejected" + (f" ({reasons})" if reasons else "")
    kinds = Counter(KINDS[run.run.plan.kind] for run in results.runs)
    several = len(kinds) > 1 or not all(kind.has_constant_speed for kind in kinds)
    kind_counts = ", ".join(kind.counted(count) for kind, count in kinds.items())
    of_kinds = f" ({kind_counts})" if several else ""
    curves = without_common_rod_pressure(results.curves)
    intervals = _known_intervals(curves)
    columns = ("direction", "load", "speeds mm/s", "friction N", *intervals)
    rows = [
        (
            _name(curve),
            load_words(curve.f_load_n, curve.p_lr_ref_pa) or "not set",
            span([1e3 * abs(point.v_m_s) for point in curve.points]),
            _friction_words(curve),
            *(_interval_words(curve, field) for field in intervals.values()),
        )
        for curve in curves
    ]
    lines = list(table_lines(WordTable("Friction against the motion", columns, tuple(rows))))
    head = f"{results.provenance.name} ({results.provenance.source})"
    counts = f"{counted(len(results.runs), 'run')}{of_kinds}: {accepted} accepted, {rejected}"
    notes = [f"note: {note}" for note in results.notes]
    if results.drift is not None:
        notes.insert(0, f"drift: friction changed by {drift_words(results.drift)}")
    if oil := temperature_words(results):
        notes.insert(0, f"oil: {oil.removesuffix('.')}")
    fits = [line for each in _fit_tables(curves) for line in ("", *table_lines(each))]
    lines += [*fits, *(line for words in _joint_words(results) for line in wrapped(words))]
    lines += wrapped(f"fits: {fit_interval_words(results)}") if fits else []
    table = ["", *lines] if results.curves else []
    moving = [line for words in motion_lines(results.motions) for line in wrapped(words)]
    bands = [line for each in _band_tables(results) for line in ("", *table_lines(each))]
    moving = ["", *moving] if moving else []
    drift = possible_drift_words(results)
    alarm = aborted_words(results)
    verdict = (
        f"{decision} by the last hbench accept." if decision else "",
        headline_words(results),
        quality_verdict(results.quality, not alarm, stated=bool(drift)),
        "" if drift else drift_reserve(results.drift),
        _ANCHOR.sub("report.html", _REFERENCE.sub("", next_step_words(results))),
    )
    verdicts = wrapped(" ".join(filter(None, verdict)).replace("–", " to "))
    paragraphs = [line for note in notes for line in wrapped(note)]
    top = [head, *wrapped(alarm), *wrapped(counts), *verdicts]
    lines = [*top, *table, *bands, *moving, *([""] if bands else [])]
    text = "\n".join([*lines, *paragraphs])
    text = text.replace("−", "-").replace("²", "^2").replace("±", "+-")
    return text.replace("–", " to ")  # not every terminal can show them


def _name(curve: Curve) -> str:
    """Write label, kind and direction of a curve; a label that is the direction is left out."""
    label = "" if curve.label == DIRECTION_WORDS[curve.direction] else curve.label
    return " ".join(filter(None, (label, kind_words(curve), curve.direction)))


def _friction_words(curve: Curve) -> str:
    """Write friction against the motion; negative where it acts with the motion."""
    sign = curve.against_motion
    if len(curve.points) != 1:
        return span([sign * point.friction_n for point in curve.points])
    (point,) = curve.points
    return with_interval(sign * point.friction_n, point.ci95_n).partition(" ±")[0]


def _known_intervals(curves: Sequence[Curve]) -> dict[str, str]:
    """Return the headings of the intervals that any point has, with their fields.

    Those of the trials do not contain the errors of the instruments; those of U do.
    """
    points = [point for curve in curves for point in curve.points]
    headings = {"trials +- N": "ci95_n", "U +- N": "u95_n"}
    return {
        heading: field
        for heading, field in headings.items()
        if any(getattr(point, field) is not None for point in points)
    }


def _interval_words(curve: Curve, field: str) -> str:
    """Write the range of the points' half-widths, and how many have one unless all have."""
    halves = [getattr(point, field) for point in curve.points]
    known = [half for half in halves if half is not None]
    if not known:
        return "-"
    low, high = (significant(half, 2) for half in (min(known), max(known)))
    text = low if low == high else f"{low}–{high}"
    return text if len(known) == len(halves) else f"{text} ({len(known)} of {len(halves)})"


def _band_tables(results: Results) -> tuple[WordTable, ...]:
    """Return the tables of friction bands that have rows, without each direction's friction."""
    tables = (
        _words("Friction bands", band_table(results), OF_DIRECTIONS),
        _words("Friction bands over pressure", trend_table(results)),
        _words(BALANCE, balance_table(results)),
    )
    return tuple(table for table in tables if table.rows)


def _words(title: str, table: Table, without: tuple[str, ...] = ()) -> WordTable:
    kept = [i for i, name in enumerate(table.head) if name not in without]
    rows = tuple(tuple(row[i].text for i in kept) for row in table.rows)
    return WordTable(title, tuple(table.head[i] for i in kept), rows)


def _fit_tables(curves: Sequence[Curve]) -> Iterator[WordTable]:
    """Yield a table for each law that is the first of some curves, a row a curve."""
    firsts = [(curve, fit) for curve in curves for fit in curve.fits[:1]]
    for law in dict.fromkeys(fit.law for _, fit in firsts):
        chosen = [(curve, fit) for curve, fit in firsts if fit.law == law]
        names = list(dict.fromkeys(name for _, fit in chosen for name in fit.parameters))
        units = {name: p.unit for _, fit in chosen for name, p in fit.parameters.items()}
        rows = tuple(
            (
                _name(curve),
                load_words(curve.f_load_n, curve.p_lr_ref_pa) or "not set",
                *(_value(name, fit.parameters.get(name)) for name in names),
                "" if fit.converged else "NOT CONVERGED",
            )
            for curve, fit in chosen
        )
        heads = (f"{_symbol(name)} {label_and_unit(name, units[name])[1]}" for name in names)
        title = f"{law_words(law)} fits (-: not determined; ?: hardly determined)"
        yield WordTable(title, ("direction", "load", *heads, ""), rows)


def _joint_words(results: Results) -> list[str]:
    """Return the fits of all curves at once."""
    words = []
    for joint in results.joint_fits:
        label = f"{joint.label}: " if joint.label else ""
        fits = "; ".join(map(_fit_words, joint.fits))
        words.append(f"fit, {label}all {joint.curves} curves at once: {fits}")
    return words


def _symbol(name: str) -> str:
    known = parameter_named(name)
    return name if known is None else known.symbol


def _value(name: str, parameter: FitParameter | None) -> str:
    """Write a parameter's value with its interval; one at a bound is not determined."""
    if parameter is None or parameter.at_bound or parameter.determination == "not determined":
        return "-"
    text = parameter_cell(name, parameter).text
    return text if parameter.determination == "determined" else f"{text} ?"


def _fit_words(fit: Fit) -> str:
    parameters = ", ".join(_parameter(name, each) for name, each in fit.parameters.items())
    return f"{law_words(fit.law)}: {parameters}{'' if fit.converged else ', NOT CONVERGED'}"


def _parameter(name: str, parameter: FitParameter) -> str:
    """Write a parameter with its symbol and unit; one at a bound is not determined."""
    symbol, value = _symbol(name), _value(name, parameter)
    if value == "-":
        return f"{symbol} not determined"
    words = f"{symbol} {value.removesuffix(' ?')} {label_and_unit(name, parameter.unit)[1]}"
    return f"{words} (hardly determined)" if value.endswith(" ?") else words
