"""Content of a certificate in its language: parts of facts, tables and paragraphs.

The page, the PDF and a laboratory's own template show the same content. ISO/IEC 17025:2017, 7.8
asks for most of it; the README of this folder has the list.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from hbench.config.sensors import ForceInstrument, PressureInstrument
from hbench.records.conformity.acceptance import Acceptance, ConformityCheck, Requirement
from hbench.records.conformity.certified import CERTIFIED_QUANTITIES, Certified
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.render.numbers import NONE, number, short, significant, with_interval
from hbench.units import from_si
from hbench.untrusted_text import printable

_UNIT = re.compile(r"(\d) (mm/s|mm²|N|bar|%|°C|s|ml/min)(?![\w/])")

Fact = tuple[str, str]  # name and text


@dataclass(frozen=True)
class GridTable:
    """Table of a certificate; columns named in ``numbers`` are aligned to the right."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Part:
    """Part of a certificate; ``key`` names it for templates."""

    key: str
    title: str
    facts: tuple[Fact, ...] = ()
    tables: tuple[GridTable, ...] = ()
    paragraphs: tuple[str, ...] = ()
    lead: str = ""  # before the rest, in bold


@dataclass(frozen=True)
class Content:
    """All that a certificate shows. ``rows`` holds the parts; two in a row are side by side."""

    language: str
    title: str
    number_label: str
    number: str
    page_label: str
    of_label: str
    mark: str  # on every page of a document that certifies nothing; empty: none
    mark_text: str  # the same in full
    head_facts: tuple[Fact, ...]
    rows: tuple[tuple[Part, ...], ...]
    signature_title: str
    signatories: tuple[tuple[str, str], ...]  # name and role
    signature_label: str
    end: str

    @property
    def parts(self) -> dict[str, Part]:
        """The parts by their keys."""
        return {part.key: part for row in self.rows for part in row}


def content(certificate: Certificate) -> Content:
    """Return the content of a certificate."""
    word = certificate.word
    rows = (
        (_laboratory(certificate), _customer(certificate)),
        (_specimen(certificate), _test(certificate)),
        (_conditions(certificate),),
        (_instruments(certificate),),
        (_method(certificate),),
        *((part,) for part in _results(certificate)),
        (_uncertainty(certificate),),
        (_conformity(certificate),),
        (_not_tested(certificate),),
        *(
            [(Part("remarks", word("remarks"), paragraphs=certificate.file.remarks),)]
            * bool(certificate.file.remarks)
        ),
        (_data(certificate),),
        (_validity(certificate),),
    )
    head = [(word("number"), certificate.number), (word("issued"), str(certificate.issued))]
    if certificate.file.replaces:
        head.append((word("replaces"), certificate.file.replaces))
    return Content(
        language=certificate.file.language,
        title=word("title"),
        number_label=word("number"),
        number=certificate.number,
        page_label=word("page"),
        of_label=word("of"),
        mark=word("simulated_short") if certificate.simulated else "",
        mark_text=word("simulated") if certificate.simulated else "",
        head_facts=tuple(head),
        rows=tuple(tuple(map(_with_joined_units, row)) for row in rows),
        signature_title=word("signatures"),
        signatories=tuple((each.name, each.role) for each in certificate.file.signatories),
        signature_label=word("date_signature"),
        end=f"{word('end')} {certificate.number}",
    )


def _with_joined_units(part: Part) -> Part:
    """Return a part whose numbers stay on the line of their units."""

    def join(text: str) -> str:
        return _UNIT.sub("\\1\u00a0\\2", text)

    tables = (
        replace(table, rows=tuple(tuple(map(join, row)) for row in table.rows))
        for table in part.tables
    )
    return replace(
        part,
        facts=tuple((name, join(text)) for name, text in part.facts),
        tables=tuple(tables),
        paragraphs=tuple(map(join, part.paragraphs)),
    )


