"""Parts with the statement of conformity, and with what was not tested."""

from collections.abc import Collection, Iterable, Iterator, Sequence

from hbench.records import KINDS
from hbench.records.conformity.acceptance import (
    Acceptance,
    ConformityCheck,
    LimitQuantity,
    Requirement,
    UntestedCause,
)
from hbench.records.conformity.certified import CERTIFIED_QUANTITIES
from hbench.records.kinds import Analysis
from hbench.records.rod_pressure import differs_in_rod_pressure
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.layout import (
    GridTable,
    Part,
    localized,
    on_a_line,
    series_words,
    without_empty,
)
from hbench.report.render.numbers import NONE, short, significant, unbroken, with_interval
from hbench.sentences import listed
from hbench.units import from_si
from hbench.untrusted_text import printable

_ANALYSES: dict[LimitQuantity, Analysis] = {  # of the runs that a quantity is from
    "friction": "steady_curve",
    "efficiency": "steady_curve",
    "breakaway": "breakaway",
    "leakage": "leakage",
}
_MOST_REMARKS = 5  # on runs; the report has all


def conformity_part(certificate: Certificate) -> Part:
    """Return the decision on the specimen, its product and limits, the table and the rule."""
    word, acceptance = certificate.word, certificate.acceptance
    if acceptance is None:
        return Part("conformity", word("conformity"), paragraphs=(word("no_limits"),))
    keys = ("quantity", "limit", "series", "measured", "conforms", "decision")
    measured = [check.measurement for check in acceptance.checks if check.measurement is not None]
    stated = [value.measurement for value in certificate.values if value.has_table]
    pressures, loads = ({each.p_lr_ref_pa for each in stated}, {each.f_load_n for each in stated})
    decided = {each.p_lr_ref_pa for each in measured} - {None}
    back = differs_in_rod_pressure(measured) or not decided <= pressures
    of_series = {each.f_load_n for each in measured if each.direction}
    load = len(of_series) > 1 or not of_series <= loads
    rows = tuple(_decision_row(certificate, check, load, back) for check in acceptance.checks)
    rows = tuple(_without_repetitions(rows))
    bold = {i for i, c in enumerate(acceptance.checks) if c.decision in ("MARGINAL", "FAIL")}
    head = tuple(map(word, keys))
    table = without_empty(GridTable(head, rows, frozenset({3, 4}), frozenset(bold)))
    share = localized(certificate, short(100 * (acceptance.largest_uncertainty or 0.0)))
    rule = word(f"rule_{acceptance.rule}", share=share)
    paragraphs = (word("decision_rule", rule=rule), " ".join(_remarks(certificate, acceptance)))
    product = acceptance.product and word(
        "of_product", product=certificate.named(acceptance.product)
    )
    limits = word("of_limits", limits=_file(acceptance))
    lead = " ".join(filter(None, (product, limits, _reservation(certificate))))
    return Part(
        *("conformity", word("conformity")),
        tables=(table,),
        paragraphs=paragraphs,
        verdict=word(acceptance.decision),
        reserve=_not_calibrated(certificate),
        lead=lead,
    )


def _remarks(certificate: Certificate, acceptance: Acceptance) -> Iterator[str]:
    """Yield what the statement applies to and rests on."""
    word, measured = certificate.word, [c for c in acceptance.checks if c.measurement is not None]
    yield word("applies")
    if any(check.at_worst_speed for check in measured):
        yield word("worst_speed")
    names = {c.requirement.name for c in measured}
    names |= {c.measurement.label for c in measured if c.measurement}
    if names - {"", *certificate.file.names}:
        yield word("names")


def _reservation(certificate: Certificate) -> str:
    """Return that the data are to be used with care, and why; empty if they are good."""
    quality, word = certificate.results.quality, certificate.word
    if quality.grade != "with care":
        return ""
    care = [check.name for check in quality.checks if check.grade != "good"]
    return word("care", checks=", ".join(word(f"check_{name}") for name in care))


def _not_calibrated(certificate: Certificate) -> str:
    """Return which instruments have no calibration certificate; empty if each has one."""
    without = [
        certificate.word(f"the_{key}")
        for key, _, calibration in certificate.calibrations()
        if not calibration.certificate
    ]
    if not without:
        return ""
    return certificate.word("not_calibrated", instruments=listed(without, certificate.word("and")))


def _file(acceptance: Acceptance) -> str:
    return f"{printable(acceptance.limits)} (SHA-256 {acceptance.limits_sha256[:12]}…)"


def _decision_row(
    certificate: Certificate, check: ConformityCheck, with_load: bool, with_back_pressure: bool
) -> tuple[str, ...]:
    word, measured, unit = certificate.word, check.measurement, check.requirement.unit
    where = series_words(
        certificate,
        measured or check.requirement,
        load=with_load or measured is None,
        back_pressure=with_back_pressure or measured is None,
    )
    text, percent = NONE, NONE
    if measured is not None:
        half = None if measured.u95 is None else from_si(measured.u95, unit)
        text = f"{with_interval(from_si(measured.value, unit), half)} {unit}"
    if check.probability is not None:
        shown = 100 * check.probability
        size = "> 99.9" if shown > 99.9 else "< 0.1" if shown < 0.1 else significant(shown, 3)
        percent = f"{size} %"
    return (
        quantity_words(certificate, check),
        on_a_line(limit_words(certificate, check.requirement), 20),
        on_a_line(where, 20) or NONE,
        localized(certificate, text),
        localized(certificate, percent),
        unbroken(word(check.decision)),
    )


