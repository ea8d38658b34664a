"""Import of another bench's logs: the suggestion of a map, a preview, and the import itself."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np

from hbench.analysis.screening.screen import screen
from hbench.analysis.screening.steadiness import speeds_over_tenths
from hbench.analysis.screening.steady_window import at_reference
from hbench.channels import CHANNELS
from hbench.config.files.loading import read_yaml
from hbench.config.import_map import ImportMap, parse_import_map
from hbench.errors import HbenchError
from hbench.experiment.campaign_header import software
from hbench.motion.rest import BLOCK_S
from hbench.records import (
    KINDS,
    ImportPreview,
    PreviewedChannel,
    PreviewedFile,
    PreviewedLog,
    PreviewedRun,
    Run,
    RunPlan,
)
from hbench.store.campaign.plan_fields import check_plan
from hbench.store.campaign.run_csv import format_run, run_of
from hbench.store.files.atomic import write_files
from hbench.store.files.bounded_read import LARGEST_LOG
from hbench.store.importing.file_matches import FileMatch, match_files
from hbench.store.importing.file_notes import FileNote, merged
from hbench.store.importing.imported_run import StoredLog
from hbench.store.importing.importer import (
    ImportSummary,
    check_log_size,
    check_source,
    import_folder,
)
from hbench.store.importing.mapped_files import (
    MappedFile,
    Piece,
    channels_of,
    cut_file,
    map_is_wrong,
    notes_on_units,
    pieces_of,
    plans_of,
    read_mapped_file,
    with_stuck_sensor,
)
from hbench.store.importing.stuck_sensors import (
    SensorActivity,
    activity_of,
    stuck_note,
    stuck_sensors,
)
from hbench.store.suggesting.suggest import Suggestion, suggest_map

_MOST_DRAWN = 12  # files
_MOST_KEPT = 500_000_000  # bytes of samples in memory; other files are read twice
_LONGEST_NUMBER = 26  # characters in a CSV


def import_runs(
    source: Path, folder: Path, map_file: Path | None, clock: Callable[[], datetime]
) -> ImportSummary:
    """Import another bench's logs as a campaign. Raises ``ConfigError``, ``DataError``."""
    return import_folder(source, folder, map_file, software(), clock())


def suggest_import_map(source: Path) -> Suggestion:
    """Suggest a map for the logs in ``source``. Raises ``ConfigError``, ``DataError``."""
    return suggest_map(source)


def preview_import(source: Path, map_file: Path) -> ImportPreview:
    """Read, cut and screen the files in ``source`` as an import by ``map_file`` would.

    A file that can't be imported is part of the result, with the reason. Raises ``ConfigError``
    for an invalid map.
    """
    check_source(source)
    rules = parse_import_map(read_yaml(map_file), str(map_file))
    matches = match_files(source, rules)
    read = _Files(source, rules)
    cut: list[tuple[PreviewedFile, list[Piece]]] = []
    for match in matches.files:
        cut.append(_cut(read, match, sum(len(pieces) for _, pieces in cut) + 1))
    stuck = read.stuck_sensors()
    cut = [(_with_stuck(file, stuck.get(file.name, {})), found) for file, found in cut]
    pieces = [piece for _, found in cut for piece in found]
    planned = plans_of(pieces, rules) if pieces else []
    plans = {plan.run: plan for plan in planned}
    cut = _with_notes(cut, notes_on_units(pieces, planned))
    samples = _SamplesToDraw(len({match.series.files for match in matches.files}))
    for match, (file, found) in zip(matches.files, cut, strict=True):
        samples.add(_screened(read, match, file, [(plans[piece.run], piece) for piece in found]))
    return ImportPreview(
        name=rules.name,
        folder=str(source),
        map_file=map_file.name,
        cuts=tuple(dict.fromkeys(rules.of(series).cut for series in rules.series)),
        files=tuple(samples.files),
        refused=bool(matches.empty)
        or map_is_wrong(sum(bool(file.error) for file in samples.files), len(samples.files)),
        unmatched=matches.unmatched,
        empty_series={series.label: series.files for series in matches.empty},
    )


def write_import_preview(folder: Path, preview: ImportPreview) -> Path:
    """Write the page of a preview with its figures, and return its path."""
    from hbench.report.import_preview.figures import draw_preview  # slow import: matplotlib
    from hbench.report.import_preview.page import preview_page
    from hbench.report.render.figures import figure_files

    drawings = draw_preview(preview)
    page = preview_page(preview, drawings).encode()
    write_files(folder, figure_files(drawings.values()) | {"preview.html": page})
    return folder / "preview.html"


