"""The import map: rules to convert another bench's files to runs."""

import difflib
import re
from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator

from hbench.channels import CHANNELS
from hbench.config import quantity as q
from hbench.config.campaign_settings import CampaignSettings
from hbench.config.files.loading import validate
from hbench.config.import_layout import (
    DATE_TIME,
    NO_CYLINDER,
    ROTARY,
    Column,
    ForeignLoadCell,
    Format,
    ImportedCylinder,
    check_column,
)
from hbench.config.quantity import ConfigSection
from hbench.config.schedule import Screening
from hbench.errors import ConfigError
from hbench.records import KINDS, kind_names
from hbench.units import parse_unit, to_si

# Channels of a sensor each: no two of them are one column.
_SENSORS = ("x_m", "v_m_s", "p_tp_pa", "p_tr_pa", "f_applied_n", "f_drive_n")
UNFILLED = "???"  # a value of a suggested map that the user must give
FIELDS = ("pressure", "load", "speed", "trial")  # of file names, besides factors
_FIELD = re.compile(r"\{([^{}]*)\}")
_FIELD_UNITS = {"pressure": "Pa", "load": "N", "speed": "m/s"}
_USUAL_UNITS = {"Pa": "bar", "m": "mm", "m/s": "mm/s"}  # of examples in messages
_UNIT_BEHIND = re.compile(r"\{(pressure|load|speed)\}([A-Za-z]+(?:_[a-z]+)?)")
_MASS_BEHIND = re.compile(r"\{load\}kg(?![A-Za-z])")
_NAME = re.compile(r"[a-z][a-z0-9_]{0,30}")


def _speed(value: object) -> float:
    """Read a speed, linear or angular."""
    try:
        si = to_si(value, "rad/s")
    except ValueError:
        si = to_si(value, "mm/s")
    if not 1e-9 <= si <= 10:
        raise ValueError(f"must be 1e-06 to 10000 mm/s, or 1e-09 to 10 rad/s; is {value}")
    return si


Cut = Literal["none", "reversals", "plateaus"]
AnySpeed = Annotated[float, BeforeValidator(_speed)]


def _known_kind(kind: str) -> str:
    """Return a kind of runs. Raises ``ValueError`` if there is none of this name."""
    if kind not in KINDS:
        raise ValueError(f"must be one of {kind_names()}")
    return kind


Kind = Annotated[str, AfterValidator(_known_kind)]  # a row of KINDS


def units_behind(files: str) -> Iterator[tuple[str, str]]:
    """Yield fields in ``files`` that are followed by a unit of theirs, such as ``{load}kN``."""
    for name, text in _UNIT_BEHIND.findall(files):
        unit = text.replace("_", "/")
        try:
            fits = parse_unit(unit).dimension == parse_unit(_FIELD_UNITS[name]).dimension
        except ValueError:
            continue
        if fits:
            yield name, unit


