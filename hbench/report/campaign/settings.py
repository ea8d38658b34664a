"""Instruments, settings, software, and notes of the analysis."""

import json
from collections.abc import Iterator, Mapping
from datetime import datetime
from typing import Any

from hbench.records import Results, Specimen
from hbench.report.render.document import Section
from hbench.report.render.numbers import number


def settings_section(results: Results, long_list: int) -> Section:
    """Return the section; more notes than ``long_list`` start folded."""
    notes: tuple[Section, ...] = ()
    if results.notes:
        title = f"Notes of the analysis ({len(results.notes)})"
        notes = (Section(title, items=results.notes, folded=len(results.notes) > long_list),)
    return Section(
        "Instruments and settings", facts=tuple(_facts(results)), parts=notes, anchor="settings"
    )


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
        areas = (1e6 * specimen.area_piston_m2, 1e6 * specimen.area_rod_m2)
        dimensions = f"A_p {number(areas[0])} mm², A_r {number(areas[1])} mm²"
        if specimen.stroke_m is not None:
            dimensions += f", stroke {number(1e3 * specimen.stroke_m, 0)} mm"
        which = ", ".join(filter(None, labels)) if len(specimens) > 1 else ""
        yield f"Cylinder {which}".strip(), dimensions
    for name, section in provenance.settings.items():
        yield _name(name), _words(section)
    yield from ((_name(name), _words(value)) for name, value in provenance.details.items())
    if provenance.software:
        versions = (f"{name} {value}" for name, value in provenance.software.items())
        yield "Software", ", ".join(versions)


def _time(written: str) -> str:
    """Write ``2026-01-31T08:15:30.5+00:00`` as ``2026-01-31 08:15:30 UTC``."""
    try:
        at = datetime.fromisoformat(written)
    except ValueError:
        return written
    return f"{at:%Y-%m-%d %H:%M:%S} {at.tzname() or ''}".strip()


def _name(key: str) -> str:
    text = key.replace("_", " ")
    return f"{text[:1].upper()}{text[1:]}"


def _words(value: Any, inside: bool = False) -> str:
    """Write a section of a bench file in a line, with its values unchanged."""
    if isinstance(value, Mapping):
        entries = [
            f"{str(name).replace('_', ' ')} {_words(entry, inside=True)}"
            for name, entry in value.items()
        ]
        return f"({', '.join(entries)})" if inside else "; ".join(entries)
    return value if isinstance(value, str) else json.dumps(value, default=str, ensure_ascii=False)
