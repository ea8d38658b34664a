"""The page of a design."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

from hbench.records import Check, ControlLoop, Design, Proposal, WordTable
from hbench.report.design import checks as check_words
from hbench.report.design import loops as loop_words
from hbench.report.design import text
from hbench.report.design.figures import section_of
from hbench.report.design.overview import SECTION, TITLE
from hbench.report.design.verdict import loops_verdict, proposal_verdict, reproduced_words
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing, of_section
from hbench.report.render.word_tables import Cell, Table, with_columns
from hbench.sentences import capital

_LOOP_HEAD = (
    *("Loop", "K_c", "τ_c (s)", "Model", "Bandwidth (rad/s)", "Phase margin (°)"),
    *("Gain margin (dB)", "Overshoot (%)", "Settling (s)", "Slowest pole (s)"),
)
_PRESENT = "Checks at the operating point that the present gains fail"
_FEW_CHECKS = 8  # that pass: more are folded
_NOT_TO_BE_USED = "They fail checks of the next section: do not write them to the bench file."
_SOURCE = (
    "The source is M. Hvoldal and C. Olesen, Friction Modelling and Parameter Estimation for "
    "Hydraulic Asymmetrical Cylinders, Aalborg University, 2011."
)
_NEGATIVE = re.compile(r"(?<!\S)-(?=\d)")
_POWER, _RAISED = re.compile(r"(?<=\d)e([-+−]\d+)"), str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def design_page(design: Design, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    proposal = design.proposal
    drawn = tuple(drawings)
    overview = of_section(drawn, SECTION)
    sections = []
    if overview:
        sections.append(
            Section(TITLE, drawings=overview, facts=_facts((("operating points", text.GRID),)))
        )
    if proposal is not None:
        checks = (*proposal.margins, *proposal.closed_loop)
        sections += [
            _proposal(design, proposal),
            _checks(checks, check_words.LIMITS, design.checks),
        ]
    elif design.checks:
        sections.append(_checks(design.checks, check_words.POINT_LIMITS))
    sections.append(Section("Operating point", facts=_facts(text.point_facts(design))))
    by_gains = loop_words.loops_by_gains(design)
    first, *others = (
        _loops(gains, by_gains[gains], design.tick_s, drawn, folded)
        for gains, folded in pairwise([*by_gains, ""])
    )
    folded = tuple(replace(other, folded=True, printed=False) for other in others)
    notes = _facts(loop_words.loop_notes(design))
    terms = Section("What the rows and columns mean", facts=notes, folded=True)
    sections.append(replace(first, parts=(terms, *_failing_first(design, first.parts), *folded)))
    sections.append(
        Section("Further results with the present gains", facts=_facts(text.facts(design)))
    )
    if design.reproduced:
        sections.append(_reproduced(design))
    return document(
        f"{design.bench}: control loops",
        "Computed from the bench file, and simulated. Nothing here was measured.",
        tuple(sections),
        _minus(_typeset(_verdict(design))),
        identity=tuple((name, _minus(text)) for name, text in text.basis_facts(design)),
    )


def _loops(
    gains: str,
    loops: Sequence[ControlLoop],
    tick_s: float,
    drawings: Sequence[Drawing],
    folded: str,
) -> Section:
    """Return the loops' table and figures with the present or the proposed gains.

    ``folded`` are the gains of the loops that are folded at the end of the section; empty: none.
    """
    others = loop_words.FOLDED.format(gains=folded) if folded else ""
    rows = tuple(tuple(map(_merit, row)) for row in loop_words.loop_rows(loops, tick_s))
    title = f"Bandwidth, margins and step response with the {gains} gains"
    table = Table(_LOOP_HEAD, rows, frozenset({"Loop", "K_c", "Model"}), title=title)
    figures = {loop.name: of_section(drawings, section_of(gains, loop)) for loop in loops}
    return Section(
        f"Loops with the {gains} gains",
        (others,) if others else (),
        tables=(table,),
        parts=tuple(
            Section(f"{capital(name)} loop", drawings=drawn)
            for name, drawn in figures.items()
            if drawn
        ),
    )


def _failing_first(design: Design, loops: Sequence[Section]) -> list[Section]:
    """Return the figures of each loop: first those that fail a check, the others folded.

    Without a check that fails, those of the first loop are not folded.
    """
    checks = design.checks if design.proposal is None else design.proposal.margins
    failed = {capital(f"{c.what.partition(':')[0]} loop") for c in checks if not c.holds}
    ranked = sorted(loops, key=lambda part: part.title not in failed)
    return [
        replace(part, folded=True, printed=False) if i and part.title not in failed else part
        for i, part in enumerate(ranked)
    ]


def _verdict(design: Design) -> str:
    proposal = design.proposal
    return loops_verdict(design) if proposal is None else proposal_verdict(proposal, design)


def _facts(lines: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    return tuple((_typeset(capital(name)), f"{capital(_typeset(text))}.") for name, text in lines)


def _checks(checks: Sequence[Check], words: str, present: Sequence[Check] = ()) -> Section:
    """Return a table of the checks, those that fail first; many that pass are folded.

    ``present`` are the checks of the present gains, of which those that fail have a table too.
    """
    rows = _rows(checks)
    few = len(rows[True]) <= _FEW_CHECKS
    shown = _check_table((*rows[False], *(rows[True] if few else ())))
    if failed := _rows(present)[False]:
        shown += (replace(_check_table(failed)[0], title=_PRESENT),)
    notes = (words, check_words.UNSTABLE) if check_words.unstable(checks) else (words,)
    title = f"Checks that pass ({len(rows[True])})"
    folded = () if few else (Section(title, tables=_check_table(rows[True]), folded=True),)
    return Section("Checks", notes, tables=shown, parts=folded)


def _rows(checks: Sequence[Check]) -> dict[bool, list[tuple[Cell, ...]]]:
    """Return a row for each check, by whether it holds."""
    rows: dict[bool, list[tuple[Cell, ...]]] = {False: [], True: []}
    for check, row in zip(checks, check_words.check_rows(checks), strict=True):
        what, value, limit, unit, _, where = row
        sign = "°" if unit == "deg" else "" if unit == "runs" else f" {unit}".rstrip()
        limit += sign if any(map(str.isdigit, limit)) else ""
        result = Cell("PASS") if check.holds else Cell("", "FAIL")
        cells = map(Cell, (value + sign, limit, _minus(where)))
        rows[check.holds].append((Cell(capital(what)), result, *cells))
    return rows


def _check_table(rows: Sequence[tuple[Cell, ...]]) -> tuple[Table, ...]:
    """Return a table of checks; none without rows."""
    head, words_in = (
        ("Check", "Result", "Value", "Limit", "Worst at"),
        frozenset({"Check", "Result", "Worst at"}),
    )
    return (_without_empty(Table(head, tuple(rows), words_in, title="Checks")),) if rows else ()


def _without_empty(table: Table) -> Table:
    """Return the table without columns that have no entry."""
    kept = [i for i in range(len(table.head)) if any(r[i].text or r[i].flag for r in table.rows)]
    return with_columns(table, kept)


def _proposal(design: Design, proposal: Proposal) -> Section:
    """Return the present and the proposed gains, and how the proposed ones were derived."""
    rows = []
    for loop in design.loops:
        gain, tau_s = proposal.gains[loop.name]
        name = capital(loop.name)
        gains = tuple(_typeset(f"{each:.4g}") for each in (loop.gain, gain))
        times = tuple(f"{1e3 * each:.4g}" for each in (loop.time_constant_s, tau_s))
        rows.append((f"{name}: gain K_c", *gains, _typeset(loop.gain_unit)))
        rows.append((f"{name}: time constant τ_c", *times, "ms"))
    cells = tuple(tuple(map(Cell, row)) for row in rows)
    head, words_in = (
        ("Controller", "Present", "Proposed", "Unit"),
        frozenset({"Controller", "Unit"}),
    )
    table = Table(head, cells, words_in, title="Present and proposed gains")
    lines = tuple(f"{capital(line)}." for line in text.proposal_lines(proposal))
    parts = [Section("How the proposed gains were computed", items=lines)]
    if proposal.holds:
        parts.insert(0, Section("As lines of the bench file", code=text.gains_yaml(proposal)))
    words = () if proposal.holds else (_NOT_TO_BE_USED,)
    return Section("Proposed gains", words, tables=(table,), parts=tuple(parts))


def _reproduced(design: Design) -> Section:
    """Return the source's numbers that are not reproduced, and all of them folded."""
    rows = [
        (capital(row[0]), *(_minus(_typeset(cell)) for cell in row[1:-1]), _minus(capital(row[-1])))
        for row in text.reproduced_rows(design.reproduced)
    ]
    head = tuple(map(capital, text.REPRODUCED_HEAD))
    agrees = head.index("Agrees")
    differ = [(*r[:agrees], *r[agrees + 1 :]) for r in rows if r[agrees] == "NO"]
    kept = (*head[:agrees], *head[agrees + 1 :])
    tables = (WordTable("Numbers that do not agree", kept, tuple(differ)),) if differ else ()
    part = Section(
        f"All numbers ({len(rows)})", tables=(WordTable("", head, tuple(rows)),), folded=True
    )
    words = f"{reproduced_words(design.reproduced)} {_SOURCE}"
    return Section("Numbers of the source", (words,), tables=tables, parts=(part,))


def _merit(words: str) -> Cell:
    """Return an entry of the loops' table."""
    return Cell("", "unstable") if words == "UNSTABLE" else Cell(_minus(_typeset(words)))


def _minus(words: str) -> str:
    return _NEGATIVE.sub("−", words)


def _typeset(words: str) -> str:
    """Return words of the terminal with the signs of a page."""
    words = words.replace("mm/s^2", "mm/s²").replace(" deg", "°").replace("tau_c", "τ_c")
    words = words.replace("-T / ln", "−T / ln")
    return _POWER.sub(
        lambda found: "·10" + str(int(found[1].replace("−", "-"))).translate(_RAISED), words
    )