class FileSeries(ConfigSection):
    """Files that belong together: one cylinder, one label, several trials, loads or speeds.

    ``files`` is a path below the imported folder with fields in braces: ``{pressure}``, ``{load}``,
    ``{speed}`` are numbers in the units given here, ``{trial}`` is a whole number, and a name of
    ``factors`` is a number in that factor's unit, or any text if its unit is empty. A star stands
    for any characters. The nominal load is ``{load}``, or else the pressure times the piston's
    area, or else there is none. Without ``speed`` and ``{speed}`` the nominal speed is measured.
    """

    label: str
    files: str
    cylinder: ImportedCylinder = NO_CYLINDER  # not needed where the drive's force is logged
    pressure_unit: str = "bar"
    load_unit: str = "N"
    speed_unit: str = "mm/s"
    speed: AnySpeed | None = None
    # What else was varied, such as current or lubricant: its unit where the file's name has the
    # value, as in {current: A}; or the value itself, as in {lubricant: PTFE grease}.
    factors: dict[str, str] = {}
    kind: Kind | None = None  # of these files, if it is not that of the map
    cut: Cut | None = None

    @property
    def fields(self) -> list[str]:
        """The fields in ``files``."""
        return _FIELD.findall(self.files)

    def factors_in(self, fields: Mapping[str, str]) -> tuple[tuple[str, str], ...]:
        """Return each factor with its value, which may be in the ``fields`` of a file's name."""
        return tuple(
            (name, f"{fields[name]} {value}".rstrip() if name in fields else value)
            for name, value in self.factors.items()
        )

    @field_validator("factors")
    @classmethod
    def _factor_names(cls, factors: dict[str, str]) -> dict[str, str]:
        for name, value in factors.items():
            if not _NAME.fullmatch(name) or name in FIELDS:
                raise ValueError(f"{name!r} is not a possible name; use a-z, 0-9 and _")
            if not value.isprintable() or len(value) > 60:
                raise ValueError(f"{name}: must be printable text of at most 60 characters")
        return factors

    @model_validator(mode="after")
    def _fields(self) -> "FileSeries":
        known = (*FIELDS, *self.factors)
        rest = _FIELD.sub("", self.files)
        unknown = [field for field in self.fields if field not in known]
        if "{" in rest or "}" in rest or unknown:
            words = ", ".join(f"{{{name}}}" for name in known)
            raise ValueError(
                f"files: only {words} are possible in braces; add other names to 'factors'"
            )
        for name, behind in units_behind(self.files):
            unit = getattr(self, f"{name}_unit")
            found, stated = parse_unit(behind), parse_unit(unit)
            if found.dimension == stated.dimension and found != stated:
                raise ValueError(
                    f"files: {{{name}}} is followed by {behind}, which contradicts {name}_unit = "
                    f"{unit!r}; write {name}_unit: {behind}"
                )
        if _MASS_BEHIND.search(self.files) and self.load_unit not in ("kgf", "tf"):
            raise ValueError(
                "files: {load} is followed by kg, a mass; write load_unit: kgf, for its weight"
            )
        if len(set(self.fields)) < len(self.fields):
            raise ValueError("files: a field may occur only once")
        for name, linear in _FIELD_UNITS.items():
            self._check_unit(name, linear)
        if self.speed is not None and "{speed}" in self.files:
            raise ValueError("speed is given twice, here and in files")
        return self

    def _check_unit(self, name: str, linear: str) -> None:
        """Refuse a field's unit of another dimension than ``linear``, or than that of a rotation.

        The defaults are units of a linear motion: they do not apply to a rotary actuator.
        """
        rotary = ROTARY.get(linear, linear)
        is_stated = f"{name}_unit" in self.model_fields_set or name == "pressure"
        if self.cylinder.rotary and not is_stated:
            if f"{{{name}}}" in self.files:
                raise ValueError(f"{name}_unit is missing: {rotary}, for a rotary actuator")
            return
        possible = {rotary} if self.cylinder.rotary else {linear}
        if not self.cylinder.known:  # of a drive, linear or rotary
            possible = {linear, rotary}
        unit = getattr(self, f"{name}_unit")
        if parse_unit(unit).dimension not in {parse_unit(si).dimension for si in possible}:
            raise ValueError(f"{name}_unit {unit!r} is not a unit of {name}")


