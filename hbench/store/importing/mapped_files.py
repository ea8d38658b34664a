"""Reader of another bench's files by an import map: one run or more from each file."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from hbench.config.import_map import ImportMap
from hbench.errors import DataError
from hbench.motion.reversals import SAME_STROKE_SPEED
from hbench.motion.similar_values import SAME_SPEED, similar_values
from hbench.records import KINDS, RunPlan, Specimen
from hbench.sentences import counted
from hbench.store.importing.channels import FileChannels, read_channels_by_map
from hbench.store.importing.file_matches import FileMatch, match_files, refuse_empty
from hbench.store.importing.file_notes import ROTARY_NOTE, FileNote, first_names, merged
from hbench.store.importing.imported_run import (
    ImportedRun,
    ImportedRuns,
    SourceFile,
    StoredLog,
    StoreLog,
    open_source,
)
from hbench.store.importing.plausibility import (
    Levels,
    LoggedSpan,
    at_the_same_time,
    other_units,
)
from hbench.store.importing.sections import Section, Sections, cut
from hbench.store.importing.signs import contradicting_signs
from hbench.store.importing.stuck_sensors import (
    SensorActivity,
    activity_of,
    stuck_note,
    stuck_sensors,
)


@dataclass(frozen=True)
class MappedFile:
    """A file whose name matches a series, with its channels."""

    match: FileMatch
    file: SourceFile
    read: FileChannels


@dataclass(frozen=True)
class Piece:
    """A section of a file that becomes a run."""

    run: str
    match: FileMatch
    file: SourceFile
    section: Section
    lines: tuple[int, int]
    log: StoredLog
    start: datetime | None  # None if the file states no dates
    levels: Mapping[str, float]  # mean magnitudes [SI] of the columns

    @property
    def series(self) -> tuple:
        """Key of runs with the same nominal speeds: kind, label, load and direction."""
        match = self.match
        return match.series.kind, match.label, match.f_load_n, self.section.v_m_s > 0


def read_mapped(folder: Path, rules: ImportMap, store: StoreLog) -> ImportedRuns:
    """Read every file below ``folder`` whose name matches a series of the map; store its runs.

    A file that can't be used is left out with a note. Raises ``DataError`` naming the first such
    file and line if most files can't be used: then the map is wrong.
    """
    matches = match_files(folder, rules)
    refuse_empty(folder, matches)
    pieces: list[Piece] = []
    notes: list[FileNote] = []
    unusable: dict[str, DataError] = {}
    activity: dict[str, SensorActivity] = {}
    spans: dict[str, LoggedSpan] = {}
    for match in matches.files:
        try:
            mapped = read_mapped_file(folder, match, rules)
            found = cut_file(mapped, folder, rules)
        except DataError as error:
            unusable[match.name] = error
            if map_is_wrong(len(unusable), len(matches.files)):
                raise next(iter(unusable.values())) from None
            continue
        activity[match.name] = activity_of(mapped.read, rules.min_stroke)
        if (span := _span(mapped)) is not None:
            spans[mapped.file.sha256] = span  # a copy has the same times
        of_file, signs = pieces_of(mapped, found, store, len(pieces) + 1)
        pieces += of_file
        notes += [*mapped.read.notes, *found.notes, *signs]
    pieces, stuck = _without_stuck_sensors(pieces, stuck_sensors(activity), folder, rules, store)
    notes += [*stuck, *_left_out(folder, unusable)]
    on_all = [*_on_all(pieces, matches.unmatched, rules)]
    if clash := at_the_same_time(spans.values()):
        pieces = [replace(piece, start=None) for piece in pieces]
        on_all.append(clash)
    plans = plans_of(pieces, rules)
    notes += [*_same_trials(pieces, plans), *notes_on_units(pieces, plans)]
    return ImportedRuns(runs_of(pieces, plans), (*merged(notes), *on_all))


def _span(mapped: MappedFile) -> LoggedSpan | None:
    origin, t_s = mapped.read.origin, mapped.read.channels["t_s"]
    if origin is None or origin.year < 2000:  # not used: the time of a clock without a date
        return None
    start, stop = (origin + timedelta(seconds=float(t)) for t in t_s[[0, -1]])
    return LoggedSpan(mapped.match.name, start, stop)


def map_is_wrong(unusable: int, files: int) -> bool:
    """Return whether so many unusable files show a wrong map instead of damaged files."""
    return 2 * unusable > files


def _left_out(folder: Path, unusable: Mapping[str, DataError]) -> Iterator[FileNote]:
    for name, error in unusable.items():
        message = error.message.removeprefix(f"{folder / name}: ")
        yield FileNote(name, f"left out: {message}{f'. {error.hint}' if error.hint else ''}")


def _without_stuck_sensors(
    pieces: Sequence[Piece],
    stuck: Mapping[str, Mapping[str, float]],
    folder: Path,
    rules: ImportMap,
    store: StoreLog,
) -> tuple[list[Piece], list[FileNote]]:
    """Store the runs of files with a stuck sensor again, marked so that screening rejects them."""
    marked, notes = [], []
    read: dict[str, MappedFile] = {}
    for piece in pieces:
        name = piece.match.name
        if name in stuck:
            if name not in read:
                read = {name: with_stuck_sensor(read_mapped_file(folder, piece.match, rules))}
                notes += [stuck_note(name, *sensor) for sensor in stuck[name].items()]
            log = store(name, piece.run, channels_of(read[name], piece.section))
            piece = replace(piece, log=log)
        marked.append(piece)
    return marked, notes


def with_stuck_sensor(mapped: MappedFile) -> MappedFile:
    """Return a file whose samples are all marked as those of a saturated sensor."""
    marked = {"sensor_saturated": np.ones(len(mapped.read.channels["t_s"]))}
    channels = {**mapped.read.channels, **marked}
    return replace(mapped, read=replace(mapped.read, channels=channels))


def read_mapped_file(folder: Path, match: FileMatch, rules: ImportMap) -> MappedFile:
    """Read one file. Raises ``DataError`` naming the invalid line."""
    with open_source(folder, match.name, rules.format) as (table, file):
        cylinder = match.series.cylinder
        read = read_channels_by_map(table, match.name, match.fields, cylinder, rules)
        return MappedFile(match, file, read)


def cut_file(mapped: MappedFile, folder: Path, rules: ImportMap) -> Sections:
    """Return the sections of a file that become runs. Raises ``DataError`` if it has none."""
    match = mapped.match
    source = str(folder / match.name)
    rules = rules.of(match.series)
    return cut(mapped.read.channels, source, match.name, rules, match.speed_m_s)


def pieces_of(
    mapped: MappedFile, found: Sections, store: StoreLog, number: int
) -> tuple[list[Piece], list[FileNote]]:
    """Store the sections of a file as runs, numbered from ``number``; return them with notes."""
    match, read = mapped.match, mapped.read
    pieces: list[Piece] = []
    notes: list[FileNote] = []
    for run, section in enumerate(found.sections, start=number):
        channels = channels_of(mapped, section)
        lines = read.lines[section.samples]
        log = store(match.name, f"{run:04d}", channels)
        ends = int(lines[0]), int(lines[-1])
        after = timedelta(seconds=float(channels["t_s"][0]))
        start = None if read.origin is None else read.origin + after
        levels = {name: _level(channels[name]) for name in read.units}
        pieces.append(Piece(f"{run:04d}", match, mapped.file, section, ends, log, start, levels))
        notes += contradicting_signs(match, channels)
    return pieces, notes


def channels_of(mapped: MappedFile, section: Section) -> dict[str, np.ndarray]:
    """Return the channels (n,) of a section."""
    return {name: values[section.samples] for name, values in mapped.read.channels.items()}


def runs_of(pieces: Sequence[Piece], plans: Sequence[RunPlan]) -> tuple[ImportedRun, ...]:
    """Return a run for each piece with its plan."""
    return tuple(
        ImportedRun(plan, piece.log, piece.file, piece.lines, start=piece.start)
        for plan, piece in zip(plans, pieces, strict=True)
    )


def plans_of(pieces: Sequence[Piece], rules: ImportMap) -> list[RunPlan]:
    """Return the plan of each piece; nominal speed and trial depend on the other pieces."""
    nominal = _nominal_speeds(pieces, rules)
    plans = []
    for piece, v_ref, trial in zip(pieces, nominal, _trials(pieces, nominal), strict=True):
        match, cylinder = piece.match, piece.match.series.cylinder
        kind = rules.of(match.series).kind
        constant = KINDS[kind].has_constant_speed
        low, high = piece.section.positions or (None, None)
        plans.append(
            RunPlan(
                run=piece.run,
                kind=kind,
                trial=trial,
                v_ref_m_s=v_ref,
                specimen=Specimen(cylinder.area_piston_m2, cylinder.area_rod_m2, cylinder.stroke),
                f_load_n=match.f_load_n,
                label=match.label,
                factors=match.factors,
                speed_is_measured=constant and match.speed_m_s is None,
                x_low_m=low,
                x_high_m=high,
            )
        )
    return plans


def notes_on_units(pieces: Sequence[Piece], plans: Sequence[RunPlan]) -> Iterator[FileNote]:
    """Yield a note on each file with another unit than the files of the same operating point."""
    return other_units(
        Levels(piece.match.name, (*piece.series, plan.v_ref_m_s), piece.levels)
        for piece, plan in zip(pieces, plans, strict=True)
    )


def _level(values: np.ndarray) -> float:
    """Return the mean magnitude of the samples with a value; 0 without any."""
    known = np.abs(values[np.isfinite(values)])
    return float(known.mean()) if len(known) else 0.0


def _trials(pieces: Sequence[Piece], nominal: Sequence[float]) -> list[int]:
    """Return the trial of each piece: that of the file's name, unless another file has it too.

    A second file with it at the same point is a further trial: what differs is not known. Where the
    name has no trial, the runs of one nominal speed are trials, in their order.
    """
    keys = [(*piece.series, v_ref) for piece, v_ref in zip(pieces, nominal, strict=True)]
    last: dict[tuple, int] = defaultdict(int)
    for key, piece in zip(keys, pieces, strict=True):
        last[key] = max(last[key], piece.match.trial or 0)
    of_files: dict[tuple, dict[str, int]] = defaultdict(dict)
    trials = []
    for key, piece in zip(keys, pieces, strict=True):
        stated, known = piece.match.trial, of_files[key]
        if stated is None:
            last[key] += 1
            trials.append(last[key])
            continue
        if piece.match.name not in known:
            if stated in known.values():
                last[key] = stated = last[key] + 1
            known[piece.match.name] = stated
        trials.append(known[piece.match.name])
    return trials


def _same_trials(pieces: Sequence[Piece], plans: Sequence[RunPlan]) -> Iterator[FileNote]:
    """Yield a note on each file whose trial is that of another file at the same point."""
    runs = zip(pieces, plans, strict=True)
    names = (
        piece.match.name for piece, plan in runs if piece.match.trial not in (None, plan.trial)
    )
    for name in dict.fromkeys(names):
        yield FileNote(
            name,
            "another file has the same trial at the same operating point: counted as a further "
            "trial. If anything else differs between these files, name it: in 'files' a field such "
            "as {temperature} in place of a star, with its unit under factors",
        )


def _nominal_speeds(pieces: Sequence[Piece], rules: ImportMap) -> list[float]:
    """Return the signed nominal speed of each piece; of a non-steady run its top speed.

    It is that of the map or the name, or else the median, to three digits, of the measured speeds
    of the same series that differ by less than a tolerance from one to the next, unless they are
    distinct. Pushes and holds have no speed: all of a series and direction have the same median.
    """
    nominal = [0.0] * len(pieces)
    groups: dict[tuple, list[int]] = defaultdict(list)
    for i, piece in enumerate(pieces):
        speed = piece.match.speed_m_s
        if speed is not None and KINDS[rules.of(piece.match.series).kind].has_constant_speed:
            nominal[i] = float(np.copysign(speed, piece.section.v_m_s))
        else:
            groups[*piece.series, speed].append(i)
    for numbers in groups.values():
        speeds = np.array([pieces[i].section.v_m_s for i in numbers])
        for cluster in _same_speeds(np.abs(speeds), rules.of(pieces[numbers[0]].match.series)):
            for i in cluster:
                nominal[numbers[i]] = float(f"{np.median(speeds[cluster]):.3g}")
    return nominal


def _same_speeds(speeds_m_s: np.ndarray, rules: ImportMap) -> list[np.ndarray]:
    """Return the indices of each group of measured speeds (n,) with the same nominal speed."""
    kind = KINDS[rules.kind]
    if not (kind.has_constant_speed or kind.covers_speeds):
        return [np.arange(len(speeds_m_s))]
    tolerance = SAME_STROKE_SPEED if rules.cut == "reversals" else SAME_SPEED
    return similar_values(speeds_m_s, tolerance)


def _on_all(pieces: Sequence[Piece], unmatched: Sequence[str], rules: ImportMap) -> Iterator[str]:
    """Yield the notes on the whole folder."""
    of_cut: dict[str, list[Piece]] = defaultdict(list)
    for piece in pieces:
        of_cut[rules.of(piece.match.series).cut].append(piece)
    whole = len(of_cut.pop("none", ()))
    for name, own in of_cut.items():
        count = len({piece.match.name for piece in own})
        yield f"{counted(len(own), 'run')} cut at {name} from {counted(count, 'file')}"
    if of_cut and whole:
        yield f"files that are one run each: {whole}"
    if any(piece.match.trial is None for own in of_cut.values() for piece in own):
        yield (
            "runs of a file without {trial} in its name are counted as trials: their intervals "
            "do not include a repeated set-up"
        )
    if rules.rotary:
        yield ROTARY_NOTE
    if "{" not in rules.constants.get("f_applied_n", "{"):
        yield (
            "the applied force is a constant: if a load acts, it is part of the friction of each "
            "direction, but not of half the difference of both (the bands)"
        )
    unmatched = [name for name in unmatched if not name.endswith((".yaml", ".yml"))]  # a map
    if unmatched:
        yield f"files that match no series of the map: {len(unmatched)} ({first_names(unmatched)})"
