"""The raw logs of a campaign as they are on disk, with their checksums.

The checksum of all of them is that of this line, in the campaign's folder (``csv`` for imported
logs):

    sha256sum runs/*.dat | LC_ALL=C sort -k2 | sha256sum
"""

from collections.abc import Iterator
from pathlib import Path

from hbench.errors import DataError
from hbench.records.conformity.certified import RawData, RawLog
from hbench.sentences import abridged, counted
from hbench.store.campaign.checksums import sha256
from hbench.store.campaign.folder import JOURNAL, StoredCampaign
from hbench.store.files.bounded_read import LARGEST_JOURNAL, check_inside, read_file


def raw_data(campaign: StoredCampaign) -> RawData:
    """Return names and checksums of the logs, also of earlier attempts at a run.

    Raises ``DataError`` if the log of a completed run is missing or was changed.
    """
    logs = tuple(RawLog(name, len(data), sha256(data)) for name, data in raw_files(campaign))
    present = {log.sha256 for log in logs}
    changed = [e.plan.run for e in campaign.latest if e.stop and e.stop.sha256 not in present]
    if changed:
        raise DataError(
            f"{campaign.folder}: the raw logs of {counted(len(changed), 'run')} are missing or "
            f"were changed after they were written: {abridged(changed, 5)}",
            "Restore them from a copy of the campaign.",
        )
    lines = "".join(f"{log.sha256}  {log.name}\n" for log in logs)
    record = read_file(campaign.folder / JOURNAL, LARGEST_JOURNAL)
    return RawData(logs, sha256(lines.encode()), sha256(record))


def raw_files(campaign: StoredCampaign) -> Iterator[tuple[str, bytes]]:
    """Yield the logs by their paths below the folder, sorted, one read at a time."""
    suffix = ".csv" if campaign.imported else ".dat"
    for path in sorted((campaign.folder / "runs").glob(f"*{suffix}"), key=_name):
        check_inside(campaign.folder, path)
        yield f"runs/{path.name}", read_file(path)


def _name(path: Path) -> bytes:
    return path.name.encode("utf-8", "surrogateescape")
