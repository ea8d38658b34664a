"""Suggestion of an import map from some files of a folder."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from hbench.channels import CHANNELS
from hbench.config.files.yaml_text import parse_yaml
from hbench.config.import_layout import LIMITS
from hbench.config.import_map import UNFILLED, ImportMap, parse_import_map
from hbench.errors import DataError, HbenchError
from hbench.motion.plateaus import plateaus
from hbench.sentences import counted
from hbench.store.importing.file_matches import FileMatch, match_files
from hbench.store.importing.file_notes import first_names
from hbench.store.importing.importer import check_source
from hbench.store.importing.mapped_files import cut_file, read_mapped_file
from hbench.store.suggesting.channels import choose_channels
from hbench.store.suggesting.choice import GUESS, Choice
from hbench.store.suggesting.duplicates import duplicates
from hbench.store.suggesting.factors import column_factors
from hbench.store.suggesting.file_names import (
    NamePattern,
    joined_holds,
    name_patterns,
    with_speeds,
)
from hbench.store.suggesting.force_balance import force_balance, with_signs
from hbench.store.suggesting.map_yaml.map_text import map_text
from hbench.store.suggesting.map_yaml.suggested_map import (
    SuggestedMap,
    SuggestedSeries,
    usual_motion,
)
from hbench.store.suggesting.motion import motion_of
from hbench.store.suggesting.name_fields import numbers_of
from hbench.store.suggesting.quantities import meaning
from hbench.store.suggesting.samples import SampleColumn, SampleFile, read_sample, sample_columns
from hbench.store.suggesting.time_base import TimeChoice, choose_time, with_own_times
from hbench.units import parse_unit

_MOST_FILES = 12  # read for a suggestion
_MOST_BYTES = 60_000_000  # of these files; the first is always read
_LONGEST_FAULT = 120  # characters
_JOIN = "a run must be a file of its own: hbench/store/README.md, Runs that are not a file each"
_NO_LOGS = (".yaml", ".yml", ".md", ".pdf", ".png", ".jpg", ".svg", ".html", ".zip", ".py", ".m")


@dataclass(frozen=True)
class Suggestion:
    """A map as YAML text, and notes for the user."""

    text: str
    notes: tuple[str, ...]


def suggest_map(folder: Path) -> Suggestion:
    """Suggest a map for the files below ``folder``.

    The map is complete but for sizes of a hydraulic cylinder, which are ``???``; what else could
    not be determined is a comment. Raises ``ConfigError``, and ``DataError`` if no file contains a
    table of numbers.
    """
    check_source(folder)
    names = sorted(
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file() and not path.name.startswith((".", "~"))
    )
    patterns = name_patterns([n for n in names if not n.lower().endswith(_NO_LOGS)])
    samples, faults = _samples(folder, patterns)
    if not samples:
        first = next(iter(faults.items()), None)
        raise DataError(
            f"{folder}: no file contains a table of numbers; it contains {first_names(names)}",
            f"{first[0]}: {first[1]}" if first else "Give the folder that contains the logs.",
        )
    by_signature: dict[tuple, list[NamePattern]] = defaultdict(list)
    for pattern, sample in samples.items():
        by_signature[sample.signature].append(pattern)
    alike = max(by_signature.values(), key=lambda group: sum(len(p.names) for p in group))
    files = {
        name: file
        for p in alike
        for name, file in _more_of(folder, p, samples[p], len(alike), faults)
    }
    suggested = _suggested_map(folder, list(files.values()), alike, len(names))
    if suggested.motion is None:
        joined = joined_holds(alike, names)
    else:
        joined = with_speeds(alike, names, suggested.speeds_m_s)
    if [(p.files, p.units) for p in joined] != [(p.files, p.units) for p in alike]:
        patterns = [*(pattern for pattern in patterns if pattern not in alike), *joined]
        suggested = _suggested_map(folder, list(files.values()), joined, len(names))
    suggested = _verified(folder, suggested, patterns, faults)
    notes = (*_notes(suggested, faults), *_joined_or_split(samples, alike))
    return Suggestion(map_text(suggested), notes)


def _joined_or_split(
    samples: Mapping[NamePattern, SampleFile], alike: Sequence[NamePattern]
) -> Iterator[str]:
    """Yield notes on runs that are not a file each: in several files, or in several sheets."""
    of_runs = {frozenset(map(numbers_of, p.names)) for p in alike if len(p.names) > 1}
    parts = [p for p in samples if p in alike or frozenset(map(numbers_of, p.names)) in of_runs]
    if of_runs and len({samples[p].signature for p in parts}) > 1:
        yield (
            "the channels of a run seem to be in several files: "
            f"{', '.join(p.files for p in parts)}; {_JOIN}"
        )
    for sample in samples.values():
        if others := sample.other_sheets:
            yield (
                f"{sample.name}: one sheet was read; {counted(len(others), 'other')}: "
                f"{first_names(others)}; format.sheet in the map chooses one; {_JOIN}"
            )


def _samples(
    folder: Path, patterns: Sequence[NamePattern]
) -> tuple[dict[NamePattern, SampleFile], dict[str, str]]:
    """Read the first file of each pattern; files that can't be read are faults."""
    samples: dict[NamePattern, SampleFile] = {}
    faults: dict[str, str] = {}
    size = 0
    for pattern in sorted(patterns, key=lambda p: -len(p.names)):
        name = pattern.names[0]
        size += (folder / name).stat().st_size
        if len(samples) == _MOST_FILES or (samples and size > _MOST_BYTES):
            break
        try:
            sample = read_sample(folder, name)
        except HbenchError as error:
            faults[name] = _fault_of(error, folder / name)
            continue
        if sample is None:
            faults[name] = "contains no table of numbers"
        else:
            samples[pattern] = sample
    return samples, faults