class _Files:
    """Files read by a map; as many as fit into some memory are read only once."""

    def __init__(self, folder: Path, rules: ImportMap):
        self.folder, self.rules = folder, rules
        self._kept: dict[str, MappedFile] = {}
        self._size = 0
        self._activity: dict[str, SensorActivity] = {}
        self._stuck: dict[str, dict[str, float]] = {}

    def read(self, match: FileMatch) -> MappedFile:
        """Read a file. Its samples are marked if a sensor was stuck. Raises ``DataError``."""
        mapped = self._kept.get(match.name) or self._read(match)
        return with_stuck_sensor(mapped) if match.name in self._stuck else mapped

    def stuck_sensors(self) -> dict[str, dict[str, float]]:
        """Return the stuck sensors of each file, now that all files were read and cut."""
        self._stuck = stuck_sensors(self._activity)
        return self._stuck

    def was_cut(self, mapped: MappedFile) -> None:
        """Take a file that could be read and cut into account for the stuck sensors."""
        self._activity[mapped.match.name] = activity_of(mapped.read, self.rules.min_stroke)

    def _read(self, match: FileMatch) -> MappedFile:
        mapped = read_mapped_file(self.folder, match, self.rules)
        size = sum(values.nbytes for values in mapped.read.channels.values())
        if self._size + size <= _MOST_KEPT:
            self._size += size
            self._kept[match.name] = mapped
        return mapped


def _cut(files: _Files, match: FileMatch, number: int) -> tuple[PreviewedFile, list[Piece]]:
    """Read and cut a file, whose runs are numbered from ``number``. An error is part of it."""
    folder, rules = files.folder, files.rules
    file = PreviewedFile(match.name, match.series.label, match.series.files, dict(_fields(match)))
    try:
        mapped = files.read(match)
        file = _described(file, mapped, rules)
        found = cut_file(mapped, folder, rules)
        files.was_cut(mapped)
        pieces, signs = pieces_of(mapped, found, _check_size, number)
    except HbenchError as error:
        return replace(file, error=_without_path(error, folder, match)), []
    notes = (*file.notes, *_texts(match.name, [*found.notes, *signs]))
    return replace(file, notes=notes), pieces


def _with_stuck(file: PreviewedFile, sensors: Mapping[str, float]) -> PreviewedFile:
    notes = (stuck_note(file.name, *sensor) for sensor in sensors.items())
    return replace(file, notes=(*file.notes, *_texts(file.name, notes)))


def _with_notes(
    cut: list[tuple[PreviewedFile, list[Piece]]], notes: Iterable[FileNote]
) -> list[tuple[PreviewedFile, list[Piece]]]:
    """Return the files with further notes, each with its own."""
    of_files: dict[str, list[FileNote]] = defaultdict(list)
    for note in notes:
        of_files[note.file].append(note)
    return [
        (replace(file, notes=(*file.notes, *_texts(file.name, of_files[file.name]))), found)
        for file, found in cut
    ]


def _check_size(name: str, run: str, channels: Mapping[str, np.ndarray]) -> StoredLog:
    """Check that a run can be stored. Raises ``DataError``."""
    values = sum(map(len, channels.values()))
    if _LONGEST_NUMBER * values > LARGEST_LOG:  # otherwise it is small enough in any case
        check_log_size(sum(map(len, format_run(channels))), name, run, channels)
    return StoredLog(len(channels["t_s"]), "")


def _without_path(error: HbenchError, folder: Path, match: FileMatch) -> str:
    return error.message.removeprefix(f"{folder / match.name}: ")


def _fields(match: FileMatch) -> Iterator[tuple[str, str]]:
    for field, value in match.fields.items():
        unit = match.series.factors.get(field, getattr(match.series, f"{field}_unit", ""))
        yield field, f"{value} {unit}".strip()


def _texts(name: str, notes: Iterable[FileNote]) -> tuple[str, ...]:
    """Return the notes on the file ``name`` without its name."""
    return tuple(note.removeprefix(f"{name}: ") for note in merged(notes))


