"""``live.json`` in a campaign's folder: what the host that makes the campaign tells at this moment.

It is there while that host is at work. One that was killed leaves it behind; its time is old then.
"""

import json
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
    """Replace what is told. A disk that refuses does not end a measurement for that."""
    text = json.dumps({"schema": SCHEMA, **state}, allow_nan=False)
    with suppress(DataError):
        write_atomic(folder / LIVE, text.encode(), lasting=False)


def remove_live(folder: Path) -> None:
    """Tell nothing any more."""
    with suppress(OSError):
        (folder / LIVE).unlink(missing_ok=True)


def read_live(folder: Path) -> dict[str, Any] | None:
    """Return what the host tells; None where there is nothing, or nothing that it wrote."""
    try:
        state = json.loads(read_file(folder / LIVE, _LARGEST), parse_constant=_refuse)
    except (DataError, ValueError, RecursionError):
        return None
    if not isinstance(state, dict) or state.get("schema") != SCHEMA:
        return None
    at = state.get("at_s")
    return state if isinstance(at, (int, float)) and not isinstance(at, bool) else None


def _refuse(word: str) -> None:
    raise ValueError(f"{word} is no number")
