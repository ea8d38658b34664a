"""Hashes by which the journal tells that a part of it was edited after it was written.

An edit may be meant, such as a load cell's corrected level, so it is told and not refused.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

SECTIONS = ("source", "bench", "schedule", "map", "log")  # what the numbers depend on


def seal(content: Any) -> str:
    """Return the hash of what YAML text says: not of its layout or comments."""
    text = json.dumps(content, default=str, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def sealed_sections(header: Mapping[str, Any]) -> dict[str, str]:
    """Return the hash of each section that is there."""
    return {name: seal(header[name]) for name in SECTIONS if name in header}


def edited_sections(header: Mapping[str, Any], seals: Any) -> list[str]:
    """Return the sections that are not as they were sealed; none where nothing was."""
    if not isinstance(seals, Mapping):
        return []
    return [name for name in SECTIONS if _seal_or_none(header.get(name)) != seals.get(name)]


def _seal_or_none(content: Any) -> str | None:
    return None if content is None else seal(content)
