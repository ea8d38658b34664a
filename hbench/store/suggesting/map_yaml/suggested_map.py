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
from hbench.units import ANGLES, parse_unit

_PNEUMATIC_PA = 1.2e6  # a higher pressure is hydraulic


@dataclass(frozen=True)
class SuggestedSeries:
    """Files of one pattern."""

    pattern: NamePattern
    bore_m: float | None = None  # by the balance of forces
    fault: str = ""  # why the map can't read them
    # Factors with their values in the files that were read.
    factors: Mapping[ColumnFactor, tuple[float, ...]] = field(default_factory=dict)
    motion: Motion | None = None


def usual_motion(of_all: Motion | None, series: Sequence[SuggestedSeries]) -> Motion | None:
    """Return the motion of all files if it is that of each series, else of the largest series."""
    known = [each for each in series if each.motion is not None]
    if of_all is None or all(_alike(each.motion, of_all) for each in known):
        return of_all
    return max(known, key=lambda each: len(each.pattern.names)).motion


def _alike(one: Motion | None, other: Motion | None) -> bool:
    if one is None or other is None:
        return True
    return (one.kind, one.cut) == (other.kind, other.cut)


@dataclass(frozen=True)
class SuggestedMap:
    """Content of a suggested map."""

    folder: str
    files: tuple[str, ...]  # that were read
    speeds_m_s: Mapping[str, tuple[float, ...]]  # sizes of the constant speeds in each of these
    count: int  # of all files
    format_name: str
    layout: Format | None
    time: TimeChoice
    choices: Mapping[str, Choice]
    units_in_file: Mapping[int | str, str]
    columns: Sequence[SampleColumn]
    motion: Motion | None  # of all files, or of the series with most files where they differ
    series: tuple[SuggestedSeries, ...]
    unread: Mapping[str, str]  # columns that are no numbers: name, and file with the first fault
    left_out: Mapping[str, tuple[str, ...]]  # other columns of a chosen channel

    def other_motion(self, series: SuggestedSeries) -> Motion | None:
        """Return the motion of a series whose kind or cut is not that of the map."""
        return None if _alike(series.motion, self.motion) else series.motion

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
