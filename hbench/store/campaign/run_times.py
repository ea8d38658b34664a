"""When the runs of a campaign started, as far as the clocks that stated it can be right."""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from itertools import pairwise

from hbench.store.campaign.journal import Entry

_CLOCK_SET = datetime(2000, 1, 1, tzinfo=UTC)  # an unset clock begins at 1970, or soon after


def moment(text: str) -> datetime | None:
    """Return an ISO 8601 time in UTC; None for other text and for a time without zone."""
    with suppress(ValueError, OverflowError):
        time = datetime.fromisoformat(text)
        return None if time.tzinfo is None else time.astimezone(UTC)
    return None


def latest_moment(texts: Iterable[str]) -> str:
    """Return the latest of some ISO 8601 times, which may be of different zones; empty for none."""
    return max(texts, key=lambda text: moment(text) or datetime.min.replace(tzinfo=UTC), default="")


def clock_fault(entries: Sequence[Entry]) -> str:
    """Return how the host's clock was wrong during a measurement; empty if nothing shows it.

    ``entries`` are all starts of runs, in the order in which they were made.
    """
    known = [(entry.plan.run, time) for entry in entries if (time := moment(entry.started))]
    unset = [(run, time) for run, time in known if time < _CLOCK_SET]
    if unset:
        run, time = unset[0]
        return f"the clock of the computer was not set: run {run} has the date {time:%Y-%m-%d}"
    for (before, earlier), (run, time) in pairwise(known):
        if time < earlier:
            back_s = (earlier - time).total_seconds()
            return (
                f"the clock of the computer went back by {back_s:.0f} s from run {before} to {run}"
            )
    return ""


def start_times_s(starts: dict[str, str]) -> dict[str, float]:
    """Return the times of ``starts`` in s after the first; empty if one is not known, or all equal.

    ``starts`` are ISO 8601 times by run.
    """
    times = {run: moment(text) for run, text in starts.items()}
    known = {run: time for run, time in times.items() if time is not None and time >= _CLOCK_SET}
    if len(known) < len(times) or len(set(known.values())) < 2:
        return {}
    first = min(known.values())
    return {run: (time - first).total_seconds() for run, time in known.items()}
