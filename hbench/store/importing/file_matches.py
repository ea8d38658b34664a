"""Files of an imported folder, matched with the series of an import map by their names."""

import re
from dataclasses import dataclass
from pathlib import Path

from hbench.config.import_map import FileSeries, ImportMap
from hbench.errors import ConfigError, DataError
from hbench.store.importing.file_notes import first_names
from hbench.units import parse_unit

# Limits of the lengths bound the time that a match takes.
_NUMBER = r"[-+]?\d{1,12}(?:[.,]\d{1,12})?"
_TRIAL = r"\d{1,6}"
_TEXT = r"[^/]{1,40}?"
_ANY = r"[^/]{0,200}?"  # for a star
_LONGEST = 400  # characters of a path


@dataclass(frozen=True)
class FileMatch:
    """A file whose name matches a series."""

    name: str
    series: FileSeries
    fields: dict[str, str]  # the values in its name

    @property
    def trial(self) -> int | None:
        """Number of the trial; None if the name contains none."""
        return int(self.fields["trial"]) if "trial" in self.fields else None

    @property
    def f_load_n(self) -> float | None:
        """Nominal load: from the name, or pressure times the piston's area."""
        load, pressure = self._si("load"), self._si("pressure")
        if load is None and pressure is not None:
            return pressure * self.series.cylinder.area_piston_m2
        return load

    @property
    def speed_m_s(self) -> float | None:
        """Nominal speed without sign: of the series, or in the name."""
        speed = self.series.speed if self.series.speed is not None else self._si("speed")
        return None if speed is None else abs(speed)

    @property
    def label(self) -> str:
        """Label of the series with its factors, which separate curves as the label does."""
        factors = (f"{name} {value}" for name, value in self.factors)
        return ", ".join([self.series.label, *factors])

    @property
    def factors(self) -> tuple[tuple[str, str], ...]:
        """Each factor of the series with its value for this file."""
        return self.series.factors_in(self.fields)

    @property
    def order(self) -> tuple[float, float, float, str, int]:
        """Sorting key of a series' files: pressure, load, speed, factors and trial."""
        pressure, load, speed = (self._si(name) or 0.0 for name in ("pressure", "load", "speed"))
        return pressure, load, speed, self.label, self.trial or 0

    def _si(self, name: str) -> float | None:
        if name not in self.fields:
            return None
        number = float(self.fields[name].replace(",", "."))
        return number * parse_unit(getattr(self.series, f"{name}_unit")).factor


@dataclass(frozen=True)
class FolderMatches:
    """All files below a folder, by the series of a map."""

    files: tuple[FileMatch, ...]  # series by series, each by pressure, load, speed and trial
    unmatched: tuple[str, ...]  # names of files that match no series
    empty: tuple[FileSeries, ...]  # series that match no file


def match_files(folder: Path, rules: ImportMap) -> FolderMatches:
    """Match the files below ``folder``. Raises ``ConfigError`` if a name matches two series.

    Also ``DataError`` for an impossible value in a name.
    """
    names = sorted(
        path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()
    )
    found: dict[str, FileMatch] = {}
    by_series = []
    for series in rules.series:
        pattern, matches = name_pattern(series), []
        for name in names:
            if len(name) <= _LONGEST and (match := pattern.fullmatch(name)):
                if name in found:
                    raise ConfigError(
                        f"{name}: matches two series, {found[name].series.files} and {series.files}"
                    )
                found[name] = FileMatch(name, series, match.groupdict())
                _check_speed(found[name])
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
        fields = (
            " A field such as {speed} is a number such as 0.5, {trial} a whole one; write a star "
            "for other characters."
            if series.fields
            else ""
        )
        raise DataError(
            f"{folder}: no file matches series {series.label!r}, files: {series.files}",
            f"Give paths from the imported folder, which contains {first_names(names)}.{fields}",
        )


def _check_speed(match: FileMatch) -> None:
    if match.speed_m_s == 0.0:
        raise DataError(
            f"{match.name}: {{speed}} in the name is 0; limit above 0",
            "Rename the file, or change 'files' in the map.",
        )


def name_pattern(series: FileSeries) -> re.Pattern[str]:
    """Return the pattern of the names of a series, with a group for each field."""
    text = re.escape(series.files).replace(r"\*", _ANY)
    for name in series.fields:
        one = _TRIAL if name == "trial" else _TEXT if series.factors.get(name) == "" else _NUMBER
        text = text.replace(re.escape(f"{{{name}}}"), f"(?P<{name}>{one})")
    return re.compile(text)
