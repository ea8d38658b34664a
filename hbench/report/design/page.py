"""The page of a design."""

import re
from collections.abc import Iterable
from dataclasses import replace

from hbench.records import Check, Design, Proposal, WordTable
from hbench.report.design import checks as check_words
from hbench.report.design import loops as loop_words
from hbench.report.design import text
from hbench.report.design.verdict import loops_verdict, proposal_verdict
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing
from hbench.report.render.symbols import capital
from hbench.report.render.word_tables import Cell, Table

_LOOP_HEAD = (
    *("Loop", "K_c", "τ_c (s)", "Model", "Bandwidth (rad/s)", "Phase margin (°)"),
    *("Gain margin (dB)", "Overshoot (%)", "Settling (s)", "Slowest pole (s)"),
)


_NEGATIVE = re.compile(r"(?<!\S)-(?=\d)")
_POWER, _RAISED = re.compile(r"(?<=\d)e([-+]\d+)"), str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def design_page(design: Design, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    proposal = design.proposal
    sections = []
    if proposal is not None:
        checks = (*proposal.margins, *proposal.closed_loop)
        sections += [_checks(checks, check_words.LIMITS, design.tick_s), _proposal(proposal)]
    elif design.checks:
        sections.append(_checks(design.checks, check_words.POINT_LIMITS, design.tick_s))
    sections.append(Section("Operating point", facts=_facts(text.point_facts(design))))
    merits = tuple(tuple(map(_merit, row)) for row in loop_words.loop_rows(design))
    words_in = frozenset({"Loop", "K_c", "Model"})
    loops = Table(_LOOP_HEAD, merits, words_in, title="The three loops with the present gains")
    notes = _facts(loop_words.loop_notes(design))
    sections.append(
        Section("Loops", (loop_words.about_loops(design),), tables=(loops,), facts=notes)
    )
    sections.append(Section("Further results", facts=_facts(text.facts(design))))
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
        "Computed from the bench file, and simulated. Nothing here was measured.",
        tuple(sections),
        _typeset(
            loops_verdict(design) if proposal is None else proposal_verdict(proposal, design.tick_s)
        ),
    )


def _facts(lines: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    return tuple((_typeset(capital(name)), f"{capital(_typeset(text))}.") for name, text in lines)


def _checks(checks: tuple[Check, ...], words: str, tick_s: float) -> Section:
    """Return the checks as a table, those that fail first."""
    ranked = sorted(checks, key=lambda check: check.holds)
    rows = []
    for check, row in zip(ranked, check_words.check_rows(ranked, tick_s), strict=True):
        what, value, limit, unit, _, where = row
        verdict = Cell("PASS") if check.holds else Cell("", "FAIL")
        sign = "°" if unit == "deg" else "" if unit == "runs" else f" {unit}".rstrip()
        limit += sign if any(map(str.isdigit, limit)) else ""
        rows.append((verdict, *map(Cell, (capital(what), value + sign, limit, _minus(where)))))
    head = ("Result", "Check", "Value", "Limit", "Worst at")
    words_in = frozenset({"Result", "Check", "Worst at"})
    table = Table(head, tuple(rows), words_in, title="Checks and their limits")
    notes = (words, check_words.UNSTABLE) if check_words.unstable(checks) else (words,)
    return Section("Checks", notes, tables=(_without_empty(table),))


def _without_empty(table: Table) -> Table:
    """Return the table without columns that have no entry."""
    kept = [i for i in range(len(table.head)) if any(r[i].text or r[i].flag for r in table.rows)]
    head = tuple(table.head[i] for i in kept)
    rows = tuple(tuple(row[i] for i in kept) for row in table.rows)
    return replace(table, head=head, rows=rows)


def _proposal(proposal: Proposal) -> Section:
    lines = tuple(f"{capital(line)}." for line in text.proposal_lines(proposal))
    return Section("Proposed gains", items=lines, code=text.gains_yaml(proposal))


def _merit(words: str) -> Cell:
    """Return an entry of the loops' table."""
    return Cell("", "unstable") if words == "UNSTABLE" else Cell(_minus(_typeset(words)))


def _minus(words: str) -> str:
    return _NEGATIVE.sub("−", words)


def _typeset(words: str) -> str:
    """Return words of the terminal with the signs of a page."""
    words = words.replace("mm/s^2", "mm/s²").replace(" deg", "°").replace("tau_c", "τ_c")
    words = words.replace("-T / ln", "−T / ln").replace("(Pa s)", "(Pa\N{NO-BREAK SPACE}s)")
    return _POWER.sub(lambda found: "·10" + str(int(found[1])).translate(_RAISED), words)