class ImportMap(CampaignSettings):
    """Map for ``hbench import``."""

    name: str
    kind: Kind = "steady"
    format: Format = Format()
    columns: dict[str, Column] = Field(min_length=2)  # t_s may be missing if files state times
    # Channel: quantity, for channels that are known but not logged. It may contain a field of the
    # file names, as in "{load} N".
    constants: dict[str, q.QuantityText] = {}
    load_cell: ForeignLoadCell | None = None  # f_applied_n is logged as a voltage: C.6
    series: tuple[FileSeries, ...] = Field(min_length=1, max_length=1000)
    repeated_times: Literal["refuse", "drop"] = "refuse"  # drop: the first sample of each counts
    resample: q.Frequency | None = None
    cut: Cut = "none"  # a run of each stroke or speed
    min_stroke: q.Length = 0.01  # shorter ones are left out, with a note
    screening: Screening = Screening(high_speed_error=None)

    @field_validator("screening", mode="before")
    @classmethod
    def _of_another_bench(cls, limits: object) -> object:
        """Return limits without the source's 2 mm/s above 150 mm/s, unless the map states one.

        It is for the source's own bench, whose supply pressure sags at up to 200 mm/s: there it is
        1 % of the speed, at 1 m/s it would be 0.2 %.
        """
        return {"high_speed_error": None} | limits if isinstance(limits, dict) else limits

    def of(self, series: FileSeries) -> "ImportMap":
        """Return the map with the kind and the cut of one of its series."""
        return self.model_copy(
            update={"kind": series.kind or self.kind, "cut": series.cut or self.cut}
        )

    def wanted(self, channel: str) -> str:
        """Return a unit of the dimension that a channel's column must have."""
        return "V" if channel == "f_applied_n" and self.load_cell else self.unit(channel)

    def unit(self, channel: str) -> str:
        """Return a channel's unit."""
        unit = CHANNELS[channel].unit
        return ROTARY.get(unit, unit) if self.rotary else unit

    @property
    def rotary(self) -> bool:
        """Whether positions are angles and forces torques: of the actuator or of a drive."""
        cylinder, position = self.series[0].cylinder, self.columns.get("x_m")
        is_angle = position is not None and position.unit in ("deg", "rad")
        return cylinder.rotary or (is_angle and not cylinder.known)

    @model_validator(mode="after")
    def _channels(self) -> "ImportMap":
        if len({series.cylinder.rotary for series in self.series}) > 1:
            raise ValueError("series: rotary and linear actuators need maps of their own")
        for name in (*self.columns, *self.constants):
            if name not in CHANNELS:
                near = [f"'{channel}'" for channel in CHANNELS if channel.startswith(name)]
                near = near or [f"'{c}'" for c in difflib.get_close_matches(name, CHANNELS, n=1)]
                known = f"known are {', '.join(CHANNELS)}"
                meant = f"did you mean {' or '.join(near)}" if near else known
                raise ValueError(f"unknown channel '{name}'; {meant}{'?' * bool(near)}")
        if "x_m" not in self.columns:
            raise ValueError("columns.x_m is missing; the analysis needs it")
        for one, other in combinations([c for c in _SENSORS if c in self.columns], 2):
            if (both := self.columns[one].column) == self.columns[other].column:
                raise ValueError(f"columns.{one} and columns.{other} are both {both!r}")
        for name, column in self.columns.items():
            for given in (column.column, column.time):
                if isinstance(given, str) and not self.format.header:
                    raise ValueError(
                        f"columns.{name}: {given!r} is a name, but format.header is false"
                    )
            if column.time is not None and (name == "t_s" or "t_s" not in self.columns):
                raise ValueError(f"columns.{name}: time needs columns.t_s, which gives its unit")
            _check_unit(name, column)
            check_column(name, column, self.format, self.wanted(name))
            if column.offset is not None:
                _quantity(f"columns.{name}.offset", column.offset, self.unit(name))
        if "f_drive_n" not in (*self.columns, *self.constants):
            for series in self.series:
                if not series.cylinder.known:
                    raise ValueError(
                        f"series {series.label!r}: cylinder is missing; without pressures give "
                        "columns.f_drive_n, the force of the drive"
                    )
        if self.load_cell and "f_applied_n" not in self.columns:
            raise ValueError("load_cell needs columns.f_applied_n")
        return self

    @model_validator(mode="after")
    def _constants(self) -> "ImportMap":
        for name, constant in self.constants.items():
            if name in self.columns:
                raise ValueError(f"{name} is both a column and a constant; remove one of them")
            fields = [field for field in FIELDS if f"{{{field}}}" in constant]
            for field in fields:
                if any(f"{{{field}}}" not in series.files for series in self.series):
                    raise ValueError(f"constants.{name}: {{{field}}} is not in every 'files'")
            self.constant(name, dict.fromkeys(fields, "1"))
        return self

    def constant(self, channel: str, fields: Mapping[str, str]) -> float:
        """Return a channel's constant in SI; ``fields`` are the values in a file's name.

        Raises ``ValueError``.
        """
        text = self.constants[channel]
        for name, number in fields.items():
            text = text.replace(f"{{{name}}}", number.replace(",", "."))
        unit = self.unit(channel)
        return _quantity(f"constants.{channel}", text, "degC" if unit == "K" else unit)


def _check_unit(name: str, column: Column) -> None:
    if column.unit is None or column.unit == DATE_TIME:
        return
    try:
        parse_unit(column.unit)
    except ValueError as error:
        volts = "; for an electrical signal write the channel's unit and a scale"
        needed = f"; {name} needs a unit such as {CHANNELS[name].unit}{volts}"
        raise ValueError(f"columns.{name}.unit: {error}{needed}") from None


def _quantity(key: str, value: str, unit: str) -> float:
    try:
        return to_si(value, _USUAL_UNITS.get(unit, unit))
    except ValueError as error:
        raise ValueError(f"{key} = {value!r}: {error}") from None


def parse_import_map(data: dict[str, Any], source: str) -> ImportMap:
    """Check the mapping of an import map. Raises ``ConfigError``."""
    if unfilled := [key for key, value in _values(data) if UNFILLED in value]:
        raise ConfigError(
            "\n".join(f"{source}: {key}: is not filled in" for key in unfilled),
            f"Replace each {UNFILLED} by a value.",
        )
    return validate(ImportMap, data, source)


def _values(data: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """Yield all texts of a mapping with their keys."""
    if isinstance(data, str):
        yield key.removeprefix("."), data
    elif isinstance(data, (dict, list)):
        for name, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from _values(value, f"{key}.{name}")
