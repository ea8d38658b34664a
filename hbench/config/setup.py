"""What is known of the bench that made a campaign: all of it, or what an import map states."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from hbench.config.bench import Bench
from hbench.config.campaign_settings import CampaignSettings, Chambers
from hbench.config.oil.record import OilRecord
from hbench.config.sensors import Instruments


class Reach(NamedTuple):
    """Highest speed and chamber pressure that a bench can measure at; infinite if not known."""

    speed_m_s: float = math.inf
    pressure_pa: float = math.inf


ANYWHERE = Reach()


@dataclass(frozen=True)
class Setup:
    """Instruments, moving mass, oil and chambers of a campaign; None where they are not known."""

    bench: Bench | None  # None: imported without a bench file
    instruments: Instruments | None
    test_mass_kg: float | None  # of the test side: piston, rod and what they carry
    oil: OilRecord = OilRecord()
    chambers: Chambers | None = None

    @property
    def reach(self) -> Reach:
        """Speed and pressure up to which the bench's limits and its supply allow a schedule."""
        if self.bench is None:
            return ANYWHERE
        limits = self.bench.limits
        pressure = min(self.bench.supply.pressure, limits.pressure_max)
        return Reach(limits.highest_reference, pressure)

    @classmethod
    def of(cls, bench: Bench | None, rules: CampaignSettings | None) -> "Setup":
        """Return the set-up of a bench file, or else that of an import map or a settings file."""
        if bench is not None:
            mass_kg = bench.moving_mass.test
            return cls(bench, bench.instruments, mass_kg, bench.oil, Chambers.of(bench))
        if rules is not None:
            return cls(None, rules.instruments, rules.moving_mass, rules.oil, rules.chambers)
        return cls(None, None, None)