def localized(certificate: Certificate, text: str) -> str:
    """Return a number's text with the decimal sign of the certificate's language."""
    return text.replace(".", ",") if certificate.file.language == "de" else text


def _facts(certificate: Certificate, pairs: Iterable[tuple[str, str, bool]]) -> tuple[Fact, ...]:
    """Return facts of words' keys and texts; empty ones only if they are required."""
    return tuple(
        (certificate.word(key), text or certificate.word("not_stated"))
        for key, text, required in pairs
        if text or required
    )


def _laboratory(certificate: Certificate) -> Part:
    laboratory = certificate.file.laboratory
    country = "" if laboratory.country in laboratory.address else laboratory.country
    pairs = [
        ("name", laboratory.name, True),
        ("address", _lines((*laboratory.address, country)), True),
        ("contact", laboratory.contact, False),
        ("accreditation", laboratory.accreditation or certificate.word("not_accredited"), True),
        ("place", certificate.test.place, True),
    ]
    return Part("laboratory", certificate.word("laboratory"), _facts(certificate, pairs))


def _customer(certificate: Certificate) -> Part:
    customer = certificate.file.customer
    pairs = [
        ("name", certificate.customer_name, True),
        ("address", _lines((*customer.address, customer.country)), True),
        ("contact", customer.contact, False),
        ("order", certificate.specimen.order, False),
    ]
    return Part("customer", certificate.word("customer"), _facts(certificate, pairs))


def _specimen(certificate: Certificate) -> Part:
    word, specimen = certificate.word, certificate.specimen
    received = certificate.file.received
    pairs = [
        ("object", word("cylinder"), True),
        ("serial", specimen.serial, True),
        ("maker", specimen.maker, False),
        *((key, getattr(specimen, key), False) for key in ("bore", "rod", "stroke", "seals")),
        ("wear", specimen.wear, True),
        ("received", "" if received is None else str(received), True),
        ("areas", _areas(certificate), False),
    ]
    return Part("specimen", word("specimen"), _facts(certificate, pairs))


def _areas(certificate: Certificate) -> str:
    specimen = certificate.results.runs[0].run.plan.specimen
    if not specimen.area_piston_m2:
        return ""
    piston, rod = (
        localized(certificate, number(1e6 * area))
        for area in (specimen.area_piston_m2, specimen.area_rod_m2)
    )
    return certificate.word("areas_mm2", piston=piston, rod=rod)


def _test(certificate: Certificate) -> Part:
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
        ("campaign", printable(results.provenance.name), True),
        ("runs", word("runs_accepted", accepted=accepted, planned=planned), True),
    ]
    return Part("test", word("test"), _facts(certificate, pairs))


def _conditions(certificate: Certificate) -> Part:
    settings = certificate.results.provenance.settings
    oil = settings.get("oil") or {}
    grade = oil.get("grade", "") if isinstance(oil, dict) else ""
    pairs = [
        ("ambient", certificate.test.ambient, True),
        ("oil", printable(str(grade)), True),
        ("oil_temperature", _oil_temperature(certificate), True),
    ]
    return Part("conditions", certificate.word("conditions"), _facts(certificate, pairs))


def _oil_temperature(certificate: Certificate) -> str:
    word, oil = certificate.word, certificate.results.oil_temperature
    if oil is None:
        return word("oil_not_measured")
    low, high, mean = (
        localized(certificate, number(from_si(kelvin, "degC")))
        for kelvin in (oil.low_k, oil.high_k, oil.mean_k)
    )
    return word("oil_range", low=low, high=high, mean=mean, place=word(oil.sensor))


def _instruments(certificate: Certificate) -> Part:
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
            expired.append(word(key))
        calibrated = "" if calibration.calibrated is None else str(calibration.calibrated)
        texts = (
            calibration.serial,
            _tolerance(certificate, key, instrument),
            calibration.certificate,
            calibrated,
            due,
        )
        rows.append((word(key), *(text or word("not_stated") for text in texts)))
    unknown = [word(key) for key, _, calibration in instruments if not calibration.certificate]
    traceable = [word("not_traceable", instruments=", ".join(unknown))] if unknown else []
    if expired:
        traceable.append(word("expired", instruments=", ".join(expired)))
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


