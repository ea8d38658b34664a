"""Parts of an import map: the dialect of a text, the columns of its channels, the actuator."""

import math
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from hbench.config import quantity as q
from hbench.config.quantity import ConfigSection, QuantityText, SignedVoltage
from hbench.config.sensors import LoadCell
from hbench.units import parse_unit

ROTARY = {"m": "rad", "m/s": "rad/s", "N": "N m"}  # units of a rotary actuator's channels
# By the unit of a channel: larger values are no measurements.
LIMITS = {"s": 1e12, "m": 1e3, "m/s": 1e3, "Pa": 1e11, "N": 1e10, "V": 1e6, "K": 473.15}
LEAST = {"K": 193.15}  # smaller values are no measurements
LONGEST_S = 1e6  # from a file's first sample to its last
ALWAYS = ("t_s", "x_m")  # required, without gaps
DATE_TIME = "date-time"  # the unit of times such as 2024-05-01T12:00:00.25


ColumnName = Annotated[q.WholeNumber, Field(ge=1)] | str


class Column(ConfigSection):
    """Column of a channel: its value is ``number * scale`` in ``unit``, plus ``offset``.

    Without ``unit`` the column has the channel's name and is in SI, or the file has a row of units.
    ``column`` is a number from 1, a header's name, or in a MATLAB file a path as MATLAB writes it:
    ``data.p``, ``runs(2).log.t_s``, ``M(:,3)``. ``time`` is the column of its times, with the unit
    of ``t_s``, if they are not those of ``t_s``.
    """

    column: ColumnName
    time: ColumnName | None = None
    unit: str | None = None
    scale: q.AnyNumber = Field(default=1.0, allow_inf_nan=False)
    offset: QuantityText | None = None  # a quantity: "-1.25 bar"
    # rest: its mean at rest before the motion is subtracted; none: the values are taken as they are
    zero: Literal["rest", "none"] = "none"

    @field_validator("scale")
    @classmethod
    def _not_zero(cls, scale: float) -> float:
        if scale == 0:
            raise ValueError("must not be 0")
        return scale


class Format(ConfigSection):
    """Dialect of text files and sheets; other formats need none.

    Blank lines and lines that begin with ``comment`` are skipped. The character set is determined
    from the file: UTF-8, UTF-16, or else Windows-1252.
    """

    separator: Literal["comma", "semicolon", "tab", "whitespace"] = "comma"
    header: bool = True
    preamble: q.WholeNumber = Field(default=0, ge=0, le=100_000)  # lines before the header
    units_row: bool = False  # the row under the header holds units
    skip_rows: q.WholeNumber = Field(default=0, ge=0, le=100_000)  # data rows to drop at the start
    decimal: Literal[".", ","] = "."  # a decimal comma beside separator comma needs quotes
    thousands: Literal[".", ",", "'", " "] | None = None
    comment: str | None = Field(default=None, min_length=1, max_length=3)
    sheet: str | None = None  # of an Excel workbook; otherwise its first one

    @model_validator(mode="after")
    def _unambiguous(self) -> "Format":
        if self.thousands == self.decimal:
            raise ValueError(f"thousands and decimal are both {self.decimal!r}")
        if self.thousands == " " and self.separator == "whitespace":
            raise ValueError("thousands ' ' and separator whitespace are ambiguous")
        if self.units_row and not self.header:
            raise ValueError("units_row needs a header, but header is false")
        return self


class ForeignLoadCell(LoadCell):
    """A strain-gauge load cell (equation C.6) of which a log holds the voltage."""

    level: SignedVoltage = 0.0


def check_column(name: str, column: Column, layout: Format, wanted: str) -> None:
    """Raise ``ValueError`` for a column that can't give a channel in ``wanted``'s dimension."""
    if column.unit is None:
        own = str(column.column).rsplit(".")[-1] == name
        if not own and not layout.units_row:
            raise ValueError(
                f"columns.{name}: unit is missing; only a column named {name} is in SI without one"
            )
    elif name == "t_s" and column.unit == DATE_TIME:
        if column.scale != 1.0 or column.offset is not None:
            raise ValueError("columns.t_s: date-times have neither scale nor offset")
    elif parse_unit(column.unit).dimension != parse_unit(wanted).dimension:
        raise ValueError(
            f"columns.{name}: unit {column.unit!r} is not one of {wanted}; for a signal write "
            f"'unit: {wanted}' and a scale, the number of {wanted} for 1 {column.unit}"
        )
    if column.zero == "rest" and (name in ("t_s", "x_m") or name.startswith("temp_")):
        raise ValueError(f"columns.{name}: zero: rest is not possible for this channel")


Area = Annotated[float, q.quantity("mm^2", gt=0, le=10)]
RodArea = Annotated[float, q.quantity("mm^2", ge=0, le=10)]
Displacement = Annotated[float, q.quantity("cm^3", gt=0, le=1)]  # a radian has no dimension


class ImportedCylinder(ConfigSection):
    """The actuator under test of another bench, by diameters, areas or displacement.

    ``displacement`` is the volume for one radian of a rotary actuator with equal sides.
    """

    piston_diameter: q.Length | None = None
    rod_diameter: Annotated[float, q.quantity("mm", ge=0, le=20)] = 0.0
    piston_area: Area | None = None
    rod_area: RodArea | None = None  # of the rod side, the annulus
    displacement: Displacement | None = None
    stroke: q.Length | None = None  # for end_stop; x_m is 0 with the piston fully retracted

    @property
    def rotary(self) -> bool:
        """Whether positions are angles and forces torques."""
        return self.displacement is not None

    @property
    def area_piston_m2(self) -> float:
        """A_p, or the displacement of a radian [m^3]; 0 if neither is known."""
        if self.piston_diameter is not None:
            return math.pi / 4 * self.piston_diameter**2
        return self.displacement or self.piston_area or 0.0

    @property
    def area_rod_m2(self) -> float:
        """A_r, the annulus, or the displacement of a radian [m^3]."""
        if self.piston_diameter is not None:
            return math.pi / 4 * (self.piston_diameter**2 - self.rod_diameter**2)
        return self.displacement or self.rod_area or 0.0

    @property
    def known(self) -> bool:
        """Whether it is a hydraulic actuator: it has a size."""
        return self.area_piston_m2 > 0.0

    @model_validator(mode="after")
    def _one_size(self) -> "ImportedCylinder":
        given = [
            name
            for name in ("piston_diameter", "piston_area", "displacement")
            if getattr(self, name) is not None
        ]
        if len(given) != 1:
            raise ValueError(
                "give one of piston_diameter (with rod_diameter), piston_area (with rod_area) and "
                f"displacement; found {' and '.join(given) or 'none'}"
            )
        if given == ["piston_diameter"] and self.rod_diameter >= (self.piston_diameter or 0):
            raise ValueError(
                "rod_diameter must be smaller than piston_diameter; for a plunger, without a rod "
                "side, leave it out and write p_tr_pa: 0 bar under constants"
            )
        if self.rod_area is not None and given != ["piston_area"]:
            raise ValueError("rod_area needs piston_area")
        if (self.rod_area or 0.0) > (self.piston_area or math.inf):
            raise ValueError("rod_area, the annulus, must not be larger than piston_area")
        if self.rod_diameter and given != ["piston_diameter"]:
            raise ValueError("rod_diameter needs piston_diameter")
        return self


NO_CYLINDER = ImportedCylinder.model_construct()
