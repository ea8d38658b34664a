"""The campaign folder: ``campaign.yaml``, ``runs/`` with the raw logs, ``results/``.

A raw log is on disk before its run's stop part, and both before anything is derived. A raw log
is never rewritten: when a run is made again, the log of the attempt before is kept as
``runs/<id>~1.dat`` (then ``~2`` and so on).
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from hbench.config.bench import Bench, parse_bench
from hbench.config.import_map import parse_import_map
from hbench.config.schedule import Screening, parse_schedule
from hbench.errors import ConfigError, DataError
from hbench.records import Outcome, Provenance, RawRun, Run, RunPlan
from hbench.store.campaign import journal
from hbench.store.campaign.dsp_log import format_words, parse_records
from hbench.store.campaign.journal import Entry, Stop
from hbench.store.campaign.log_layout import read_layout
from hbench.store.files.atomic import append, rename, truncate, write_atomic, write_files
from hbench.store.files.bounded_read import LARGEST_JOURNAL, check_inside, read_file
from hbench.store.files.run_csv import parse_run
from hbench.untrusted_text import printable

JOURNAL = "campaign.yaml"
ADD_A_BENCH = "Lay a bench file 'bench.yaml' into what `hbench export` writes of it; import that."
_SETTINGS = ("instruments", "sensors", "controllers", "limits", "screening")  # told in the report


class CampaignWriter:
    """Writes a campaign while it is being made: the header, then each run's start and stop."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._journal = folder / JOURNAL
        self._started: RunPlan | None = None

    @classmethod
    def create(cls, folder: Path, header: Mapping[str, Any]) -> "CampaignWriter":
        """Begin a campaign. Raises ``ConfigError`` where ``folder`` holds one already."""
        refuse_existing(folder)
        write_atomic(folder / JOURNAL, journal.header_text(header).encode())
        return cls(folder)

    @classmethod
    def resume(cls, folder: Path) -> "CampaignWriter":
        """Go on with a campaign; a half-written last line is cut off. Raises ``DataError``."""
        path = folder / JOURNAL
        data = _read_journal(path)
        journal.parse_journal(data, str(path))
        check_inside(folder, path)
        check_inside(folder, folder / "runs")
        truncate(path, journal.intact_length(data))
        return cls(folder)

    def start_run(self, plan: RunPlan, at: datetime, after_rejection: str = "") -> None:
        """Append the start part of a run; ``after_rejection`` says why it is made again."""
        text = journal.start_text(plan, at, after_rejection=after_rejection)
        append(self._journal, text.encode())
        self._started = plan

    def finish_run(
        self, plan: RunPlan, words: np.ndarray, outcome: Outcome, why: str, at: datetime
    ) -> None:
        """Write the raw log of the run that was started last, then append its stop part.

        ``words`` is (records, words of a record), uint16.
        """
        if plan != self._started:
            raise ValueError(f"run {plan.run} is not the one that was started last")
        log = format_words(words)
        path = self._folder / "runs" / f"{plan.run}.dat"
        _keep_earlier(path)
        write_atomic(path, log, overwrite=False)
        stop = Stop(at.isoformat(), outcome, len(words), sha256(log), why)
        append(self._journal, journal.stop_text(stop).encode())
        self._started = None