def _method(certificate: Certificate) -> Part:
    word, file, provenance = certificate.word, certificate.file, certificate.results.provenance
    measured = {value.quantity for value in certificate.values}
    version = provenance.software.get("hbench", word("not_stated"))
    firmware = printable(provenance.firmware) or word("not_stated")
    paragraphs = [
        *([word("procedure", method=file.method)] if file.method else []),
        *([word("method_steady")] if measured & {"friction", "efficiency"} else []),
        *(word(f"method_{key}") for key in ("breakaway", "leakage") if key in measured),
        word("software", version=printable(version), firmware=firmware),
        word("external", external=file.external) if file.external else word("no_external"),
        word("no_sampling"),
    ]
    if provenance.source == "imported":
        paragraphs.append(word("imported"))
    return Part("method", word("method"), paragraphs=tuple(paragraphs))


def _results(certificate: Certificate) -> Iterator[Part]:
    word = certificate.word
    if certificate.of("friction") or certificate.of("efficiency"):
        remarks = (
            [word("p_lr")] if any(v.measurement.p_lr_ref_pa for v in certificate.values) else []
        )
        if not certificate.all_speeds:
            remarks.append(word("fewer"))
        table = _steady(certificate)
        yield Part("friction", word("friction"), tables=(table,), paragraphs=tuple(remarks))
    if certificate.of("breakaway"):
        yield Part("breakaway", word("breakaway"), tables=(_breakaways(certificate),))
    if certificate.of("leakage"):
        rows = tuple(
            (
                word(value.leak or ""),
                value.measurement.label,
                _interval(certificate, value, from_si(1.0, "ml/min") / from_si(1.0, "bar")),
            )
            for value in certificate.of("leakage")
        )
        head = tuple(map(word, ("leak", "series", "leakage_u")))
        table = _without_empty(GridTable(head, rows, frozenset({2})))
        yield Part("leakage", word("leakage"), tables=(table,))


def _steady(certificate: Certificate) -> GridTable:
    """Return a row for each series and speed, with friction, pressure and efficiency."""
    points: dict[tuple, dict[str, Certified]] = {}
    for value in (*certificate.of("friction"), *certificate.of("efficiency")):
        each = value.measurement
        at = each.label, each.direction, each.f_load_n, each.p_lr_ref_pa, each.v_m_s
        points.setdefault(at, {})[value.quantity] = value
    rows = []
    for (*series, speed), values in points.items():
        force, share = values.get("friction"), values.get("efficiency")
        row = (
            *_series(certificate, series),
            localized(certificate, number(None if speed is None else 1e3 * speed)),
            _interval(certificate, force),
            _factor(certificate, force),
            _pressure(certificate, force),
            _interval(certificate, share, 100.0),
            _factor(certificate, share),
        )
        rows.append(row)
    words = (
        *("series", "direction", "load", "back_pressure", "speed"),
        *("friction_u", "k", "pressure_u", "efficiency_u", "k"),
    )
    head = tuple(map(certificate.word, words))
    return _without_empty(GridTable(head, tuple(rows), frozenset(range(2, len(head)))))


def _breakaways(certificate: Certificate) -> GridTable:
    rows = tuple(
        (
            *_series(
                certificate,
                (each.label, each.direction, each.f_load_n, each.p_lr_ref_pa),
            ),
            localized(certificate, short(each.dwell_s)),
            _interval(certificate, value),
            _factor(certificate, value),
            _pressure(certificate, value),
        )
        for value in certificate.of("breakaway")
        for each in (value.measurement,)
    )
    words = ("series", "direction", "load", "back_pressure", "dwell", "breakaway_u", "k")
    head = tuple(map(certificate.word, (*words, "pressure_u")))
    return _without_empty(GridTable(head, rows, frozenset(range(2, len(head)))))


