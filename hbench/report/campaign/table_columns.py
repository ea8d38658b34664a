"""Columns that tables of the page share, and a table without empty ones."""

from collections.abc import Iterable

from hbench.records import DIRECTION_WORDS, Curve
from hbench.report.campaign.series_words import AnySeries, kind_words, load_words
from hbench.report.render.numbers import NONE, force, number
from hbench.report.render.word_tables import Cell, Table, with_columns
from hbench.units import from_si

ROD_SIDE = "P_Lr (bar)"
LOAD_CELL = "Load cell F_applied (N)"
OF_LOAD = "Load (N)"  # of benches that may have none
OIL, HERSEY = "Oil (°C)", "η|v|/p (nm)"
SIGMAS = (  # of efficiencies
    "σ of instruments (% points)",
    "σ by eq. 6.16 of the source (% points)",
    "U of both (% points)",
)
WHO = ("Label", "Kind", "Direction", "Load F_L (N)", ROD_SIDE)
BALANCE = "Coulomb and viscous friction from both directions"
OF_DIRECTIONS = ("Friction extending (N)", "Friction retracting (N)")
_WORDS = frozenset({"Run", "Label", "Kind", "Direction", "Reason", "Remark"})
_WHERE_GIVEN = (
    *("Label", "Kind", ROD_SIDE, LOAD_CELL, OF_LOAD, "Remark", "At (mm/s)"),
    *("Trials alone (N)", "U (N)", "Energy of a cycle (J)"),
    *("Friction ± U (N)", "Friction ± U (bar)", "Breakaway ± U (N)", "Breakaway ± U (bar)"),
    *("Efficiency ± U (%)", OIL, HERSEY, "ν", *SIGMAS),
)


def table(
    head: tuple[str, ...],
    rows: Iterable[tuple[str | Cell, ...]],
    messages: list[str] | tuple = (),
    words: tuple[str, ...] = (),
) -> Table:
    """Build a table; a column of ``_WHERE_GIVEN`` without any entry is left out.

    An empty kind is written as steady where other kinds are present. Columns in ``words`` hold
    no numbers.
    """
    cells = [tuple(c if isinstance(c, Cell) else Cell(c) for c in row) for row in rows]
    if "Kind" in head and any(row[head.index("Kind")].text for row in cells):
        at = head.index("Kind")
        steady = Cell("steady")
        cells = [row if row[at].text else (*row[:at], steady, *row[at + 1 :]) for row in cells]
    kept = [
        i
        for i, name in enumerate(head)
        if name not in _WHERE_GIVEN or any(row[i].text not in ("", NONE) for row in cells)
    ]
    return with_columns(Table(head, tuple(cells), _WORDS | set(words), tuple(messages)), kept)


def who(curve: AnySeries) -> tuple[str, ...]:
    """Return the identification of a curve, in the columns ``WHO``."""
    load = force(curve.f_load_n).removesuffix(" N")
    direction = DIRECTION_WORDS[curve.direction]
    return curve.label, kind_words(curve), direction, load, rod_side(curve.p_lr_ref_pa)


def rod_side(pressure_pa: float | None) -> str:
    """Write the rod-side pressure of a series in bar; empty where series do not differ in it."""
    return "" if pressure_pa is None else in_bar(pressure_pa)


def who_text(curve: Curve) -> str:
    """Return the identification of a curve as text."""
    load = load_words(curve.f_load_n, curve.p_lr_ref_pa)
    texts = curve.label, kind_words(curve), DIRECTION_WORDS[curve.direction], load
    return ", ".join(filter(None, texts))


def in_bar(pressure_pa: float | None) -> str:
    """Write a pressure in bar."""
    return number(None if pressure_pa is None else from_si(pressure_pa, "bar"), 2)
