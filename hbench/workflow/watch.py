"""A campaign as somebody sees it who only reads its folder, while it is made and after it."""

import threading
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

from hbench.config.schedule import parse_schedule
from hbench.errors import ConfigError, DataError, HbenchError
from hbench.experiment.plan import plan_runs
from hbench.records import ScreenedRun
from hbench.store.campaign.folder import JOURNAL, Campaign, load_campaign
from hbench.store.campaign.journal import Entry
from hbench.store.campaign.live_file import read_live
from hbench.workflow.results import screened_runs

STALE_S = 5.0  # a host at work tells more often, even where it asks a silent board again and again
_GO_ON = "Go on with hbench run --resume."
_SHARE = 0.1  # of the time, at most, that goes into reading a campaign that grows


class Watch:
    """Reads a campaign's folder again and again; nothing is written."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._lock = threading.Lock()  # of a page's requests that come at once
        self._seen: str | None = None  # version of the journal that was read last
        self._rest_s = 0.0  # until when it is not read again
        self._campaign: Campaign | None = None
        self._wrong = ""  # with the journal
        self._planned: int | None = None
        self._rows: dict[tuple[str, str], dict[str, Any]] = {}  # by run and hash of its log

    def state(self) -> dict[str, Any]:
        """Return what is told of this moment: ``running``, ``silent``, ``ended`` or ``nothing``.

        While a host is at work only its own words are read, so that the answer is quick.
        """
        live, version = read_live(self._folder), self._version()
        if live is not None:
            age_s = abs(time.time() - live["at_s"])
            if age_s <= STALE_S:
                return {"state": "running", "said": "", "version": version, "live": live}
            said = (
                f"no word from its host for {_time(age_s)}: killed, asleep or out of reach. "
                f"A board without its host stops itself. {_GO_ON}"
            )
            return {"state": "silent", "said": said, "version": version, "live": None}
        with self._lock:
            self._read(at_once=True)
            state = "ended" if self._campaign else "nothing"
            said = self._ending(self._campaign) if self._campaign else self._wrong
        return {"state": state, "said": said, "version": version, "live": None}

    def runs(self) -> dict[str, Any]:
        """Return the campaign's name, and the runs that have ended, each with its verdict."""
        with self._lock:
            self._read()
            campaign = self._campaign
            if campaign is None:
                name = self._folder.resolve().name
                return {"name": name, "source": "", "version": self._seen, "runs": []}
            ended = [entry for entry in campaign.entries if entry.stop]
            attempts = Counter(entry.plan.run for entry in ended)
            return {
                "name": campaign.header["name"],
                "source": campaign.header["source"],
                "version": self._seen,
                "runs": [
                    self._rows[_key(entry)] | {"attempts": attempts[entry.plan.run]}
                    for entry in campaign.latest
                    if entry.stop
                ],
            }

    def _version(self) -> str:
        """Return what changes with the journal."""
        try:
            stat = (self._folder / JOURNAL).stat()
        except OSError:
            return ""
        return f"{stat.st_size}-{stat.st_mtime_ns}"

    def _read(self, at_once: bool = False) -> None:
        """Read what has changed, and no more often than keeps the machine free for a host."""
        version, begin = self._version(), time.monotonic()
        resting = self._campaign and begin < self._rest_s and not at_once
        if version == self._seen or resting:
            return
        if not version:
            self._seen = version
            self._campaign, self._wrong = None, "no campaign yet; it is shown once it begins"
            return
        try:
            campaign = load_campaign(self._folder)
            ended = [entry for entry in campaign.latest if entry.stop]
            fresh = tuple(entry for entry in ended if _key(entry) not in self._rows)
            judged = screened_runs(replace(campaign, entries=fresh))
            for entry, one in zip(fresh, judged, strict=True):
                self._rows[_key(entry)] = _row(one)
            if self._campaign is None:
                self._planned = _planned(campaign)
            self._campaign, self._wrong = campaign, ""
        except HbenchError as error:
            self._campaign, self._wrong = None, error.message
        self._seen = version
        self._rest_s = time.monotonic() + (time.monotonic() - begin) / _SHARE

    def _ending(self, campaign: Campaign) -> str:
        if campaign.imported:
            return f"{len(campaign.latest)} runs, imported"
        made, all_made = len(campaign.done), self._planned is None
        words = f"{made} runs made"
        if self._planned is not None:
            words, all_made = f"{made} of {self._planned} runs made", made >= self._planned
        if not campaign.entries:
            return words
        run, stop = campaign.entries[-1].plan.run, campaign.entries[-1].stop
        if stop is None:
            return f"{words}; its host ended without a word in run {run}. {_GO_ON}"
        if stop.outcome != "done":
            return f"{words}; run {run} {stop.outcome}: {stop.why}. {_GO_ON}"
        return f"{words}, the last until {stop.at[:19]}" + ("" if all_made else f". {_GO_ON}")


def _key(entry: Entry) -> tuple[str, str]:
    return entry.plan.run, entry.stop.sha256 if entry.stop else ""


def _row(one: ScreenedRun) -> dict[str, Any]:
    plan, means = one.run.plan, one.means
    return {
        "run": plan.run,
        "kind": plan.kind,
        "label": plan.label,
        "direction": plan.direction,
        "trial": plan.trial,
        "v_plan_m_s": plan.v_ref_m_s,
        "f_load_ref_n": plan.f_load_n,
        "reasons": list(one.reasons),
        "v_m_s": means.v_m_s if means else None,
        "friction_n": means.friction_n if means else None,
    }


def _planned(campaign: Campaign) -> int | None:
    """Return how many runs its schedule has; None where that is not known."""
    try:
        schedule = parse_schedule(campaign.header["schedule"]["content"], "schedule")
        if (bench := campaign.bench()) is None:
            return None
        plan = plan_runs(schedule, bench, "schedule")
    except (KeyError, TypeError, ConfigError, DataError):
        return None
    return None if plan.undecided else len(plan.runs)


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"
