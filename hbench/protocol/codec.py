"""Payloads: fields of the dictionary to octets and back."""

import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hbench.protocol.dictionary import MESSAGES, SETTINGS, Message

_FORMATS = {"u16": "H", "u32": "I", "f32": "f", "text16": "16s"}
_TAILS = {"words": "<u2", "f32s": "<f4"}  # a last field that takes the rest

BY_NAME: Mapping[str, Message] = {message.name: message for message in MESSAGES}


def pack(fields: Sequence[tuple[str, str]], values: Mapping[str, Any]) -> bytes:
    """Return the payload of ``values``, which must name every field."""
    if values.keys() != {name for name, _ in fields}:
        raise ValueError(f"fields {sorted(values)} given, {[name for name, _ in fields]} expected")
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
    """Return the fields in a payload. Raises ``ValueError`` if its length does not fit."""
    values: dict[str, Any] = {}
    offset = 0
    for name, kind in fields:
        if kind in _TAILS:
            dtype = np.dtype(_TAILS[kind])
            rest = payload[offset:]
            if len(rest) % dtype.itemsize:
                raise ValueError(f"{name}: {len(rest)} octets are not whole items")
            values[name], offset = np.frombuffer(rest, dtype), len(payload)
            continue
        size = struct.calcsize("<" + _FORMATS[kind])
        if offset + size > len(payload):
            raise ValueError(f"payload of {len(payload)} octets ends before {name}")
        (value,) = struct.unpack_from("<" + _FORMATS[kind], payload, offset)
        values[name] = value.rstrip(b"\0").decode("ascii", "replace") if kind == "text16" else value
        offset += size
    if offset != len(payload):
        raise ValueError(f"payload has {len(payload) - offset} octets too many")
    return values


def pack_settings(settings: Mapping[str, float]) -> bytes:
    """Return all settings in the dictionary's order as octets, as the board's CRC sees them."""
    if settings.keys() != set(SETTINGS):
        raise ValueError(f"settings differ: {set(SETTINGS) ^ settings.keys()}")
    return np.array([settings[name] for name in SETTINGS], dtype="<f4").tobytes()
