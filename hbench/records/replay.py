"""A measured campaign's runs as a model makes them under the same valve commands."""

from dataclasses import dataclass
from typing import Any

from hbench.records.flow import Provenance, Run


@dataclass(frozen=True)
class Off:
    """How far a signal of the model is from the measured one: root mean square, in ``unit``."""

    signal: str
    unit: str
    off: float  # over all runs
    worst: float  # of the run that is furthest off
    worst_run: str


@dataclass(frozen=True)
class Replay:
    """What a model makes of measured valve commands and supply pressure: SIMULATED runs."""

    provenance: Provenance  # of the measured campaign
    model: str  # file name
    bench: dict[str, Any]  # the campaign's bench file, under a name that says simulated
    runs: tuple[Run, ...]  # labelled as simulated; commands and supply are the measured ones
    off: tuple[Off, ...]  # by signal
    left_out: tuple[str, ...]  # runs that could not be simulated, each with its reason
