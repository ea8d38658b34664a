"""Reader of another bench's files by an import map: columns, units, cuts, nominal values."""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from hbench.config.import_map import FileSeries, ImportMap
from hbench.errors import ConfigError, DataError
from hbench.motion.reversals import StrokeCuts, cut_at_reversals, stroke_speed
from hbench.records import KINDS, RunPlan, Specimen
from hbench.store.importing.channels import FileChannels, read_channels_by_map
from hbench.store.importing.imported_run import ImportedRun, ImportedRuns, SourceFile, open_source
from hbench.units import parse_unit

# Limits of the digits bound the time that a match takes.
_NUMBER = r"\d{1,12}(?:\.\d{1,12})?"
_FIELDS = {"pressure": _NUMBER, "load": f"-?{_NUMBER}", "speed": _NUMBER, "trial": r"\d{1,6}"}


@dataclass(frozen=True)
class _Match:
    """A file whose name matches a series."""

    name: str
    series: FileSeries
    fields: dict[str, str]  # the values in its name

    @property
    def trial(self) -> int:
        """Number of the trial; 1 if the name contains none."""
        return int(self.fields.get("trial", 1))

    @property
    def f_load_n(self) -> float | None:
        """Nominal load: from the name, or pressure times the piston's area."""
        load, pressure = self._si("load"), self._si("pressure")
        if load is None and pressure is not None:
            return pressure * self.series.cylinder.area_piston_m2
        return load

    @property
    def speed_m_s(self) -> float | None:
        """Nominal speed, without sign."""
        return self.series.speed if self.series.speed is not None else self._si("speed")

    @property
    def order(self) -> tuple[float, float, float, int]:
        """Sorting key of a series' files: pressure, load, speed and trial."""
        pressure, load, speed = (self._si(name) or 0.0 for name in ("pressure", "load", "speed"))
        return pressure, load, speed, self.trial

    def _si(self, name: str) -> float | None:
        if name not in self.fields:
            return None
        return float(self.fields[name]) * parse_unit(getattr(self.series, f"{name}_unit")).factor


@dataclass(frozen=True)
class _Stroke:
    """A section of a file that becomes a run."""

    match: _Match
    file: SourceFile
    lines: tuple[int, int]
    channels: dict[str, np.ndarray]
    v_m_s: float  # measured, signed

    @property
    def reference(self) -> tuple:
        """Key of strokes with the same nominal speed: label, load and direction."""
        return (self.match.series.label, self.match.f_load_n, self.v_m_s > 0)


def read_mapped(folder: Path, rules: ImportMap) -> ImportedRuns:
    """Read every file below ``folder`` whose name matches a series of the map.

    Raises ``DataError`` naming the invalid file and line.
    """
    strokes: list[_Stroke] = []
    notes: list[str] = []
    partial = short = 0
    for match in _matches(folder, rules):
        with open_source(folder, match.name, rules.format) as (table, file):
            read = read_channels_by_map(table, match.name, match.fields, rules)
        cut = _cut(read.channels["x_m"], str(folder / match.name), rules)
        strokes += [_stroke(match, file, read, piece, rules.kind) for piece in cut.pieces]
        notes += read.notes
        partial, short = partial + cut.partial, short + cut.short
    if not strokes:
        raise DataError(
            f"{folder}: no stroke between two reversals is longer than min_stroke = "
            f"{1e3 * rules.min_stroke:g} mm",
            "Reduce 'min_stroke' in the map.",
        )
    speeds = _nominal_speeds(strokes)
    runs = tuple(
        ImportedRun(_plan(number, s, rules.kind, speeds), s.channels, s.file, s.lines)
        for number, s in enumerate(strokes, start=1)
    )
    return ImportedRuns(runs, (*_notes(len(runs), partial, short, rules), *notes))


def _listed(names: list[str]) -> str:
    few = ", ".join(name[:60] for name in names[:3]) or "no file"
    return f"{few}{', ...' if len(names) > 3 else ''}"


def _matches(folder: Path, rules: ImportMap) -> Iterator[_Match]:
    """Yield the files of each series by pressure and trial."""
    names = [path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()]
    taken: dict[str, str] = {}
    for series in rules.series:
        pattern = _pattern(series.files)
        matches = []
        for name in sorted(names):
            if match := pattern.fullmatch(name):
                if name in taken:
                    raise ConfigError(
                        f"{name}: matches two series, {taken[name]} and {series.files}"
                    )
                taken[name] = series.files
                matches.append(_Match(name, series, match.groupdict()))
        if not matches:
            raise DataError(
                f"{folder}: no file matches series {series.label!r}, files: {series.files}",
                f"Give paths from the imported folder, which contains {_listed(sorted(names))}.",
            )
        yield from sorted(matches, key=lambda m: m.order)


def _pattern(files: str) -> re.Pattern[str]:
    text = re.escape(files)
    for name, number in _FIELDS.items():
        text = text.replace(re.escape(f"{{{name}}}"), f"(?P<{name}>{number})")
    return re.compile(text)


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


def _stroke(
    match: _Match, file: SourceFile, read: FileChannels, piece: slice, kind: str
) -> _Stroke:
    channels = {name: values[piece] for name, values in read.channels.items()}
    constant = KINDS[kind].has_constant_speed
    measured = stroke_speed(channels["t_s"], channels["x_m"]) if constant else None
    return _Stroke(
        match=match,
        file=file,
        lines=(int(read.lines[piece][0]), int(read.lines[piece][-1])),
        channels=channels,
        v_m_s=_top_speed(channels, match, kind) if measured is None else measured,
    )


def _top_speed(channels: dict[str, np.ndarray], match: _Match, kind: str) -> float:
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


def _nominal_speeds(strokes: list[_Stroke]) -> dict[tuple, float]:
    """Return the signed nominal speed for each label, load and direction."""
    measured = defaultdict(list)
    for stroke in strokes:
        measured[stroke.reference].append(stroke.v_m_s)
    return {reference: float(f"{median(speeds):.2g}") for reference, speeds in measured.items()}


def _plan(number: int, stroke: _Stroke, kind: str, speeds: dict[tuple, float]) -> RunPlan:
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


def _notes(whole: int, partial: int, short: int, rules: ImportMap) -> tuple[str, ...]:
    if rules.cut == "none":
        return ()
    return (
        f"cut at reversals into {whole} strokes; left out: {partial} sections before the first or "
        f"after the last reversal of a file, {short} shorter than {1e3 * rules.min_stroke:g} mm",
    )
