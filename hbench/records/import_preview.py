"""Preview of an import: what each file of a folder becomes."""

from dataclasses import dataclass, field

import numpy as np

from hbench.records.runs import ScreenedRun


@dataclass(frozen=True)
class PreviewedRun:
    """A run that a file would become."""

    screened: ScreenedRun
    span_s: tuple[float, float]  # its first and last sample in the file
    at_speed_s: tuple[float, float] | None = None  # at the reference speed; None for no such time


@dataclass(frozen=True)
class PreviewedChannel:
    """A channel of a file: its column, unit and range."""

    name: str  # in the import map
    column: str  # in the file; empty for a constant
    unit_in_file: str
    unit: str  # of ``lowest`` and ``highest``
    lowest: float
    highest: float
    gaps: int  # samples without a value
    zero: float | None = None  # offset that was subtracted
    zero_se: float | None = None  # its standard error


@dataclass(frozen=True)
class PreviewedLog:
    """The samples of a file that is drawn."""

    channels: dict[str, np.ndarray]  # (n,) in SI
    units: dict[str, str]  # of the channels
    block_t_s: np.ndarray  # (k,)
    block_v_m_s: np.ndarray  # (k,) speed between means over blocks
    rest_s: tuple[float, float] | None


@dataclass(frozen=True)
class PreviewedFile:
    """A file whose name matches a series."""

    name: str
    series: str  # its label
    pattern: str  # ``files`` of the series
    fields: dict[str, str]  # values in its name, with units
    error: str = ""  # why it can't be imported
    samples: int = 0
    rate_hz: float = np.nan  # median
    duration_s: float = np.nan
    longest_step_s: float = np.nan
    channels: tuple[PreviewedChannel, ...] = ()
    notes: tuple[str, ...] = ()
    runs: tuple[PreviewedRun, ...] = ()
    log: PreviewedLog | None = None  # of the first file of a series

    @property
    def accepted(self) -> int:
        """Number of accepted runs."""
        return sum(run.screened.accepted for run in self.runs)


@dataclass(frozen=True)
class ImportPreview:
    """What the files of a folder become by an import map."""

    name: str
    folder: str
    map_file: str
    cuts: tuple[str, ...]  # of its series, each once
    files: tuple[PreviewedFile, ...]  # series by series
    refused: bool  # the import would stop: most files have an error, or a series matches none
    unmatched: tuple[str, ...]  # files that match no series
    empty_series: dict[str, str] = field(
        default_factory=dict
    )  # label to ``files``: no file matches

    @property
    def runs(self) -> tuple[PreviewedRun, ...]:
        """The runs of all files."""
        return tuple(run for file in self.files for run in file.runs)
