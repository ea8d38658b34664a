"""State of a test station for ``hbench watch --station``: present campaign and the last ones."""

import os
import time
from itertools import islice
from pathlib import Path
from typing import Any

from hbench.errors import HbenchError
from hbench.report.conformity.text import POOR_STEP, next_steps
from hbench.store.campaign.folder import JOURNAL, load_header
from hbench.store.campaign.live_file import LIVE
from hbench.store.campaign.stored_acceptance import (
    FILE_NAME,
    is_of_poor_data,
    stored_checks,
    stored_decision,
)
from hbench.workflow.watching.charts import limits_checked, station_charts
from hbench.workflow.watching.watch import Watch

_LAST = 20  # campaigns
_EVERY_S = 1.0  # between readings of the folder


class Station:
    """Reader of a folder of campaigns for repeated calls; writes nothing.

    Its campaign is the one that was changed last. The list and the charts are in the order of the
    tests' starts, also in a copied folder or after a decision on an earlier cylinder.
    """

    def __init__(self, folder: Path):
        self._folder = folder
        self._watch = Watch(folder)
        self._shown: Path | None = None
        self._next_read_s = 0.0
        self._campaigns: list[Path] = []
        self._known: dict[Path, tuple[tuple, dict[str, Any]]] = {}  # by folder: version, row
        self._charted: dict[Path, float] = {}  # campaigns in the charts, and when they were decided
        self._charts: list[dict[str, Any]] = []
        self._limited = 0  # quantities of the last decided campaign

    def state(self) -> dict[str, Any]:
        """Return the present campaign's state, with the last campaigns of the station.

        ``present`` is the folder's name of this campaign. ``charts`` are the control charts of the
        limited quantities, over the last campaigns; ``limited`` is the number of these quantities.
        ``unusual`` are the quantities whose value is unusual though the present cylinder passed.
        """
        self._read()
        state = self._watch.state()
        cylinders = [self._row(folder) for folder in self._campaigns]
        version = f"{self._shown}-{state['version']}"
        present = "" if self._shown is None else self._shown.name
        charts = {"charts": self._charts, "limited": self._limited, "unusual": self._unusual()}
        return state | {"version": version, "present": present, "cylinders": cylinders} | charts

    def _unusual(self) -> list[str]:
        """Return the quantities with an unusual value if the present cylinder passed."""
        if self._shown is None or self._shown not in self._campaigns:
            return []
        row = self._row(self._shown)
        name = row["serial"] or row["folder"]
        if row["decision"] != "PASS":
            return []
        charts = (chart for chart in self._charts if chart["names"][-1] == name)
        return list(dict.fromkeys(chart["quantity"] for chart in charts if chart["last_unusual"]))

    def runs(self) -> dict[str, Any]:
        """Return the present campaign's runs."""
        self._read()
        runs = self._watch.runs()
        return runs | {"version": f"{self._shown}-{runs['version']}"}

    def _read(self) -> None:
        now = time.monotonic()
        if now < self._next_read_s:
            return
        self._next_read_s = now + _EVERY_S
        changed = {folder: max(_moments(folder)) for folder in self._folders()}
        last = sorted(changed, key=lambda f: -changed[f])[:_LAST]
        self._campaigns = sorted(last, key=lambda f: self._row(f)["started"], reverse=True)
        self._chart({folder: _moments(folder)[2] for folder in self._campaigns})
        newest = last[0] if last else None
        if newest is not None and newest != self._shown:
            self._shown, self._watch = newest, Watch(newest)

    def _chart(self, decided: dict[Path, float]) -> None:
        """Compute the charts again if a campaign or a decision was added."""
        if decided != self._charted:
            self._charted = decided
            checks = [stored_checks(folder) for folder in reversed(self._campaigns)]
            names = [self._row(folder) for folder in reversed(self._campaigns)]
            self._charts = station_charts([row["serial"] or row["folder"] for row in names], checks)
            newest = next((each for each in reversed(checks) if each), ())
            self._limited = sum(check.measurement is not None for check in newest)

    def _folders(self) -> list[Path]:
        try:
            entries = [Path(entry.path) for entry in os.scandir(self._folder) if entry.is_dir()]
        except OSError:
            return []
        return [folder for folder in entries if (folder / JOURNAL).is_file()]

    def _row(self, folder: Path) -> dict[str, Any]:
        """Return name, serial number, time and decision of a campaign, and its limits in words."""
        version = _moments(folder)
        if folder not in self._known or self._known[folder][0] != version:
            self._known[folder] = version, _described(folder)
        return self._known[folder][1]


def _moments(folder: Path) -> tuple[float, float, float]:
    """Return when journal, live state and decision were written; 0 where there is none."""
    found = []
    for path in (folder / JOURNAL, folder / LIVE, folder / "results" / FILE_NAME):
        try:
            found.append(path.stat().st_mtime)
        except OSError:
            found.append(0.0)
    return found[0], found[1], found[2]


def _described(folder: Path) -> dict[str, Any]:
    row: dict[str, Any] = {"folder": folder.name, "serial": "", "started": "", "source": ""}
    row |= {"checked": [], "next": [], "poor": False}
    try:
        provenance = load_header(folder).provenance()
    except HbenchError:
        return row | {"decision": "not readable"}
    specimen = provenance.settings.get("specimen") or {}
    checks, poor = stored_checks(folder), is_of_poor_data(folder)
    return row | {
        "serial": str(specimen.get("serial", "")),
        "started": provenance.started[:19].replace("T", " "),
        "source": provenance.source,
        "decision": stored_decision(folder),
        "poor": poor,
        "checked": limits_checked(checks),
        "next": [
            *([f"The data is poor: {POOR_STEP}."] if poor else []),
            *(f"Next, after {each}: {step}." for each, step in islice(next_steps(checks), 1)),
        ],
    }