def _series(certificate: Certificate, series: Iterable) -> tuple[str, str, str, str]:
    label, direction, f_load_n, p_lr_ref_pa = series
    back = None if p_lr_ref_pa is None else from_si(p_lr_ref_pa, "bar")
    return (
        label,
        certificate.word(direction) if direction else "",
        "" if f_load_n is None else localized(certificate, short(f_load_n)),
        "" if back is None else localized(certificate, short(back)),
    )


def _without_empty(table: GridTable) -> GridTable:
    """Return the table without columns that have no text in any row."""
    kept = [
        i for i in range(len(table.head)) if any(row[i] not in ("", NONE) for row in table.rows)
    ]
    return GridTable(
        tuple(table.head[i] for i in kept),
        tuple(tuple(row[i] for i in kept) for row in table.rows),
        frozenset(new for new, old in enumerate(kept) if old in table.numbers),
    )


def _interval(certificate: Certificate, value: Certified | None, scale: float = 1.0) -> str:
    if value is None:
        return NONE
    half = value.measurement.u95
    text = with_interval(scale * value.measurement.value, None if half is None else scale * half)
    return localized(certificate, text)


def _pressure(certificate: Certificate, value: Certified | None) -> str:
    if value is None or value.pressure_pa is None:
        return NONE
    half = value.pressure_u95_pa
    bar = from_si(value.pressure_pa, "bar")
    return localized(
        certificate, with_interval(bar, None if half is None else from_si(half, "bar"))
    )


def _factor(certificate: Certificate, value: Certified | None) -> str:
    k = None if value is None or value.measurement.u95 is None else value.k
    return localized(certificate, number(k, 2))


def _uncertainty(certificate: Certificate) -> Part:
    word = certificate.word
    paragraphs = [word("trials_only" if certificate.instruments is None else "gum")]
    if certificate.of("leakage"):
        paragraphs.append(word("leak_interval"))
    return Part("uncertainty", word("uncertainty"), paragraphs=tuple(paragraphs))


def _conformity(certificate: Certificate) -> Part:
    word, acceptance = certificate.word, certificate.acceptance
    if acceptance is None:
        return Part("conformity", word("conformity"), paragraphs=(word("no_limits"),))
    keys = ("quantity", "series", "measured", "limit", "conforms", "decision")
    rows = tuple(_decision_row(certificate, check) for check in acceptance.checks)
    table = _without_empty(GridTable(tuple(map(word, keys)), rows, frozenset({2, 4})))
    share = localized(certificate, short(100 * (acceptance.largest_uncertainty or 0.0)))
    rule = word(f"rule_{acceptance.rule}", share=share)
    paragraphs = (word("decision_rule", rule=rule), word("applies"))
    decision = word("overall", decision=word(acceptance.decision), limits=_file(acceptance))
    if acceptance.product:
        decision += " " + word("of_product", product=acceptance.product)
    title = word("conformity")
    return Part("conformity", title, tables=(table,), paragraphs=paragraphs, lead=decision)


def _file(acceptance: Acceptance) -> str:
    return f"{printable(acceptance.limits)}, SHA-256 {acceptance.limits_sha256[:12]}…"


def _decision_row(certificate: Certificate, check: ConformityCheck) -> tuple[str, ...]:
    word, measured, unit = certificate.word, check.measurement, check.requirement.unit
    series = measured or check.requirement
    load = "" if series.f_load_n is None else f"{short(series.f_load_n)} N"
    direction = word(series.direction) if series.direction else ""
    where = filter(None, (series.label, direction, localized(certificate, load)))
    text, percent = NONE, NONE
    if measured is not None:
        half = None if measured.u95 is None else from_si(measured.u95, unit)
        text = f"{with_interval(from_si(measured.value, unit), half)} {unit}"
    if check.probability is not None:
        shown = 100 * check.probability
        percent = "> 99.9" if shown > 99.9 else "< 0.1" if shown < 0.1 else significant(shown, 3)
    return (
        quantity_words(certificate, check),
        ", ".join(where),
        localized(certificate, text),
        limit_words(certificate, check.requirement),
        localized(certificate, percent),
        word(check.decision),
    )


