"""Elements of a digital calibration certificate, and D-SI values."""

from xml.etree.ElementTree import Element

from hbench.report.conformity.certificate.certificate import Certificate
from hbench.untrusted_text import printable

DCC = "https://ptb.de/dcc"
SI = "https://ptb.de/si"
_COVERAGE = "0.95"


def dcc(tag: str, *children: Element | None, text: str = "", **attributes: str) -> Element:
    """Return an element of the DCC; children that are None are left out."""
    element = Element(f"{{{DCC}}}{tag}", attributes)
    element.extend(child for child in children if child is not None)
    if text:
        element.text = text
    return element


def si(tag: str, *children: Element | None, text: str = "") -> Element:
    """Return an element of D-SI; children that are None are left out."""
    element = Element(f"{{{SI}}}{tag}")
    element.extend(child for child in children if child is not None)
    if text:
        element.text = text
    return element


def one_line(text: str) -> str:
    """Return text as schema and XML want it: no control characters, no blanks at its ends."""
    return " ".join(printable(text).split())


def optional(tag: str, text: str) -> Element | None:
    """Return an element with a text; None for an empty text."""
    return dcc(tag, text=one_line(text)) if text.strip() else None


def text_of(certificate: Certificate, tag: str, *lines: str) -> Element:
    """Return an element with ``content`` in the certificate's language."""
    language = certificate.file.language
    return dcc(tag, *(dcc("content", text=one_line(line), lang=language) for line in lines))


def software(certificate: Certificate) -> Element:
    """Return hbench with its release, written as PTB's rules want it: ``v0.1.0``."""
    version = one_line(certificate.results.provenance.software.get("hbench", "0"))
    return dcc(
        "software", text_of(certificate, "name", "hbench"), dcc("release", text=f"v{version}")
    )


def identifications(certificate: Certificate, *stated: tuple[str, str, str, str]) -> Element | None:
    """Return identifications of issuer, value, word's key and refType; None without a value."""
    known = [
        dcc(
            "identification",
            dcc("issuer", text=issuer),
            dcc("value", text=one_line(value)),
            text_of(certificate, "name", certificate.word(key)),
            **({"refType": kind} if kind else {}),
        )
        for issuer, value, key, kind in stated
        if value.strip()
    ]
    return dcc("identifications", *known) if known else None


def real(value: float, unit: str, u95: float | None = None, k: float | None = None) -> Element:
    """Return a D-SI value; an uncertainty without a coverage factor cannot be expressed."""
    uncertainty = None
    if u95 is not None and k is not None:
        expanded = si(
            "expandedMU",
            si("valueExpandedMU", text=_number(u95)),
            si("coverageFactor", text=_number(k)),
            si("coverageProbability", text=_COVERAGE),
        )
        uncertainty = si("measurementUncertaintyUnivariate", expanded)
    return si("real", si("value", text=_number(value)), si("unit", text=unit), uncertainty)


def _number(value: float) -> str:
    return f"{value:.9g}"
