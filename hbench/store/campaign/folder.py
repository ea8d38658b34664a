"""The campaign folder: ``campaign.yaml``, ``runs/`` with the raw logs, ``results/``.

Its reader; ``writer.py`` writes it during a measurement.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from hbench.config.bench import Bench, parse_bench
from hbench.config.campaign_settings import CampaignSettings, ExportedSettings, parse_settings
from hbench.config.import_map import ImportMap, parse_import_map
from hbench.config.schedule import Schedule, Screening, parse_schedule
from hbench.config.setup import Setup
from hbench.errors import ConfigError, DataError
from hbench.records import Provenance, RawRun, Run, RunPlan
from hbench.store.campaign import journal
from hbench.store.campaign.checksums import sha256
from hbench.store.campaign.journal import Entry
from hbench.store.campaign.journal_notes import repeated_runs, unlisted_logs
from hbench.store.campaign.run_csv import parse_run
from hbench.store.campaign.run_times import clock_fault, latest_moment, moment, start_times_s
from hbench.store.dsp_logs.dsp_log import parse_records
from hbench.store.dsp_logs.log_layout import read_layout
from hbench.store.files.atomic import write_document, write_files
from hbench.store.files.bounded_read import LARGEST_JOURNAL, check_inside, read_file
from hbench.untrusted_text import printable

JOURNAL = "campaign.yaml"
NOT_INTO_A_CAMPAIGN = "Choose another folder with -o: the files could replace raw logs."
_CAMPAIGN = "Give a folder written by `hbench run` or `hbench import`; it contains campaign.yaml."
_KNOWN = (  # sections of the header that are no details
    *"name source created software bench firmware log schedule schema map settings notes".split(),
)
WITH_SETTINGS = ("schedule", "map", "settings")  # sections of the header
_SETTINGS = (  # for the report
    *("specimen", "test", "oil"),
    *("instruments", "sensors", "controllers", "limits", "screening"),
)


@dataclass(frozen=True)
class StoredCampaign:
    """A campaign on disk. Its logs are read on demand."""

    folder: Path
    header: dict[str, Any] = field(repr=False)
    entries: tuple[Entry, ...] = field(repr=False)  # every start, in order
    warnings: tuple[str, ...]

    @property
    def imported(self) -> bool:
        """Whether the logs are another bench's, in SI: ``runs`` reads them, not ``raw_runs``."""
        return self.header["source"] == "imported"

    @property
    def latest(self) -> tuple[Entry, ...]:
        """One entry per run: the last with a stop part, or else the last."""
        chosen: dict[str, Entry] = {}
        for entry in self.entries:
            before = chosen.get(entry.plan.run)
            if before is None or entry.stop or not before.stop:
                chosen[entry.plan.run] = entry
        return tuple(chosen.values())

    @property
    def plans(self) -> tuple[RunPlan, ...]:
        """All runs that were started, each once."""
        return tuple(entry.plan for entry in self.latest)

    @property
    def done(self) -> frozenset[str]:
        """Ids of the completed runs, which need no repetition."""
        return frozenset(
            entry.plan.run for entry in self.latest if entry.stop and entry.stop.outcome == "done"
        )

    def damaged(self) -> dict[str, str]:
        """Return the completed runs whose log is missing or changed, each with the reason."""
        done, suffix = self.done, ".csv" if self.imported else ".dat"
        reasons = {
            entry.plan.run: self._log(entry, suffix)[1]
            for entry in self.latest
            if entry.plan.run in done
        }
        return {run: "; ".join(found) for run, found in reasons.items() if found}

    def start_times_s(self) -> dict[str, float]:
        """Return when each run started, in s after the first; empty if that is not known.

        The journal of an imported log has the time of the import; its file may state dates.
        """
        if self.imported:
            starts = {e.plan.run: str((e.origin or {}).get("start")) for e in self.latest}
            return start_times_s(starts)
        if clock_fault(self.entries):
            return {}
        return start_times_s({entry.plan.run: entry.started for entry in self.latest})

    def source_files(self) -> dict[str, str]:
        """Return the file that each imported run was cut from; empty for hbench's own runs."""
        return {e.plan.run: str(e.origin.get("file")) for e in self.latest if e.origin}

    def ended_at(self) -> datetime | None:
        """Return when the last run ended; None before the first has."""
        times = [moment(entry.stop.at) for entry in self.entries if entry.stop]
        return max((time for time in times if time is not None), default=None)

    @property
    def bench_content(self) -> dict[str, Any]:
        """The bench file as it was read; empty for imported logs without one."""
        return (self.header.get("bench") or {}).get("content") or {}

    def bench(self) -> Bench | None:
        """Return the bench of the measurement; None for imported logs without a bench file."""
        if not self.imported and not self.header.get("bench"):
            raise DataError(
                f"{self._source('bench')}: is missing; raw counts can't be converted without it"
            )
        return self._parsed("bench", parse_bench)

    def schedule(self) -> Schedule | None:
        """Return the schedule of the measurement; None for imported logs."""
        schedule: Schedule | None = self._parsed("schedule", parse_schedule)
        return schedule

    def setup(self) -> Setup:
        """Return the instruments and the moving mass, as far as they are known."""
        return Setup.of(self.bench(), self._settings())

    def screening(self) -> Screening:
        """Return the screening limits: of the schedule, map or settings, or the default ones."""
        rules = self._parsed("schedule", parse_schedule) or self._settings()
        return rules.screening if rules else Screening()

    def provenance(self) -> Provenance:
        """Return the origin of the data: bench, firmware, software, times and settings."""
        header = self.header
        bench = header.get("bench") or header.get("map") or {}
        firmware = header.get("firmware") or {}
        rules = self._settings()
        return Provenance(
            name=str(header["name"]),
            source="simulated" if rules and rules.simulated else header["source"],
            bench=str(bench.get("content", {}).get("name", "not specified")),
            firmware=", ".join(f"{key} {value}" for key, value in firmware.items()),
            started=str(header["created"]),
            stopped=latest_moment(e.stop.at for e in self.entries if e.stop),
            software={k: str(v) for k, v in (header.get("software") or {}).items()},
            details={k: v for k, v in header.items() if k not in _KNOWN}
            | (rules.details if rules else {}),
            settings=_written_settings(self.header),
        )

    def raw_runs(self) -> Iterator[RawRun]:
        """Read the raw logs, in the order in which the runs were first started.

        A log that is missing, cut or unreadable still gives a ``RawRun``, with a warning, so
        that it is rejected with a reason. Raises ``DataError`` if the header does not specify the
        log's layout.
        """
        channels, rate_hz, flags = read_layout(self.header.get("log"), self._source("log"))
        for entry in self.latest:
            words, warnings = self._words(entry, len(channels))
            yield RawRun(
                plan=entry.plan,
                words=words,
                channels=channels,
                flags=flags,
                rate_hz=rate_hz,
                outcome=entry.stop.outcome if entry.stop else None,
                why=entry.stop.why if entry.stop else "",
                warnings=warnings,
            )

    def runs(self) -> Iterator[Run]:
        """Read the runs of an imported campaign.

        A missing or unreadable run has no samples; ``truncated`` states the reason. A log that was
        incomplete when it was exported is one here too. So is a copy of the log of another trial.
        """
        same = journal.copied_logs(self.latest)
        for entry in self.latest:
            data, warnings = self._log(entry, ".csv")
            if entry.plan.run in same:
                warnings += (f"copy: its log is that of run {same[entry.plan.run]}",)
            empty = Run(entry.plan, t_s=np.zeros(0), x_m=np.zeros(0))
            try:
                run = parse_run(data, entry.plan, f"runs/{entry.plan.run}.csv") if data else empty
            except DataError as error:
                run, warnings = empty, (*warnings, f"unreadable: {error.message}")
            why = {} if entry.stop is None else {entry.stop.outcome: entry.stop.why}
            warnings = tuple(filter(None, (why.get("failed"), *warnings)))
            yield replace(run, truncated="; ".join(warnings), aborted=why.get("aborted", ""))

    def _words(self, entry: Entry, channels: int) -> tuple[np.ndarray, tuple[str, ...]]:
        data, warnings = self._log(entry, ".dat")
        nothing = np.zeros((0, channels), np.uint16)
        if not data:
            return nothing, warnings
        try:
            words, log_warnings = parse_records(data, channels, f"runs/{entry.plan.run}.dat")
        except DataError as error:
            return nothing, (*warnings, f"unreadable: {error.message}")
        if entry.stop and len(words) < entry.stop.records:
            log_warnings += (f"truncated: contains {len(words)} of {entry.stop.records} records",)
        return words, (*warnings, *log_warnings)

    def _log(self, entry: Entry, suffix: str) -> tuple[bytes, tuple[str, ...]]:
        """Return the file of one attempt at a run, identified by its checksum, and warnings."""
        path = self.folder / "runs" / f"{entry.plan.run}{suffix}"
        warnings: tuple[str, ...] = ()
        data = b""
        if not path.is_file():
            warnings = (f"missing: runs/{path.name} does not exist",)
        else:
            try:
                check_inside(self.folder, path)
                data = read_file(path)
            except DataError as error:
                warnings = (f"unreadable: {error.message}",)
        if entry.stop is None or (not warnings and sha256(data) == entry.stop.sha256):
            return data, warnings
        for earlier in path.parent.glob(f"{path.stem}~*{suffix}"):
            with suppress(DataError):  # an unreadable file is not the attempt
                check_inside(self.folder, earlier)
                attempt = read_file(earlier)
                if sha256(attempt) == entry.stop.sha256:
                    return attempt, ()
        changed = f"changed: runs/{path.name} was changed after it was written (SHA-256 differs)"
        return data, warnings or (changed,)

    def _settings(self) -> CampaignSettings | None:
        """Return the settings of an imported campaign: its map, or an exported settings file."""
        rules: CampaignSettings | None = self._parsed("map", parse_import_map)
        return rules or self._parsed("settings", parse_settings)

    @property
    def rotary(self) -> bool:
        """Whether the specimen is rotary: 1 m of the numbers stands for 1 rad, 1 N for 1 N m."""
        rules = self._settings()
        return isinstance(rules, ImportMap | ExportedSettings) and rules.rotary

    def _parsed(self, key: str, parse: Callable[[dict, str], Any]) -> Any:
        """Return a section's content, parsed. A fault in it is a ``DataError``."""
        section = self.header.get(key)
        try:
            return parse(section["content"], self._source(key)) if section else None
        except ConfigError as error:
            raise DataError(error.message, error.hint) from None

    def _source(self, key: str) -> str:
        return f"{self.folder / JOURNAL}: {key}"


