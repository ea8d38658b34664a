"""Identity of the test, instruments, settings, software, and notes of the analysis."""

import math
from collections.abc import Iterator, Mapping
from datetime import datetime
from typing import Any

from hbench.records import Provenance, Results, Specimen
from hbench.report.campaign.sections.rejected import LONG_LIST
from hbench.report.render.document import Section
from hbench.report.render.numbers import number
from hbench.report.setting_words import key_words, section_words
from hbench.report.zero_words import tolerance_words
from hbench.sentences import capital

_SIZES = ("bore", "rod", "stroke")
_TEST = ("customer", "operator", "mounting", "place", "ambient")


def identity_facts(results: Results, label: str = "") -> tuple[tuple[str, str], ...]:
    """Return what was measured, where, when and by whom, as far as the campaign states it.

    ``label`` is that of all runs. An imported campaign has the name that its map states for the
    bench.
    """
    specimens = {run.run.plan.specimen for run in results.runs if run.accepted}
    sizes = _dimensions(next(iter(specimens))) if len(specimens) == 1 else ""
    return provenance_facts(results.provenance, sizes, label)


def provenance_facts(
    provenance: Provenance, sizes: str = "", label: str = ""
) -> tuple[tuple[str, str], ...]:
    """Return ``identity_facts`` of a campaign; ``sizes`` are those if it states none itself."""
    specimen, test = (provenance.settings.get(name, {}) for name in ("specimen", "test"))
    stated = ", ".join(f"{name} {specimen[name]}" for name in _SIZES if specimen.get(name))
    name = "Simulated time" if provenance.source == "simulated" else "Measured"
    bench, when = provenance.bench, {name: _period(provenance)}
    if provenance.source == "imported":
        bench = f"{bench} (name in the map of the import)"
        measured = test.get("date", "") or "date not recorded (test.date in the map)"
        when = {"Measured": measured, "Imported": _time(provenance.started)}
    facts = {
        "Cylinder": specimen.get("serial", "") or "no serial number recorded",
        "Dimensions": stated or sizes,
        **{_name(name): specimen.get(name, "") for name in ("maker", "order", "seals", "wear")},
        "Label of the runs": label,
        "Test number": test.get("number", ""),
        **({} if "Imported" in when else {"Test date": test.get("date", "")}),
        **{_name(name): test.get(name, "") for name in _TEST},
        "Bench": bench,
        **when,
        "Instruments": _calibrations(provenance.settings.get("instruments", {})),
        "Analysis": f"hbench {provenance.software.get('hbench', '')}".strip(),
    }
    return tuple((name, str(text)) for name, text in facts.items() if text)


def settings_section(results: Results) -> Section:
    """Return the section; a long list of notes starts folded."""
    notes: tuple[Section, ...] = ()
    if results.notes:
        title = f"Notes of the analysis ({len(results.notes)})"
        notes = (
            Section(
                title,
                items=tuple(map(_sentence, results.notes)),
                folded=len(results.notes) > LONG_LIST,
            ),
        )
    return Section(
        "Instruments and settings",
        facts=tuple(_facts(results)),
        parts=notes,
        anchor="settings",
        folded=True,
    )


def _sentence(note: str) -> str:
    return f"{capital(note).rstrip('.')}."


def _facts(results: Results) -> Iterator[tuple[str, str]]:
    provenance = results.provenance
    about = {
        "Source": provenance.source,
        "Bench": provenance.bench,
        "Firmware": provenance.firmware,
    }
    if provenance.source == "imported":
        about["Imported"] = _time(provenance.started)
    else:
        about |= {"Started": _time(provenance.started), "Stopped": _time(provenance.stopped)}
    yield from ((name, value or "not recorded") for name, value in about.items())
    specimens: dict[Specimen, dict[str, None]] = {}
    for run in results.runs:
        if run.accepted:
            specimens.setdefault(run.run.plan.specimen, {})[run.run.plan.label] = None
    for specimen, labels in specimens.items():
        which = ", ".join(filter(None, labels)) if len(specimens) > 1 else ""
        yield f"Cylinder {which}".strip(), _dimensions(specimen)
    for name, section in provenance.settings.items():
        yield _name(name), section_words(section)
    yield from ((_name(name), section_words(value)) for name, value in provenance.details.items())
    if provenance.software:
        versions = (f"{name} {value}" for name, value in provenance.software.items())
        yield "Software", ", ".join(versions)


def _dimensions(specimen: Specimen) -> str:
    piston, rod = 1e6 * specimen.area_piston_m2, 1e6 * specimen.area_rod_m2
    stroke = (
        "" if specimen.stroke_m is None else f", stroke {number(1e3 * specimen.stroke_m, 0)} mm"
    )
    if 0 < rod < piston:  # a piston with one rod
        bore, rod_diameter = (2 * math.sqrt(area / math.pi) for area in (piston, piston - rod))
        return f"bore {bore:.4g} mm, rod {rod_diameter:.4g} mm{stroke}"
    return f"A_p {number(piston)} mm², A_r {number(rod)} mm²{stroke}"


def _calibrations(instruments: Mapping[str, Any]) -> str:
    """Return each instrument's calibration and tolerance, as far as the bench file has them."""
    named = []
    for name, instrument in instruments.items():
        known = instrument.get("calibration", {}) if isinstance(instrument, Mapping) else {}
        stated = (
            f"no. {known['serial']}" if known.get("serial") else "",
            f"certificate {known['certificate']}" if known.get("certificate") else "",
            f"due {known['due']}" if known.get("due") else "",
        )
        if any(stated):
            named.append(f"{name.replace('_', ' ')} ({', '.join(filter(None, stated))})")
    known = named or ["no calibration recorded"]
    return "; ".join(filter(None, (*known, tolerance_words(instruments))))


def not_calibrated_words(results: Results) -> str:
    """State that U rests on tolerances alone; empty where an instrument has a certificate."""
    instruments = results.provenance.settings.get("instruments") or {}
    stated = [each for each in instruments.values() if isinstance(each, Mapping)]
    certified = any((each.get("calibration") or {}).get("certificate") for each in stated)
    if certified or not tolerance_words(instruments):
        return ""
    return "U rests on stated tolerances; no calibration certificate is recorded."


def _period(provenance: Provenance) -> str:
    """Write begin and end, with the date once if they have the same; one of equal times."""
    first, last = _time(provenance.started), _time(provenance.stopped)
    if first == last:
        stopped_clock = provenance.source == "simulated" and first
        return f"{first} for every run" if stopped_clock else first
    same_day = first[:10] == last[:10] and first.endswith(" UTC") and last.endswith(" UTC")
    if same_day:
        first, last = first.removesuffix(" UTC"), last[11:]
    return " to ".join(filter(None, (first, last)))


def _time(written: str) -> str:
    """Write ``2026-01-31T08:15:30.5+00:00`` as ``2026-01-31 08:15:30 UTC``."""
    try:
        at = datetime.fromisoformat(written)
    except ValueError:
        return written
    return f"{at:%Y-%m-%d %H:%M:%S} {at.tzname() or ''}".strip()


def _name(key: str) -> str:
    text = key_words(key)
    return f"{text[:1].upper()}{text[1:]}"
