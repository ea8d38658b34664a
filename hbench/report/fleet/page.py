"""The page of a fleet: campaigns, outliers, distributions, drifts, control charts.

It lists up to 500 campaigns; beyond, its size does not grow with the fleet.
"""

import re
from collections.abc import Iterable, Iterator

from hbench.records import FEWEST_CAMPAIGNS, Fleet, WordTable
from hbench.report.fleet.charts import (
    capability_notes,
    capability_table,
    chart_table,
    signal_table,
    step_table,
    wear_table,
)
from hbench.report.fleet.figures import DISTRIBUTIONS, DRIFTS
from hbench.report.fleet.method import fleet_method
from hbench.report.fleet.names import (
    distinct_names,
    main_spreads,
    of_side,
    range_words,
    without_condition,
    working_speed,
)
from hbench.report.fleet.precision import components_table, limit_sentences, limits_table
from hbench.report.fleet.precision_figures import CHARTS, COMPONENTS, WEAR
from hbench.report.fleet.row import kind_difference, kind_parts
from hbench.report.fleet.text import (
    ROW_WORDS,
    WORST_HEAD,
    campaign_table,
    cells,
    others,
    spread_table,
    trend_table,
)
from hbench.report.fleet.verdict import (
    decision_words,
    fleet_verdict,
    further_sentences,
    steady_trends,
    stepped_numbers,
)
from hbench.report.render.document import BANNERS, Document, Section, Tile, page
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import alike
from hbench.report.render.symbols import capital
from hbench.report.render.word_tables import Cell, Table

_AT = re.compile(r", (?=[\d.]+ bar\b)")  # between a load and its pressure
_FEW = (
    "Histograms are drawn and the standard deviation σ between campaigns is computed from "
    f"{FEWEST_CAMPAIGNS} campaigns on."
)
_NO_TREND = f"Trends are tested from {FEWEST_CAMPAIGNS} campaigns on."
_PRECISION = "Repeatability and reproducibility"
_CORRECTED = (
    "Each campaign is listed with its largest deviation. Expected is the median of the fleet; "
    "where the mean has a step, that of the campaigns before or after it; where a number drifts, "
    "its line. σ contains the scatter between campaigns and that of their trials. A campaign is an "
    "outlier beyond the limit of the table, at which p, corrected for the number of values, is "
    "0.05. This limit is far in a small fleet, since few campaigns determine σ poorly."
)
_ALONE = (
    "The intervals are those of each number alone. p is corrected for the number of trends (Holm), "
    "and can be above 0.05 where the interval does not contain 0."
)
_STEPS = "A number whose mean has a step has no trend: see the table of change points."
_LEAST = 5  # of the worst campaigns that are shown, outliers or not
_TILES = ("friction_n", "efficiency", "half_band_n", "half_band_slope_n_pa")
_ALSO = 2  # further outlying numbers that a row names
_INTERVALS = (
    "Intervals are those of 95 %. They include the stated errors of the instruments, which the "
    "campaigns of a bench have in common: smaller differences between them can be significant. "
    "Values therefore have at least four digits."
)
_AT_MEDIAN = "Half band, middle and energy are those at the median pressure of a campaign."


