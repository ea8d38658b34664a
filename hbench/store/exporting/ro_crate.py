"""A campaign with its certificate as RO-Crate 1.1: a folder or ZIP file that describes itself.

``ro-crate-metadata.json`` is JSON-LD; it lists each file with its type, size and SHA-256. The
bytes depend on the campaign only: entries of a ZIP file have a fixed time.
"""

import errno
import hashlib
import json
import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any, Protocol

from hbench.errors import ConfigError
from hbench.records.conformity.certified import RawData
from hbench.store.campaign.folder import JOURNAL, StoredCampaign
from hbench.store.campaign.lock_file import folder_lock
from hbench.store.campaign.raw_logs import raw_files
from hbench.store.files.atomic import (
    move_folder,
    new_file,
    refused,
    temporary_folder,
    whole_file,
)
from hbench.store.files.bounded_read import LARGEST_JOURNAL, read_file

METADATA = "ro-crate-metadata.json"
_CONTEXT = "https://w3id.org/ro/crate/1.1/context"
_PROFILE = "https://w3id.org/ro/crate/1.1"
_TIME = (1980, 1, 1, 0, 0, 0)  # of a ZIP file's entries
_TYPES = {
    ".csv": "text/csv",
    ".dat": "text/plain",  # lines of a Code Composer Studio data file
    ".html": "text/html",
    ".json": "application/json",
    ".xml": "application/xml",
    ".yaml": "application/yaml",
}
_ABOUT = {
    JOURNAL: "Record of the campaign: bench, schedule, versions, start and end of each run, "
    "SHA-256 of each log",
    "certificate.html": "Certificate for readers",
    "certificate.xml": "Certificate as digital calibration certificate (PTB DCC 3.3.0)",
    "results.json": "All results of the analysis in SI units (schema hbench.results/1)",
}


@dataclass(frozen=True)
class Described:
    """What the archive says of itself."""

    name: str
    description: str
    number: str  # of the certificate
    published: date
    publisher: str
    raw: RawData


class _Target(Protocol):
    def __call__(self, name: str, data: bytes) -> None: ...


def write_crate(
    output: Path, campaign: StoredCampaign, derived: Mapping[str, bytes], about: Described
) -> None:
    """Write logs, record and ``derived`` files; a ZIP file if ``output`` ends in ``.zip``.

    File or folder appear under their name once all is written.

    Raises ``ConfigError`` if the folder exists, ``DataError`` if it can't be written.
    """
    with _target(output) as put:
        entities = []
        for name, data in _files(campaign, derived):
            put(name, data)
            entities.append(_entity(name, data))
        put(METADATA, _metadata(entities, about))


def _files(campaign: StoredCampaign, derived: Mapping[str, bytes]) -> Iterator[tuple[str, bytes]]:
    yield JOURNAL, read_file(campaign.folder / JOURNAL, LARGEST_JOURNAL)
    yield from sorted(derived.items())
    yield from raw_files(campaign)


def _target(output: Path) -> AbstractContextManager[_Target]:
    return _zip(output) if output.suffix.lower() == ".zip" else _folder(output)


@contextmanager
def _zip(output: Path) -> Iterator[_Target]:
    with whole_file(output) as file, zipfile.ZipFile(file, "w") as archive:

        def put(name: str, data: bytes) -> None:
            entry = zipfile.ZipInfo(name, _TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data)

        yield put


@contextmanager
def _folder(output: Path) -> Iterator[_Target]:
    """Write to a hidden folder beside ``output``, locked, that gets its name when it is whole."""
    part = output.with_name(f".{output.name}.part")
    files = part / output.name

    def put(name: str, data: bytes) -> None:
        with new_file(files / name) as file:
            file.write(data)

    if part.is_symlink():
        raise refused(part, OSError(errno.ELOOP, os.strerror(errno.ELOOP)))
    with folder_lock(part, f"{output}: another hbench is writing this archive"):
        if output.exists():
            raise ConfigError(f"{output}: exists already", "Choose another folder.")
        with temporary_folder(files):
            yield put
            move_folder(files, output)
    with suppress(OSError):  # of an hbench that was killed
        part.rmdir()


def _entity(name: str, data: bytes) -> dict[str, Any]:
    suffix = Path(name).suffix
    return {
        "@id": name,
        "@type": "File",
        "name": name,
        "description": _ABOUT.get(name, "Raw log of a run"),
        "contentSize": str(len(data)),
        "encodingFormat": _TYPES[suffix],
        "sha256": hashlib.sha256(data).hexdigest(),
    }


def _metadata(entities: list[dict[str, Any]], about: Described) -> bytes:
    publisher = {"@id": "#laboratory", "@type": "Organization", "name": about.publisher}
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": about.name,
        "description": about.description,
        "identifier": about.number,
        "datePublished": about.published.isoformat(),
        "publisher": {"@id": "#laboratory"},
        "license": "Not licensed: the laboratory and its customer decide on the use of the data.",
        "sha256": about.raw.sha256,
        "hasPart": [{"@id": entity["@id"]} for entity in entities],
    }
    descriptor = {
        "@id": METADATA,
        "@type": "CreativeWork",
        "conformsTo": {"@id": _PROFILE},
        "about": {"@id": "./"},
    }
    # RO-Crate's context has no term for a checksum: this is its own extension.
    context = [_CONTEXT, {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}]
    graph = [descriptor, root, publisher, *entities]
    text = json.dumps({"@context": context, "@graph": graph}, indent=1, ensure_ascii=False)
    return (text + "\n").encode()
