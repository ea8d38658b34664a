"""Reads another bench's files by an import map: columns, units, cuts, nominal values."""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from hbench.config.importmap import ALWAYS, CHANNELS, ImportMap, Series
from hbench.errors import ConfigError, DataError
from hbench.records import RunPlan, Specimen
from hbench.store.foreign_run import ForeignRun, ForeignRuns, SourceFile, read_source
from hbench.store.run_csv import check_time
from hbench.store.strokes import Strokes, cut_at_reversals, stroke_speed
from hbench.store.table import parse_table
from hbench.units import parse_unit, to_si

_FIELDS = {"pressure": r"\d+(?:\.\d+)?", "trial": r"\d+"}


@dataclass(frozen=True)
class _Match:
    """A file that a series names."""

    name: str
    series: Series
    pressure_pa: float | None
    trial: int

    @property
    def f_load_n(self) -> float | None:
        """Nominal load: pressure times the piston's area."""
        if self.pressure_pa is None:
            return None
        return self.pressure_pa * self.series.cylinder.area_piston_m2


@dataclass(frozen=True)
class _Stroke:
    """A piece of a file that becomes a run."""

    match: _Match
    file: SourceFile
    lines: tuple[int, int]
    channels: dict[str, np.ndarray]
    v_m_s: float  # measured, signed

    @property
    def reference(self) -> tuple:
        """What strokes of one nominal speed have in common."""
        return (self.match.series.label, self.match.f_load_n, self.v_m_s > 0)


def read_mapped(folder: Path, rules: ImportMap) -> ForeignRuns:
    """Read every file below ``folder`` that a series of the map names.

    Raises ``DataError`` naming the file and line that can't be used.
    """
    strokes: list[_Stroke] = []
    partial = short = 0
    for match in _matches(folder, rules):
        file = read_source(folder, match.name)
        source = str(folder / match.name)
        channels, first_line = _read_channels(file, source, rules)
        cut = _cut(channels["x_m"], source, rules)
        strokes += [_stroke(match, file, channels, first_line, piece) for piece in cut.pieces]
        partial, short = partial + cut.partial, short + cut.short
    if not strokes:
        raise DataError(
            f"{folder}: no stroke between two reversals is as long as min_stroke "
            f"({1e3 * rules.min_stroke:g} mm)"
        )
    speeds = _nominal_speeds(strokes)
    runs = tuple(
        ForeignRun(_plan(number, s, rules.kind, speeds), s.channels, s.file, s.lines)
        for number, s in enumerate(strokes, start=1)
    )
    return ForeignRuns(runs, _notes(len(runs), partial, short, rules))


def _matches(folder: Path, rules: ImportMap) -> Iterator[_Match]:
    """Yield the files of each series by pressure and trial."""
    names = [path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()]
    taken: dict[str, str] = {}
    for series in rules.series:
        pattern = _pattern(series.files)
        found = []
        for name in sorted(names):
            if match := pattern.fullmatch(name):
                if name in taken:
                    raise ConfigError(f"{name}: belongs to series {taken[name]} and {series.files}")
                taken[name] = series.files
                found.append(_match(name, series, match.groupdict()))
        if not found:
            raise DataError(
                f"{folder}: no file fits series {series.label!r}, files: {series.files}",
                "Paths start at the imported folder.",
            )
        yield from sorted(found, key=lambda m: (m.pressure_pa or 0.0, m.trial))


def _pattern(files: str) -> re.Pattern[str]:
    text = re.escape(files)
    for name, number in _FIELDS.items():
        text = text.replace(re.escape(f"{{{name}}}"), f"(?P<{name}>{number})")
    return re.compile(text)


def _match(name: str, series: Series, fields: dict[str, str]) -> _Match:
    pressure = fields.get("pressure")
    factor = parse_unit(series.pressure_unit).factor
    return _Match(
        name=name,
        series=series,
        pressure_pa=None if pressure is None else float(pressure) * factor,
        trial=int(fields.get("trial", 1)),
    )


def _read_channels(
    file: SourceFile, source: str, rules: ImportMap
) -> tuple[dict[str, np.ndarray], int]:
    """Return the channels of a whole file in SI, and the line of their first sample."""
    table = parse_table(file.data, source, rules.format)
    channels = {}
    for name, column in rules.columns.items():
        factor = parse_unit(column.unit).factor * column.scale
        numbers = table.numbers(column.column, gaps=name not in ALWAYS)
        channels[name] = numbers * factor
    for name, constant in rules.constants.items():
        channels[name] = np.full(len(table.rows), to_si(constant, CHANNELS[name]))
    check_time(channels["t_s"], table.first_line, source)
    return channels, table.first_line


def _cut(x_m: np.ndarray, source: str, rules: ImportMap) -> Strokes:
    if rules.cut == "reversals":
        return cut_at_reversals(x_m, rules.min_stroke)
    if abs(x_m[-1] - x_m[0]) < rules.min_stroke:
        raise DataError(
            f"{source}: ends {1e3 * abs(x_m[-1] - x_m[0]):.3g} mm from where it began; expected "
            f"one stroke of at least min_stroke = {1e3 * rules.min_stroke:g} mm",
            "For files with strokes in both directions, write 'cut: reversals'.",
        )
    return Strokes((slice(0, len(x_m)),), partial=0, short=0)


def _stroke(
    match: _Match,
    file: SourceFile,
    channels: dict[str, np.ndarray],
    first_line: int,
    piece: slice,
) -> _Stroke:
    part = {name: values[piece] for name, values in channels.items()}
    return _Stroke(
        match=match,
        file=file,
        lines=(first_line + piece.start, first_line + piece.stop - 1),
        channels=part,
        v_m_s=stroke_speed(part["t_s"], part["x_m"]),
    )


def _nominal_speeds(strokes: list[_Stroke]) -> dict[tuple, float]:
    """Return the signed nominal speed for each label, load and direction."""
    measured = defaultdict(list)
    for stroke in strokes:
        measured[stroke.reference].append(stroke.v_m_s)
    return {reference: float(f"{median(speeds):.2g}") for reference, speeds in measured.items()}


def _plan(number: int, stroke: _Stroke, kind: str, speeds: dict[tuple, float]) -> RunPlan:
    match = stroke.match
    given = match.series.speed
    v_ref = speeds[stroke.reference] if given is None else np.copysign(given, stroke.v_m_s)
    cylinder = match.series.cylinder
    return RunPlan(
        run=f"{number:04d}",
        kind=kind,
        trial=match.trial,
        v_ref_m_s=float(v_ref),
        specimen=Specimen(cylinder.area_piston_m2, cylinder.area_rod_m2),
        f_load_n=match.f_load_n,
        label=match.series.label,
    )


def _notes(whole: int, partial: int, short: int, rules: ImportMap) -> tuple[str, ...]:
    if rules.cut == "none":
        return ()
    return (
        f"cut at reversals into {whole} strokes; left out: {partial} pieces before the first or "
        f"after the last reversal of a file, {short} shorter than {1e3 * rules.min_stroke:g} mm",
    )
