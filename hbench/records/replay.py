"""Simulation of a campaign's runs under the measured valve commands."""

from dataclasses import dataclass
from typing import Any

from hbench.records.flow import Provenance, Run


@dataclass(frozen=True)
class SignalError:
    """Root mean square error of a simulated signal, in ``unit``."""

    signal: str
    unit: str
    off: float  # over all runs
    worst: float  # of the worst run
    worst_run: str


@dataclass(frozen=True)
class Replay:
    """SIMULATED runs of a model under measured valve commands and supply pressure."""

    provenance: Provenance  # of the measured campaign
    model: str  # file name
    bench: dict[str, Any]  # the campaign's bench file, under a name that says simulated
    runs: tuple[Run, ...]  # labelled as simulated; commands and supply are the measured ones
    off: tuple[SignalError, ...]  # by signal
    left_out: tuple[str, ...]  # runs that could not be simulated, each with its reason
