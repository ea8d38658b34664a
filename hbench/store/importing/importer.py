"""Import of another bench's logs into a campaign folder.

Everything is read and checked first; then the runs are written, and ``campaign.yaml`` last, so
that an import that fails leaves no campaign behind.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from hbench.config.files.loading import read_yaml
from hbench.config.import_map import parse_import_map
from hbench.errors import ConfigError
from hbench.store.campaign import journal
from hbench.store.campaign.folder import JOURNAL, refuse_existing, sha256
from hbench.store.campaign.journal import Stop
from hbench.store.files.atomic import write_atomic
from hbench.store.files.run_csv import format_run
from hbench.store.importing.imported_run import ForeignRun, SourceFile
from hbench.store.importing.indexed_folder import read_indexed
from hbench.store.importing.mapped_files import read_mapped


@dataclass(frozen=True)
class ImportSummary:
    """What an import brought in."""

    runs: int
    files: int
    notes: tuple[str, ...]  # what was left out, assumed or noticed


def import_folder(
    source: Path,
    destination: Path,
    map_path: Path | None,
    software: Mapping[str, str],
    at: datetime,
) -> ImportSummary:
    """Import the logs in ``source`` as the campaign ``destination``.

    With ``map_path`` its files are read as the map says, else in the default layout.
    ``software`` and ``at`` go into the campaign's header. Raises ``ConfigError`` and
    ``DataError`` naming file and line; then nothing counts as imported.
    """
    if not source.is_dir():
        if source.exists():
            raise ConfigError(f"{source}: is a file", "Give the folder that it is in.")
        raise ConfigError(f"{source}: no such folder")
    refuse_existing(destination)
    header: dict[str, Any] = {"name": source.resolve().name, "source": "imported"}
    header |= {"created": at.isoformat(), "software": dict(software), "folder": str(source)}
    if map_path is None:
        found = read_indexed(source)
        if found.bench is not None:
            header["bench"] = found.bench
    else:
        content = read_yaml(map_path)
        rules = parse_import_map(content, str(map_path))
        found = read_mapped(source, rules)
        header |= {"name": rules.name, "map": {"file": map_path.name, "content": content}}
    files = {run.file.name: run.file for run in found.runs}
    notes = (*found.notes, *_duplicates(files.values()), *_maybe_cut(files.values()))
    text = [journal.header_text({**header, "notes": list(notes)})]
    for run in found.runs:
        text.append(_write_run(destination, run, at))
    write_atomic(destination / JOURNAL, "".join(text).encode())
    return ImportSummary(len(found.runs), len(files), notes)


def _write_run(destination: Path, run: ForeignRun, at: datetime) -> str:
    """Write a run's CSV and return its item of the journal."""
    data = format_run(run.channels)
    write_atomic(destination / "runs" / f"{run.plan.run}.csv", data)
    origin = {"file": run.file.name, "lines": list(run.lines), "sha256": run.file.sha256}
    stop = Stop(at.isoformat(), "done", len(run.channels["t_s"]), sha256(data))
    return journal.start_text(run.plan, at, origin) + journal.stop_text(stop)


def _duplicates(files: Iterable[SourceFile]) -> list[str]:
    first: dict[str, str] = {}
    notes = []
    for file in files:
        same = first.setdefault(file.sha256, file.name)
        if same != file.name:
            notes.append(f"{file.name} is byte for byte the same as {same}")
    return notes


def _maybe_cut(files: Iterable[SourceFile]) -> Iterator[str]:
    """Tell of files of text whose last line has no end: its last number may lack digits."""
    names = [
        file.name
        for file in files
        if not file.name.endswith((".mat", ".parquet")) and not file.data.endswith((b"\n", b"\r"))
    ]
    if names:
        few = ", ".join(names[:10]) + (", ..." if len(names) > 10 else "")
        yield f"the last line of {few} has no end, as in a file that was cut ({len(names)} files)"