def load_campaign(folder: Path) -> StoredCampaign:
    """Read a campaign's journal. Raises ``DataError``."""
    path = folder / JOURNAL
    check_inside(folder, path)
    content = journal.parse_journal(read_journal(path), str(path))
    warnings = [str(note) for note in content.header.get("notes") or ()]
    warnings += [*content.warnings, *unlisted_logs(path, content), *repeated_runs(content)]
    if content.header["source"] != "imported" and (fault := clock_fault(content.entries)):
        warnings.append(f"{path}: {fault}; the order of the runs replaces their times")
    return StoredCampaign(folder, content.header, content.entries, tuple(map(printable, warnings)))


def load_header(folder: Path) -> StoredCampaign:
    """Read a campaign's journal without its runs, in less time. Raises ``DataError``."""
    path = folder / JOURNAL
    check_inside(folder, path)
    head, runs, _ = read_journal(path).partition(b"\nruns:")
    content = journal.parse_journal(head + (b"\nruns: []\n" if runs else b""), str(path))
    return StoredCampaign(folder, content.header, (), ())


def read_journal(path: Path) -> bytes:
    """Return the text of a campaign's journal. Raises ``DataError``."""
    if path.parent.is_file():
        raise DataError(f"{path.parent}: is a file, not a campaign", _campaign_hint(path.parent))
    return read_file(path, LARGEST_JOURNAL, _campaign_hint(path.parent))


