"""Parts with the method, the results and their uncertainty."""

import math
from collections.abc import Iterable, Iterator

from hbench.records.conformity.acceptance import LimitQuantity
from hbench.records.conformity.certified import Certified
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.layout import (
    GridTable,
    Part,
    localized,
    on_a_line,
    series_words,
    without_empty,
)
from hbench.report.conformity.text import step_words
from hbench.report.render.numbers import NONE, in_mm_s, number, short, span, with_interval
from hbench.sentences import listed
from hbench.units import from_si
from hbench.untrusted_text import printable

_PER_PA = 1e7  # pressure that leakages are stated for


def method_part(certificate: Certificate) -> Part:
    """Return the laboratory's procedure, how each quantity is measured, and the software."""
    word, file, provenance = certificate.word, certificate.file, certificate.results.provenance
    measured = {value.quantity for value in certificate.values}
    checks = certificate.acceptance.checks if certificate.acceptance is not None else ()
    decided = {check.requirement.quantity for check in checks if check.measurement is not None}
    version = provenance.software.get("hbench", word("not_stated"))
    firmware = printable(provenance.firmware) or word("not_stated")
    paragraphs = [
        *([word("procedure", method=file.method)] if file.method else []),
        *([word("method_steady")] if measured & {"friction", "efficiency"} else []),
        *(
            word(f"method_{key}", **_settings(certificate))
            for key in ("efficiency", "breakaway", "leakage")
            if key in measured
        ),
        *(word(f"method_{key}") for key in ("speed_ripple", "drift") if key in decided),
    ]
    of_record = [
        word("software", version=printable(version), firmware=firmware),
        word("external", external=file.external) if file.external else word("no_external"),
        word("no_sampling"),
        *([word("imported")] if provenance.source == "imported" else []),
    ]
    paragraphs.append(" ".join(of_record))
    return Part("method", word("method"), paragraphs=tuple(paragraphs))


def _settings(certificate: Certificate) -> dict[str, str]:
    """Return the settings that breakaway and leakage depend on, each in parentheses if known."""
    motions = certificate.results.motions
    values = {
        "rate": ([each.rate_n_s for each in motions.breakaways if each.rate_n_s], "N/s"),
        "creep": ([1e3 * each.displacement_m for each in motions.breakaways], "mm"),
        "bulk_modulus": (
            [from_si(each.bulk_modulus_pa, "bar") for each in motions.leakages],
            "bar",
        ),
    }
    settings = {
        name: f" ({localized(certificate, span(each))} {unit})" if each else ""
        for name, (each, unit) in values.items()
    }
    return settings | {"leak_law": _leak_law(certificate)}


def _leak_law(certificate: Certificate) -> str:
    """Return how leakage depends on the pressure: assumed, or as the holds show it."""
    leaks = certificate.results.motions.leakages
    powers = [leak for leak in leaks if leak.exponent != 1.0 and leak.reference_pa]
    if not powers:
        decays = [decay for leak in leaks for decay in leak.decays]
        across = [from_si(abs(decay.p_p_pa - decay.p_r_pa), "bar") for decay in decays]
        held = localized(certificate, span(across)) if across else ""
        holds = certificate.word("leak_holds", count=len(decays), pressures=held) if held else ""
        flows = [value.measurement for value in certificate.of("leakage")]
        if all(flow.u95 is not None and abs(flow.value) <= flow.u95 for flow in flows):
            holds += certificate.word("leak_none")
        return certificate.word("leak_laminar", holds=holds)
    exponents = span([leak.exponent for leak in powers])
    pressures = span([from_si(leak.reference_pa or 0.0, "bar") for leak in powers])
    return certificate.word(
        "leak_power",
        exponent=localized(certificate, exponents),
        pressure=localized(certificate, pressures),
    )


def result_parts(certificate: Certificate) -> Iterator[Part]:
    """Yield a part for each kind of measurement.

    Speed ripple and drift have none: the statement of conformity has all of their values.
    """
    word = certificate.word
    if certificate.of("friction") or certificate.of("efficiency"):
        remarks = (
            [word("p_lr")] if any(v.measurement.p_lr_ref_pa for v in certificate.values) else []
        )
        if certificate.has_no_load:
            remarks.append(word("no_load"))
        if not certificate.all_speeds:
            remarks.append(word("fewer"))
        table = _steady(certificate)
        title = word("friction" if certificate.of("efficiency") else "friction_alone")
        yield Part(
            "friction", title, tables=(table,), paragraphs=(" ".join(remarks),) * bool(remarks)
        )
    if certificate.of("breakaway"):
        yield Part("breakaway", word("breakaway"), tables=(_breakaways(certificate),))
    if leaks := _leaks(certificate):
        rows = tuple(
            (
                word(value.leak or ""),
                certificate.named(value.measurement.label),
                _runs(value),
                _interval(certificate, value, _PER_PA * from_si(1.0, "ml/min")),
                _factor(certificate, value) if value.k else "",
            )
            for value in leaks
        )
        head = tuple(map(word, ("leak", "series", "n", "leakage_u", "k")))
        table = without_empty(GridTable(head, rows, frozenset({2, 3, 4})))
        others = (word("other_leaks"),) if len(leaks) < len(certificate.of("leakage")) else ()
        yield Part("leakage", word("leakage"), tables=(table,), paragraphs=others)


def _leaks(certificate: Certificate) -> list[Certified]:
    """Return the leakages without those that the statement of conformity has at 100 bar.

    With several series of holds none is left out: the table has their numbers of runs.
    """
    leaks = list(certificate.of("leakage"))
    if certificate.acceptance is None or len(certificate.results.motions.leakages) != 1:
        return leaks
    decided = [
        (check.requirement.leak, check.measurement.value / _PER_PA)
        for check in certificate.acceptance.checks
        if check.measurement is not None
        and math.isclose(check.requirement.pressure_pa or 0.0, _PER_PA)
    ]
    return [
        each
        for each in leaks
        if not any(
            leak == each.leak and math.isclose(per_pa, each.measurement.value)
            for leak, per_pa in decided
        )
    ]