@dataclass(frozen=True)
class Campaign:
    """A campaign as it lies on disk. Logs are read when they are asked for."""

    folder: Path
    header: dict[str, Any] = field(repr=False)
    entries: tuple[Entry, ...] = field(repr=False)  # every start, in order
    warnings: tuple[str, ...]

    @property
    def imported(self) -> bool:
        """Whether its logs come from elsewhere and are in SI: ``runs``, not ``raw_runs``."""
        return self.header["source"] == "imported"

    @property
    def latest(self) -> tuple[Entry, ...]:
        """One entry a run: the last with a stop part, or else the last."""
        chosen: dict[str, Entry] = {}
        for entry in self.entries:
            before = chosen.get(entry.plan.run)
            if before is None or entry.stop or not before.stop:
                chosen[entry.plan.run] = entry
        return tuple(chosen.values())

    @property
    def plans(self) -> tuple[RunPlan, ...]:
        """The runs that were started, each once."""
        return tuple(entry.plan for entry in self.latest)

    @property
    def done(self) -> frozenset[str]:
        """Ids of the runs that need not be made again."""
        return frozenset(
            entry.plan.run for entry in self.latest if entry.stop and entry.stop.outcome == "done"
        )

    def bench(self) -> Bench | None:
        """Return the bench that it was made on; None where the source did not tell."""
        if not self.imported and not self.header.get("bench"):
            raise DataError(f"{self._source('bench')}: is missing; counts mean nothing without it")
        return self._parsed("bench", parse_bench)

    def screening(self) -> Screening:
        """Return the limits for its runs: of its schedule or import map, or the default ones."""
        rules = self._parsed("schedule", parse_schedule) or self._parsed("map", parse_import_map)
        return rules.screening if rules else Screening()

    def provenance(self) -> Provenance:
        """Return what was measured by what."""
        header = self.header
        bench = header.get("bench") or header.get("map") or {}
        contents = [(header.get(key) or {}).get("content") for key in ("schedule", "bench")]
        written = {k: v for one in contents if isinstance(one, dict) for k, v in one.items()}
        firmware = header.get("firmware") or {}
        known = ("name", "source", "created", "software", "bench", "firmware", "log", "schedule")
        return Provenance(
            name=str(header["name"]),
            source=header["source"],
            bench=str(bench.get("content", {}).get("name", "not told")),
            firmware=", ".join(f"{key} {value}" for key, value in firmware.items()),
            started=str(header["created"]),
            stopped=max((e.stop.at for e in self.entries if e.stop), default=""),
            software={k: str(v) for k, v in (header.get("software") or {}).items()},
            details={
                k: v for k, v in header.items() if k not in (*known, "schema", "map", "notes")
            },
            settings={name: written[name] for name in _SETTINGS if name in written},
        )

    def raw_runs(self) -> Iterator[RawRun]:
        """Read the raw logs, in the order in which the runs were first started.

        A log that is missing, cut or unreadable still gives a ``RawRun``, with a warning, so
        that it is rejected with a reason. Raises ``DataError`` where the header lacks the log's
        layout.
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

        One that is missing or unreadable has no samples; ``truncated`` says what is wrong.
        """
        for entry in self.latest:
            data, warnings = self._log(entry, ".csv")
            empty = Run(entry.plan, t_s=np.zeros(0), x_m=np.zeros(0))
            try:
                run = parse_run(data, entry.plan, f"runs/{entry.plan.run}.csv") if data else empty
            except DataError as error:
                run, warnings = empty, (*warnings, f"unreadable: {error.message}")
            yield replace(run, truncated="; ".join(warnings))

    def _words(self, entry: Entry, channels: int) -> tuple[np.ndarray, tuple[str, ...]]:
        data, warnings = self._log(entry, ".dat")
        nothing = np.zeros((0, channels), np.uint16)
        if not data:
            return nothing, warnings
        try:
            words, noticed = parse_records(data, channels, f"runs/{entry.plan.run}.dat")
        except DataError as error:
            return nothing, (*warnings, f"unreadable: {error.message}")
        if entry.stop and len(words) < entry.stop.records:
            noticed += (f"truncated: {len(words)} of {entry.stop.records} records are there",)
        return words, (*warnings, *noticed)

    def _log(self, entry: Entry, suffix: str) -> tuple[bytes, tuple[str, ...]]:
        """Return the file of one attempt at a run, known by its hash, and what is odd about it."""
        path = self.folder / "runs" / f"{entry.plan.run}{suffix}"
        odd: tuple[str, ...] = ()
        data = b""
        if not path.is_file():
            odd = (f"missing: runs/{path.name} is not there",)
        else:
            try:
                check_inside(self.folder, path)
                data = read_file(path)
            except DataError as error:
                odd = (f"unreadable: {error.message}",)
        if entry.stop is None or (not odd and sha256(data) == entry.stop.sha256):
            return data, odd
        for earlier in path.parent.glob(f"{path.stem}~*{suffix}"):
            with suppress(DataError):  # which can't be the one, then
                check_inside(self.folder, earlier)
                attempt = read_file(earlier)
                if sha256(attempt) == entry.stop.sha256:
                    return attempt, ()
        changed = f"changed: runs/{path.name} is not what was written (SHA-256 differs)"
        return data, odd or (changed,)

    def _parsed(self, key: str, parse: Callable[[dict, str], Any]) -> Any:
        """Return a section's content, checked; what is wrong with it is an error of the data."""
        section = self.header.get(key)
        try:
            return parse(section["content"], self._source(key)) if section else None
        except ConfigError as error:
            raise DataError(error.message, error.hint) from None

    def _source(self, key: str) -> str:
        return f"{self.folder / JOURNAL}: {key}"


