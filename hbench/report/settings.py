"""What was measured by what: instruments, settings, software, and notes of the analysis."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from hbench.records import Results
from hbench.report.document import Section
from hbench.report.text import number


def settings_section(results: Results, long_list: int) -> Section:
    """Return the section; more notes than ``long_list`` start folded."""
    notes: tuple[Section, ...] = ()
    if results.notes:
        words = f"Notes of the analysis ({len(results.notes)})"
        notes = (Section(words, items=results.notes, folded=len(results.notes) > long_list),)
    return Section(
        "Instruments and settings", facts=tuple(_facts(results)), parts=notes, anchor="settings"
    )


def _facts(results: Results) -> Iterator[tuple[str, str]]:
    made = results.provenance
    told = {
        "Source": made.source,
        "Bench": made.bench,
        "Firmware": made.firmware,
        "Started": made.started,
        "Stopped": made.stopped,
    }
    yield from ((name, value or "not recorded") for name, value in told.items())
    for specimen in dict.fromkeys(run.run.plan.specimen for run in results.runs if run.accepted):
        areas = (1e6 * specimen.area_piston_m2, 1e6 * specimen.area_rod_m2)
        words = f"A_p {number(areas[0])} mm², A_r {number(areas[1])} mm²"
        if specimen.stroke_m is not None:
            words += f", stroke {number(1e3 * specimen.stroke_m, 0)} mm"
        yield "Cylinder", words
    for name, section in made.settings.items():
        yield name.capitalize(), _words(section)
    yield from ((name, _words(value)) for name, value in made.details.items())
    if made.software:
        yield "Software", ", ".join(f"{name} {value}" for name, value in made.software.items())


def _words(value: Any, inside: bool = False) -> str:
    """Write a section of a bench file in a line, as it stands there."""
    if isinstance(value, Mapping):
        parts = [f"{name} {_words(one, inside=True)}" for name, one in value.items()]
        return f"({', '.join(parts)})" if inside else "; ".join(parts)
    return value if isinstance(value, str) else json.dumps(value, default=str, ensure_ascii=False)
