"""Checksums of logs and of the journal's parts, which show whether one was edited later.

An edit can be intended, such as a corrected load cell level, so it is reported and not refused.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

SECTIONS = ("source", "bench", "schedule", "map", "settings", "log")  # the results depend on these


def sha256(data: bytes) -> str:
    """Return the checksum by which the journal identifies a file."""
    return hashlib.sha256(data).hexdigest()


def content_checksum(content: Any) -> str:
    """Return the SHA-256 of parsed YAML; layout and comments of the text do not count."""
    text = json.dumps(content, default=str, separators=(",", ":"))
    return sha256(text.encode())


def section_checksums(header: Mapping[str, Any]) -> dict[str, str]:
    """Return the checksum of each section that the header contains."""
    return {name: content_checksum(header[name]) for name in SECTIONS if name in header}


def edited_sections(header: Mapping[str, Any], checksums: Any) -> list[str]:
    """Return the sections whose checksum has changed; none for a journal without checksums."""
    if not isinstance(checksums, Mapping):
        return []
    return [name for name in SECTIONS if _checksum(header.get(name)) != checksums.get(name)]


def _checksum(content: Any) -> str | None:
    return None if content is None else content_checksum(content)
