"""Reader of another bench's files by an import map: columns, units, cuts, nominal values."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from hbench.config.import_map import ImportMap
from hbench.errors import DataError
from hbench.motion.reversals import StrokeCuts, cut_at_reversals, stroke_speed
from hbench.records import KINDS, RunPlan, Specimen
from hbench.store.importing.channels import FileChannels, read_channels_by_map
from hbench.store.importing.file_matches import FileMatch, match_files, refuse_empty
from hbench.store.importing.imported_run import ImportedRun, ImportedRuns, SourceFile, open_source


@dataclass(frozen=True)
class MappedFile:
    """A file whose name matches a series, with its channels."""

    match: FileMatch
    file: SourceFile
    read: FileChannels


@dataclass(frozen=True)
class Stroke:
    """A section of a file that becomes a run."""

    match: FileMatch
    file: SourceFile
    lines: tuple[int, int]
    channels: dict[str, np.ndarray]
    v_m_s: float  # measured, signed

    @property
    def reference(self) -> tuple:
        """Key of strokes with the same nominal speed: label, load and direction."""
        return (self.match.series.label, self.match.f_load_n, self.v_m_s > 0)


@dataclass(frozen=True)
class FileStrokes:
    """The strokes of a file, and the numbers of its other sections as in ``StrokeCuts``."""

    strokes: tuple[Stroke, ...]
    partial: int
    short: int


def read_mapped(folder: Path, rules: ImportMap) -> ImportedRuns:
    """Read every file below ``folder`` whose name matches a series of the map.

    Raises ``DataError`` naming the invalid file and line.
    """
    matches = match_files(folder, rules)
    refuse_empty(folder, matches)
    cuts: list[FileStrokes] = []
    notes: list[str] = []
    for match in matches.files:
        mapped = read_mapped_file(folder, match, rules)
        cuts.append(cut_strokes(mapped, folder, rules))
        notes += mapped.read.notes
    strokes = [stroke for cut in cuts for stroke in cut.strokes]
    if not strokes:
        raise DataError(
            f"{folder}: no stroke between two reversals is longer than min_stroke = "
            f"{1e3 * rules.min_stroke:g} mm",
            "Reduce 'min_stroke' in the map.",
        )
    return ImportedRuns(runs_of(strokes, rules.kind), (*_notes(cuts, rules), *notes))


def read_mapped_file(folder: Path, match: FileMatch, rules: ImportMap) -> MappedFile:
    """Read one file. Raises ``DataError`` naming the invalid line."""
    with open_source(folder, match.name, rules.format) as (table, file):
        return MappedFile(match, file, read_channels_by_map(table, match.name, match.fields, rules))


def cut_strokes(mapped: MappedFile, folder: Path, rules: ImportMap) -> FileStrokes:
    """Cut a file into strokes. Raises ``DataError`` if it has none, or if a speed is missing."""
    cut = _cut(mapped.read.channels["x_m"], str(folder / mapped.match.name), rules)
    strokes = tuple(_stroke(mapped, piece, rules.kind) for piece in cut.pieces)
    return FileStrokes(strokes, cut.partial, cut.short)


def runs_of(strokes: Sequence[Stroke], kind: str) -> tuple[ImportedRun, ...]:
    """Return a run for each stroke; its nominal speed depends on the other strokes."""
    speeds = _nominal_speeds(strokes)
    return tuple(
        ImportedRun(_plan(number, s, kind, speeds), s.channels, s.file, s.lines)
        for number, s in enumerate(strokes, start=1)
    )


def _cut(x_m: np.ndarray, source: str, rules: ImportMap) -> StrokeCuts:
    if rules.cut == "reversals":
        return cut_at_reversals(x_m, rules.min_stroke)
    if not KINDS[rules.kind].has_constant_speed:
        return StrokeCuts((slice(0, len(x_m)),), partial=0, short=0)
    if abs(x_m[-1] - x_m[0]) < rules.min_stroke:
        raise DataError(
            f"{source}: ends {1e3 * abs(x_m[-1] - x_m[0]):.3g} mm from where it began; expected "
            f"one stroke of at least min_stroke = {1e3 * rules.min_stroke:g} mm",
            "For files with strokes in both directions, write 'cut: reversals' in the map.",
        )
    return StrokeCuts((slice(0, len(x_m)),), partial=0, short=0)


def _stroke(mapped: MappedFile, piece: slice, kind: str) -> Stroke:
    match, read = mapped.match, mapped.read
    channels = {name: values[piece] for name, values in read.channels.items()}
    constant = KINDS[kind].has_constant_speed
    measured = stroke_speed(channels["t_s"], channels["x_m"]) if constant else None
    return Stroke(
        match=match,
        file=mapped.file,
        lines=(int(read.lines[piece][0]), int(read.lines[piece][-1])),
        channels=channels,
        v_m_s=_top_speed(channels, match, kind) if measured is None else measured,
    )


def _top_speed(channels: dict[str, np.ndarray], match: FileMatch, kind: str) -> float:
    """Return the top speed [m/s] of a non-steady run, with the sign of its reference."""
    v_ref = channels.get("v_ref_m_s")
    if KINDS[kind].is_at_rest:
        return 0.0
    if v_ref is not None and np.isfinite(v_ref).any():
        return float(v_ref[np.nanargmax(np.abs(v_ref))])
    if match.speed_m_s is None:
        raise DataError(
            f"{match.name}: the top speed of a {kind} run is not specified",
            "Add 'columns.v_ref_m_s' to the map, or the series' 'speed' or {speed} in its 'files'.",
        )
    return match.speed_m_s


def _nominal_speeds(strokes: Sequence[Stroke]) -> dict[tuple, float]:
    """Return the signed nominal speed for each label, load and direction."""
    measured = defaultdict(list)
    for stroke in strokes:
        measured[stroke.reference].append(stroke.v_m_s)
    return {reference: float(f"{median(speeds):.2g}") for reference, speeds in measured.items()}


def _plan(number: int, stroke: Stroke, kind: str, speeds: dict[tuple, float]) -> RunPlan:
    match = stroke.match
    if not KINDS[kind].has_constant_speed:
        v_ref = stroke.v_m_s
    elif match.speed_m_s is not None:
        v_ref = np.copysign(match.speed_m_s, stroke.v_m_s)
    else:
        v_ref = speeds[stroke.reference]
    cylinder = match.series.cylinder
    return RunPlan(
        run=f"{number:04d}",
        kind=kind,
        trial=match.trial,
        v_ref_m_s=float(v_ref),
        specimen=Specimen(cylinder.area_piston_m2, cylinder.area_rod_m2, cylinder.stroke),
        f_load_n=match.f_load_n,
        label=match.series.label,
    )


def _notes(cuts: Sequence[FileStrokes], rules: ImportMap) -> tuple[str, ...]:
    if rules.cut == "none":
        return ()
    whole = sum(len(cut.strokes) for cut in cuts)
    partial, short = sum(cut.partial for cut in cuts), sum(cut.short for cut in cuts)
    return (
        f"cut at reversals into {whole} strokes; left out: {partial} sections before the first or "
        f"after the last reversal of a file, {short} shorter than {1e3 * rules.min_stroke:g} mm",
    )
