"""Pages: one HTML file each that needs nothing else, every text of it escaped."""

import base64
import re
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from hbench.records import WordTable
from hbench.report.figures import Drawing

_NUMBER = re.compile(r"(< )?[-+−±]?\d[\d.,e+−-]*( [±%] ?[\d.]*)?|[-–]|none|")


@dataclass(frozen=True)
class Section:
    """A part of a document: its words, then its figures, then its tables."""

    title: str = ""
    paragraphs: tuple[str, ...] = ()
    items: tuple[str, ...] = ()
    code: str = ""
    drawings: tuple[Drawing, ...] = ()
    tables: tuple[WordTable, ...] = ()


def document(title: str, subtitle: str, sections: tuple[Section, ...], verdict: str = "") -> str:
    """Return a page of sections."""
    return rendered(
        "document.html.j2",
        title=title,
        subtitle=subtitle,
        sections=sections,
        verdict=verdict,
        version=version("hbench"),
    )


def rendered(template: str, **values: Any) -> str:
    """Return a template of this folder with its values; a value that is missing is an error."""
    environment = Environment(
        loader=PackageLoader("hbench.report", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["base64"] = lambda data: base64.b64encode(data).decode("ascii")
    environment.filters["numeric"] = _numeric
    environment.filters["subscripts"] = _subscripts
    return environment.get_template(template).render(values)


def _numeric(table: WordTable) -> set[int]:
    """Return the columns that hold numbers, or that there are none."""
    columns = enumerate(zip(*table.rows, strict=True))
    return {i for i, cells in columns if all(_NUMBER.fullmatch(cell) for cell in cells)}


def _subscripts(text: str) -> Markup:
    """Write the index of a symbol such as F_C below the line; all else is escaped."""
    return Markup(re.sub(r"\b([AFPp])_(\w+)", r"\1<sub>\2</sub>", str(escape(text))))
