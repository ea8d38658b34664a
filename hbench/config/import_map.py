"""The import map: rules to convert another bench's files to runs."""

import math
import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from hbench.config import quantity as q
from hbench.config.files.loading import validate
from hbench.config.import_layout import (
    CHANNELS,
    Column,
    ForeignLoadCell,
    Format,
    check_column,
)
from hbench.config.quantity import ConfigSection
from hbench.config.schedule import Screening
from hbench.records import KINDS, kind_names
from hbench.units import parse_unit, to_si

FIELDS = ("pressure", "load", "speed", "trial")  # of file names


class ImportedCylinder(ConfigSection):
    """The cylinder under test of another bench."""

    piston_diameter: q.Length
    rod_diameter: Annotated[float, q.quantity("mm", ge=0, le=20)] = 0.0
    stroke: q.Length | None = None  # for end_stop; x_m is 0 with the piston fully retracted

    @property
    def area_piston_m2(self) -> float:
        """A_p."""
        return math.pi / 4 * self.piston_diameter**2

    @property
    def area_rod_m2(self) -> float:
        """A_r, the annulus."""
        return math.pi / 4 * (self.piston_diameter**2 - self.rod_diameter**2)

    @model_validator(mode="after")
    def _rod_fits(self) -> "ImportedCylinder":
        if self.rod_diameter >= self.piston_diameter:
            raise ValueError("rod_diameter must be smaller than piston_diameter")
        return self


class FileSeries(ConfigSection):
    """Files that belong together: one cylinder, one label, several trials, loads or speeds.

    ``files`` is a path below the imported folder with fields in braces, each a number:
    ``{pressure}``, ``{load}``, ``{speed}`` in the units given here with at most 12 digits before
    and after the point, and ``{trial}`` with at most 6 digits. The nominal load is ``{load}``, or
    else the pressure times the piston's area, or else there is none. Without ``{trial}`` a file is
    trial 1. Without ``speed`` and ``{speed}`` the nominal speed is the median of the strokes of one
    load and direction, to two digits.
    """

    label: str
    files: str
    cylinder: ImportedCylinder
    pressure_unit: str = "bar"
    load_unit: str = "N"
    speed_unit: str = "mm/s"
    speed: q.Speed | None = None

    @field_validator("files")
    @classmethod
    def _fields(cls, files: str) -> str:
        rest = re.sub(rf"\{{({'|'.join(FIELDS)})\}}", "", files)
        if "{" in rest or "}" in rest:
            words = ", ".join(f"{{{name}}}" for name in FIELDS)
            raise ValueError(f"only {words} are possible in braces")
        if any(files.count(f"{{{name}}}") > 1 for name in FIELDS):
            raise ValueError("a field may occur only once")
        return files

    @model_validator(mode="after")
    def _units(self) -> "FileSeries":
        for name, si in (("pressure", "Pa"), ("load", "N"), ("speed", "m/s")):
            unit = getattr(self, f"{name}_unit")
            if parse_unit(unit).dimension != parse_unit(si).dimension:
                raise ValueError(f"{name}_unit {unit!r} is not a unit of {name}")
        if self.speed is not None and "{speed}" in self.files:
            raise ValueError("speed is given twice, here and in files")
        return self


class ImportMap(ConfigSection):
    """Map for ``hbench import``."""

    name: str
    kind: str = "steady"  # a row of KINDS
    format: Format = Format()
    columns: dict[str, Column] = Field(min_length=2)  # t_s may be missing if files state times
    # Channel: quantity, for channels that are known but not logged. It may contain a field of the
    # file names, as in "{load} N".
    constants: dict[str, str] = {}
    load_cell: ForeignLoadCell | None = None  # f_applied_n is logged as a voltage: C.6
    series: tuple[FileSeries, ...] = Field(min_length=1, max_length=1000)
    repeated_times: Literal["refuse", "drop"] = "refuse"  # drop: the first sample of each counts
    resample: q.Frequency | None = None
    cut: Literal["none", "reversals"] = "none"
    min_stroke: q.Length = 0.01  # shorter strokes are dropped, with a note
    screening: Screening = Screening()

    @field_validator("kind")
    @classmethod
    def _known_kind(cls, kind: str) -> str:
        if kind not in KINDS:
            raise ValueError(f"must be one of {kind_names()}")
        return kind

    def wanted(self, channel: str) -> str:
        """Return a unit of the dimension that a channel's column must have."""
        return "V" if channel == "f_applied_n" and self.load_cell else CHANNELS[channel]

    @model_validator(mode="after")
    def _channels(self) -> "ImportMap":
        for name in (*self.columns, *self.constants):
            if name not in CHANNELS:
                raise ValueError(f"unknown channel '{name}'; known are {', '.join(CHANNELS)}")
        if "x_m" not in self.columns:
            raise ValueError("columns.x_m is missing; the analysis needs it")
        for name, column in self.columns.items():
            for given in (column.column, column.time):
                if isinstance(given, str) and not self.format.header:
                    raise ValueError(
                        f"columns.{name}: {given!r} is a name, but format.header is false"
                    )
            if column.time is not None and (name == "t_s" or "t_s" not in self.columns):
                raise ValueError(f"columns.{name}: time needs columns.t_s, which gives its unit")
            check_column(name, column, self.format, self.wanted(name))
            if column.offset is not None:
                _quantity(f"columns.{name}.offset", column.offset, CHANNELS[name])
        if self.load_cell and "f_applied_n" not in self.columns:
            raise ValueError("load_cell needs columns.f_applied_n")
        return self

    @model_validator(mode="after")
    def _constants(self) -> "ImportMap":
        for name, constant in self.constants.items():
            if name in self.columns:
                raise ValueError(f"{name} stands both in columns and in constants")
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
            text = text.replace(f"{{{name}}}", number)
        return _quantity(f"constants.{channel}", text, CHANNELS[channel])


def _quantity(key: str, value: str, unit: str) -> float:
    try:
        return to_si(value, unit)
    except ValueError as error:
        raise ValueError(f"{key} = {value!r}: {error}") from None


def parse_import_map(data: dict[str, Any], source: str) -> ImportMap:
    """Check the mapping of an import map. Raises ``ConfigError``."""
    return validate(ImportMap, data, source)
