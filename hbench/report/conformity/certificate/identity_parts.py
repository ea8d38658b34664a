"""Parts that identify laboratory, customer, specimen, test, instruments and raw data."""

import math
from collections.abc import Iterable, Iterator

from hbench.config.sensors import ForceInstrument, PressureInstrument
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.layout import (
    GridTable,
    Part,
    localized,
    stated_facts,
)
from hbench.report.render.numbers import number, short
from hbench.sentences import listed
from hbench.units import from_si
from hbench.untrusted_text import printable


def laboratory_part(certificate: Certificate) -> Part:
    """Return name, address, accreditation and the place of the test."""
    laboratory = certificate.file.laboratory
    country = "" if laboratory.country in laboratory.address else laboratory.country
    pairs = [
        ("name", laboratory.name, True),
        ("address", _lines((*laboratory.address, country)), True),
        ("contact", laboratory.contact, False),
        ("accreditation", laboratory.accreditation or certificate.word("not_accredited"), True),
        ("place", certificate.test.place, True),
    ]
    return Part("laboratory", certificate.word("laboratory"), stated_facts(certificate, pairs))


def customer_part(certificate: Certificate) -> Part:
    """Return name, address and order of the customer."""
    customer = certificate.file.customer
    pairs = [
        ("name", certificate.customer_name, True),
        ("address", _lines((*customer.address, customer.country)), True),
        ("contact", customer.contact, False),
        ("order", certificate.specimen.order, False),
    ]
    return Part("customer", certificate.word("customer"), stated_facts(certificate, pairs))


def specimen_part(certificate: Certificate) -> Part:
    """Return identity, condition and areas of the cylinder."""
    word, specimen = certificate.word, certificate.specimen
    received = certificate.file.received
    pairs = [
        ("object", word("cylinder"), True),
        ("serial", specimen.serial, True),
        ("maker", specimen.maker, False),
        *((key, getattr(specimen, key) or size, False) for key, size in _sizes(certificate)),
        ("seals", specimen.seals, False),
        ("wear", specimen.wear, True),
        ("received", "" if received is None else str(received), True),
        ("areas", _areas(certificate), False),
    ]
    return Part("specimen", word("specimen"), stated_facts(certificate, pairs))


def _sizes(certificate: Certificate) -> Iterator[tuple[str, str]]:
    """Yield bore, rod and stroke of the campaign's cylinder; empty where they are not known."""
    specimen = certificate.results.runs[0].run.plan.specimen
    piston, rod, stroke = specimen.area_piston_m2, specimen.area_rod_m2, specimen.stroke_m
    one_rod = 0 < rod < piston
    sizes = {
        "bore": 2 * math.sqrt(piston / math.pi) if one_rod else None,
        "rod": 2 * math.sqrt((piston - rod) / math.pi) if one_rod else None,
        "stroke": stroke,
    }
    for key, size_m in sizes.items():
        known = "" if size_m is None else localized(certificate, f"{short(1e3 * size_m)} mm")
        yield key, known


def _areas(certificate: Certificate) -> str:
    specimen = certificate.results.runs[0].run.plan.specimen
    if not specimen.area_piston_m2:
        return ""
    piston, rod = (
        localized(certificate, number(1e6 * area))
        for area in (specimen.area_piston_m2, specimen.area_rod_m2)
    )
    return certificate.word("areas_mm2", piston=piston, rod=rod)


def test_part(certificate: Certificate) -> Part:
    """Return date, operator and number of runs."""
    word, test, results = certificate.word, certificate.test, certificate.results
    days = certificate.performed
    performed = test.date if days is None else " – ".join(dict.fromkeys(map(str, days)))
    accepted = sum(run.accepted for run in results.runs)
    planned = results.quality.completeness.planned or len(results.runs)
    pairs = [
        ("test_number", test.number, False),
        ("performed", performed, True),
        ("operator", test.operator, False),
        ("mounting", test.mounting, False),
        ("campaign", printable(certificate.named(results.provenance.name)), True),
        ("runs", word("runs_accepted", accepted=accepted, planned=planned), True),
    ]
    return Part("test", word("test"), stated_facts(certificate, pairs))


