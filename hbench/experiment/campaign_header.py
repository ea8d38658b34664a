"""What a campaign says of itself: its header, and whether a session may go on with it."""

import platform
import zlib
from collections.abc import Mapping
from datetime import datetime
from importlib.metadata import version
from typing import Any

from hbench.config.bench import Bench
from hbench.errors import ConfigError
from hbench.protocol.dictionary import FLAGS, PROTOCOL, RECORD, dictionary_hash
from hbench.rig.client import Identity
from hbench.store.campaign.folder import Campaign

SIMULATED_BOARDS = ("host", "mps2")  # ports of the firmware that never have a real bench
_PACKAGES = ("hbench", "numpy", "scipy", "pandas", "matplotlib", "numba")


def campaign_header(
    name: str,
    files: Mapping[str, Mapping[str, Any]],
    identity: Identity,
    bench: Bench,
    port: str,
    now: datetime,
) -> dict[str, Any]:
    """Return the header of a campaign on the board that answered; ``files`` as read."""
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
            "flags": list(FLAGS),
            "channels": [
                {"name": w.name, "signed": w.signed, "scale": w.scale, "unit": w.unit}
                for w in RECORD
            ],
        },
    }


def software() -> dict[str, str]:
    """Return the versions of what computes."""
    packages = {name: version(name) for name in _PACKAGES}
    return {"python": platform.python_version(), **packages}


def session_seed(seed: int, campaign: Campaign | None) -> int:
    """The rig's seed: another for each session, so that a resumed trial is no copy of one before.

    It follows from the campaign: its seed and the number of runs that had been started.
    """
    started = len(campaign.entries) if campaign else 0
    return zlib.crc32(f"{seed} {started}".encode()) if started else seed


def refuse_another(campaign: Campaign, header: dict[str, Any]) -> None:
    """Raise ``ConfigError`` where a resumed campaign would mix what can't be compared."""
    for key in ("source", "bench", "schedule", "plant", "firmware", "log"):
        before, now = (_content(part.get(key)) for part in (campaign.header, header))
        if before != now:
            raise ConfigError(
                f"{campaign.folder}: its {key} is not the present one, so it can't be resumed",
                "Resume with what it was begun with, or begin a new campaign.",
            )


def _content(section: Any) -> Any:
    """The content of a file section: its file may have been renamed."""
    return section.get("content", section) if isinstance(section, dict) else section
