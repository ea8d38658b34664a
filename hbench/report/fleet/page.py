"""The page of a fleet: the first screen, its campaigns, and folded, each quantity and each test.

It lists up to 500 campaigns; beyond, its size does not grow with the fleet.
"""

from collections.abc import Iterable, Iterator

from hbench.records import FEWEST_CAMPAIGNS, Fleet, Quantity, WordTable
from hbench.records.numbers import SIGNIFICANCE
from hbench.report.fleet.charts import (
    capability_notes,
    capability_table,
    chart_table,
    signal_table,
    step_table,
    wear_table,
)
from hbench.report.fleet.figures import DISTRIBUTIONS
from hbench.report.fleet.method import fleet_method
from hbench.report.fleet.names import campaign_names, in_sentence
from hbench.report.fleet.overview import (
    fleet_identity,
    fleet_tiles,
    interval_facts,
    overview_table,
)
from hbench.report.fleet.precision import components_table, limit_sentences, limits_table
from hbench.report.fleet.precision_figures import COMPONENTS, WEAR
from hbench.report.fleet.row import at_pressure, kind_difference, kind_parts
from hbench.report.fleet.text import (
    ROW_WORDS,
    WORST_HEAD,
    campaign_table,
    cells,
    others,
    shared_intervals,
    spread_table,
    trend_table,
)
from hbench.report.fleet.verdict import (
    fleet_verdict,
    further_sentences,
    steady_spreads,
)
from hbench.report.render.document import BANNERS, Document, Section, page
from hbench.report.render.figures import Drawing, of_section
from hbench.report.render.word_tables import Cell, Table
from hbench.sentences import capital

_FEW = (
    "Histograms, limits, trends and the standard deviation σ between campaigns are computed from "
    f"{FEWEST_CAMPAIGNS} campaigns on."
)
_PRECISION = "Repeatability and reproducibility"
_CORRECTED = (
    "Each campaign is listed with its largest deviation. Expected is the median of the fleet; "
    "where the mean has a step, that of the campaigns before or after it; where a number drifts, "
    "its line. σ contains the scatter between campaigns and that of their trials. A campaign is an "
    "outlier beyond the limit of the table, at which p, corrected for the number of values, is "
    f"{SIGNIFICANCE:g}. This limit is far in a small fleet, since few campaigns determine σ poorly."
)
_ALONE = (
    "The intervals are those of each number alone. p is corrected (Holm) for all {count} trends "
    "that were tested, and can be above {level:g} where the interval does not contain 0. A number "
    "whose mean has a step is tested too, but the table of change points replaces its trend."
)
_CENTRED = (
    "σ between campaigns is about the mean before and after a step, or about the line of a drift: "
    "it is smaller than the range of the values shows."
)
_LEAST = 5  # of the worst campaigns that are shown, outliers or not
_ALSO = 2  # further outlying numbers that a row names
_INTERVALS = (
    "Intervals contain the errors of the instruments, which the campaigns of a bench have in "
    "common: smaller differences between campaigns can be significant."
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
        identity=fleet_identity(fleet),
    )


def _of_trends(fleet: Fleet, *, changed: bool) -> str:
    """Return what intervals and p of the drifts are; ``changed``: some numbers have a step."""
    count = sum(spread.trend is not None for spread in fleet.spreads)
    words = _ALONE.format(count=count, level=SIGNIFICANCE)
    return words if changed else words.rpartition(" A number")[0]


def _sections(fleet: Fleet, drawings: tuple[Drawing, ...]) -> Iterator[Section]:
    left_out = "{} campaigns of this kind at other speeds are left out."
    remark = (left_out.format(fleet.other_speeds),) if fleet.other_speeds else ()
    overview = overview_table(fleet)
    leading, *others = _figures(fleet, drawings) or [Section()]
    few = () if of_section(drawings, DISTRIBUTIONS) or not fleet.spreads else (_FEW,)
    yield Section(
        "Summary",
        (*remark, *few),
        items=tuple(further_sentences(fleet)),
        tiles=tuple(fleet_tiles(fleet)),
        drawings=leading.drawings,
        tables=(*((overview,) if overview.rows else ()), *_protocols(fleet)),
        facts=interval_facts(fleet),
        parts=tuple(others),
    )
    if fleet.outliers:
        yield _deviations(fleet)
    if fleet.rows:
        why = " ".join(() if fleet.precision else fleet.plan_notes)
        notes = (f"{_PRECISION} are not estimated. {why}",) if why else ()
        yield Section("Campaigns", (*_about_numbers(fleet), *notes), tables=(_campaigns(fleet),))
    if fleet.capabilities or fleet.without_capability:
        table = _untitled(capability_table(fleet))
        known = (table,) if table.rows else ()
        yield Section("Capability", tuple(capability_notes(fleet)), tables=known)
    if fleet.precision:
        yield _precision(fleet, drawings)
    if fleet.wear:
        table = _untitled(wear_table(fleet))
        yield Section("Wear", drawings=of_section(drawings, WEAR), tables=(table,))
    if fleet.failed:
        yield _failures(fleet)
    if tests := tuple(_tests(fleet)):
        yield Section("Scatter and tests", parts=tests, folded=True)
    facts = tuple(fleet_method(fleet))
    yield Section("How it was computed", facts=facts, folded=True, anchor="method")


