"""The page of a phenomenon."""

from collections.abc import Iterable

from hbench.records import Phenomenon
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing
from hbench.report.simulation.text import phenomenon_tables

_SUBTITLE = (
    "Simulated; nothing here was measured. Equation, table and figure numbers: M. Hvoldal and "
    "C. Olesen, Friction Modelling and Parameter Estimation for Hydraulic Asymmetrical Cylinders, "
    "Aalborg University, 2011."
)


def phenomenon_page(phenomenon: Phenomenon, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    phenomenon_section = Section(paragraphs=phenomenon.text, drawings=tuple(drawings))
    numbers = Section("Numbers", tables=phenomenon_tables(phenomenon))
    return document(phenomenon.title, _SUBTITLE, (phenomenon_section, numbers))
