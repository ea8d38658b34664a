"""A figure's SVG as a part of a page: names of its own, and colours for light and dark."""

import re
from xml.etree import ElementTree

from markupsafe import Markup

from hbench.report.render.figures import POINT, SVG, Drawing
from hbench.report.render.style import DARK, READ_AS

_HREF = "{http://www.w3.org/1999/xlink}href"
_COLOUR = re.compile("|".join(DARK))
_LONG = re.compile(r"(\d+\.\d\d)\d+")


def inline(drawing: Drawing, number: int) -> Markup:
    """Return the SVG element of ``drawing``, figure ``number`` of its page.

    A colour that has another one in the dark becomes a variable of the page.
    """
    root = ElementTree.fromstring(drawing.svg)
    for name in ("metadata", "style"):
        for parent in list(root.iter()):
            for child in parent.findall(f"{SVG}{name}"):
                parent.remove(child)
    for element in root.iter():
        if element.get("id") == READ_AS:
            element.set("class", READ_AS)  # on a narrow screen the caption has it
        _make_local(element, f"f{number}-")
    points = any(group.get("class") == POINT for group in root.iter(f"{SVG}g"))
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)
    text_alternative = drawing.seen or f"{drawing.title}. {drawing.caption}"
    root.attrib |= {
        "class": "plot",
        "role": "group" if points else "img",
        "aria-label": text_alternative,
    }
    if points:
        root.set("tabindex", "0")
    text = ElementTree.tostring(root, encoding="unicode").replace(f' xmlns="{SVG[1:-1]}"', "")
    return Markup(text)


def _make_local(element: ElementTree.Element, prefix: str) -> None:
    """Give an element names of its own, and colours that follow the page."""
    attributes = element.attrib
    if _HREF in attributes:  # of a mark or a letter, or data of an image
        link = attributes.pop(_HREF)
        attributes["href"] = f"#{prefix}{link[1:]}" if link.startswith("#") else link
    if "id" in attributes:
        attributes["id"] = prefix + attributes["id"]
    for name in ("clip-path", "style"):
        if name in attributes:  # of a hatch, in a style
            attributes[name] = attributes[name].replace("url(#", f"url(#{prefix}")
    if "style" in attributes:
        attributes["style"] = _COLOUR.sub(
            lambda colour: f"var(--c{colour[0][1:]},{colour[0]})", attributes["style"]
        )
    element.tail = None
    if not (element.text or "").strip():
        element.text = None
    if "d" in attributes:
        attributes["d"] = _LONG.sub(r"\1", " ".join(attributes["d"].split()))
