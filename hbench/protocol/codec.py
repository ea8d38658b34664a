"""Conversion of payloads between fields and octets."""

import struct
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from hbench.protocol.dictionary import MESSAGES, SETTINGS, Message
from hbench.untrusted_text import printable

_FORMATS = {"u16": "H", "u32": "I", "f32": "f", "text16": "16s"}
_TAILS = {"words": "<u2", "f32s": "<f4"}  # arrays at the end of a payload

BY_NAME: Mapping[str, Message] = {message.name: message for message in MESSAGES}


def pack(fields: Sequence[tuple[str, str]], values: Mapping[str, Any]) -> bytes:
    """Return the payload of ``values``. Raises ``ValueError`` for a missing or unknown field."""
    if different := values.keys() ^ {name for name, _ in fields}:
        raise ValueError(f"missing or unknown fields: {', '.join(sorted(different))}")
    payload = b""
    for name, kind in fields:
        value = values[name]
        if kind in _TAILS:
            payload += np.asarray(value, dtype=_TAILS[kind]).tobytes()
        elif kind == "text16":
            payload += struct.pack("<16s", value.encode("ascii"))
        else:
            payload += struct.pack("<" + _FORMATS[kind], value)
    return payload


def unpack(fields: Sequence[tuple[str, str]], payload: bytes) -> dict[str, Any]:
    """Return the fields of a payload by name. Raises ``ValueError`` for a wrong length."""
    fixed, tail = _layout(tuple(fields))
    excess = len(payload) - fixed.size
    if excess < 0 or (excess > 0 and not tail):
        raise ValueError(f"payload of {len(payload)} octets, {fixed.size} expected")
    numbers = iter(fixed.unpack_from(payload))
    values: dict[str, Any] = {}
    for name, kind in fields:
        if kind in _TAILS:
            values[name] = np.frombuffer(payload[fixed.size :], tail)
        else:
            value = next(numbers)
            values[name] = _text(value) if kind == "text16" else value
    return values


@cache
def _layout(fields: tuple[tuple[str, str], ...]) -> tuple[struct.Struct, str]:
    """Return the layout of a payload's fixed part, and the type of an array after it, or ""."""
    kinds = [kind for _, kind in fields]
    tail = _TAILS[kinds.pop()] if kinds and kinds[-1] in _TAILS else ""
    return struct.Struct("<" + "".join(_FORMATS[kind] for kind in kinds)), tail


def _text(octets: bytes) -> str:
    """Return text that is harmless on a terminal."""
    return printable(octets.rstrip(b"\0").decode("ascii", "replace"))


def pack_settings(settings: Mapping[str, float]) -> bytes:
    """Return all settings as they are sent, in the order of the dictionary."""
    if different := settings.keys() ^ set(SETTINGS):
        raise ValueError(f"missing or unknown settings: {', '.join(sorted(different))}")
    return np.array([settings[name] for name in SETTINGS], dtype="<f4").tobytes()
