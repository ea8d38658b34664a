"""``live.json`` in a campaign's folder: the present state, written by the host during measurement.

The host removes the file when it ends. A killed host leaves it behind; its time is then old.
"""

import json
import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from hbench.errors import DataError
from hbench.store.files.atomic import write_atomic
from hbench.store.files.bounded_read import read_file

LIVE = "live.json"
SCHEMA = "hbench.live/1"
_LARGEST = 100_000  # bytes


def write_live(folder: Path, state: Mapping[str, Any]) -> None:
    """Replace the state. A failed write does not end the measurement."""
    text = json.dumps({"schema": SCHEMA, **state}, allow_nan=False)
    with suppress(DataError):
        write_atomic(folder / LIVE, text.encode(), lasting=False)


def remove_live(folder: Path) -> None:
    """Remove the state."""
    with suppress(OSError):
        (folder / LIVE).unlink(missing_ok=True)


def read_live(folder: Path) -> dict[str, Any] | None:
    """Return the host's state; None if there is no file, or not one written by a host."""
    try:
        text = read_file(folder / LIVE, _LARGEST)
        state = json.loads(text, parse_constant=_refuse, parse_float=_finite, parse_int=_finite)
    except (DataError, ValueError, RecursionError):
        return None
    if not isinstance(state, dict) or state.get("schema") != SCHEMA:
        return None
    at = state.get("at_s")
    return state if isinstance(at, (int, float)) and not isinstance(at, bool) else None


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is too large")
    return value if "." in text or "e" in text.lower() else int(value)


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is not a number")