def _steady(certificate: Certificate) -> GridTable:
    """Return a row for each series and speed, with friction, pressure and efficiency."""
    points: dict[tuple, dict[str, Certified]] = {}
    for value in (*certificate.of("friction"), *certificate.of("efficiency")):
        each = value.measurement
        at = each.label, each.direction, each.f_load_n, each.p_lr_ref_pa, each.v_m_s
        points.setdefault(at, {})[value.quantity] = value
    rows = []
    for (*series, v_m_s), values in points.items():
        force, share = values.get("friction"), values.get("efficiency")
        row = (
            *_series(certificate, series),
            localized(certificate, in_mm_s(v_m_s)),
            _runs(force),
            _interval(certificate, force),
            _factor(certificate, force),
            _pressure(certificate, force),
            _interval(certificate, share, 100.0),
            _factor(certificate, share),
        )
        rows.append(row)
    words = (
        *("series", "direction", "load", "back_pressure", "speed", "n"),
        *("friction_u", "k", "pressure_u", "efficiency_u", "k"),
    )
    head = tuple(map(certificate.word, words))
    return without_empty(GridTable(head, tuple(rows), frozenset(range(2, len(head)))))


def _breakaways(certificate: Certificate) -> GridTable:
    rows = tuple(
        (
            *_series(
                certificate,
                (each.label, each.direction, each.f_load_n, each.p_lr_ref_pa),
            ),
            localized(certificate, short(each.dwell_s)),
            _runs(value),
            _interval(certificate, value),
            _factor(certificate, value),
            _pressure(certificate, value),
        )
        for value in certificate.of("breakaway")
        for each in (value.measurement,)
    )
    words = ("series", "direction", "load", "back_pressure", "dwell", "n", "breakaway_u", "k")
    head = tuple(map(certificate.word, (*words, "pressure_u")))
    return without_empty(GridTable(head, rows, frozenset(range(2, len(head)))))


def _series(certificate: Certificate, series: Iterable) -> tuple[str, str, str, str]:
    label, direction, f_load_n, p_lr_ref_pa = series
    label = certificate.named(label)
    back = None if p_lr_ref_pa is None else from_si(p_lr_ref_pa, "bar")
    return (
        on_a_line(label, 12),
        certificate.word(direction) if direction else "",
        "" if f_load_n is None else localized(certificate, short(f_load_n)),
        "" if back is None else localized(certificate, short(back)),
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


def _runs(value: Certified | None) -> str:
    """Write how many accepted runs a value is the mean of; empty where that is not known."""
    return str(len(value.measurement.runs)) if value and value.measurement.runs else ""


def _factor(certificate: Certificate, value: Certified | None) -> str:
    k = None if value is None or value.measurement.u95 is None else value.k
    return localized(certificate, number(k, 2))


def _load_cell_zero(certificate: Certificate) -> str:
    """Return how far U contains the zero error of a load cell whose zero was not checked."""
    if certificate.instruments is None or certificate.instruments.force.of != "reading":
        return certificate.word("load_cell_zero")
    full_scale_n = certificate.instruments.force.full_scale
    return certificate.word(
        "load_cell_zero_of_reading",
        full_scale=f"{localized(certificate, short(full_scale_n / 1e3))} kN",
        change=f"{localized(certificate, short(full_scale_n / 1e3))} N",
    )


def _of_trials(certificate: Certificate, quantity: LimitQuantity) -> str:
    """Return a quantity with the runs and the factor of its values.

    Where they differ, the series of those that are fewer are named.
    """
    series: dict[str, dict[str, None]] = {}
    for value in certificate.of(quantity):
        measured, k = value.measurement, _factor(certificate, value)
        runs, where = len(measured.runs), series_words(certificate, measured, True, True)
        words = []
        if runs:
            words.append(certificate.word("each_of_runs" if runs > 1 else "of_a_run", runs=runs))
        if k != NONE:
            words.append(f"k = {k}")
        if measured.v_m_s:
            speed = localized(certificate, short(1e3 * measured.v_m_s))
            where = f"{where} {certificate.word('at_speed', speed=speed)}"
        series.setdefault(", ".join(words), {})[where.strip()] = None
    most, *others = sorted(series, key=lambda each: -len(series[each]))
    parts = [
        most,
        *(f"{each}: {listed(list(series[each]), certificate.word('and'))}" for each in others),
    ]
    shown = "; ".join(filter(None, parts))
    return certificate.word(f"q_{quantity}") + (f" ({shown})" if shown else "")


def uncertainty_part(certificate: Certificate) -> Part:
    """Return what U is and what it does not contain."""
    word = certificate.word
    motions = certificate.results.motions
    general = [word("trials_only" if certificate.instruments is None else "gum")]
    of_trials: tuple[LimitQuantity, ...] = ("speed_ripple", "drift")
    if alone := [_of_trials(certificate, each) for each in of_trials if certificate.of(each)]:
        general.append(word("of_trials", quantities=listed(alone, word("and"))))
    if motions.load_cell_zero_unchecked:
        general.append(_load_cell_zero(certificate))
    paragraphs = [" ".join(general)]
    if certificate.of("leakage"):
        step = max((each.step_pa or 0.0 for each in motions.leakages), default=0.0)
        paragraphs.append(word("leak_interval", step=localized(certificate, step_words(step))))
    return Part("uncertainty", word("uncertainty"), paragraphs=tuple(paragraphs))
