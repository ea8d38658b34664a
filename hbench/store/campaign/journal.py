"""The text of ``campaign.yaml``: an append-only journal that is valid YAML after every append.

    schema: hbench.campaign/1
    name: ...                          the header, written once
    sha256: {bench: ..., ...}          of its sections: an edit is told, and not refused
    runs:
    - run: '0001'                      start part, appended when a run starts
      plan: {kind: steady, ...}
      start: {at: '2024-05-01T12:00:00+00:00', plan_sha256: ...}
      stop: {at: ..., outcome: done, records: 812, sha256: ...}      appended when it ends

A run without stop part is one during which the host crashed. A crash may also leave the last
line half-written; it is then left out, and said so. A run made again is a second item. One that
was made again at once, since it had been rejected, holds the reasons in its ``start`` as
``after_rejection``.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any, get_args

import yaml

from hbench.config.files.yaml_text import parse_yaml
from hbench.errors import DataError
from hbench.records import Outcome, RunPlan
from hbench.store.campaign.checksums import edited_sections, seal, sealed_sections
from hbench.store.campaign.plan_fields import read_plan
from hbench.untrusted_text import printable

SCHEMA = "hbench.campaign/1"
REQUIRED = ("name", "source", "created")

_ONE_LINE = 2**30
_RUN_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}")
_RUNS = b"\nruns:\n"


_Base: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


class _Dumper(_Base):
    """A dumper that writes a value out each time, for readers of the file: no ``*id001``."""

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
    """One time that a run was made."""

    plan: RunPlan
    started: str
    stop: Stop | None  # None: crashed
    origin: Mapping[str, Any] | None = None  # of an imported run: file, lines, sha256
    after_rejection: str = ""  # why the attempt before it was rejected, of a run made again at once


@dataclass(frozen=True)
class Journal:
    """What ``campaign.yaml`` says."""

    header: dict[str, Any]
    entries: tuple[Entry, ...]
    warnings: tuple[str, ...]


def check_run_id(run: str, source: str) -> str:
    """Return ``run`` if it can name a file inside the campaign. Raises ``DataError``."""
    if not _RUN_ID.fullmatch(run) or run.endswith("."):
        raise DataError(
            f"{source}: run {run!r} can't name a file",
            "Use letters, digits and . _ + - in a run's name.",
        )
    return run


def header_text(header: Mapping[str, Any]) -> str:
    """Return the journal's beginning; ``REQUIRED`` keys must be there.

    The schema is added, and the hashes by which an edited section is known.
    """
    missing = [key for key in REQUIRED if key not in header]
    if missing or "runs" in header:
        raise ValueError(f"campaign header lacks {missing} or holds 'runs'")
    text = _dump({"schema": SCHEMA, **header}, flow=False)
    seals = sealed_sections(parse_yaml(text))
    return text + _dump({"sha256": seals}, flow=False) + "runs:\n"


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
        if key != "run" and value is not None and value != ""
    }
    fields["specimen"] = {k: v for k, v in fields["specimen"].items() if v is not None}
    text = _dump(fields)
    lines = [f"- run: '{check_run_id(plan.run, 'campaign')}'", f"  plan: {text}"]
    if origin is not None:
        lines.append(f"  from: {_dump(dict(origin))}")
    start = {"at": at.isoformat(), "plan_sha256": seal(parse_yaml(text))}
    if after_rejection:
        start["after_rejection"] = after_rejection
    lines.append(f"  start: {_dump(start)}")
    return "\n".join(lines) + "\n"


def stop_text(stop: Stop) -> str:
    """Return the stop part, which goes on the item that ``start_text`` began."""
    return f"  stop: {_dump({key: v for key, v in asdict(stop).items() if v != ''})}\n"


def intact_length(data: bytes) -> int:
    """Return how many bytes of a journal are whole: a torn tail is not."""
    length = data.rfind(b"\n") + 1
    runs = data.find(_RUNS) + len(_RUNS) - 1
    item = data.rfind(b"\n- run:", runs, length)
    if item >= 0 and data.find(b"\n  start:", item, length) < 0:
        length = item + 1
    return length


def parse_journal(data: bytes, source: str) -> Journal:
    """Read a journal. Raises ``DataError`` naming ``source`` and the line or run."""
    intact = data[: intact_length(data)]
    warnings: tuple[str, ...] = ()
    if len(intact) < len(data):
        line = intact.count(b"\n") + 1
        warnings = (f"{source}: line {line}: half-written and left out; the host crashed there",)
    try:
        content = parse_yaml(intact.decode("utf-8"))
    except UnicodeDecodeError as error:
        line = intact.count(b"\n", 0, error.start) + 1
        raise DataError(f"{source}: line {line}: not text in UTF-8") from None
    except ValueError as error:
        raise DataError(f"{source}: {error}", "The journal is not valid YAML.") from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        found = content.get("schema") if isinstance(content, dict) else None
        raise DataError(f"{source}: schema is {found!r}; expected {SCHEMA!r}")
    missing = [key for key in REQUIRED if key not in content]
    if missing:
        raise DataError(f"{source}: key {missing[0]!r} is missing")
    _check_header(content, source)
    items = content.pop("runs", None) or []
    if not isinstance(items, list):
        raise DataError(f"{source}: runs: not a list")
    entries = tuple(_entry(item, f"{source}: runs.{n}") for n, item in enumerate(items))
    seals = content.pop("sha256", None)
    warnings += tuple(f"{source}: {words}" for words in _edited(content, seals, items))
    return Journal(content, entries, warnings)


def _check_header(header: dict[str, Any], source: str) -> None:
    """Raise ``DataError`` where a section of the header is not of its kind."""
    if header["source"] not in ("simulated", "real", "imported"):
        raise DataError(f"{source}: source is {header['source']!r}, which no campaign has")
    for key in ("bench", "schedule", "map", "software", "firmware", "log"):
        section = header.get(key, {})
        whole = isinstance(section, dict)
        if whole and section and key in ("bench", "schedule", "map"):
            whole = isinstance(section.get("content"), dict)
        if not whole:
            raise DataError(f"{source}: {key}: not a section as this program writes it")
    if not isinstance(header["name"], str) or not header["name"].strip():
        raise DataError(f"{source}: name: is not text")
    if not isinstance(header.get("notes") or [], list):
        raise DataError(f"{source}: notes: not a list")


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
        raise DataError(f"{source}: not a run as this program writes it: {error}") from None


def _stop(fields: Mapping[str, Any]) -> Stop:
    stop = Stop(**fields)
    if stop.outcome not in get_args(Outcome):
        raise ValueError(f"outcome is {str(stop.outcome)[:40]!r}")
    if isinstance(stop.records, bool) or not isinstance(stop.records, int) or stop.records < 0:
        raise ValueError(f"records is {str(stop.records)[:40]!r}, not a count")
    if not all(isinstance(text, str) for text in (stop.at, stop.sha256, stop.why)):
        raise ValueError("at, sha256 and why of its stop part must be text")
    return stop


def _edited(header: Mapping[str, Any], seals: Any, items: list[Any]) -> Iterator[str]:
    """Tell which sections and plans are not as they were written."""
    if sections := edited_sections(header, seals):
        yield f"{', '.join(sections)}: edited since the campaign was made (SHA-256 differs)"
    runs = (
        item["run"]
        for item in items
        if (kept := item["start"].get("plan_sha256")) is not None and kept != seal(item["plan"])
    )
    if words := ", ".join(runs):
        yield f"the plan of {words}: edited since the run was made (SHA-256 differs)"


def _dump(value: Any, *, flow: bool = True) -> str:
    """Return YAML: block style, or flow style on one line without its end."""
    text = yaml.dump(
        _printable(value),
        Dumper=_Dumper,
        default_flow_style=flow,
        width=_ONE_LINE,
        sort_keys=False,
        allow_unicode=True,
    )
    return text.rstrip("\n") if flow else text


def _printable(value: Any) -> Any:
    """Leave out what no reader of the journal takes, such as a folder's name can hold."""
    if isinstance(value, str):
        return printable(value)
    if isinstance(value, Mapping):
        return {_printable(key): _printable(one) for key, one in value.items()}
    return [_printable(one) for one in value] if isinstance(value, list | tuple) else value
