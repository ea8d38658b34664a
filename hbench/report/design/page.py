"""The page of a design."""

from collections.abc import Iterable

from hbench.records import Design, WordTable
from hbench.report.design import text
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing


def design_page(design: Design, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    proposal = design.proposal
    sections = []
    if proposal is not None:
        rows = text.check_rows((*proposal.margins, *proposal.closed_loop))
        checks = WordTable("Checks", text.CHECK_HEAD, tuple(rows))
        items, code = tuple(text.proposal_lines(proposal)), text.gains_yaml(proposal)
        sections.append(Section("Proposal", items=items, code=code, tables=(checks,)))
    chains = tuple(f"{name}: {about}" for name, about in text.CHAINS.items())
    loops = WordTable("", text.LOOP_HEAD, tuple(text.loop_rows(design)))
    facts = tuple(text.fact_lines(design))
    sections.append(Section("Loops", items=(*chains, *facts), tables=(loops,)))
    if design.reproduced:
        rows = text.reproduced_rows(design.reproduced)
        table = WordTable("", text.REPRODUCED_HEAD, tuple(rows))
        sections.append(Section("The source's numbers", tables=(table,)))
    sections.append(Section("Figures", drawings=tuple(drawings)))
    return document(
        f"{design.bench}: control loops",
        "Computed and simulated; nothing here was measured. Operating point: "
        f"{text.point_words(design)}.",
        tuple(sections),
        "" if proposal is None else text.design_verdict(proposal),
    )
