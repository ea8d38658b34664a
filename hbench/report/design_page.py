"""The page of a design: one HTML file that needs nothing else."""

import base64
from collections.abc import Iterable
from importlib.resources import files

from jinja2 import Environment, StrictUndefined

from hbench.records import Design
from hbench.report import design_text
from hbench.report.figures import Drawing


def design_page(design: Design, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside. Every text is escaped."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    source = files("hbench.report").joinpath("design.html.j2").read_text(encoding="utf-8")
    found = design.proposal
    tables = [("Loops", design_text.LOOP_HEAD, design_text.loop_rows(design))]
    if design.reproduced:
        rows = design_text.reproduced_rows(design.reproduced)
        tables.append(("The source's numbers", design_text.REPRODUCED_HEAD, rows))
    if found is not None:
        rows = design_text.check_rows((*found.margins, *found.closed_loop))
        tables.append(("Checks of the proposal", design_text.CHECK_HEAD, rows))
    return environment.from_string(source).render(
        name=design.bench,
        point=design_text.point_words(design),
        chains=design_text.CHAINS,
        facts=design_text.fact_lines(design),
        tables=tables,
        verdict="" if found is None else design_text.verdict(found),
        proposal=() if found is None else design_text.proposal_lines(found),
        gains="" if found is None else design_text.gains_yaml(found),
        figures=[
            {
                "title": drawing.title,
                "caption": drawing.caption,
                "data": base64.b64encode(drawing.svg).decode("ascii"),
            }
            for drawing in drawings
        ],
    )