def _figures(fleet: Fleet, drawings: tuple[Drawing, ...]) -> list[Section]:
    """Return the figures of each quantity, folded; those of a quantity that changed are first."""
    changed = {c.quantity for c in fleet.charts if c.step is not None and c.step.real}
    changed |= {spread.quantity for spread, trend in steady_spreads(fleet) if trend.real}
    quantities = dict.fromkeys(spread.quantity for spread in fleet.spreads)
    return [
        Section(f"Figures: {in_sentence(quantity)}", drawings=chosen, folded=True)
        for quantity in sorted(quantities, key=lambda each: each not in changed)
        if (chosen := _of_quantity(drawings, quantity))
    ]


def _of_quantity(drawings: tuple[Drawing, ...], quantity: Quantity) -> tuple[Drawing, ...]:
    """Return the control charts; distribution and course only where there is none."""
    name = quantity.name.replace("_", "-")
    charts = [f"control-{name}{side}" for side in ("", "-extend", "-retract")]
    found = {drawing.name: drawing for drawing in drawings}
    for names in (charts, [f"distribution-{name}", f"drift-{name}"]):
        if chosen := tuple(found[each] for each in names if each in found):
            return chosen
    return ()


def _tests(fleet: Fleet) -> Iterator[Section]:
    """Yield the tables of spread, changes, control limits and deviations."""
    changed = any(chart.step is not None and chart.step.real for chart in fleet.charts)
    signals = signal_table(fleet)
    for title, table, words in (
        ("Spread of each number", spread_table(fleet), _CENTRED if fleet.charts else ""),
        ("Change points", step_table(fleet), ""),
        ("Drifts", trend_table(fleet), _of_trends(fleet, changed=changed)),
        ("Control limits", chart_table(fleet), ""),
        ("Signals of the control charts", signals, ""),
    ):
        if table.rows:
            notes = (words,) if words else ()
            yield Section(title, notes, tables=(_untitled(table),))
    if fleet.worst and not fleet.outliers:
        yield _deviations(fleet)


def _deviations(fleet: Fleet) -> Section:
    """Return the outliers, or folded the campaigns that deviate most."""
    table = _worst(fleet)
    if not fleet.outliers:
        title = "Campaigns that deviate most, none significantly"
        return Section(title, (_CORRECTED,), tables=(table,), anchor="worst")
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
    return Section(_PRECISION, notes, drawings=of_section(drawings, COMPONENTS), tables=tables)


def _protocols(fleet: Fleet) -> tuple[Table, ...]:
    """Return the kinds of campaigns, if there are several: one is the page's identity."""
    if len(fleet.protocols) < 2:
        return ()
    evaluated = fleet.protocols[0][0]
    groups = [
        f"not compared: {kind_difference(protocol, evaluated)}" for protocol, _ in fleet.protocols
    ]
    groups[0] = "evaluated here"
    kinds = [kind_parts(protocol) for protocol, _ in fleet.protocols]
    given = [name for name in kinds[0] if any(kind[name] for kind in kinds)]
    rows = tuple(
        (
            Cell(str(count)),
            *(Cell(at_pressure("; ".join(kind[name]))) for name in given),
            Cell(group),
        )
        for (_, count), kind, group in zip(fleet.protocols, kinds, groups, strict=True)
    )
    pressures = any(at_pressure(protocol) != protocol for protocol, _ in fleet.protocols)
    loads = "; loads at rod-side pressures of the load cylinder" if pressures else ""
    title = f"Kinds of campaigns (size: areas of piston and rod side{loads})"
    head = ("Campaigns", *map(capital, given), "Group")
    return (Table(head, rows, frozenset(head[1:]), title=title),)


def _about_numbers(fleet: Fleet) -> tuple[str, ...]:
    """Return the intervals of the campaigns' numbers, and at which pressure these are."""
    median = any(spread.direction is None for spread in fleet.spreads)
    words = (shared_intervals(fleet), _INTERVALS, _AT_MEDIAN if median else "")
    return (" ".join(filter(None, words)),)


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
    names = campaign_names(fleet)
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
