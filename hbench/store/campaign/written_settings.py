"""Settings of a campaign as they are written in its header, for reports and exports."""

import json
from collections.abc import Mapping
from typing import Any

from hbench.config.campaign_settings import CampaignSettings

_WITH_SETTINGS = ("schedule", "map", "settings")  # sections of the header
_SETTINGS = (  # for the report
    *("specimen", "test", "oil"),
    *("instruments", "sensors", "controllers", "limits", "screening"),
)


def written_settings(header: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a header for the report; a schedule adds to those of the bench."""
    written: dict[str, Any] = {}
    for file in ("bench", *_WITH_SETTINGS):
        content = (header.get(file) or {}).get("content")
        known = content if isinstance(content, dict) else {}
        for name in _SETTINGS:
            section = known.get(name)
            before = written.get(name)
            if isinstance(before, dict) and isinstance(section, dict):
                written[name] = before | section
            elif section is not None:
                written[name] = section
    plain: dict[str, Any] = json.loads(json.dumps(written, default=str))  # dates as text
    return {name: plain[name] for name in _SETTINGS if name in plain}


def exported_settings(header: Mapping[str, Any], *, rotary: bool) -> dict[str, Any]:
    """Return the settings of a header for an export; empty if all are defaults."""
    contents = [(header.get(key) or {}).get("content") for key in _WITH_SETTINGS]
    stated = {"simulated": header["source"] == "simulated", "rotary": rotary}
    return {name: True for name, holds in stated.items() if holds} | {
        key: content[key]
        for content in contents
        if isinstance(content, dict)
        for key in CampaignSettings.model_fields
        if key in content
    }
