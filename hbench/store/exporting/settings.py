"""Settings of a campaign for an export, as they are written in its header."""

from typing import Any

from hbench.config.campaign_settings import CampaignSettings
from hbench.store.campaign.folder import WITH_SETTINGS, StoredCampaign


def exported_settings(campaign: StoredCampaign) -> dict[str, Any]:
    """Return the settings of a campaign for an export; empty if all are defaults."""
    header = campaign.header
    contents = [(header.get(key) or {}).get("content") for key in WITH_SETTINGS]
    stated = {"simulated": header["source"] == "simulated", "rotary": campaign.rotary}
    settings = {name: True for name, holds in stated.items() if holds} | {
        key: content[key]
        for content in contents
        if isinstance(content, dict)
        for key in CampaignSettings.model_fields
        if key in content
    }
    if header.get("map"):  # without a map the default is another one
        settings["screening"] = {"high_speed_error": None} | settings.get("screening", {})
    return settings
