"""A campaign with fewer runs or fewer logged channels, as a bench that has not more makes it."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from hbench.records import RunPlan
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.writer import CampaignWriter


def thinned(
    source: Path,
    folder: Path,
    keep: Callable[[RunPlan], bool] = lambda plan: True,
    without: tuple[str, ...] = (),
) -> Path:
    """Write the runs of ``source`` that ``keep`` tells, ``without`` some channels."""
    campaign = load_campaign(source)
    log = campaign.header["log"]
    kept = [i for i, one in enumerate(log["channels"]) if one["name"] not in without]
    log = log | {"channels": [log["channels"][i] for i in kept]}
    writer = CampaignWriter.create(folder, campaign.header | {"log": log})
    at = datetime.fromisoformat(campaign.header["created"])
    for raw in campaign.raw_runs():
        if keep(raw.plan):
            writer.start_run(raw.plan, at)
            writer.finish_run(raw.plan, raw.words[:, kept], raw.outcome, raw.why, at)
    return folder