def quantity_words(certificate: Certificate, check: ConformityCheck) -> str:
    """Write the limited quantity, after the name that the file of limits gives it."""
    word, requirement, measured = certificate.word, check.requirement, check.measurement
    parts = [word(f"q_{requirement.quantity}")]
    if requirement.leak is not None and requirement.pressure_pa is not None:
        pressure = short(from_si(requirement.pressure_pa, "bar"))
        leak = word(requirement.leak)
        parts.append(word("at_pressure", leak=leak, pressure=localized(certificate, pressure)))
    speed = requirement.v_m_s if measured is None else measured.v_m_s
    if speed is not None:
        parts.append(word("at_speed", speed=localized(certificate, short(1e3 * speed))))
    dwell = requirement.dwell_s if measured is None else measured.dwell_s
    if dwell is not None:
        parts.append(word("after_rest", dwell=localized(certificate, short(dwell))))
    text = " ".join(parts)
    return f"{requirement.name}: {text}" if requirement.name else text


def limit_words(certificate: Certificate, requirement: Requirement) -> str:
    """Write the limits with their unit."""
    low, high = (
        "" if limit is None else localized(certificate, short(from_si(limit, requirement.unit)))
        for limit in (requirement.low, requirement.high)
    )
    key = "between" if low and high else "at_least" if low else "at_most"
    return certificate.word(key, low=low, high=high, unit=requirement.unit)


def _not_tested(certificate: Certificate) -> Part:
    word, results = certificate.word, certificate.results
    complete, paragraphs = results.quality.completeness, []
    measured = {value.quantity for value in certificate.values}
    untested = [word(f"q_{key}") for key in CERTIFIED_QUANTITIES if key not in measured]
    if certificate.acceptance is not None:
        checks = certificate.acceptance.checks
        asked = [quantity_words(certificate, c) for c in checks if c.measurement is None]
        untested += [text for text in asked if text not in untested]
    if untested:
        paragraphs.append(word("untested", quantities="; ".join(untested)))
    rejected = sum(not run.accepted for run in results.runs)
    deviations = []
    if complete.short_points:
        points = len(complete.short_points)
        deviations.append(word("short", points=points, of=complete.points))
    if rejected:
        deviations.append(word("rejected", runs=rejected))
    paragraphs += deviations or [word("no_deviations")]
    if results.quality.grade == "with care":
        care = [c.name for c in results.quality.checks if c.grade != "good"]
        graded = ", ".join(word(f"check_{name}") for name in care)
        paragraphs.append(word("care", checks=graded))
    if certificate.warnings:
        paragraphs.append(word("record_notes", notes="; ".join(certificate.warnings)))
    return Part("not_tested", word("not_tested"), paragraphs=tuple(paragraphs))


def _data(certificate: Certificate) -> Part:
    word, raw = certificate.word, certificate.raw
    suffix = "csv" if certificate.results.provenance.source == "imported" else "dat"
    pairs = [
        ("logs", word("logs_count", count=len(raw.logs)), True),
        ("logs_sha256", raw.sha256, True),
        ("record_sha256", raw.record_sha256, True),
        ("verify", f"sha256sum runs/*.{suffix} | LC_ALL=C sort -k2 | sha256sum", True),
    ]
    return Part("data", word("data"), _facts(certificate, pairs))


def _validity(certificate: Certificate) -> Part:
    keys = ("only_item", "in_full", "customer_data")
    text = " ".join(map(certificate.word, keys))
    return Part("statements", certificate.word("statements"), paragraphs=(text,))


def _lines(lines: Iterable[str]) -> str:
    return ", ".join(filter(None, lines))
