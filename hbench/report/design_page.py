"""The page of a design."""

from collections.abc import Iterable

from hbench.records import Design, WordTable
from hbench.report import design_text
from hbench.report.document import Section, document
from hbench.report.figures import Drawing


def design_page(design: Design, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    found = design.proposal
    sections = []
    if found is not None:
        rows = design_text.check_rows((*found.margins, *found.closed_loop))
        checks = WordTable("Checks", design_text.CHECK_HEAD, tuple(rows))
        items, code = tuple(design_text.proposal_lines(found)), design_text.gains_yaml(found)
        sections.append(Section("Proposal", items=items, code=code, tables=(checks,)))
    chains = tuple(f"{name}: {words}" for name, words in design_text.CHAINS.items())
    loops = WordTable("", design_text.LOOP_HEAD, tuple(design_text.loop_rows(design)))
    facts = tuple(design_text.fact_lines(design))
    sections.append(Section("Loops", items=(*chains, *facts), tables=(loops,)))
    if design.reproduced:
        rows = design_text.reproduced_rows(design.reproduced)
        table = WordTable("", design_text.REPRODUCED_HEAD, tuple(rows))
        sections.append(Section("The source's numbers", tables=(table,)))
    sections.append(Section("Figures", drawings=tuple(drawings)))
    return document(
        f"{design.bench}: control loops",
        "Computed and simulated; nothing here was measured. Operating point: "
        f"{design_text.point_words(design)}.",
        tuple(sections),
        "" if found is None else design_text.verdict(found),
    )
