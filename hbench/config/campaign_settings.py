"""What the analysis of foreign logs needs besides them: screening limits, instruments, chambers."""

from typing import Any

from pydantic import Field, field_validator

from hbench.config import quantity as q
from hbench.config.bench import Bench
from hbench.config.files.loading import validate
from hbench.config.identity import Identified
from hbench.config.oil.record import OilRecord
from hbench.config.quantity import ConfigSection
from hbench.config.schedule import Screening
from hbench.config.sensors import Instruments


class Chambers(ConfigSection):
    """Effective bulk modulus of the oil, and the volumes that remain at the ends of the stroke.

    A dead volume includes everything up to the closed valves: ports, pipes and hoses.
    """

    bulk_modulus: q.BulkModulus
    dead_volume_piston: q.Volume
    dead_volume_rod: q.Volume = 0.0  # of a plunger there is none

    @classmethod
    def of(cls, bench: Bench) -> "Chambers":
        """Return the chambers that a bench file states."""
        cylinder = bench.test_cylinder
        return cls.model_construct(
            bulk_modulus=bench.oil.bulk_modulus,
            dead_volume_piston=cylinder.dead_volume_piston,
            dead_volume_rod=cylinder.dead_volume_rod,
        )


class CampaignSettings(Identified):
    """Settings of an imported campaign: of its map, or the ``settings.yaml`` of an export."""

    instruments: Instruments | None = None  # tolerances, for the expanded uncertainty
    oil: OilRecord = OilRecord()
    moving_mass: q.Mass | None = None  # of the test side: piston, rod and what they carry
    chambers: Chambers | None = None  # for the leakage of holds
    # Anything else that identifies the test, printed in the report: oil, temperature, ...
    details: dict[str, str] = Field(default={}, max_length=30)
    screening: Screening = Screening()
    simulated: bool = False  # the runs were computed: exports of simulated campaigns state it

    @field_validator("details")
    @classmethod
    def _printable(cls, details: dict[str, str]) -> dict[str, str]:
        for name, text in details.items():
            if not (name + text).isprintable() or len(name) > 40 or len(text) > 200:
                raise ValueError(f"{name[:40]!r}: must be printable text of 200 characters at most")
        return details


class ExportedSettings(CampaignSettings):
    """The ``settings.yaml`` of an export, which has no map."""

    rotary: bool = False  # 1 m of the numbers stands for 1 rad, 1 N for 1 N m


def parse_settings(data: dict[str, Any], source: str) -> ExportedSettings:
    """Check the mapping of a settings file. Raises ``ConfigError``."""
    return validate(ExportedSettings, data, source)
