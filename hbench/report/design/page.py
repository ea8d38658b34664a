"""The page of a design."""

import re
from collections.abc import Iterable

from hbench.records import Check, Design, Proposal, WordTable
from hbench.report.design import text
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing
from hbench.report.render.word_tables import Cell, Table

_LOOP_HEAD = (
    *("Loop", "K_c", "τ_c (s)", "Chain", "Bandwidth (rad/s)", "Phase margin (°)"),
    *("Gain margin (dB)", "Overshoot (%)", "Settling (s)", "Largest |z|"),
)


_POWER, _RAISED = re.compile(r"(?<=\d)e([-+]\d+)"), str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def design_page(design: Design, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    proposal = design.proposal
    sections = []
    if proposal is not None:
        checks = (*proposal.margins, *proposal.closed_loop)
        sections += [_checks(checks, text.LIMITS), _proposal(proposal)]
    elif design.checks:
        sections.append(_checks(design.checks, text.POINT_LIMITS))
    chains = tuple((_capital(name), f"{_capital(about)}.") for name, about in text.CHAINS.items())
    merits = tuple(tuple(map(_typeset, row)) for row in text.loop_rows(design))
    loops = WordTable("", _LOOP_HEAD, merits)
    facts = tuple(f"{_typeset(_capital(line))}." for line in text.fact_lines(design))
    sections.append(Section("Operating point", facts=text.point_facts(design)))
    sections.append(
        Section("Loops", items=facts, tables=(loops,), parts=(Section(facts=chains),)),
    )
    if design.reproduced:
        rows = text.reproduced_rows(design.reproduced)
        table = WordTable("", text.REPRODUCED_HEAD, tuple(rows))
        agree = sum(number.agrees for number in design.reproduced)
        said = f"{agree} of {len(design.reproduced)} numbers of the source agree."
        part = Section(f"Each number ({len(rows)})", tables=(table,), folded=True)
        sections.append(Section("The source's numbers", (said,), parts=(part,)))
    drawn = tuple(drawings)
    for loop in design.loops:
        own = tuple(drawing for drawing in drawn if drawing.section == loop.name)
        if own:
            sections.append(Section(f"Figures of the {loop.name} loop", drawings=own))
    return document(
        f"{design.bench}: control loops",
        "Computed and simulated; nothing here was measured.",
        tuple(sections),
        text.loops_verdict(design) if proposal is None else text.page_verdict(proposal),
    )


def _checks(checks: tuple[Check, ...], words: str) -> Section:
    """Return the checks as a table, those that fail first."""
    ranked = sorted(checks, key=lambda check: check.holds)
    rows = []
    for check, row in zip(ranked, text.check_rows(ranked), strict=True):
        what, value, limit, unit, _, where = row
        verdict = Cell("PASS") if check.holds else Cell("", "FAIL")
        sign = {"deg": "°", "1": ""}.get(unit, unit)
        least = "≥" if "margin" in what else "<" if "modulus" in what else "≤"
        rows.append((verdict, *map(Cell, (_capital(what), value, f"{least} {limit}", sign, where))))
    head = ("Result", "Check", "Value", "Limit", "Unit", "Worst at")
    table = Table(head, tuple(rows), frozenset({"Result", "Check", "Unit", "Worst at"}))
    return Section("Checks", (words,), tables=(_without_empty(table),))


def _without_empty(table: Table) -> Table:
    """Return the table without columns that have no entry."""
    kept = [i for i in range(len(table.head)) if any(r[i].text or r[i].flag for r in table.rows)]
    head = tuple(table.head[i] for i in kept)
    return Table(head, tuple(tuple(row[i] for i in kept) for row in table.rows), table.words)


def _proposal(proposal: Proposal) -> Section:
    lines = tuple(f"{_capital(line)}." for line in text.proposal_lines(proposal))
    return Section("Proposed gains", items=lines, code=text.gains_yaml(proposal))


def _typeset(words: str) -> str:
    """Return words of the terminal with the signs of a page."""
    words = words.replace("mm/s^2", "mm/s²").replace(" deg", "°")
    return _POWER.sub(lambda found: "·10" + str(int(found[1])).translate(_RAISED), words)


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
