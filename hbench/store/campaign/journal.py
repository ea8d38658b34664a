"""The text of ``campaign.yaml``: an append-only journal that is valid YAML after every append.

    schema: hbench.campaign/1
    name: ...                          the header, written once
    sha256: {bench: ..., ...}          of its sections: an edit is reported, not refused
    runs:
    - run: '0001'                      start part, appended when a run starts
      plan: {"kind": "steady", ...}
      start: {"at": "2024-05-01T12:00:00+00:00", "plan_sha256": ...}
      stop: {"at": ..., "outcome": "done", "records": 812, "sha256": ...}     appended when it ends

A run without stop part was interrupted by a crash of the host. A crash can also leave the last
line half-written; it is then left out, with a warning. A repeated run is a second item. A run that
was repeated directly after its rejection has the reasons in its ``start`` as ``after_rejection``.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from typing import Any, get_args

import yaml

from hbench.config.files.yaml_text import parse_yaml
from hbench.errors import DataError
from hbench.records import Outcome, RunPlan
from hbench.store.campaign.checksums import content_checksum, edited_sections, section_checksums
from hbench.store.campaign.plan_fields import read_plan
from hbench.store.campaign.run_lines import json_line, parse_run_lines
from hbench.untrusted_text import printable

SCHEMA = "hbench.campaign/1"
REQUIRED = ("name", "source", "created")
_SECTIONS = ("bench", "schedule", "map", "settings")  # with a content of their own

_ONE_LINE = 2**30
_RUN_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}")
_RUNS = b"\nruns:\n"
_ALWAYS = ("v_m_s", "a_m_s2", "duration_s")  # of a segment, also where 0


_Base: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


class _Dumper(_Base):
    """YAML dumper without aliases (``*id001``), so that people can read the file."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


@dataclass(frozen=True)
class Stop:
    """The stop part of a run."""

    at: str
    outcome: Outcome
    records: int
    sha256: str  # of the log file
    why: str = ""


@dataclass(frozen=True)
class Entry:
    """One attempt at a run."""

    plan: RunPlan
    started: str
    stop: Stop | None  # None: crashed
    origin: Mapping[str, Any] | None = None  # of an imported run: file, lines, sha256; start
    after_rejection: str = ""  # of a run repeated directly: why the attempt before was rejected

    @property
    def measured(self) -> str:
        """Identity of the measurement, the checksum of its log; empty without a log."""
        return self.stop.sha256 if self.stop and self.stop.records else ""


@dataclass(frozen=True)
class JournalContent:
    """Content of ``campaign.yaml``."""

    header: dict[str, Any]
    entries: tuple[Entry, ...]
    warnings: tuple[str, ...]


def measurements(entries: Iterable[Entry]) -> frozenset[str]:
    """Return the identities of all measurements: a copied campaign has those of the original."""
    return frozenset(entry.measured for entry in entries if entry.measured)


def copied_logs(entries: Iterable[Entry]) -> dict[str, str]:
    """Return the runs with the log of another trial of the same plan, each with that run."""
    first: dict[tuple[str, RunPlan], str] = {}
    copies = {}
    for entry in entries:
        run = entry.plan.run
        same = first.setdefault((entry.measured, replace(entry.plan, run="", trial=0)), run)
        if entry.measured and same != run:
            copies[run] = same
    return copies


def check_run_id(run: str, source: str) -> str:
    """Return ``run`` if it is a valid file name. Raises ``DataError``."""
    if not _RUN_ID.fullmatch(run) or run.endswith("."):
        raise DataError(
            f"{source}: run {run!r} is not a valid file name",
            "Use only letters, digits and . _ + - in a run's name.",
        )
    return run


def journal_header(header: Mapping[str, Any]) -> str:
    """Return the journal's beginning; ``REQUIRED`` keys must be there.

    The schema is added, and the checksums that identify an edited section.
    """
    missing = [key for key in REQUIRED if key not in header]
    if missing or "runs" in header:
        raise ValueError(f"campaign header without {missing}, or with 'runs'")
    text = _dump({"schema": SCHEMA, **header}, flow=False)
    checksums = section_checksums(parse_yaml(text))
    return text + _dump({"sha256": checksums}, flow=False) + "runs:\n"


def start_text(
    plan: RunPlan,
    at: datetime,
    origin: Mapping[str, Any] | None = None,
    after_rejection: str = "",
) -> str:
    """Return the start part of a run."""
    fields = {
        key: value
        for key, value in asdict(plan).items()
        if key != "run" and value is not None and value != "" and value is not False
    }
    del fields["factors"]
    if plan.factors:
        fields["factors"] = plan.factor_values
    if fields.get("motion"):
        fields["motion"]["segments"] = [
            {k: v for k, v in segment.items() if k in _ALWAYS or v}
            for segment in fields["motion"]["segments"]
        ]
    fields["specimen"] = {k: v for k, v in fields["specimen"].items() if v is not None}
    fields = _printable(fields)
    lines = [f"- run: '{check_run_id(plan.run, 'campaign')}'", f"  plan: {_dump(fields)}"]
    if origin is not None:
        lines.append(f"  from: {_dump(dict(origin))}")
    start = {"at": at.isoformat(), "plan_sha256": content_checksum(fields)}
    if after_rejection:
        start["after_rejection"] = after_rejection
    lines.append(f"  start: {_dump(start)}")
    return "\n".join(lines) + "\n"


def stop_text(stop: Stop) -> str:
    """Return the stop part, which completes the item that ``start_text`` began."""
    return f"  stop: {_dump({key: v for key, v in asdict(stop).items() if v != ''})}\n"


