"""The page of a fleet: what stands out, distributions, drifts; its size is that of no fleet."""

from collections.abc import Iterable, Iterator
from pathlib import PurePath

from hbench.records import Fleet, WordTable
from hbench.report.fleet.figures import DISTRIBUTIONS, DRIFTS
from hbench.report.fleet.text import (
    WORST_HEAD,
    cells,
    others,
    spread_table,
    trend_table,
    verdict,
)
from hbench.report.render.document import BANNERS, Document, Section, Tile, page
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import alike
from hbench.report.render.style import TITLES
from hbench.report.render.word_tables import Cell, Table

_LEAST = 5  # of the worst campaigns that are shown, outliers or not
_ALSO = 2  # further outlying numbers that a row names
_METHOD = (
    (
        "Numbers",
        "Those of each campaign's report. Where a direction has several loads it is the mean over "
        "them, and only where all of them have the number. Its interval is the mean of theirs, as "
        "wide as if their errors were the same.",
    ),
    (
        "Compared",
        "Only campaigns of the same kind: areas of piston and rod side, loads and working speed. "
        "Those of the most frequent kind are judged here; analyze others by a call of their own.",
    ),
    (
        "Spread",
        "A campaign's number is taken as m + b + e: b with σ between cylinders, e with σ of the "
        "campaign's own trials: the root mean square of their standard errors, and its own for a "
        "campaign whose trials scatter more than three times as much as is usual. "
        "m is the median. σ between cylinders is such that the median of |x − m| / "
        "sqrt(σ_between² + σ_own²) is 0.6745: up to half of the campaigns may be anything. Errors "
        "of the instruments are common to a bench's campaigns and take no part.",
    ),
    (
        "Outliers",
        "The deviation is (x − m) / sqrt(σ_between² + σ_own²); where a number drifts, m is its "
        "trend line. p is that of Student's distribution with 0.37 (n − 1) degrees of freedom, "
        "times the number of campaigns and numbers (Bonferroni): among good cylinders alone, one "
        "fleet in twenty has an outlier. An outlier has p below 0.05; at least 10 campaigns are "
        "needed.",
    ),
    (
        "Trends",
        "Theil and Sen's line, its interval and p by Kendall's rank correlation, corrected after "
        "Holm for the number of trends. A trend is called a drift where p is below 0.05. "
        "It does not tell cylinders that change from a bench that changes.",
    ),
    (
        "All rows",
        "fleet.parquet beside this page: a row a campaign, each number with its interval.",
    ),
)


