"""Content of a suggested import map."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from hbench.config.import_layout import Format
from hbench.store.suggesting.choice import Choice
from hbench.store.suggesting.factors import ColumnFactor
from hbench.store.suggesting.file_names import NamePattern
from hbench.store.suggesting.motion import Motion
from hbench.store.suggesting.samples import SampleColumn
from hbench.store.suggesting.time_base import TimeChoice
from hbench.store.suggesting.units import ANGLES
from hbench.units import parse_unit

_PNEUMATIC_PA = 1.2e6  # a higher pressure is hydraulic


@dataclass(frozen=True)
class SuggestedSeries:
    """Files of one pattern."""

    pattern: NamePattern
    bore_m: float | None = None  # by the balance of forces
    fault: str = ""  # why the map can't read them
    # Factors with their values in the files that were read.
    factors: Mapping[ColumnFactor, tuple[float, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class SuggestedMap:
    """Content of a suggested map."""

    folder: str
    files: tuple[str, ...]  # that were read
    count: int  # of all files
    format_name: str
    layout: Format | None
    time: TimeChoice
    choices: Mapping[str, Choice]
    units_in_file: Mapping[int | str, str]
    columns: Sequence[SampleColumn]
    motion: Motion | None
    series: tuple[SuggestedSeries, ...]
    unread: Mapping[str, str]  # columns that are no numbers: name, and file with the first fault
    left_out: Mapping[str, tuple[str, ...]]  # other columns of a chosen channel

    @property
    def is_rotary(self) -> bool:
        """Whether the position is an angle."""
        return "x_m" in self.choices and self.choices["x_m"].unit in ANGLES

    @property
    def is_driven(self) -> bool:
        """Whether a drive without hydraulics moves the specimen, which has no cylinder then."""
        return "f_drive_n" in self.choices

    @property
    def assumed_constants(self) -> tuple[str, ...]:
        """Channels with an assumed constant: the open side of a pneumatic cylinder."""
        pressures = [channel for channel in ("p_tp_pa", "p_tr_pa") if channel in self.choices]
        if pressures != ["p_tp_pa"]:
            return ()
        choice = self.choices["p_tp_pa"]
        highest = max(abs(choice.column.known)) * parse_unit(choice.unit).factor
        return ("p_tr_pa",) if highest < _PNEUMATIC_PA else ()
