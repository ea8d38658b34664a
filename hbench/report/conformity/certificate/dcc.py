"""The certificate as a digital calibration certificate: XML after PTB's DCC 3.3.0, units D-SI.

This file writes the administrative data, ``dcc_results.py`` the measurement results.

Values are those of the certificate in SI. A name is given in the certificate's language.
"""

from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from hbench.config.conformity.certificate import Contact
from hbench.errors import ConfigError
from hbench.records.conformity.acceptance import Conformity
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.conformity_parts import limit_words, quantity_words
from hbench.report.conformity.certificate.content import content
from hbench.report.conformity.certificate.dcc_elements import (
    DCC,
    SI,
    dcc,
    identifications,
    one_line,
    optional,
    real,
    software,
    text_of,
)
from hbench.report.conformity.certificate.dcc_results import measurement_results
from hbench.report.conformity.certificate.layout import Part

VERSION = "3.3.0"
_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_SCHEMA = f"{DCC} https://ptb.de/dcc/v{VERSION}/dcc.xsd"
_AREA = r"\metre\tothe{2}"
_CONFORMITY: dict[Conformity, str] = {
    "PASS": "pass",
    "FAIL": "fail",
    "MARGINAL": "conditionalPass",
}


def dcc_xml(certificate: Certificate) -> str:
    """Return the text of the DCC. Raises ``ConfigError`` where it has no date of the test."""
    for prefix, namespace in (("dcc", DCC), ("si", SI), ("xsi", _XSI)):
        ElementTree.register_namespace(prefix, namespace)
    root = Element(
        f"{{{DCC}}}digitalCalibrationCertificate",
        {f"{{{_XSI}}}schemaLocation": _SCHEMA, "schemaVersion": VERSION},
    )
    root.append(_administrative(certificate))
    root.append(measurement_results(certificate))
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"


def _administrative(certificate: Certificate) -> Element:
    laboratory = certificate.file.laboratory
    return dcc(
        "administrativeData",
        dcc("dccSoftware", software(certificate)),
        _core(certificate),
        dcc("items", _item(certificate)),
        dcc("calibrationLaboratory", _contact(certificate, "contact", laboratory.name, laboratory)),
        _persons(certificate),
        _contact(certificate, "customer", certificate.customer_name, certificate.file.customer),
        _statements(certificate),
    )


def _core(certificate: Certificate) -> Element:
    days = certificate.performed
    if days is None:
        raise ConfigError(
            "the digital calibration certificate needs the date of the test",
            "State it as test.date in the certificate file, such as 2026-01-31.",
        )
    language, file = certificate.file.language, certificate.file
    order = identifications(
        certificate,
        ("customer", certificate.specimen.order, "order", "basic_orderNo"),
        ("calibrationLaboratory", certificate.test.number, "test_number", ""),
    )
    replaced = None
    if file.replaces:
        replaced = dcc(
            "reportAmendedSubstituted",
            dcc("typeOfChange", text="substituted"),
            dcc("replacedUniqueIdentifier", text=file.replaces),
        )
    return dcc(
        "coreData",
        dcc("countryCodeISO3166_1", text=file.laboratory.country),
        dcc("usedLangCodeISO639_1", text=language),
        dcc("mandatoryLangCodeISO639_1", text=language),
        dcc("uniqueIdentifier", text=certificate.number),
        order,
        None if file.received is None else dcc("receiptDate", text=file.received.isoformat()),
        dcc("beginPerformanceDate", text=days[0].isoformat()),
        dcc("endPerformanceDate", text=days[1].isoformat()),
        dcc("performanceLocation", text="laboratory"),
        dcc("issueDate", text=certificate.issued.isoformat()),
        replaced,
    )


def _item(certificate: Certificate) -> Element:
    specimen = certificate.specimen
    serial = one_line(specimen.serial) or certificate.word("not_stated")
    about = [
        f"{certificate.word(key)}: {getattr(specimen, key)}"
        for key in ("bore", "rod", "stroke", "seals", "wear")
        if getattr(specimen, key)
    ]
    areas = certificate.results.runs[0].run.plan.specimen
    quantities = [
        dcc("itemQuantity", text_of(certificate, "name", name), real(area, _AREA))
        for name, area in (("A_p", areas.area_piston_m2), ("A_r", areas.area_rod_m2))
        if area
    ]
    maker = one_line(specimen.maker)
    return dcc(
        "item",
        text_of(certificate, "name", certificate.word("cylinder")),
        text_of(certificate, "description", *about) if about else None,
        dcc("manufacturer", text_of(certificate, "name", maker)) if maker else None,
        identifications(certificate, ("manufacturer", serial, "serial", "basic_serialNumber")),
        dcc("itemQuantities", *quantities) if quantities else None,
    )


def _contact(certificate: Certificate, tag: str, name: str, contact: Contact) -> Element:
    lines = contact.address or (certificate.word("not_stated"),)
    country = dcc("countryCode", text=contact.country) if contact.country else None
    return dcc(
        tag,
        text_of(certificate, "name", name or certificate.word("not_stated")),
        dcc("location", country, text_of(certificate, "further", *lines)),
    )


def _persons(certificate: Certificate) -> Element:
    return dcc(
        "respPersons",
        *(
            dcc(
                "respPerson",
                dcc("person", text_of(certificate, "name", each.name)),
                optional("role", each.role),
                dcc("mainSigner", text="true" if number == 0 else "false"),
            )
            for number, each in enumerate(certificate.file.signatories)
        ),
    )


def _statements(certificate: Certificate) -> Element:
    shown = content(certificate)
    keys = ("instruments", "uncertainty", "not_tested", "remarks", "statements")
    parts = [shown.parts[key] for key in keys if key in shown.parts]
    data = shown.parts["data"]
    facts = tuple(f"{name}: {text}" for name, text in data.facts)
    accreditation = certificate.file.laboratory.accreditation or certificate.word("not_accredited")
    statements = [
        *([_statement(certificate, shown.mark, shown.mark_text)] if shown.mark else []),
        _statement(certificate, certificate.word("accreditation"), accreditation),
        *(_statement(certificate, part.title, *part.paragraphs) for part in parts),
        _statement(certificate, data.title, *facts),
        *_conformity(certificate, shown.parts["conformity"]),
    ]
    return dcc("statements", *statements)


def _statement(
    certificate: Certificate, title: str, *lines: str, conformity: str = "", norm: str = ""
) -> Element:
    return dcc(
        "statement",
        text_of(certificate, "name", title),
        optional("norm", norm),
        text_of(certificate, "declaration", *lines),
        optional("conformity", conformity),
        **({"refType": "basic_conformity"} if conformity else {}),
    )


def _conformity(certificate: Certificate, part: Part) -> Iterable[Element]:
    """Yield the decision on the specimen, then that on each limit; not tested: without a status."""
    acceptance = certificate.acceptance
    if acceptance is None:
        return
    norm = "JCGM 106:2012"
    status = _CONFORMITY.get(acceptance.decision, "")
    lines = (part.verdict, part.lead, *part.paragraphs)
    yield _statement(certificate, part.title, *lines, conformity=status, norm=norm)
    rows = part.tables[0].rows
    for check, row in zip(acceptance.checks, rows, strict=True):
        name = (
            f"{quantity_words(certificate, check)}, {limit_words(certificate, check.requirement)}"
        )
        status = _CONFORMITY.get(check.decision, "")
        yield _statement(certificate, name, "; ".join(row), conformity=status, norm=norm)