def fleet_page(found: Fleet, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    return page(fleet_document(found, drawings))


def fleet_document(found: Fleet, drawings: Iterable[Drawing]) -> Document:
    """Return what the page is made of."""
    drawings = tuple(drawings)
    sources = [source for source, _ in found.sources]
    banner = "Some of the campaigns are simulated." if "simulated" in sources else ""
    if len(sources) == 1:
        banner = BANNERS.get(sources[0], "") if sources[0] == "simulated" else ""
    days = [] if found.first is None else [f"{day:%Y-%m-%d}" for day in (found.first, found.last)]
    span = " to ".join(dict.fromkeys(days))
    return Document(
        f"Fleet of {found.campaigns} campaigns",
        " · ".join(filter(None, ("Friction and efficiency of cylinders side by side", span))),
        tuple(_sections(found, drawings)),
        verdict(found),
        banner,
        "simulated" if banner else "",
    )


def _sections(found: Fleet, drawings: tuple[Drawing, ...]) -> Iterator[Section]:
    yield Section("Summary", tiles=tuple(_tiles(found)), tables=_protocols(found))
    if found.worst:
        few = "These deviate most; what is not called an outlier is not told from the others."
        none = (few,) if found.outliers < _LEAST else ()
        yield Section("Worst cylinders", none, tables=(_worst(found),), anchor="worst")
    if found.spreads:
        own = tuple(one for one in drawings if one.section == DISTRIBUTIONS)
        yield Section("Distributions", drawings=own, tables=(_untitled(spread_table(found)),))
        own = tuple(one for one in drawings if one.section == DRIFTS)
        table = _untitled(trend_table(found))
        yield Section("Drifts", drawings=own, tables=(table,) if table.rows else ())
    if found.failed:
        yield _failures(found)
    yield Section("How it was computed", facts=_METHOD, anchor="method")


def _tiles(found: Fleet) -> Iterator[Tile]:
    good = found.campaigns - found.failed
    failed = f"{found.failed} failed" if found.failed else "none failed"
    yield Tile(f"{good} of {found.campaigns}", "campaigns", f"analyzed; {failed}")
    yield Tile(str(found.outliers), "", "stand out from the others", "method-outliers")
    drifts = sum(one.trend is not None and one.trend.real for one in found.spreads)
    yield Tile(str(drifts), "", f"of {len(found.spreads)} numbers drift", "method-trends")
    for one in found.spreads:
        if one.quantity.name in ("friction_n", "efficiency"):
            scale = one.quantity.scale
            words = f"{one.quantity.words.split()[0].lower()}, {TITLES[one.direction].lower()}"
            value = alike((scale * one.low, scale * one.high))
            words = f"{words}: 5 to 95 % of the campaigns"
            yield Tile(value, one.quantity.unit, words, "method-spread")
    for grade, count in found.qualities:
        yield Tile(str(count), "campaigns" if count != 1 else "campaign", f"data: {grade}")


def _protocols(found: Fleet) -> tuple[Table, ...]:
    rows = tuple(
        (Cell(str(count), "" if i else "judged here"), Cell(words))
        for i, (words, count) in enumerate(found.protocols)
    )
    title = "Kinds of campaigns" if len(rows) > 1 else "Kind of campaign"
    words = frozenset({"Piston and rod-side areas, loads, working speed"})
    return (Table(("Campaigns", *words), rows, words, title=title),) if rows else ()


def _worst(found: Fleet) -> Table:
    rows = []
    for one in found.worst[: max(found.outliers, _LEAST)]:
        name = PurePath(one.path).name or one.path
        flag = "outlier" if one.deviations[0].outlier else ""
        remarks = (
            *([] if one.started is None else [f"{one.started:%Y-%m-%d}"]),
            *([] if one.quality == "good" else [f"data: {one.quality}"]),
            _also(tuple(others(one))),
            one.path,
        )
        numbers = map(Cell, cells(one)[:-1])
        rows.append(
            (Cell(name, flag, one.report), *numbers, Cell("; ".join(filter(None, remarks))))
        )
    last = "Started; remarks; folder"
    words = frozenset({"Campaign", "Number", last})
    return Table(("Campaign", *WORST_HEAD[:-1], last), tuple(rows), words)


def _also(further: tuple[str, ...]) -> str:
    """Write the first of the further numbers in which a campaign is an outlier."""
    if not further:
        return ""
    rest = f" and {len(further) - _ALSO} more" if len(further) > _ALSO else ""
    return f"also {', '.join(further[:_ALSO])}{rest}"


def _failures(found: Fleet) -> Section:
    reasons = Table(
        ("Campaigns", "Reason"),
        tuple((Cell(str(count)), Cell(words)) for words, count in found.reasons),
        frozenset({"Reason"}),
    )
    rows = tuple((Cell(path), Cell(words)) for path, words in found.failures)
    first = Table(("Folder", "Reason"), rows, frozenset({"Folder", "Reason"}))
    words = f"The first {len(rows)} of them" if found.failed > len(rows) else "Each of them"
    parts = (Section(words, tables=(first,), folded=True),)
    return Section("Not analyzed", tables=(reasons,), parts=parts, anchor="failed")


def _untitled(table: WordTable) -> WordTable:
    return WordTable("", table.head, table.rows)