def _more_of(
    folder: Path,
    pattern: NamePattern,
    first: SampleFile,
    patterns: int,
    faults: dict[str, str],
) -> Iterator[tuple[str, SampleFile]]:
    """Yield some files of a pattern, spread over all of them.

    The first of those that cannot be read as the ``first`` file is added to ``faults``.
    """
    share = max(1, _MOST_FILES // patterns)
    unlike: dict[str, str] = {}
    spread = np.linspace(0, len(pattern.names) - 1, min(share, len(pattern.names)))
    size = 0
    for name in dict.fromkeys([pattern.names[int(i)] for i in np.rint(spread)]):
        size += (folder / name).stat().st_size
        if name == first.name:
            yield name, first
        elif size < _MOST_BYTES / patterns:
            try:
                sample = read_sample(folder, name, first.dialect)
            except HbenchError as error:
                unlike[name] = _fault_of(error, folder / name)
                continue
            if sample is not None and sample.signature == first.signature:
                yield name, sample
            else:
                unread = {} if sample is None else sample.unread
                new = (fault for key, fault in unread.items() if key not in first.unread)
                unlike[name] = next(new, f"its columns are not those of {first.name}")
    faults |= dict(islice(unlike.items(), 1))


def _fault_of(error: HbenchError, path: Path) -> str:
    message = error.message.removeprefix(f"{path}: ")
    return f"{message}. {error.hint}" if error.hint else message


def _suggested_map(
    folder: Path, files: list[SampleFile], alike: Sequence[NamePattern], count: int
) -> SuggestedMap:
    columns = sample_columns(files)
    time = choose_time(files, columns)
    pattern_of = {name: pattern for pattern in alike for name in pattern.names}
    fields = [pattern_of[file.name].values(file.name) for file in files]
    choices = with_own_times(choose_channels(columns, time, fields), time, columns)
    channels = [_channels(i, file, time, choices) for i, file in enumerate(files)]
    steady = [plateaus(c["t_s"], c["x_m"]) if c else [] for c in channels]
    choices = with_signs(choices, channels, steady)
    factors = column_factors(columns, files[0].units)
    series = []
    for pattern in alike:
        own = [i for i, file in enumerate(files) if file.name in pattern.names]
        moved = [channels[i] for i in own], [steady[i] for i in own]
        values = {
            f: tuple(dict.fromkeys(f.values[i] for i in own))
            for f in factors
            if f.name not in pattern.factors
        }
        bore_m, motion = force_balance(*moved).bore_m, motion_of(*moved)
        series.append(SuggestedSeries(pattern, bore_m, factors=values, motion=motion))
    return SuggestedMap(
        folder=folder.resolve().name,
        files=tuple(file.name for file in files),
        speeds_m_s={
            file.name: tuple(abs(plateau.v_m_s) for plateau in found)
            for file, found in zip(files, steady, strict=True)
        },
        count=count,
        format_name=files[0].format_name,
        layout=None if files[0].dialect is None else files[0].dialect.layout,
        time=time,
        choices=choices,
        units_in_file=files[0].units,
        columns=columns,
        motion=usual_motion(motion_of(channels, steady), series),
        series=tuple(series),
        unread=_unread(files, columns),
        left_out=duplicates(columns, choices),
    )


def _unread(files: Sequence[SampleFile], columns: Sequence[SampleColumn]) -> dict[str, str]:
    """Return the columns that can't be read in a file: the name, and the file with the fault."""
    read = {column.name for column in columns}
    faults: dict[str, str] = {}
    for file in files:
        for name, fault in file.unread.items():
            if name not in read:
                faults.setdefault(name, f"{file.name}: {fault}")
    return faults


def _channels(
    i: int, file: SampleFile, time: TimeChoice, choices: Mapping[str, Choice]
) -> dict[str, np.ndarray]:
    """Return the channels in SI of ``file``, the number ``i``, that have the time's samples.

    They have no gaps.
    """
    t_s = time.t_s[i]
    values = {
        channel: parse_unit(choice.unit).to_si(choice.column.values[i] * choice.scale)
        for channel, choice in choices.items()
        if time.is_that_of(choice.column, i, file) and choice.scale is not None
    }
    values = {
        channel: y
        for channel, y in values.items()
        if not (np.abs(y) > LIMITS[CHANNELS[channel].unit]).any()  # else it is refused
    }
    if "x_m" not in values:
        return {}
    known = np.isfinite(t_s) & np.isfinite(values["x_m"])
    t = t_s[known]
    later = np.concatenate(([True], np.diff(t) > 0)) if len(t) else np.zeros(0, dtype=bool)
    return {"t_s": t[later], **{key: y[known][later] for key, y in values.items()}}


def _verified(
    folder: Path,
    suggested: SuggestedMap,
    patterns: Sequence[NamePattern],
    faults: Mapping[str, str],
) -> SuggestedMap:
    """Import one file of each pattern by the map, and mark the patterns for which this fails.

    Patterns of other columns are added if the map reads them too.
    """
    known = {series.pattern.files: series for series in suggested.series}
    others = [
        SuggestedSeries(p) for p in patterns if p.files not in known and p.names[0] not in faults
    ]
    rules = _rules(replace(suggested, series=(*suggested.series, *others)))
    if isinstance(rules, str):
        return suggested
    matches = {match.name: match for match in match_files(folder, rules).files}
    checked = []
    for series in (*suggested.series, *others):
        match = matches.get(series.pattern.names[0])
        fault = "" if match is None else _import_fault(folder, match, rules)
        checked.append(replace(series, fault=fault))
    checked.sort(key=lambda series: series.pattern.names[0])
    return replace(suggested, series=tuple(checked))


def _rules(suggested: SuggestedMap) -> ImportMap | str:
    """Return the map with assumed sizes, or why it is invalid."""
    text = map_text(suggested).replace(f"piston_diameter: {UNFILLED}", "piston_diameter: 40")
    text = text.replace(f"rod_diameter: {UNFILLED}", "rod_diameter: 0")
    text = text.replace(f"displacement: {UNFILLED}", "displacement: 10")
    try:
        return parse_import_map(parse_yaml(text), "the suggested map")
    except HbenchError as error:
        return error.message


def _import_fault(folder: Path, match: FileMatch, rules: ImportMap) -> str:
    try:
        cut_file(read_mapped_file(folder, match, rules), folder, rules)
    except HbenchError as error:
        message = error.message.removeprefix(f"{folder / match.name}: ")
        return message if len(message) < _LONGEST_FAULT else f"{message[:_LONGEST_FAULT]}..."
    return ""


def _notes(suggested: SuggestedMap, faults: Mapping[str, str]) -> Iterator[str]:
    yield f"read {counted(len(suggested.files), 'file')}: {first_names(suggested.files)}"
    for name, fault in faults.items():
        yield f"not read: {name}: {fault}"
    for name, fault in suggested.unread.items():
        means = meaning(name)
        is_stated = means.channel == "t_s" and suggested.time.stated
        if means.is_sure and not is_stated and means.channel not in ("", *suggested.choices):
            yield f"{means.channel}: column {name!r} can't be read: {fault}"
    for series in suggested.series:
        if series.fault:
            count = counted(len(series.pattern.names), "file")
            yield f"not in the map: {series.pattern.files} ({count}): {series.fault}"
    if isinstance(rules := _rules(suggested), str):
        yield f"the map is not complete: {rules}"
    for channel, names in suggested.left_out.items():
        used = suggested.choices[channel].column.name
        yield f"{channel} is {used}; left out: {', '.join(names)}"
    guesses = [c for c, choice in suggested.choices.items() if choice.certainty == GUESS]
    guesses += suggested.assumed_constants
    if guesses:
        yield f"guesses to check: {', '.join(guesses)}"
    needed = ("p_tp_pa", "p_tr_pa", "f_applied_n")
    missing = [c for c in needed if c not in (*suggested.choices, *suggested.assumed_constants)]
    if missing and not suggested.is_driven:
        yield (
            f"no column found for {', '.join(missing)}: name them under 'columns' or 'constants'; "
            "friction can't be computed without"
        )
    if not suggested.is_driven:
        yield f"fill in what is marked {UNFILLED}: the size of the cylinder is not in the files"
