"""The certificate file: laboratory, customer, number, language, and the document's look."""

import re
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from hbench.config.files.loading import validate
from hbench.config.files.regular_file import FileTooLarge, read_regular_file
from hbench.config.identity import Identified, SpecimenIdentity, TestIdentity, Text
from hbench.config.quantity import ConfigSection
from hbench.errors import ConfigError

Language = Literal["en", "de"]

_NUMBER = re.compile(r"[A-Za-z0-9][A-Za-z0-9._/-]{0,59}")  # it is printed in style sheets and XML
_LARGEST_LOGO = 300_000  # bytes
_LARGEST_TEMPLATE = 300_000
_LARGEST_SIDE = 4000  # of a PNG, pixels: a small file can unpack to gigabytes
_PNG = b"\x89PNG\r\n\x1a\n"


def _number(text: str) -> str:
    if text and not _NUMBER.fullmatch(text):
        raise ValueError("must be at most 60 letters, digits and . _ / -")
    return text


Number = Annotated[Text, AfterValidator(_number)]


class Contact(ConfigSection):
    """Laboratory or customer with its address."""

    name: Text = ""
    address: tuple[Text, ...] = Field(default=(), max_length=8)  # lines
    contact: Text = ""  # telephone, e-mail
    country: str = Field(default="", pattern=r"^([A-Z]{2})?$")  # ISO 3166-1, such as DE


class Laboratory(Contact):
    """The laboratory that issues the certificate."""

    name: Text = Field(min_length=1)
    address: tuple[Annotated[Text, Field(min_length=1)], ...] = Field(min_length=1, max_length=8)
    country: str = Field(pattern=r"^[A-Z]{2}$")
    accreditation: Text = ""  # body, number and scope; empty: none is claimed


class Signatory(ConfigSection):
    """Person who authorises the certificate."""

    name: Text = Field(min_length=1)
    role: Text = ""


class CertificateFile(Identified):
    """Certificate file. ``specimen`` and ``test`` add to the sections of the campaign."""

    laboratory: Laboratory
    signatories: tuple[Signatory, ...] = Field(min_length=1, max_length=4)
    customer: Contact = Contact()  # its name: by default test.customer
    number: Number = ""  # empty: derived from the campaign
    replaces: Number = ""  # number of the certificate that this one amends
    issued: date | None = None  # None: today
    received: date | None = None  # when the specimen was received
    language: Language = "en"
    method: Text = ""  # the laboratory's procedure with its issue
    external: Text = ""  # results from external providers
    # Of series, limits, product and schedule: as campaign and limits have it, and as it is printed.
    names: dict[Text, Text] = Field(default={}, max_length=200)
    remarks: tuple[Text, ...] = Field(default=(), max_length=20)
    limits: str | None = (
        None  # file of limits, beside this one: then with a statement of conformity
    )
    logo: str | None = None  # PNG or SVG file, beside this one
    template: str | None = None  # Jinja template that replaces the page's own

    @model_validator(mode="after")
    def _amendments_have_numbers(self) -> "CertificateFile":
        if self.replaces and (not self.number or self.number == self.replaces):
            raise ValueError("an amended certificate ('replaces') needs a 'number' of its own")
        return self


@dataclass(frozen=True)
class Image:
    """Content of an image file."""

    media_type: Literal["image/png", "image/svg+xml"]
    data: bytes


def parse_certificate(data: dict[str, Any], source: str) -> CertificateFile:
    """Check the mapping of a certificate file. Raises ``ConfigError``."""
    return validate(CertificateFile, data, source)


def completed(
    file: CertificateFile, settings: dict[str, Any], source: str
) -> tuple[SpecimenIdentity, TestIdentity]:
    """Return the identity of a campaign with what the certificate file adds.

    ``settings`` are those of the campaign. Raises ``ConfigError`` where the two contradict.
    """
    stated: dict[str, dict[str, str]] = {}
    for section, added in (("specimen", file.specimen), ("test", file.test)):
        recorded = {key: str(value) for key, value in (settings.get(section) or {}).items()}
        extra = {key: value for key, value in added.model_dump().items() if value}
        for key in recorded.keys() & extra.keys():
            if recorded[key] and recorded[key] != extra[key]:
                raise ConfigError(
                    f"{source}: {section}.{key} = {extra[key]!r}: the campaign has "
                    f"{recorded[key]!r}",
                    f"Remove {key!r} from the file: it adds to the campaign's record and cannot "
                    "change it.",
                )
        stated[section] = extra | {key: value for key, value in recorded.items() if value}
    return (
        validate(SpecimenIdentity, stated["specimen"], "specimen"),
        validate(TestIdentity, stated["test"], "test"),
    )


def read_logo(path: Path) -> Image:
    """Return a PNG or SVG file. Raises ``ConfigError``."""
    data = _read(path, _LARGEST_LOGO)
    if data.startswith(_PNG):
        sides = (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big"))
        if not 0 < max(sides) <= _LARGEST_SIDE:
            raise ConfigError(
                f"{path}: has {sides[0]} x {sides[1]} pixels; limit {_LARGEST_SIDE} a side"
            )
        return Image("image/png", data)
    if b"<svg" in data[:2000]:
        return Image("image/svg+xml", data)
    raise ConfigError(f"{path}: is neither a PNG nor an SVG file")


def read_template(path: Path) -> str:
    """Return the text of a template. Raises ``ConfigError``."""
    try:
        return _read(path, _LARGEST_TEMPLATE).decode("utf-8")
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a text file in UTF-8") from None


def _read(path: Path, largest: int) -> bytes:
    try:
        return read_regular_file(path, largest)
    except FileTooLarge as error:
        raise ConfigError(f"{path}: {error}") from None
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror or error}") from None
