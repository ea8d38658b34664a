"""Import of another bench's logs into a campaign folder.

The logs are read, checked and written one file at a time, to a temporary folder in the campaign's.
Once all are there they are moved to ``runs``, and ``campaign.yaml`` is written last, so that a
failed import leaves nothing behind.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hbench.config.files.loading import read_yaml
from hbench.config.import_map import parse_import_map
from hbench.errors import ConfigError, DataError
from hbench.sentences import abridged, counted
from hbench.store.campaign import journal
from hbench.store.campaign.folder import JOURNAL, refuse_existing
from hbench.store.campaign.journal import Stop
from hbench.store.campaign.lock_file import campaign_lock
from hbench.store.campaign.plan_fields import check_plan
from hbench.store.campaign.run_csv import format_run
from hbench.store.files.atomic import move_files, new_file, temporary_folder, write_atomic
from hbench.store.files.bounded_read import LARGEST_LOG, check_inside
from hbench.store.importing.imported_run import ImportedRun, SourceFile, StoredLog
from hbench.store.importing.indexed_folder import read_indexed
from hbench.store.importing.mapped_files import read_mapped

_PART = ".runs.part"  # folder in the campaign's


@dataclass(frozen=True)
class ImportSummary:
    """Numbers of imported runs and files, and notes."""

    runs: int
    files: int
    notes: tuple[str, ...]  # omissions, assumptions and irregularities


def import_folder(
    source: Path,
    destination: Path,
    map_path: Path | None,
    software: Mapping[str, str],
    at: datetime,
) -> ImportSummary:
    """Import the logs in ``source`` as the campaign ``destination``.

    ``map_path`` specifies the files' layout; without it they must have the default layout.
    ``software`` and ``at`` go into the campaign's header. Raises ``ConfigError`` and
    ``DataError`` naming file and line; then no campaign is written.
    """
    check_source(source)
    with campaign_lock(destination):
        refuse_existing(
            destination, "Give another folder with -o: an import does not add to a campaign."
        )
        check_inside(destination, destination / "runs")
        _refuse_own_files(source, destination / "runs")
        with temporary_folder(destination / _PART):
            return _import(source, destination, map_path, software, at)


def _import(
    source: Path,
    destination: Path,
    map_path: Path | None,
    software: Mapping[str, str],
    at: datetime,
) -> ImportSummary:
    store = partial(_store_log, destination / _PART)
    header: dict[str, Any] = {"name": source.resolve().name, "source": "imported"}
    header |= {"created": at.isoformat(), "software": dict(software), "folder": str(source)}
    if map_path is None:
        imported = read_indexed(source, store)
        if imported.bench is not None:
            header["bench"] = imported.bench
        if imported.settings is not None:
            header["settings"] = imported.settings
    else:
        content = read_yaml(map_path)
        rules = parse_import_map(content, str(map_path))
        imported = read_mapped(source, rules, store)
        header |= {"name": rules.name, "map": {"file": map_path.name, "content": content}}
    files = {run.file.name: run.file for run in imported.runs}
    notes = (*imported.notes, *_duplicates(files.values()), *_truncations(files.values()))
    text = [journal.journal_header({**header, "notes": list(notes)})]
    text += [_journal_item(run, at) for run in imported.runs]
    move_files(destination / _PART, destination / "runs")
    write_atomic(destination / JOURNAL, "".join(text).encode())
    return ImportSummary(len(imported.runs), len(files), notes)


def check_source(source: Path) -> None:
    """Raise ``ConfigError`` unless ``source`` is a folder."""
    if not source.is_dir():
        if source.exists():
            raise ConfigError(f"{source}: is a file", "Give the folder that contains it.")
        raise ConfigError(f"{source}: does not exist", "Give an existing folder.")


def _refuse_own_files(source: Path, runs: Path) -> None:
    """Raise ``ConfigError`` if the import would replace files of the imported folder."""
    if runs.exists() and runs.resolve().is_relative_to(source.resolve()):
        raise ConfigError(
            f"{runs}: is a part of the imported folder, whose files are never replaced",
            "Choose another folder with -o.",
        )


def _store_log(folder: Path, name: str, run: str, channels: Mapping[str, np.ndarray]) -> StoredLog:
    """Write a run of the file ``name`` as CSV to ``folder``, also again. Raises ``DataError``."""
    sha256, size = hashlib.sha256(), 0
    (folder / f"{run}.csv").unlink(missing_ok=True)
    with new_file(folder / f"{run}.csv") as file:
        for rows in format_run(channels):
            file.write(rows)
            sha256.update(rows)
            size += len(rows)
            check_log_size(size, name, run, channels)
    return StoredLog(len(channels["t_s"]), sha256.hexdigest())


def check_log_size(size: int, name: str, run: str, channels: Mapping[str, np.ndarray]) -> None:
    """Raise ``DataError`` if a run's CSV of ``size`` bytes could not be read again."""
    if size > LARGEST_LOG:
        raise DataError(
            f"{name}: run {run} has {len(channels['t_s'])} samples, which take more than "
            f"{LARGEST_LOG / 1e6:g} MB as CSV",
            "Write 'resample: 100 Hz' in the map, or cut the file into strokes.",
        )


def _journal_item(run: ImportedRun, at: datetime) -> str:
    """Return a run's item for the journal. Raises ``DataError``."""
    try:
        check_plan(run.plan)
    except ValueError as error:  # such as the trial 0, by the file's name
        raise DataError(f"{run.file.name}: {error}") from None
    origin = {"file": run.file.name, "lines": list(run.lines), "sha256": run.file.sha256}
    if run.start is not None:
        origin["start"] = run.start.isoformat()
    stop = Stop(at.isoformat(), run.outcome, run.log.samples, run.log.sha256, run.why)
    return journal.start_text(run.plan, at, origin) + journal.stop_text(stop)


def _duplicates(files: Iterable[SourceFile]) -> list[str]:
    first: dict[str, str] = {}
    notes = []
    for file in files:
        same = first.setdefault(file.sha256, file.name)
        if same != file.name:
            notes.append(f"{file.name} and {same} are identical files")
    return notes


def _truncations(files: Iterable[SourceFile]) -> Iterator[str]:
    """Report text files without a final newline: the last number can be incomplete."""
    names = [file.name for file in files if file.is_truncated]
    if names:
        few = abridged(names, 10)
        yield f"no newline at the end of {few}: possibly truncated ({counted(len(names), 'file')})"