def intact_length(data: bytes) -> int:
    """Return how many bytes of a journal are whole: a torn tail is not."""
    length = data.rfind(b"\n") + 1
    runs = data.find(_RUNS) + len(_RUNS) - 1
    item = data.rfind(b"\n- run:", runs, length)
    if item >= 0 and data.find(b"\n  start:", item, length) < 0:
        length = item + 1
    return length


def parse_journal(data: bytes, source: str) -> JournalContent:
    """Read a journal. Raises ``DataError`` naming ``source`` and the line or run."""
    intact = data[: intact_length(data)]
    warnings: tuple[str, ...] = ()
    if len(intact) < len(data):
        line = intact.count(b"\n") + 1
        warnings = (f"{source}: line {line}: half-written, left out; the host crashed there",)
    try:
        content = _parsed(intact.decode("utf-8"))
    except UnicodeDecodeError as error:
        line = intact.count(b"\n", 0, error.start) + 1
        raise DataError(f"{source}: line {line}: is not UTF-8 text") from None
    except ValueError as error:
        raise DataError(f"{source}: {error}", "The journal is not valid YAML.") from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        schema = content.get("schema") if isinstance(content, dict) else None
        found = "has no schema" if schema is None else f"schema is {schema!r}"
        raise DataError(
            f"{source}: {found}; expected {SCHEMA!r}",
            "The file was changed, or another version wrote it: restore it, or use that version.",
        )
    missing = [key for key in REQUIRED if key not in content]
    if missing:
        raise DataError(f"{source}: key {missing[0]!r} is missing")
    _check_header(content, source)
    items = content.pop("runs", None) or []
    if not isinstance(items, list):
        raise DataError(f"{source}: runs: is not a list")
    entries = tuple(_entry(item, f"{source}: runs.{n}") for n, item in enumerate(items))
    checksums = content.pop("sha256", None)
    warnings += tuple(f"{source}: {edit}" for edit in _edits(content, checksums, items))
    return JournalContent(content, entries, warnings)


def _parsed(text: str) -> Any:
    header, begin, lines = text.partition(_RUNS.decode())
    runs = parse_run_lines(lines) if begin and "runs" not in header else None
    if runs is None:
        return parse_yaml(text)
    content = parse_yaml(header + "\n")
    return content | {"runs": runs} if isinstance(content, dict) else content


def _check_header(header: dict[str, Any], source: str) -> None:
    """Raise ``DataError`` if a section of the header has the wrong type."""
    sources = ("simulated", "real", "imported")
    if header["source"] not in sources:
        raise DataError(
            f"{source}: source is {header['source']!r}; expected one of {', '.join(sources)}"
        )
    for key in (*_SECTIONS, "software", "firmware", "log"):
        section = header.get(key, {})
        whole = isinstance(section, dict)
        if whole and section and key in _SECTIONS:
            whole = isinstance(section.get("content"), dict)
        if not whole:
            raise DataError(f"{source}: {key}: is not a section written by hbench")
    if not isinstance(header["name"], str):
        raise DataError(f"{source}: name: is not text")
    if not isinstance(header.get("notes") or [], list):
        raise DataError(f"{source}: notes: is not a list")


def _entry(item: Any, source: str) -> Entry:
    try:
        if not isinstance(item["run"], str):
            raise ValueError(f"run is {item['run']!r}; expected text, in quotes")
        plan = read_plan(check_run_id(item["run"], source), item["plan"])
        stop, origin = item.get("stop"), item.get("from")
        if origin is not None and not isinstance(origin, dict):
            raise ValueError("from is not a section")
        after_rejection = item["start"].get("after_rejection", "")
        if not isinstance(after_rejection, str):
            raise ValueError("after_rejection is not text")
        return Entry(
            plan=plan,
            started=str(item["start"]["at"]),
            stop=None if stop is None else _stop(stop),
            origin=origin,
            after_rejection=after_rejection,
        )
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise DataError(f"{source}: is not a run written by hbench: {error}") from None


def _stop(fields: Mapping[str, Any]) -> Stop:
    stop = Stop(**fields)
    if stop.outcome not in get_args(Outcome):
        raise ValueError(f"outcome is {str(stop.outcome)[:40]!r}")
    if isinstance(stop.records, bool) or not isinstance(stop.records, int) or stop.records < 0:
        raise ValueError(f"records is {str(stop.records)[:40]!r}, not a count")
    if not all(isinstance(text, str) for text in (stop.at, stop.sha256, stop.why)):
        raise ValueError("at, sha256 and why of its stop part must be text")
    return stop


def _edits(header: Mapping[str, Any], checksums: Any, items: list[Any]) -> Iterator[str]:
    """Report the sections and plans that were changed after they were written."""
    if sections := edited_sections(header, checksums):
        yield f"{', '.join(sections)}: edited since the campaign was made (SHA-256 differs)"
    runs = (
        item["run"]
        for item in items
        if (stored := item["start"].get("plan_sha256")) is not None
        and stored != content_checksum(item["plan"])
    )
    if listed := ", ".join(runs):
        yield f"the plan of {listed}: edited since the run was made (SHA-256 differs)"


def _dump(value: Any, *, flow: bool = True) -> str:
    """Return YAML: block style, or flow style on one line without its end, JSON if possible."""
    value = _printable(value)
    if flow and (line := json_line(value)) is not None:
        return line
    text = yaml.dump(
        value,
        Dumper=_Dumper,
        default_flow_style=flow,
        width=_ONE_LINE,
        sort_keys=False,
        allow_unicode=True,
    )
    return text.rstrip("\n") if flow else text


def _printable(value: Any) -> Any:
    """Replace control characters, which YAML refuses; a folder's name can contain them."""
    if isinstance(value, str):
        return printable(value)
    if isinstance(value, Mapping):
        return {_printable(key): _printable(item) for key, item in value.items()}
    return [_printable(item) for item in value] if isinstance(value, list | tuple) else value
