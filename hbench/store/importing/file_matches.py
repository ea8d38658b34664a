"""Files of an imported folder, matched with the series of an import map by their names."""

import re
from dataclasses import dataclass
from pathlib import Path

from hbench.config.import_map import FileSeries, ImportMap
from hbench.errors import ConfigError, DataError
from hbench.units import parse_unit

# Limits of the digits bound the time that a match takes.
_NUMBER = r"\d{1,12}(?:\.\d{1,12})?"
_FIELDS = {"pressure": _NUMBER, "load": f"-?{_NUMBER}", "speed": _NUMBER, "trial": r"\d{1,6}"}


@dataclass(frozen=True)
class FileMatch:
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
class FolderMatches:
    """All files below a folder, by the series of a map."""

    files: tuple[FileMatch, ...]  # series by series, each by pressure, load, speed and trial
    unmatched: tuple[str, ...]  # names of files that match no series
    empty: tuple[FileSeries, ...]  # series that match no file


def match_files(folder: Path, rules: ImportMap) -> FolderMatches:
    """Match the files below ``folder``. Raises ``ConfigError`` if a name matches two series."""
    names = sorted(
        path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()
    )
    found: dict[str, FileMatch] = {}
    by_series = []
    for series in rules.series:
        pattern, matches = _pattern(series.files), []
        for name in names:
            if match := pattern.fullmatch(name):
                if name in found:
                    raise ConfigError(
                        f"{name}: matches two series, {found[name].series.files} and {series.files}"
                    )
                found[name] = FileMatch(name, series, match.groupdict())
                matches.append(found[name])
        by_series.append(sorted(matches, key=lambda match: match.order))
    return FolderMatches(
        files=tuple(match for matches in by_series for match in matches),
        unmatched=tuple(name for name in names if name not in found),
        empty=tuple(s for s, matches in zip(rules.series, by_series, strict=True) if not matches),
    )


def refuse_empty(folder: Path, matches: FolderMatches) -> None:
    """Raise ``DataError`` for a series that matches no file."""
    for series in matches.empty:
        names = sorted([*matches.unmatched, *(match.name for match in matches.files)])
        raise DataError(
            f"{folder}: no file matches series {series.label!r}, files: {series.files}",
            f"Give paths from the imported folder, which contains {_listed(names)}.",
        )


def _listed(names: list[str]) -> str:
    few = ", ".join(name[:60] for name in names[:3]) or "no file"
    return f"{few}{', ...' if len(names) > 3 else ''}"


def _pattern(files: str) -> re.Pattern[str]:
    text = re.escape(files)
    for name, number in _FIELDS.items():
        text = text.replace(re.escape(f"{{{name}}}"), f"(?P<{name}>{number})")
    return re.compile(text)
