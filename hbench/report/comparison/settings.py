"""What differs between the benches and schedules of two campaigns, as a table."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from hbench.records import CampaignDifferences, Curve, Provenance
from hbench.report.render.numbers import NONE, number
from hbench.report.render.word_tables import Cell, Table
from hbench.report.setting_words import key_words, value_words

_HEAD = ("Section", "Setting", "A", "B")
_LONGEST = 80  # letters of a value
_STATED = "stated"
SERIAL = ("specimen", "serial")
_SEED, _PLANT = "seed", "plant"
_NO_SETTINGS = (_SEED, _PLANT, "folder")
_HASH = re.compile(r"[0-9a-f]{40,}")


def settings_that_differ(differences: CampaignDifferences) -> tuple[tuple[str, str, str, str], ...]:
    """Return each difference as section, setting, A's value and B's, in the order of A's files.

    Compared are the bench file and schedule as the campaigns state them, firmware, software, the
    origin of the data, and the areas of the cylinders. A setting of one campaign alone is a dash
    in the other; a section of one alone, as that of controllers beside imported logs, is one row.
    The cylinder's serial number, the seed of simulated noise, the folder of imported logs and the
    simulated plant, which stands for the cylinder, are no settings.
    """
    a, b = (
        dict(_settings(provenance, curves))
        for provenance, curves in (
            (differences.a, [curve.a for curve in differences.curves]),
            (differences.b, [curve.b for curve in differences.curves]),
        )
    )
    different = [key for key in dict.fromkeys((*a, *b)) if a.get(key) != b.get(key)]
    of_a, of_b = (Counter(section for section, _ in settings) for settings in (a, b))
    rows: dict[tuple[str, str], tuple[str, str]] = {}
    for section, setting in different:
        count = of_a[section] + of_b[section]
        if count > 1 and not (of_a[section] and of_b[section]):
            stated = _STATED if of_a[section] else NONE, _STATED if of_b[section] else NONE
            rows[section, f"all {count} settings"] = stated
        else:
            key = section, setting
            rows[key] = _short(a.get(key) or NONE), _short(b.get(key) or NONE)
    return tuple((*key, *values) for key, values in rows.items())


def settings_table(differences: CampaignDifferences) -> Table:
    """Return the settings that differ; no rows if all agree."""
    rows = [tuple(map(Cell, row)) for row in settings_that_differ(differences)]
    return Table(_HEAD, tuple(rows), frozenset(_HEAD))


def settings_words(differences: CampaignDifferences) -> str:
    """State in a sentence how many settings differ; empty where none does."""
    settings = settings_that_differ(differences)
    if not settings:
        return ""
    if len(settings) == 1:
        section, name, *_ = settings[0]
        return f"1 setting differs between A and B: {name} ({section})."
    return f"{len(settings)} settings differ between A and B; they are listed below."


def plants_words(differences: CampaignDifferences) -> str:
    """State that the plants of two virtual rigs differ; empty if they are equal, or none is."""
    both = differences.a, differences.b
    a, b = (str((each.details.get(_PLANT) or {}).get("sha256", "")) for each in both)
    if a == b or any(each.details.get("port") != "sim" for each in both):
        return ""
    if a and b:
        return (
            "Different plant files, for two cylinders. The campaigns record only their checksums."
        )
    own, other = ("B", "A") if b else ("A", "B")
    return f"{own} was simulated with a plant file, {other} with the bench file's plant."


def _settings(provenance: Provenance, curves: list[Curve]) -> Iterator[tuple[tuple[str, str], str]]:
    yield ("campaign", "schedule"), provenance.name
    yield ("campaign", "origin of the data"), provenance.source
    yield ("bench", "name"), provenance.bench
    yield ("bench", "firmware"), provenance.firmware
    for specimen in dict.fromkeys(curve.specimen for curve in curves):
        yield (
            ("cylinder", "area of the piston side"),
            f"{number(1e6 * specimen.area_piston_m2)} mm²",
        )
        yield ("cylinder", "area of the rod side"), f"{number(1e6 * specimen.area_rod_m2)} mm²"
    for section, content in provenance.settings.items():
        for path, value in _flat(content):
            if (section, path) != SERIAL:
                yield (key_words(section), path or "value"), value
    for name, value in provenance.details.items():
        for path, text in _flat(value) if name not in _NO_SETTINGS else ():
            yield ("run", ", ".join(filter(None, (key_words(name), path)))), text
    for name, version in provenance.software.items():
        yield ("software", name), version


def _flat(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield the entries of a section of a file, each with its keys in words."""
    if isinstance(value, Mapping):
        for name, entry in value.items():
            yield from _flat(entry, f"{path} {key_words(name)}".strip())
    else:
        yield path, value_words(value)


def _short(text: str) -> str:
    if _HASH.fullmatch(text):
        return text[:12]
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