def _without_repetitions(rows: Iterable[tuple[str, ...]]) -> Iterator[tuple[str, ...]]:
    """Leave out the quantity and the limit of each row that has those of the row above."""
    above: tuple[str, ...] = ()
    for row in rows:
        yield ("", "", *row[2:]) if row[:2] == above else row
        above = row[:2]


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
    text, name = " ".join(parts), certificate.named(requirement.name)
    return f"{name}: {text}" if name and name.lower() != parts[0].lower() else text


def limit_words(certificate: Certificate, requirement: Requirement) -> str:
    """Write the limits with their unit."""
    low, high = (
        "" if limit is None else localized(certificate, short(from_si(limit, requirement.unit)))
        for limit in (requirement.low, requirement.high)
    )
    key = "between" if low and high else "at_least" if low else "at_most"
    return certificate.word(key, low=low, high=high, unit=requirement.unit)


def not_tested_part(certificate: Certificate) -> Part:
    """Return what was not measured, and how the campaign deviates from its plan."""
    word, results = certificate.word, certificate.results
    complete, paragraphs = results.quality.completeness, list[str]()
    if certificate.acceptance is not None:
        paragraphs += _tested(certificate, certificate.acceptance.checks)
    stated: set[str] = {value.quantity for value in certificate.values}
    if certificate.acceptance is not None:
        stated |= {check.requirement.quantity for check in certificate.acceptance.checks}
    if certificate.has_no_load:
        stated.add("efficiency")  # measured; a remark states why it has no value
    paragraphs += _not_measured(certificate, stated)
    rejected = sum(not run.accepted for run in results.runs)
    deviations = []
    if complete.short_points:
        points = len(complete.short_points)
        deviations.append(word("short", points=points, of=complete.points))
    if rejected:
        deviations.append(word("rejected", runs=rejected))
    imported = results.provenance.source == "imported"
    none = word("no_schedule" if imported else "no_deviations")
    paragraphs.append(" ".join(deviations or [none]))
    if remarks := [
        f"{run.run.plan.run}: {printable('; '.join(run.notes))}"
        for run in results.runs
        if run.accepted and run.notes
    ]:
        more = [f"… ({len(remarks)})"] if len(remarks) > _MOST_REMARKS else []
        shown = "; ".join((*remarks[:_MOST_REMARKS], *more))
        paragraphs[-1] += f" {word('run_remarks', remarks=shown)}"
    if certificate.acceptance is None and (reservation := _reservation(certificate)):
        paragraphs.append(reservation)
    if certificate.warnings:
        paragraphs.append(word("record_notes", notes="; ".join(certificate.warnings)))
    return Part("not_tested", word("not_tested"), paragraphs=tuple(paragraphs))


def _tested(certificate: Certificate, checks: Sequence[ConformityCheck]) -> Iterator[str]:
    """Yield how many limits were tested, those that were not, and those without a decision."""
    word = certificate.word
    count = len(dict.fromkeys(check.requirement for check in checks))
    missing = [check for check in checks if check.decision == "NOT TESTED"]
    untested = [check for check in missing if check.measurement is None]
    whys = {
        f"{_limited_words(certificate, check)} ({_causes(certificate, check)})": None
        for check in untested
    }
    tested = count - len(dict.fromkeys(check.requirement for check in untested))
    why = [word("untested", quantities="; ".join(whys))] if whys else []
    decisions = len(checks) - len(missing)
    yield " ".join((word("tested", tested=tested, count=count, decisions=decisions), *why))
    undecided: dict[UntestedCause, dict[str, None]] = {}
    for check in missing:
        if check.measurement is not None:
            for cause in check.causes:
                name = certificate.named(check.requirement.name)
                words = name or quantity_words(certificate, check)
                undecided.setdefault(cause, {})[words] = None
    for cause, quantities in undecided.items():
        yield word(cause, quantities="; ".join(quantities))


def _limited_words(certificate: Certificate, check: ConformityCheck) -> str:
    """Write a quantity without a measured value, with the series that its limit states."""
    series = series_words(certificate, check.requirement, load=True, back_pressure=True)
    return ", ".join(filter(None, (quantity_words(certificate, check), series)))


def _causes(certificate: Certificate, check: ConformityCheck) -> str:
    """Write why a limited quantity was not measured."""
    leak, motions = check.requirement.leak, certificate.results.motions
    highest = [leakage.highest_pa(leak) for leakage in motions.leakages if leak is not None]
    bar = localized(certificate, short(from_si(max(highest, default=0.0), "bar")))
    causes = (certificate.word(f"cause_{cause}", pressure=bar) for cause in check.causes)
    return ", ".join(causes)


def _not_measured(certificate: Certificate, stated: Collection[str]) -> Iterator[str]:
    """Yield the quantities that are not among the stated ones, by whether runs were made."""
    made = {KINDS[each.run.plan.kind].analysis for each in certificate.results.runs}
    others = [key for key in CERTIFIED_QUANTITIES if key not in stated]
    without = [key for key in others if _ANALYSES[key] not in made]
    for key, quantities in (
        ("no_runs", without),
        ("not_determined", [each for each in others if each not in without]),
    ):
        if quantities:
            words = (certificate.word(f"q_{quantity}") for quantity in quantities)
            yield certificate.word(key, quantities="; ".join(words))
