"""The import map: how another bench's files become runs."""

import math
import re
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from hbench.config import quantity as q
from hbench.config.loading import validate
from hbench.config.quantity import Section
from hbench.config.schedule import Screening
from hbench.units import parse_unit, to_si

# Channels a map can fill, and the unit that each ends in.
CHANNELS = {
    "t_s": "s",
    "x_m": "m",
    "v_m_s": "m/s",
    "p_tp_pa": "Pa",
    "p_tr_pa": "Pa",
    "p_lp_pa": "Pa",
    "p_lr_pa": "Pa",
    "p_s_pa": "Pa",
    "f_applied_n": "N",
    "u_t_v": "V",
    "u_l1_v": "V",
    "u_l2_v": "V",
    "v_ref_m_s": "m/s",
    "p_lr_ref_pa": "Pa",
    "p_lp_ref_pa": "Pa",
}
ALWAYS = ("t_s", "x_m")  # without these nothing can be analyzed; no gaps in them


class Column(Section):
    """Where a channel stands in a file, and its unit. ``scale: -1`` turns its sign."""

    column: Annotated[int, Field(ge=1)] | str  # number from 1, or the header's name
    unit: str
    scale: float = 1.0


class Format(Section):
    """The dialect of the files."""

    separator: Literal["comma", "semicolon", "tab", "whitespace"] = "comma"
    header: bool = True
    skip_rows: int = Field(default=0, ge=0, le=100_000)  # data rows to drop at the start
    decimal: Literal[".", ","] = "."

    @model_validator(mode="after")
    def _unambiguous(self) -> "Format":
        if self.decimal == "," and self.separator == "comma":
            raise ValueError("decimal ',' can't be told from separator comma")
        return self


class ImportedCylinder(Section):
    """The cylinder under test of another bench."""

    piston_diameter: q.Length
    rod_diameter: q.quantity("mm", ge=0, le=20) = 0.0

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


class Series(Section):
    """Files that belong together: one cylinder, one label, several trials or pressures.

    ``files`` is a path below the imported folder with fields: ``{pressure}`` (in ``pressure_unit``)
    and ``{trial}``, each a number. The nominal load is the pressure times the piston's area;
    without ``{pressure}`` there is none. Without ``{trial}`` a file is trial 1. Without ``speed``
    the nominal speed is the median of the strokes of one load and direction, to two digits.
    """

    label: str
    files: str
    cylinder: ImportedCylinder
    pressure_unit: str = "bar"
    speed: q.Speed | None = None

    @field_validator("files")
    @classmethod
    def _fields(cls, files: str) -> str:
        rest = re.sub(r"\{(pressure|trial)\}", "", files)
        if "{" in rest or "}" in rest:
            raise ValueError("only {pressure} and {trial} can stand in braces")
        if any(files.count(name) > 1 for name in ("{pressure}", "{trial}")):
            raise ValueError("a field can stand there once")
        return files

    @field_validator("pressure_unit")
    @classmethod
    def _pressure(cls, unit: str) -> str:
        if parse_unit(unit).dimension != parse_unit("Pa").dimension:
            raise ValueError("is not a unit of pressure")
        return unit


class ImportMap(Section):
    """A map for ``hbench import``."""

    name: str
    kind: Literal["steady", "ramp", "triangle", "steps", "hold", "verification"] = "steady"
    format: Format = Format()
    columns: dict[str, Column] = Field(min_length=2)
    constants: dict[str, str] = {}  # channel: quantity, for what is known but not logged
    series: tuple[Series, ...] = Field(min_length=1, max_length=1000)
    cut: Literal["none", "reversals"] = "none"
    min_stroke: q.Length = 0.01  # shorter pieces between reversals are dropped, and said so
    screening: Screening = Screening()

    @model_validator(mode="after")
    def _channels(self) -> "ImportMap":
        for name in (*self.columns, *self.constants):
            if name not in CHANNELS:
                raise ValueError(f"unknown channel '{name}'; known are {', '.join(CHANNELS)}")
        for name in ALWAYS:
            if name not in self.columns:
                raise ValueError(f"columns.{name} is missing; nothing can be analyzed without it")
        for name, constant in self.constants.items():
            if name in self.columns:
                raise ValueError(f"{name} stands both in columns and in constants")
            try:
                to_si(constant, CHANNELS[name])
            except ValueError as error:
                raise ValueError(f"constants.{name} = {constant!r}: {error}") from None
        for name, column in self.columns.items():
            if isinstance(column.column, str) and not self.format.header:
                raise ValueError(
                    f"columns.{name}: {column.column!r} is a name, but format.header is false"
                )
            if parse_unit(column.unit).dimension != parse_unit(CHANNELS[name]).dimension:
                raise ValueError(
                    f"columns.{name}: unit {column.unit!r} is not one of {CHANNELS[name]}"
                )
        return self


def parse_import_map(data: dict[str, Any], source: str) -> ImportMap:
    """Check the mapping of an import map. Raises ``ConfigError``."""
    return validate(ImportMap, data, source)
