"""The rows of a fleet during its analysis, in a SQLite file, so that finished rows are never lost.

Each call of ``hbench fleet`` analyzes the campaigns without a row and those whose fingerprint has
changed. Memory does not grow with their number: rows are on disk, in the order of their paths.
"""

import json
import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

from hbench.errors import ConfigError, DataError
from hbench.store.files.atomic import refused

ROWS = "fleet.sqlite"
_LAYOUT = 6  # of the file and of its cells
_BATCH = 1000
_MAKE = """
    CREATE TABLE rows (
        path BLOB PRIMARY KEY, round INTEGER NOT NULL, fingerprint TEXT, failed INTEGER, cells TEXT
    )
"""


class FleetRows:
    """Rows of the fleet in a folder, for one process at a time.

    Raises ``ConfigError`` if another process uses them, ``DataError`` if they can't be read or
    written.
    """

    def __init__(self, folder: Path):
        self._path = folder / ROWS
        with self._errors():
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise refused(folder, error) from None
            self._rows = sqlite3.connect(self._path, isolation_level=None, timeout=0.5)
            self._open()

    def _open(self) -> None:
        self._rows.execute("PRAGMA locking_mode = EXCLUSIVE")
        self._rows.execute("PRAGMA journal_mode = WAL")  # commits each row at little cost
        self._rows.execute("PRAGMA synchronous = NORMAL")
        self._rows.execute("BEGIN IMMEDIATE")
        (layout,) = self._rows.execute("PRAGMA user_version").fetchone()
        if layout != _LAYOUT:
            self._rows.execute("DROP TABLE IF EXISTS rows")
            self._rows.execute(_MAKE)
            self._rows.execute(f"PRAGMA user_version = {_LAYOUT}")
        (last,) = self._rows.execute("SELECT max(round) FROM rows").fetchone()
        self._round = (last or 0) + 1
        self._rows.execute("COMMIT")

    def __enter__(self) -> "FleetRows":
        return self

    def __exit__(
        self, kind: type | None, error: BaseException | None, at: TracebackType | None
    ) -> None:
        self._rows.close()

    def fingerprint(self, path: str) -> str | None:
        """Return a campaign's fingerprint at the time of its analysis, if it has a row."""
        with self._errors():
            row = self._rows.execute(
                "SELECT fingerprint FROM rows WHERE path = ?", (_key(path),)
            ).fetchone()
        return row[0] if row else None

    def register(self, campaigns: Iterable[tuple[str, bool]]) -> None:
        """Register the campaigns of this call: each one's path, and whether its row is valid."""
        with self._errors():
            self._rows.execute("BEGIN")
            try:
                for path, valid in campaigns:
                    kept = "" if valid else ", fingerprint = NULL, failed = NULL, cells = NULL"
                    self._rows.execute(
                        "INSERT INTO rows (path, round) VALUES (?, ?) "
                        f"ON CONFLICT (path) DO UPDATE SET round = excluded.round{kept}",
                        (_key(path), self._round),
                    )
            finally:
                self._rows.execute("COMMIT")

    def missing(self) -> Iterator[str]:
        """Yield the paths of the campaigns without a row, in order."""
        for path, *_ in self._in_order("path", "fingerprint IS NULL"):
            yield os.fsdecode(path)

    def keep(self, path: str, fingerprint: str, failed: bool, cells: list[Any]) -> None:
        """Store a campaign's row. The next call repeats a row without fingerprint."""
        text = json.dumps(cells, allow_nan=False, separators=(",", ":"))
        with self._errors():
            self._rows.execute(
                "UPDATE rows SET fingerprint = ?, failed = ?, cells = ? WHERE path = ?",
                (fingerprint, failed, text, _key(path)),
            )

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of campaigns of this call: all, those with a row, those failed."""
        with self._errors():
            campaigns, analyzed, failed = self._rows.execute(
                "SELECT count(*), count(fingerprint), sum(failed) FROM rows WHERE round = ?",
                (self._round,),
            ).fetchone()
        return campaigns, analyzed, failed or 0

    def cells(self) -> Iterator[list[Any]]:
        """Yield the rows of this call in the order of their paths."""
        for _, text in self._in_order("path, cells", "fingerprint IS NOT NULL"):
            yield json.loads(text)

    def remove_others(self) -> None:
        """Remove the rows of campaigns that this call has not registered."""
        with self._errors():
            self._rows.execute("DELETE FROM rows WHERE round < ?", (self._round,))

    def _in_order(self, columns: str, which: str) -> Iterator[tuple]:
        last = b""
        while True:
            with self._errors():
                batch = self._rows.execute(
                    f"SELECT {columns} FROM rows WHERE path > ? AND round = ? AND {which} "
                    f"ORDER BY path LIMIT {_BATCH}",
                    (last, self._round),
                ).fetchall()
            if not batch:
                return
            yield from batch
            last = batch[-1][0]

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            if "locked" in str(error):
                raise ConfigError(
                    f"{self._path}: is in use by another hbench", "Wait until it has ended."
                ) from None
            raise DataError(
                f"{self._path}: can't be read or written: {error}",
                "Check the free space, or delete the file to analyze all campaigns again.",
            ) from None


def _key(path: str) -> bytes:
    return os.fsencode(path)