def fleet_page(fleet: Fleet, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    return page(fleet_document(fleet, drawings))


def fleet_document(fleet: Fleet, drawings: Iterable[Drawing]) -> Document:
    """Return the content of the page."""
    drawings = tuple(drawings)
    sources = [source for source, _ in fleet.sources]
    banner = "Some of the campaigns are simulated." if "simulated" in sources else ""
    if len(sources) == 1:
        banner = BANNERS.get(sources[0], "") if sources[0] == "simulated" else ""
    days = [] if fleet.first is None else [f"{day:%Y-%m-%d}" for day in (fleet.first, fleet.last)]
    span = " to ".join(dict.fromkeys(days))
    return Document(
        f"Fleet of {fleet.campaigns} campaigns",
        " · ".join(filter(None, ("Friction and efficiency of cylinders side by side", span))),
        tuple(_sections(fleet, drawings)),
        fleet_verdict(fleet),
        banner,
        "simulated" if banner else "",
    )


def _sections(fleet: Fleet, drawings: tuple[Drawing, ...]) -> Iterator[Section]:
    left_out = "{} campaigns of this kind at other speeds are left out."
    remark = (left_out.format(fleet.other_speeds),) if fleet.other_speeds else ()
    yield Section(
        "Summary",
        remark,
        items=tuple(further_sentences(fleet)),
        tiles=tuple(_tiles(fleet)),
        tables=_protocols(fleet),
    )
    changed = bool(stepped_numbers(fleet))
    if changed:
        yield _charts(fleet, drawings)
    if fleet.precision:
        yield _precision(fleet, drawings)
    if fleet.rows:
        yield Section("Campaigns", _about_numbers(fleet), tables=(_campaigns(fleet),))
    if fleet.worst:
        yield _deviations(fleet)
    if fleet.spreads:
        chosen = _of(drawings, DISTRIBUTIONS)
        table = _untitled(spread_table(fleet))
        yield Section("Distributions", () if chosen else (_FEW,), drawings=chosen, tables=(table,))
        chosen = _of(drawings, DRIFTS)
        table = _untitled(trend_table(fleet))
        if table.rows:
            words = f"{_ALONE} {_STEPS}" if changed else _ALONE
            yield Section("Drifts", (words,), drawings=chosen, tables=(table,))
        elif chosen:
            each = Section(f"Each number over time ({len(chosen)})", drawings=chosen, folded=True)
            yield Section("Drifts", (_NO_TREND,), parts=(each,))
    if fleet.capabilities or fleet.without_capability:
        table = _untitled(capability_table(fleet))
        known = (table,) if table.rows else ()
        yield Section("Capability", tuple(capability_notes(fleet)), tables=known)
    if fleet.charts and not changed:
        yield _charts(fleet, drawings)
    if fleet.wear:
        table = _untitled(wear_table(fleet))
        yield Section("Wear", drawings=_of(drawings, WEAR), tables=(table,))
    if fleet.plan_notes and not fleet.precision:
        yield Section(_PRECISION, tuple(fleet.plan_notes))
    if fleet.failed:
        yield _failures(fleet)
    yield Section("How it was computed", facts=tuple(fleet_method(fleet)), anchor="method")


def _charts(fleet: Fleet, drawings: tuple[Drawing, ...]) -> Section:
    """Return the control charts with their steps; directly below the summary if one is real."""
    signals = signal_table(fleet)
    tables = (step_table(fleet), _untitled(chart_table(fleet)))
    title = f"Signals of the control charts ({len(signals.rows)})"
    each = (Section(title, tables=(_untitled(signals),), folded=True),) if signals.rows else ()
    shown = tuple(table for table in tables if table.rows)
    speed = working_speed(fleet)
    words = (
        f"Each value is the mean over the loads{f' at {speed}' if speed else ''}. The charts of a "
        "station (hbench watch --station) show the values of the limits, at one load and speed."
    )
    note = (words,) if fleet.decisions else ()
    return Section("Control charts", note, drawings=_of(drawings, CHARTS), tables=shown, parts=each)


def _deviations(fleet: Fleet) -> Section:
    """Return the outliers, or folded the campaigns that deviate most."""
    table = _worst(fleet)
    if not fleet.outliers:
        none = ("No campaign deviates significantly.",)
        title = f"The {len(table.rows)} campaigns that deviate most"
        each = Section(title, (_CORRECTED,), tables=(table,), folded=True)
        return Section("Largest deviations", none, parts=(each,), anchor="worst")
    if fleet.outliers >= _LEAST:
        return Section("Outliers", tables=(table,), anchor="worst")
    marked = f"Only campaigns marked as outliers deviate significantly. {_CORRECTED}"
    return Section("Largest deviations", (marked,), tables=(table,), anchor="worst")


def _precision(fleet: Fleet, drawings: tuple[Drawing, ...]) -> Section:
    study = fleet.precision[0]
    cylinders = "1 cylinder" if study.cylinders == 1 else f"{study.cylinders} cylinders"
    words = (
        f"{study.campaigns} campaigns of {cylinders}. s_r is the standard deviation of the trials "
        "of a campaign, s_R that under all conditions that the plan varies. Units are those of "
        "the number."
    )
    tables = (_untitled(limits_table(fleet)), components_table(fleet))
    notes = (*limit_sentences(fleet), words, *fleet.plan_notes)
    return Section(_PRECISION, notes, drawings=_of(drawings, COMPONENTS), tables=tables)


def _of(drawings: tuple[Drawing, ...], section: str) -> tuple[Drawing, ...]:
    return tuple(drawing for drawing in drawings if drawing.section == section)


def _tiles(fleet: Fleet) -> Iterator[Tile]:
    good = fleet.campaigns - fleet.failed
    about = [f"analysed, {fleet.failed} failed" if fleet.failed else "analysed"]
    if fleet.decisions:
        about.append(f"decisions: {decision_words(fleet)}")
    if fleet.qualities:
        grades = ", ".join(f"{count} {grade}" for grade, count in fleet.qualities)
        why = ", ".join(
            name if count == good else f"{name} in {count}" for name, count in fleet.weak_checks
        )
        about.append(f"data: {grades}{f' (because of {why})' if why else ''}")
    yield Tile(f"{good} of {fleet.campaigns}", "campaigns", "; ".join(about))
    if fleet.outliers:
        caption = f"{'outlier' if fleet.outliers == 1 else 'outliers'} among the campaigns"
        yield Tile(str(fleet.outliers), "", caption, "method-outliers")
    stepped, trends = stepped_numbers(fleet), steady_trends(fleet)
    if fleet.charts or trends:
        drifting = sum(trend.real for trend in trends)
        of = len(trends) + len(stepped)
        parts = [f"{len(stepped)} by a step"] if stepped else []
        parts += [f"{drifting} by a steady drift"] if drifting else []
        changed = f"tested numbers changed over time{': ' * bool(parts)}{', '.join(parts)}"
        how = "method-change-points" if stepped else "method-trends"
        yield Tile(f"{len(stepped) + drifting} of {of}", "", changed, how)
    for spread in main_spreads(fleet):
        if spread.quantity.name in _TILES:
            scale = spread.quantity.scale
            value = alike((scale * spread.low, scale * spread.high))
            words = f"{without_condition(spread.quantity)}{of_side(spread.direction)}"
            caption = f"{words[0].lower()}{words[1:]}: {range_words(spread.n)}"
            yield Tile(value, spread.quantity.unit, caption, "method-spread")


def _protocols(fleet: Fleet) -> tuple[Table, ...]:
    evaluated = fleet.protocols[0][0] if fleet.protocols else ""
    several = len(fleet.protocols) > 1
    groups = [
        f"not compared: {kind_difference(protocol, evaluated)}" for protocol, _ in fleet.protocols
    ]
    groups[:1] = ["evaluated here"][: len(groups)]
    kinds = [kind_parts(protocol) for protocol, _ in fleet.protocols]
    given = [name for name in kinds[0] if any(kind[name] for kind in kinds)] if kinds else []
    rows = tuple(
        (
            Cell(str(count)),
            *(Cell(_AT.sub(" at ", "; ".join(kind[name]))) for name in given),
            *([Cell(group)] if several else []),
        )
        for (_, count), kind, group in zip(fleet.protocols, kinds, groups, strict=True)
    )
    title = "Kinds of campaigns" if several else "Kind of campaign"
    pressures = any(_AT.search(protocol) for protocol, _ in fleet.protocols)
    loads = "; loads at rod-side pressures of the load cylinder" if pressures else ""
    title += f" (size: areas of piston and rod side{loads})"
    head = ("Campaigns", *map(capital, given), *(["Group"] if several else []))
    return (Table(head, rows, frozenset(head[1:]), title=title),) if rows else ()


def _about_numbers(fleet: Fleet) -> tuple[str, ...]:
    """Return what the intervals of the campaigns' numbers contain, and at which pressure."""
    if any(spread.direction is None for spread in fleet.spreads):
        return (_INTERVALS, _AT_MEDIAN)
    return (_INTERVALS,)


def _campaigns(fleet: Fleet) -> Table:
    words = campaign_table(fleet)
    decision = words.head.index("Decision") if "Decision" in words.head else -1
    rows = tuple(
        tuple(
            Cell(text, link=campaign.report)
            if column == 0
            else Cell("", text)
            if column == decision and text not in ("", "PASS")
            else Cell(text)
            for column, text in enumerate(row)
        )
        for campaign, row in zip(fleet.rows, words.rows, strict=True)
    )
    text_columns = frozenset({*ROW_WORDS, "Remark"})
    return Table(words.head, rows, text_columns, sortable=len(rows) > 1)


def _worst(fleet: Fleet) -> Table:
    rows = []
    names = distinct_names([suspect.path for suspect in fleet.worst])
    for suspect in fleet.worst[: max(fleet.outliers, _LEAST)]:
        name = names[suspect.path]
        flag = "outlier" if suspect.deviations[0].outlier else ""
        remarks = (
            *([] if suspect.started is None else [f"{suspect.started:%Y-%m-%d}"]),
            *([] if suspect.quality == "good" else [f"data: {suspect.quality}"]),
            _also(tuple(others(suspect))),
        )
        numbers = map(Cell, cells(suspect)[:-1])
        rows.append(
            (Cell(name, flag, suspect.report), *numbers, Cell("; ".join(filter(None, remarks))))
        )
    last = "Started; remarks"
    text_columns = frozenset({"Campaign", "Quantity", last})
    return Table(("Campaign", *WORST_HEAD[:-1], last), tuple(rows), text_columns)


def _also(further: tuple[str, ...]) -> str:
    """Write the first of the further numbers in which a campaign is an outlier."""
    if not further:
        return ""
    rest = f" and {len(further) - _ALSO} more" if len(further) > _ALSO else ""
    return f"also {', '.join(further[:_ALSO])}{rest}"


def _failures(fleet: Fleet) -> Section:
    reasons = Table(
        ("Campaigns", "Reason"),
        tuple((Cell(str(count)), Cell(reason)) for reason, count in fleet.reasons),
        frozenset({"Reason"}),
    )
    rows = tuple((Cell(path), Cell(reason)) for path, reason in fleet.failures)
    first = Table(("Folder", "Reason"), rows, frozenset({"Folder", "Reason"}))
    title = f"The first {len(rows)} of them" if fleet.failed > len(rows) else "Each of them"
    subsections = (Section(title, tables=(first,), folded=True),)
    return Section("Not analysed", tables=(reasons,), parts=subsections, anchor="failed")


def _untitled(table: WordTable) -> WordTable:
    return WordTable("", table.head, table.rows)
