"""The certificate as a digital calibration certificate: XML after PTB's DCC 3.3.0, units D-SI.

Values are those of the certificate in SI. A name is given in the certificate's language.
"""

from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from hbench.config.conformity.certificate import Contact
from hbench.config.identity import Calibration
from hbench.errors import ConfigError
from hbench.records.conformity.acceptance import Conformity
from hbench.records.conformity.certified import Certified
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.conformity_parts import limit_words, quantity_words
from hbench.report.conformity.certificate.content import content
from hbench.report.conformity.certificate.dcc_elements import (
    DCC,
    SI,
    dcc,
    one_line,
    optional,
    real,
    text_of,
)
from hbench.report.conformity.certificate.layout import Part

VERSION = "3.3.0"
_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_SCHEMA = f"{DCC} https://ptb.de/dcc/v{VERSION}/dcc.xsd"
_NEWTON, _PASCAL, _ONE, _KELVIN = r"\newton", r"\pascal", r"\one", r"\kelvin"
_METRE_PER_SECOND = r"\metre\second\tothe{-1}"
_LEAK = r"\metre\tothe{3}\second\tothe{-1}\pascal\tothe{-1}"
_UNITS = {
    **{"friction": _NEWTON, "breakaway": _NEWTON, "leakage": _LEAK},
    **{"efficiency": _ONE, "speed_ripple": _ONE, "drift": _ONE},
}
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
    root.append(_results(certificate))
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"


def _administrative(certificate: Certificate) -> Element:
    return dcc(
        "administrativeData",
        dcc("dccSoftware", _software(certificate)),
        _core(certificate),
        dcc("items", _item(certificate)),
        dcc("calibrationLaboratory", _contact(certificate, "contact", *_laboratory(certificate))),
        _persons(certificate),
        _contact(
            certificate,
            "customer",
            certificate.customer_name,
            certificate.file.customer,
        ),
        _statements(certificate),
    )


def _software(certificate: Certificate) -> Element:
    """Return hbench with its release, written as PTB's rules want it: ``v0.1.0``."""
    version = one_line(certificate.results.provenance.software.get("hbench", "0"))
    return dcc(
        "software", text_of(certificate, "name", "hbench"), dcc("release", text=f"v{version}")
    )


def _core(certificate: Certificate) -> Element:
    days = certificate.performed
    if days is None:
        raise ConfigError(
            "the digital calibration certificate needs the date of the test",
            "State it as test.date in the certificate file, such as 2026-01-31.",
        )
    language, file = certificate.file.language, certificate.file
    order = _optional_identifications(
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


def _optional_identifications(
    certificate: Certificate, *stated: tuple[str, str, str, str]
) -> Element | None:
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
        _optional_identifications(
            certificate, ("manufacturer", serial, "serial", "basic_serialNumber")
        ),
        dcc("itemQuantities", *quantities) if quantities else None,
    )


def _laboratory(certificate: Certificate) -> tuple[str, Contact]:
    return certificate.file.laboratory.name, certificate.file.laboratory


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


def _results(certificate: Certificate) -> Element:
    word = certificate.word
    method = content(certificate).parts["method"]
    used = dcc(
        "usedMethod",
        text_of(certificate, "name", certificate.file.method or method.title),
        text_of(certificate, "description", *method.paragraphs),
    )
    equipment = [_equipment(certificate, key, each) for key, _, each in certificate.calibrations()]
    results = [
        _result(certificate, word(f"q_{quantity}"), certificate.of(quantity))
        for quantity in dict.fromkeys(value.quantity for value in certificate.values)
    ]
    return dcc(
        "measurementResults",
        dcc(
            "measurementResult",
            text_of(certificate, "name", word("cylinder")),
            dcc("usedMethods", used),
            dcc("usedSoftware", _software(certificate)),
            dcc("measuringEquipments", *equipment) if equipment else None,
            _influences(certificate),
            dcc("results", *results),
        ),
    )


def _equipment(certificate: Certificate, key: str, calibration: Calibration) -> Element:
    word = certificate.word
    stated = {
        "certificate": calibration.certificate,
        "calibrated": str(calibration.calibrated or ""),
        "due": str(calibration.due or ""),
    }
    lines = [f"{word(name)}: {text or word('not_stated')}" for name, text in stated.items()]
    return dcc(
        "measuringEquipment",
        text_of(certificate, "name", word(key)),
        text_of(certificate, "description", *lines),
        _optional_identifications(
            certificate, ("manufacturer", calibration.serial, "serial", "basic_serialNumber")
        ),
    )


def _influences(certificate: Certificate) -> Element:
    word, oil = certificate.word, certificate.results.oil_temperature
    ambient = certificate.test.ambient or word("not_stated")
    conditions = [_condition(certificate, "ambient", text_of(certificate, "noQuantity", ambient))]
    if oil is None:
        text = text_of(certificate, "noQuantity", word("oil_not_measured"))
        conditions.append(_condition(certificate, "oil_temperature", text))
    else:
        conditions.append(_condition(certificate, "oil_temperature", real(oil.mean_k, _KELVIN)))
    return dcc("influenceConditions", *conditions)


def _condition(certificate: Certificate, key: str, quantity: Element) -> Element:
    return dcc(
        "influenceCondition",
        text_of(certificate, "name", certificate.word(key)),
        dcc("data", dcc("quantity", quantity)),
    )


def _result(certificate: Certificate, name: str, values: Iterable[Certified]) -> Element:
    lists = [_values(certificate, value) for value in values]
    return dcc("result", text_of(certificate, "name", name), dcc("data", *lists))


def _values(certificate: Certificate, value: Certified) -> Element:
    """Return a measured value with the operating point that it belongs to."""
    word, each = certificate.word, value.measurement
    title = ", ".join(
        filter(
            None,
            (
                certificate.named(each.label),
                word(each.direction) if each.direction else "",
                word(value.leak) if value.leak else "",
            ),
        )
    )
    point = (
        ("load", each.f_load_n, _NEWTON),
        ("back_pressure", each.p_lr_ref_pa, _PASCAL),
        ("speed", each.v_m_s, _METRE_PER_SECOND),
        ("dwell", each.dwell_s, r"\second"),
    )
    quantities = [
        _quantity(certificate, _without_unit(word(key)), real(number, unit))
        for key, number, unit in point
        if number is not None
    ]
    measured = real(each.value, _UNITS[value.quantity], each.u95, value.k)
    name = word(f"q_{value.quantity}")
    quantities.append(_quantity(certificate, name, measured, "basic_measuredValue"))
    if value.pressure_pa is not None:
        pressure = real(value.pressure_pa, _PASCAL, value.pressure_u95_pa, value.k)
        name = f"{name}, {_without_unit(word('pressure_u'))}"
        quantities.append(_quantity(certificate, name, pressure, "basic_measuredValue"))
    heading = text_of(certificate, "name", title) if title else None
    return dcc("list", heading, *quantities)


def _quantity(certificate: Certificate, name: str, real: Element, kind: str = "") -> Element:
    attributes = {"refType": kind} if kind else {}
    return dcc("quantity", text_of(certificate, "name", name), real, **attributes)


def _without_unit(text: str) -> str:
    return text.rpartition(" (")[0].removesuffix(" ± U") or text