def load_campaign(folder: Path) -> Campaign:
    """Read a campaign's journal. Raises ``DataError``."""
    path = folder / JOURNAL
    content = journal.parse_journal(_read_journal(path), str(path))
    told = [str(note) for note in content.header.get("notes") or ()]
    told += [*content.warnings, *_unknown_logs(folder, content), *_made_again(content)]
    return Campaign(folder, content.header, content.entries, tuple(map(printable, told)))


def _unknown_logs(folder: Path, content: journal.Journal) -> Iterator[str]:
    """Tell of logs without an entry: their part of the journal was lost, or they came later."""
    known = {entry.plan.run for entry in content.entries}
    suffix = ".csv" if content.header["source"] == "imported" else ".dat"
    found = sorted(path.name for path in (folder / "runs").glob(f"*{suffix}"))
    unknown = [name for name in found if name.removesuffix(suffix).split("~")[0] not in known]
    if unknown:
        few = ", ".join(unknown[:10]) + (", ..." if len(unknown) > 10 else "")
        yield f"{folder / JOURNAL}: has no entry for {few} in runs: left out ({len(unknown)} logs)"


def _made_again(content: journal.Journal) -> Iterator[str]:
    """Tell of runs that were repeated because they had been rejected: a choice among trials."""
    repeated = [entry for entry in content.entries if entry.after_rejection]
    if repeated:
        few = "; ".join(f"{e.plan.run} ({e.after_rejection})" for e in repeated[:5])
        more = "; ..." if len(repeated) > 5 else ""
        yield (
            f"{len(repeated)} times a run was made again at once, since it had been rejected: "
            f"{few}{more}. The last attempt stands here; the logs of those before are kept in runs"
        )


def _read_journal(path: Path) -> bytes:
    hint = "A campaign is a folder that `hbench run` or `hbench import` made, with campaign.yaml."
    return read_file(path, LARGEST_JOURNAL, hint)


def refuse_existing(folder: Path) -> None:
    """Raise ``ConfigError`` where ``folder`` holds a campaign already."""
    if (folder / JOURNAL).exists():
        raise ConfigError(
            f"{folder}: holds a campaign already",
            "Choose another folder; `hbench run --resume` goes on with an interrupted one.",
        )


def write_results(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write derived files below ``results/`` of a campaign, each whole or not at all."""
    check_inside(folder, folder / "results")
    write_files(folder / "results", files)


def _keep_earlier(path: Path) -> None:
    """Give a log that is there already the name of an earlier attempt."""
    if path.exists():
        number = 1
        while (kept := path.with_name(f"{path.stem}~{number}{path.suffix}")).exists():
            number += 1
        rename(path, kept.name)


def sha256(data: bytes) -> str:
    """Return the hash by which the journal knows a file."""
    return hashlib.sha256(data).hexdigest()
