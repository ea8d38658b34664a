"""Header of a campaign, and the check that a resumed session may continue it."""

import platform
import zlib
from collections.abc import Mapping
from datetime import datetime
from functools import cache
from importlib.metadata import version
from typing import Any

from hbench.config.bench import Bench
from hbench.config.files.loading import brief
from hbench.errors import ConfigError
from hbench.protocol.dictionary import PROTOCOL, RECORD, RECORD_FLAGS, dictionary_hash
from hbench.rig.client import Identity
from hbench.store.campaign.folder import StoredCampaign

SIMULATED_BOARDS = ("host", "mps2", "stm32f4-emulated")  # firmware ports without a real bench
_PACKAGES = ("hbench", "numpy", "scipy", "pandas", "matplotlib", "numba")
_version = cache(version)  # it reads the package's files each time


def campaign_header(
    name: str,
    files: Mapping[str, Mapping[str, Any]],
    identity: Identity,
    bench: Bench,
    port: str,
    now: datetime,
) -> dict[str, Any]:
    """Return the header of a campaign; ``identity`` is the board's, ``files`` are as read."""
    simulated = identity.board in SIMULATED_BOARDS
    return {
        "schema": "hbench.campaign/1",
        "name": name,
        "source": "simulated" if simulated else "real",
        "created": now.isoformat(timespec="seconds"),
        "software": software(),
        "firmware": {
            "id": identity.firmware,
            "board": identity.board,
            "protocol": PROTOCOL,
            "dictionary": f"{dictionary_hash():08x}",
        },
        "port": port,
        **files,
        "log": {
            "rate_hz": bench.controllers.log_rate,
            "flags": list(RECORD_FLAGS),
            "channels": [
                {"name": w.name, "signed": w.signed, "scale": w.scale, "unit": w.unit}
                for w in RECORD
            ],
        },
    }


def software() -> dict[str, str]:
    """Return the versions of Python and of the packages that compute results."""
    packages = {name: _version(name) for name in _PACKAGES}
    return {"python": platform.python_version(), **packages}


def session_seed(seed: int, campaign: StoredCampaign | None) -> int:
    """Return the seed of the virtual rig, different for each session of a campaign.

    It follows from ``seed`` and the number of runs started so far, so that a resumed trial does
    not repeat the noise of an earlier one.
    """
    started = len(campaign.entries) if campaign else 0
    return zlib.crc32(f"{seed} {started}".encode()) if started else seed


def refuse_another(campaign: StoredCampaign, header: dict[str, Any]) -> None:
    """Raise ``ConfigError`` where bench, schedule, firmware or log format have changed."""
    for key in ("source", "bench", "schedule", "plant", "firmware", "log"):
        before, now = (_content(part.get(key)) for part in (campaign.header, header))
        if before != now:
            hint = f"Resume with the original {key}, or start a new campaign."
            if key == "schedule" and _without_serial(before) == _without_serial(now):
                hint = "Give the same --specimen as at the start, or start a new campaign."
            raise ConfigError(
                f"{campaign.folder}: can't be resumed: {key} differs from the campaign's: "
                f"{_first_difference(before, now)}",
                hint,
            )


def _without_serial(schedule: Any) -> Any:
    """Return a schedule without the serial number, which an option of the command can give."""
    if not isinstance(schedule, Mapping):
        return schedule
    identity = schedule.get("specimen") or {}
    rest = {key: value for key, value in identity.items() if key != "serial"}
    return {key: value for key, value in schedule.items() if key != "specimen"} | (
        {"specimen": rest} if rest else {}
    )


def _first_difference(before: Any, now: Any, key: str = "") -> str:
    """Return the first key whose values differ, with both values."""
    pairs: list[tuple[Any, Any, Any]] = []
    sections = [side for side in (before, now) if isinstance(side, Mapping)]
    if sections and all(side is None or isinstance(side, Mapping) for side in (before, now)):
        before, now = before or {}, now or {}
        keys = dict.fromkeys((*before, *now))
        pairs = [(name, before.get(name), now.get(name)) for name in keys]
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        pairs = [(number, *pair) for number, pair in enumerate(zip(before, now, strict=True))]
    for name, a, b in pairs:
        if a != b:
            return _first_difference(a, b, f"{key}.{name}" if key else str(name))
    words = ("nothing" if value is None else brief(value) for value in (before, now))
    return f"{key}: {' in the campaign, '.join(words)} now".removeprefix(": ")


def _content(section: Any) -> Any:
    """Return the content of a file section, without the name of its file."""
    return section.get("content", section) if isinstance(section, dict) else section