def _campaign_hint(given: Path) -> str:
    """Return which folder is meant by a path that is no campaign: one above it, or logs."""
    for above in given.parents:
        if (above / JOURNAL).is_file():
            return f"Give {above}, the campaign that contains it."
    if not given.exists():
        return _CAMPAIGN
    logs = given.parent if given.is_file() else given
    return f"{_CAMPAIGN} For logs of another bench begin with `hbench import {logs} --suggest`."


def refuse_existing(folder: Path, hint: str) -> None:
    """Raise ``ConfigError`` with ``hint`` if ``folder`` contains a campaign already."""
    if (folder / JOURNAL).exists():
        raise ConfigError(f"{folder}: contains a campaign already", hint)


def write_results(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write derived files below ``results/`` of a campaign, each whole or not at all."""
    check_inside(folder, folder / "results")
    write_files(folder / "results", files)


def write_report(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write derived files as ``write_results``; figures of an earlier report alone are removed."""
    check_inside(folder, folder / "results")
    write_document(folder / "results", files, "results.json")


def _written_settings(header: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a header for the report; a schedule adds to those of the bench."""
    written: dict[str, Any] = {}
    for file in ("bench", *WITH_SETTINGS):
        content = (header.get(file) or {}).get("content")
        known = content if isinstance(content, dict) else {}
        for name in _SETTINGS:
            section = known.get(name)
            before = written.get(name)
            if isinstance(before, dict) and isinstance(section, dict):
                written[name] = before | section
            elif section is not None:
                written[name] = section
    plain: dict[str, Any] = json.loads(json.dumps(written, default=str))  # dates as text
    return {name: plain[name] for name in _SETTINGS if name in plain}