def _described(file: PreviewedFile, mapped: MappedFile, rules: ImportMap) -> PreviewedFile:
    read = mapped.read
    t_s = read.channels["t_s"]
    steps = np.diff(t_s)
    names = [name for name in CHANNELS if name in read.channels]
    return replace(
        file,
        samples=len(t_s),
        rate_hz=float(1 / np.median(steps)) if len(steps) else np.nan,
        duration_s=float(t_s[-1] - t_s[0]),
        longest_step_s=float(steps.max()) if len(steps) else np.nan,
        channels=tuple(_channel(name, mapped, rules) for name in names),
        notes=_texts(mapped.match.name, read.notes),
    )


def _log(mapped: MappedFile, rules: ImportMap) -> PreviewedLog:
    read = mapped.read
    blocks = speeds_over_tenths(read.channels["t_s"], read.channels["x_m"])
    return PreviewedLog(
        channels=read.channels,
        units={name: rules.unit(name) for name in read.channels if name in CHANNELS},
        block_t_s=blocks.t_s,
        block_v_m_s=blocks.v_m_s,
        rest_s=read.rest if read.rest and np.ptp(read.rest) >= BLOCK_S else None,
    )


def _channel(name: str, mapped: MappedFile, rules: ImportMap) -> PreviewedChannel:
    read, column = mapped.read, rules.columns.get(name)
    values = read.channels[name]
    known = values[np.isfinite(values)]
    zero = read.zeros.get(name)
    return PreviewedChannel(
        name=name,
        column="" if column is None else str(column.column),
        unit_in_file=read.units.get(name, ""),
        unit=rules.unit(name),
        lowest=float(known.min()) if len(known) else np.nan,
        highest=float(known.max()) if len(known) else np.nan,
        gaps=len(values) - len(known),
        zero=None if zero is None else zero.mean,
        zero_se=None if zero is None else zero.se,
    )


def _screened(
    files: _Files, match: FileMatch, file: PreviewedFile, runs: Sequence[tuple[RunPlan, Piece]]
) -> PreviewedFile:
    """Add a file's samples and its screened runs."""
    if not file.samples:
        return file
    try:
        mapped = files.read(match)
        file = replace(file, log=_log(mapped, files.rules))
        screened = tuple(_run(plan, piece, mapped, files.rules) for plan, piece in runs)
    except HbenchError as error:
        return replace(file, error=_without_path(error, files.folder, match))
    except ValueError as error:  # of check_plan: such as the trial 0, by the file's name
        return replace(file, error=str(error))
    return replace(file, runs=screened)


def _run(plan: RunPlan, piece: Piece, mapped: MappedFile, rules: ImportMap) -> PreviewedRun:
    check_plan(plan)
    channels = channels_of(mapped, piece.section)
    screened = screen(run_of(channels, plan), rules.screening)
    run, at_speed = screened.run, None
    if KINDS[plan.kind].has_constant_speed:
        section = at_reference(run)
        if section.stop > section.start:
            at_speed = float(run.t_s[section.start]), float(run.t_s[section.stop - 1])
    start, stop = channels["t_s"][[0, -1]]
    without_samples = replace(screened, run=Run(plan, t_s=np.zeros(0), x_m=np.zeros(0)))
    return PreviewedRun(without_samples, (float(start), float(stop)), at_speed)


class _SamplesToDraw:
    """Files, of which some keep their samples to be drawn.

    These are the first file of each series, if possible one with runs, and the first file with each
    other reason for rejection.
    """

    def __init__(self, series: int):
        self.files: list[PreviewedFile] = []
        self._first: dict[str, int] = {}  # of each series
        self._more = max(_MOST_DRAWN - series, 0)  # with another reason
        self._codes: set[str] = set()

    def add(self, file: PreviewedFile) -> None:
        """Add a file, and leave out its samples if it is not drawn."""
        codes = {reason.partition(":")[0] for run in file.runs for reason in run.screened.reasons}
        first = self._first.get(file.pattern)
        better = first is not None and bool(file.runs) and not self.files[first].runs
        if file.log is None:
            is_drawn = False
        elif first is None or better:
            is_drawn = better or len(self._first) < _MOST_DRAWN
            if first is not None:
                self.files[first] = replace(self.files[first], log=None)
            self._first[file.pattern] = len(self.files)
        else:
            is_drawn = bool(codes - self._codes) and self._more > 0
            self._more -= is_drawn
        self._codes |= codes if is_drawn else set()
        self.files.append(file if is_drawn else replace(file, log=None))