def conditions_part(certificate: Certificate) -> Part:
    """Return ambient and oil with their temperatures."""
    settings = certificate.results.provenance.settings
    oil = settings.get("oil") or {}
    grade = oil.get("grade", "") if isinstance(oil, dict) else ""
    pairs = [
        ("ambient", certificate.test.ambient, True),
        ("oil", printable(str(grade)), True),
        ("oil_temperature", _oil_temperature(certificate), True),
    ]
    return Part("conditions", certificate.word("conditions"), stated_facts(certificate, pairs))


def _oil_temperature(certificate: Certificate) -> str:
    word, oil = certificate.word, certificate.results.oil_temperature
    if oil is None:
        return word("oil_not_measured")
    low, high, mean = (
        localized(certificate, number(from_si(kelvin, "degC")))
        for kelvin in (oil.low_k, oil.high_k, oil.mean_k)
    )
    return word("oil_range", low=low, high=high, mean=mean, place=word(oil.sensor))


def instruments_part(certificate: Certificate) -> Part:
    """Return the instruments with their calibrations, and whether the results are traceable."""
    word = certificate.word
    title = word("instruments")
    instruments = list(certificate.calibrations())
    if not instruments:
        return Part("instruments", title, paragraphs=(word("no_instruments"),))
    keys = ("instrument", "serial", "tolerance", "certificate", "calibrated", "due")
    days = certificate.performed
    rows: list[tuple[str, ...]] = []
    expired = []
    for key, instrument, calibration in instruments:
        due = "" if calibration.due is None else str(calibration.due)
        if calibration.due is not None and days is not None and calibration.due < days[1]:
            due = word("overdue", date=due)
            expired.append(word(f"the_{key}"))
        calibrated = "" if calibration.calibrated is None else str(calibration.calibrated)
        texts = (
            calibration.serial,
            _tolerance(certificate, key, instrument),
            calibration.certificate,
            calibrated,
            due,
        )
        rows.append((word(key), *(text or word("not_stated") for text in texts)))
    unknown = [word(f"the_{key}") for key, _, known in instruments if not known.certificate]
    traceable = [word("not_traceable", instruments=listed(unknown, word("and")))] if unknown else []
    if expired:
        traceable.append(word("expired", instruments=listed(expired, word("and"))))
    table = GridTable(tuple(map(word, keys)), tuple(rows))
    return Part(
        "instruments", title, tables=(table,), paragraphs=tuple(traceable) or (word("traceable"),)
    )


def _tolerance(
    certificate: Certificate, key: str, instrument: ForceInstrument | PressureInstrument
) -> str:
    unit = "N" if key == "force" else "bar"
    return certificate.word(
        f"of_{instrument.of}",
        tolerance=localized(certificate, short(100 * instrument.tolerance)),
        full_scale=localized(certificate, f"{short(from_si(instrument.full_scale, unit))} {unit}"),
    )


def data_part(certificate: Certificate) -> Part:
    """Return the checksums of the raw data with the line that verifies them."""
    word, raw = certificate.word, certificate.raw
    suffix = raw.logs[0].name.rpartition(".")[2] if raw.logs else "dat"
    pairs = [
        ("logs", word("logs_count", count=len(raw.logs)), True),
        ("logs_sha256", raw.sha256, True),
        ("record_sha256", raw.record_sha256, True),
        ("verify", f"sha256sum runs/*.{suffix} | LC_ALL=C sort -k2 | sha256sum", True),
    ]
    return Part("data", word("data"), stated_facts(certificate, pairs))


def validity_part(certificate: Certificate) -> Part:
    """Return what the certificate applies to."""
    keys = ("only_item", "in_full", "customer_data")
    text = " ".join(map(certificate.word, keys))
    return Part("statements", certificate.word("statements"), paragraphs=(text,))


def _lines(lines: Iterable[str]) -> str:
    return ", ".join(filter(None, lines))
