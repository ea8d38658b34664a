"""Measured values as a certificate states them. All quantities are SI."""

from dataclasses import dataclass

from hbench.records.conformity.acceptance import LimitQuantity, Measurement
from hbench.records.motions import Leak

# Stated wherever they were measured; the others only where a limit was decided.
CERTIFIED_QUANTITIES: tuple[LimitQuantity, ...] = (
    "friction",
    "breakaway",
    "efficiency",
    "leakage",
)


@dataclass(frozen=True)
class Certified:
    """Measured value with its expanded uncertainty (``measurement.u95``) and coverage factor."""

    quantity: LimitQuantity
    measurement: Measurement  # N, 1, or m^3/(s Pa) of a leak
    k: float | None  # None: not known, or without an uncertainty
    pressure_pa: float | None = None  # a force as the pressure on the driving area
    pressure_u95_pa: float | None = None
    leak: Leak | None = None

    @property
    def has_table(self) -> bool:
        """Whether a certificate has a table of its quantity; others are with their decisions."""
        return self.quantity in CERTIFIED_QUANTITIES


@dataclass(frozen=True)
class RawData:
    """The raw logs of a campaign: names, sizes and checksums."""

    logs: tuple["RawLog", ...]
    sha256: str  # of the lines of sha256sum, sorted by name
    record_sha256: str  # of campaign.yaml


@dataclass(frozen=True)
class RawLog:
    """A file of raw data."""

    name: str  # path below the campaign's folder
    size: int  # bytes
    sha256: str
