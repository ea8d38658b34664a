"""The certificate as a record: everything that its forms (page, PDF, DCC) are made of."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date, datetime

from hbench.config.conformity.certificate import CertificateFile, Image
from hbench.config.identity import Calibration, SpecimenIdentity, TestIdentity
from hbench.config.sensors import ForceInstrument, Instruments, PressureInstrument
from hbench.records import Results
from hbench.records.conformity.acceptance import Acceptance, LimitQuantity
from hbench.records.conformity.certified import Certified, RawData
from hbench.report.conformity.certificate.words import WORDS

SIMULATED = "SIM-"  # begins the number of a simulated campaign's document
_DIGITS = 10  # of the checksum in a derived number: 40 bits


@dataclass(frozen=True)
class Certificate:
    """Content of a certificate, in SI and without words of a language."""

    file: CertificateFile
    issued: date
    specimen: SpecimenIdentity
    test: TestIdentity
    results: Results
    values: tuple[Certified, ...]
    all_speeds: bool  # whether every measured speed is among the values
    instruments: Instruments | None  # None: their errors are not known
    raw: RawData
    acceptance: Acceptance | None  # None: no limits were given
    warnings: tuple[str, ...] = ()  # of the campaign's record
    logo: Image | None = None

    @property
    def simulated(self) -> bool:
        """Whether no cylinder was measured."""
        return self.results.provenance.source == "simulated"

    @property
    def number(self) -> str:
        """Number of the file; or of the date and the checksum of all that the document states."""
        begin = SIMULATED if self.simulated else ""
        return begin + (self.file.number or self._derived_number())

    def _derived_number(self) -> str:
        stated = (
            self.raw.sha256,
            self.raw.record_sha256,
            self.file.model_dump_json(),
            self.acceptance.limits_sha256 if self.acceptance else "",
            self.issued.isoformat(),
        )
        digest = hashlib.sha256("\n".join(stated).encode()).hexdigest()
        return f"HB-{self.issued:%Y%m%d}-{digest[:_DIGITS].upper()}"

    @property
    def customer_name(self) -> str:
        """Name of the customer, of the certificate file or of the campaign."""
        return self.file.customer.name or self.test.customer

    @property
    def performed(self) -> tuple[date, date] | None:
        """First and last day of the test; None for imported runs without a date (ISO 8601)."""
        provenance = self.results.provenance
        if self.test.date:
            days = [_day(part) for part in self.test.date.replace(" to ", "/").split("/")]
        elif provenance.source == "imported":
            return None
        else:
            days = [_day(provenance.started), _day(provenance.stopped or provenance.started)]
        known = [day for day in days if day is not None]
        return (min(known), max(known)) if known and len(known) == len(days) else None

    @property
    def has_no_load(self) -> bool:
        """Whether an efficiency without load was measured, which is not among the values."""
        return any(
            curve.f_load_n == 0 and any(point.efficiency is not None for point in curve.points)
            for curve in self.results.efficiency
        )

    def of(self, quantity: LimitQuantity) -> tuple[Certified, ...]:
        """Return the values of a quantity."""
        return tuple(value for value in self.values if value.quantity == quantity)

    def word(self, key: str, **values: str | int) -> str:
        """Return words of the certificate's language."""
        return WORDS[self.file.language][key].format(**values)

    def named(self, name: str) -> str:
        """Return a name of the campaign or of the limits as the certificate file prints it."""
        return self.file.names.get(name, name)

    def calibrations(
        self,
    ) -> Iterator[tuple[str, ForceInstrument | PressureInstrument, Calibration]]:
        """Yield the instruments by their word's key, with their calibrations."""
        if self.instruments is not None:
            yield "force", self.instruments.force, self.instruments.force.calibration
            yield "pressure", self.instruments.pressure, self.instruments.pressure.calibration

    @property
    def missing(self) -> tuple[str, ...]:
        """Keys that ISO/IEC 17025 asks for and neither campaign nor file states."""
        stated = {
            "customer.name": self.customer_name,
            "customer.address": self.file.customer.address,
            "specimen.serial": self.specimen.serial,
            "test.date": self.test.date or self.performed,
            "test.place": self.test.place,
            "test.ambient": self.test.ambient,
            "method": self.file.method,
            "instruments": self.instruments,
        }
        calibrations = {
            f"instruments.{key}.calibration.certificate": calibration.certificate
            for key, _, calibration in self.calibrations()
        }
        return tuple(key for key, value in (stated | calibrations).items() if not value)


def _day(text: str) -> date | None:
    try:
        return datetime.fromisoformat(text.strip()).date()
    except ValueError:
        return None
