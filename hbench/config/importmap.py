"""The import map: how another bench's files become runs."""

from typing import Any, Literal

from pydantic import Field, model_validator

from hbench.config import quantity as q
from hbench.config.loading import validate
from hbench.config.quantity import Section
from hbench.config.schedule import Screening
from hbench.units import parse_unit

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


class Column(Section):
    """Where a channel stands in a file, and its unit. ``scale: -1`` turns its sign."""

    column: int | str  # number from 1, or the header's name
    unit: str
    scale: float = 1.0


class Format(Section):
    """The dialect of the files."""

    separator: Literal["comma", "semicolon", "tab", "whitespace"] = "comma"
    header: bool = True
    skip_rows: int = Field(default=0, ge=0, le=100_000)  # data rows to drop at the start
    decimal: Literal[".", ","] = "."


class ImportedCylinder(Section):
    """The cylinder under test of another bench."""

    piston_diameter: q.Length
    rod_diameter: q.quantity("mm", ge=0, le=20) = 0.0


class Series(Section):
    """Files that belong together: one cylinder, one label, several trials or pressures.

    ``files`` is a path below the imported folder with fields: ``{pressure}`` (in ``pressure_unit``)
    and ``{trial}``, each a number. Without ``{trial}`` a file is trial 1.
    """

    label: str
    files: str
    cylinder: ImportedCylinder
    pressure_unit: str = "bar"


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
        for name in ("t_s", "x_m"):
            if name not in self.columns:
                raise ValueError(f"columns.{name} is missing; nothing can be analyzed without it")
        for name, column in self.columns.items():
            if parse_unit(column.unit).dimension != parse_unit(CHANNELS[name]).dimension:
                raise ValueError(
                    f"columns.{name}: unit {column.unit!r} is not one of {CHANNELS[name]}"
                )
        return self


def parse_import_map(data: dict[str, Any], source: str) -> ImportMap:
    """Check the mapping of an import map. Raises ``ConfigError``."""
    return validate(ImportMap, data, source)
