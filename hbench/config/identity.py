"""Identity of a test: the specimen, the order, the oil. Texts for the report; none is computed."""

from datetime import date
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field

from hbench.config.quantity import ConfigSection

_LONGEST = 200  # characters


def _as_text(value: object) -> object:
    if isinstance(value, bool):
        raise ValueError("yes and no, true and false are read as no text: put them between quotes")
    if isinstance(value, (int, float)):
        raise ValueError("is read as a number, which may change it (007): put it between quotes")
    return str(value) if isinstance(value, date) else value


def _printable(text: str) -> str:
    if not text.isprintable() or len(text) > _LONGEST:
        raise ValueError(f"must be printable text of {_LONGEST} characters at most")
    return text


# Also a date.
Text = Annotated[str, BeforeValidator(_as_text), AfterValidator(_printable)]


class SpecimenIdentity(ConfigSection):
    """The cylinder under test."""

    serial: Text = ""
    order: Text = ""
    maker: Text = ""
    bore: Text = ""
    rod: Text = ""
    stroke: Text = ""
    seals: Text = ""
    wear: Text = ""  # run-in, distance travelled


class TestIdentity(ConfigSection):
    """The test itself."""

    __test__ = False  # no test class of pytest

    number: Text = ""
    customer: Text = ""
    operator: Text = ""
    mounting: Text = ""  # campaigns of a cylinder that was not removed between them have the same
    date: Text = ""
    place: Text = ""
    ambient: Text = ""  # temperature, humidity


class Calibration(ConfigSection):
    """Identity of an instrument and of its calibration."""

    serial: Text = ""
    certificate: Text = ""  # number and laboratory
    calibrated: date | None = None
    due: date | None = None


class Identified(ConfigSection):
    """Bench file, schedule or import map, each of which may identify the test."""

    specimen: SpecimenIdentity = Field(default=SpecimenIdentity())
    test: TestIdentity = Field(default=TestIdentity())
