"""Writer of a campaign folder during a measurement.

A raw log is on disk before its run's stop part, and both before any result is derived. A raw log
is never rewritten: when a run is repeated, the log of the previous attempt is kept as
``runs/<id>~1.dat`` (then ``~2`` and so on).
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from hbench.errors import DataError
from hbench.records import Outcome, RunPlan
from hbench.store.campaign import journal
from hbench.store.campaign.checksums import sha256
from hbench.store.campaign.folder import JOURNAL, read_journal, refuse_existing
from hbench.store.campaign.journal import Stop
from hbench.store.dsp_logs.dsp_log import format_words
from hbench.store.files.atomic import append, rename, truncate, write_atomic
from hbench.store.files.bounded_read import check_inside


@contextmanager
def _to_be_resumed() -> Iterator[None]:
    """Add to the hint of a disk that refuses that the campaign can be continued."""
    try:
        yield
    except DataError as error:
        if not isinstance(error.__cause__, OSError):
            raise
        hint = f"{error.hint} Then continue with --resume."
        raise DataError(error.message, hint) from error.__cause__


class CampaignWriter:
    """Writer of a campaign during its measurement: the header, then each run's start and stop."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._journal = folder / JOURNAL
        self._started: RunPlan | None = None

    @classmethod
    def create(cls, folder: Path, header: Mapping[str, Any]) -> "CampaignWriter":
        """Begin a campaign. Raises ``ConfigError`` if ``folder`` contains one already."""
        refuse_existing(
            folder, "Choose another folder, or continue an interrupted campaign with --resume."
        )
        write_atomic(folder / JOURNAL, journal.journal_header(header).encode())
        return cls(folder)

    @classmethod
    def resume(cls, folder: Path) -> "CampaignWriter":
        """Continue a campaign; a half-written last line is cut off. Raises ``DataError``."""
        path = folder / JOURNAL
        check_inside(folder, path)
        data = read_journal(path)
        journal.parse_journal(data, str(path))
        check_inside(folder, folder / "runs")
        truncate(path, journal.intact_length(data))
        return cls(folder)

    @_to_be_resumed()
    def start_run(self, plan: RunPlan, at: datetime, after_rejection: str = "") -> None:
        """Append the start part of a run; ``after_rejection`` is the reason for a repetition."""
        text = journal.start_text(plan, at, after_rejection=after_rejection)
        append(self._journal, text.encode())
        self._started = plan

    @_to_be_resumed()
    def finish_run(
        self, plan: RunPlan, words: np.ndarray, outcome: Outcome, why: str, at: datetime
    ) -> None:
        """Write the raw log of the run that was started last, then append its stop part.

        ``words`` is (records, words of a record), uint16.
        """
        if plan != self._started:
            raise ValueError(f"run {plan.run} is not the run that was started last")
        log = format_words(words)
        path = self._folder / "runs" / f"{plan.run}.dat"
        _keep_earlier(path)
        write_atomic(path, log, overwrite=False)
        stop = Stop(at.isoformat(), outcome, len(words), sha256(log), why)
        append(self._journal, journal.stop_text(stop).encode())
        self._started = None


def _keep_earlier(path: Path) -> None:
    """Rename an existing log to the name of an earlier attempt."""
    if path.exists():
        number = 1
        while (kept := path.with_name(f"{path.stem}~{number}{path.suffix}")).exists():
            number += 1
        rename(path, kept.name)
