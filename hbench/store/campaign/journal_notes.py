"""Notes on a campaign by its journal: logs without an entry, and repeated runs."""

from collections.abc import Iterator
from pathlib import Path

from hbench.sentences import abridged, counted
from hbench.store.campaign.journal import JournalContent


def unlisted_logs(path: Path, content: JournalContent) -> Iterator[str]:
    """Yield a note on logs without an entry in the journal at ``path``.

    The entry was lost, or the log was added later.
    """
    listed = {entry.plan.run for entry in content.entries}
    suffix = ".csv" if content.header["source"] == "imported" else ".dat"
    logs = sorted(path.name for path in (path.parent / "runs").glob(f"*{suffix}"))
    unlisted = [name for name in logs if name.removesuffix(suffix).split("~")[0] not in listed]
    if unlisted:
        yield (
            f"{path}: no entry for {abridged(unlisted, 10)} in runs: left out "
            f"({counted(len(unlisted), 'log')})"
        )


def repeated_runs(content: JournalContent) -> Iterator[str]:
    """Yield a note on runs that were repeated after a rejection, which selects among trials."""
    repeated = [entry for entry in content.entries if entry.after_rejection]
    if repeated:
        few = "; ".join(f"{e.plan.run} ({e.after_rejection})" for e in repeated[:5])
        more = "; ..." if len(repeated) > 5 else ""
        yield (
            f"{len(repeated)} repetitions of runs directly after their rejection: {few}{more}. "
            "The last attempt counts; the logs of earlier attempts are kept in runs"
        )
