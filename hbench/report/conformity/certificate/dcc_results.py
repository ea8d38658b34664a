"""Measurement results of a digital calibration certificate."""

from collections.abc import Iterable
from xml.etree.ElementTree import Element

from hbench.config.identity import Calibration
from hbench.records.conformity.certified import Certified
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.content import content
from hbench.report.conformity.certificate.dcc_elements import (
    dcc,
    identifications,
    real,
    software,
    text_of,
)

_NEWTON, _PASCAL, _ONE, _KELVIN = r"\newton", r"\pascal", r"\one", r"\kelvin"
_METRE_PER_SECOND = r"\metre\second\tothe{-1}"
_LEAK = r"\metre\tothe{3}\second\tothe{-1}\pascal\tothe{-1}"
_UNITS = {
    **{"friction": _NEWTON, "breakaway": _NEWTON, "leakage": _LEAK},
    **{"efficiency": _ONE, "speed_ripple": _ONE, "drift": _ONE},
}


def measurement_results(certificate: Certificate) -> Element:
    """Return the element of all measured values, with method, instruments and conditions."""
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
            dcc("usedSoftware", software(certificate)),
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
        identifications(
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
