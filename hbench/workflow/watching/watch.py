"""State of a campaign for ``hbench watch``, read from its folder during and after measurement."""

import threading
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hbench.errors import HbenchError
from hbench.experiment.staged_plan import planned_runs
from hbench.records import KINDS, ScreenedRun
from hbench.sentences import counted, listed
from hbench.store.campaign.folder import JOURNAL, StoredCampaign, load_campaign
from hbench.store.campaign.journal import Entry
from hbench.store.campaign.live_file import read_live
from hbench.workflow.results import screened_runs

STALE_S = 5.0  # a working host writes more often, even while it waits for a silent board
_RESUME = "Continue with hbench run --resume."
_SHARE = 0.1  # of the time, at most, for reading a growing campaign


class Watch:
    """Reader of a campaign's folder for repeated calls; writes nothing."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._lock = threading.Lock()  # between simultaneous requests of a page
        self._seen: str | None = None  # version of the journal at the last reading
        self._next_read_s = 0.0
        self._campaign: StoredCampaign | None = None
        self._error = ""  # in reading the journal
        self._planned: int | None = None
        self._rows: dict[tuple[str, str], dict[str, Any]] = {}  # by run and checksum of its log

    def state(self) -> dict[str, Any]:
        """Return the present state: running, silent, ended, finished (complete) or nothing.

        While a host measures, only its ``live.json`` is read, so that the answer is quick.
        """
        live, version = read_live(self._folder), self._version()
        if live is not None:
            age_s = abs(time.time() - live["at_s"])
            if age_s <= STALE_S:
                return {"state": "running", "said": "", "version": version, "live": live}
            words = (
                f"The host has been silent for {_time(age_s)}: killed, suspended or disconnected. "
                f"A board without its host stops by itself. {_RESUME}"
            )
            return {"state": "silent", "said": words, "version": version, "live": None}
        with self._lock:
            self._read(at_once=True)
            state, words = (
                self._ending(self._campaign) if self._campaign else ("nothing", self._error)
            )
        return {"state": state, "said": words, "version": version, "live": None}

    def runs(self) -> dict[str, Any]:
        """Return the campaign's name, and the finished runs with their verdicts."""
        with self._lock:
            self._read()
            campaign = self._campaign
            if campaign is None:
                name = self._folder.resolve().name
                return {
                    "name": name,
                    "source": "",
                    "version": self._seen,
                    "runs": [],
                    "without_speed": "",
                }
            ended = [entry for entry in campaign.entries if entry.stop]
            attempts = Counter(entry.plan.run for entry in ended)
            rows = [
                self._rows[_key(entry)] | {"attempts": attempts[entry.plan.run]}
                for entry in campaign.latest
                if entry.stop
            ]
            return {
                "name": campaign.header["name"],
                "source": campaign.header["source"],
                "version": self._seen,
                "runs": rows,
                "without_speed": _without_speed(rows),
            }

    def _version(self) -> str:
        """Return a text that changes with the journal."""
        try:
            stat = (self._folder / JOURNAL).stat()
        except OSError:
            return ""
        return f"{stat.st_size}-{stat.st_mtime_ns}"

    def _read(self, at_once: bool = False) -> None:
        """Read changes, at intervals that leave the machine's time to the host."""
        version, begin = self._version(), time.monotonic()
        too_soon = self._campaign and begin < self._next_read_s and not at_once
        if version == self._seen or too_soon:
            return
        if not version:
            self._seen = version
            self._campaign, self._error = (
                None,
                "The page shows the campaign when hbench run begins it.",
            )
            return
        try:
            campaign = load_campaign(self._folder)
            ended = [entry for entry in campaign.latest if entry.stop]
            fresh = tuple(entry for entry in ended if _key(entry) not in self._rows)
            screened = screened_runs(replace(campaign, entries=fresh))
            for entry, run in zip(fresh, screened, strict=True):
                self._rows[_key(entry)] = _row(run)
            if self._campaign is None:
                self._planned = _planned(campaign)
            self._campaign, self._error = campaign, ""
        except HbenchError as error:
            self._campaign, self._error = None, error.message
        self._seen = version
        self._next_read_s = time.monotonic() + (time.monotonic() - begin) / _SHARE

    def _ending(self, campaign: StoredCampaign) -> tuple[str, str]:
        """Return the state and the words of a campaign without a host."""
        if campaign.imported:
            return "finished", f"{counted(len(campaign.latest), 'run')}, imported"
        done, planned = len(campaign.done), self._planned
        runs = counted(done, "run") if planned is None else f"{done} of {planned} runs"
        summary = f"{runs} measured"
        if not campaign.entries:
            return "ended", summary
        run, stop = campaign.entries[-1].plan.run, campaign.entries[-1].stop
        if stop is None:
            return "ended", f"{summary}; the host was killed or crashed in run {run}. {_RESUME}"
        if stop.outcome != "done":
            return "ended", f"{summary}; run {run} {stop.outcome}: {stop.why}. {_RESUME}"
        at = stop.at[:19].replace("T", " ")
        if planned is not None and done < planned:
            return "ended", f"{summary}, the last ended at {at} UTC. {_RESUME}"
        return (
            "ended" if planned is None else "finished"
        ), f"{summary}, the last ended at {at} UTC"


def _key(entry: Entry) -> tuple[str, str]:
    return entry.plan.run, entry.stop.sha256 if entry.stop else ""


def _row(screened: ScreenedRun) -> dict[str, Any]:
    plan, means = screened.run.plan, screened.means
    return {
        "run": plan.run,
        "kind": plan.kind,
        "label": plan.label,
        "direction": plan.direction,
        "trial": plan.trial,
        "v_plan_m_s": plan.v_ref_m_s,
        "f_load_ref_n": plan.f_load_n,
        "reasons": list(screened.reasons),
        "v_m_s": means.v_m_s if means else None,
        "friction_n": means.friction_n if means else None,
    }


def _without_speed(rows: Sequence[dict[str, Any]]) -> str:
    """Count the accepted runs that have no friction at a constant speed, by kind."""
    kinds = Counter(KINDS[row["kind"]] for row in rows if not row["reasons"])
    return listed(
        [kind.counted(count) for kind, count in kinds.items() if not kind.has_constant_speed]
    )


def _planned(campaign: StoredCampaign) -> int | None:
    """Return the number of runs in the schedule; None if not known."""
    plan, _ = planned_runs(campaign, ())
    return None if plan is None or plan.undecided else len(plan.runs)


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"
