"""Some runs of a campaign as a campaign, whose analysis takes less time."""

import shutil
from collections.abc import Container, Iterable
from datetime import UTC, datetime
from pathlib import Path

from hbench.store.campaign import journal
from hbench.store.campaign.folder import load_campaign
from tests.support import ROOT


def cut_campaign(source: Path, target: Path, wanted: Container[str]) -> Path:
    """Write a campaign of some runs of another one, as the program writes it."""
    campaign = load_campaign(source)
    header = {key: value for key, value in campaign.header.items() if key != "schema"}
    text = [journal.journal_header(header)]
    (target / "runs").mkdir(parents=True)
    for entry in campaign.latest:
        if entry.plan.run in wanted:
            shutil.copy(source / "runs" / f"{entry.plan.run}.dat", target / "runs")
            text += [journal.start_text(entry.plan, datetime(2026, 1, 1, tzinfo=UTC))]
            text += [journal.stop_text(entry.stop)]
    (target / "campaign.yaml").write_text("".join(text))
    return target


def one_load(target: Path) -> Path:
    """Write a campaign of a fourth of a sample: 18 runs of one load and direction."""
    return _sample(target, range(1, 19))


def two_curves(target: Path) -> Path:
    """Write a campaign of eight steady runs of a sample, in both directions."""
    return _sample(target, (1, 2, 10, 13, 16, 17, 37, 40))


def _sample(target: Path, numbers: Iterable[int]) -> Path:
    wanted = [f"{number:04d}" for number in numbers]
    return cut_campaign(ROOT / "data_samples" / "stribeck-small", target, wanted)
