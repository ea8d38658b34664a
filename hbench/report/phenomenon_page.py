"""The page of a phenomenon: one HTML file that needs nothing else."""

import base64
from collections.abc import Iterable
from importlib.resources import files

from jinja2 import Environment, StrictUndefined

from hbench.records import Phenomenon
from hbench.report.figures import Drawing
from hbench.report.phenomenon_text import tables


def phenomenon_page(phenomenon: Phenomenon, drawings: Iterable[Drawing], version: str) -> str:
    """Return the page with ``drawings`` inside. Every text is escaped."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    source = files("hbench.report").joinpath("phenomenon.html.j2").read_text(encoding="utf-8")
    figures = [
        {"title": drawing.title, "data": base64.b64encode(drawing.svg).decode("ascii")}
        for drawing in drawings
    ]
    return environment.from_string(source).render(
        phenomenon=phenomenon, tables=tables(phenomenon), figures=figures, version=version
    )
