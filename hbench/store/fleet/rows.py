"""The rows of a fleet while it is made: in a SQLite file, so that what is done is never lost.

Each call of ``hbench fleet`` finds campaigns, does those without a row, and those whose fingerprint
has changed. Memory does not grow with their number: they are on disk, in the order of their paths.
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

ROWS = "fleet.sqlite"
_LAYOUT = 1  # of the file
_BATCH = 1000
_MAKE = """
    CREATE TABLE rows (
        path BLOB PRIMARY KEY, round INTEGER NOT NULL, fingerprint TEXT, failed INTEGER, cells TEXT
    )
"""


class FleetRows:
    """The rows in a folder, for one process at a time.

    Raises ``ConfigError`` where another has them, ``DataError`` where they can't be used.
    """

    def __init__(self, folder: Path):
        self._path = folder / ROWS
        with self._told():
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise DataError(f"{folder}: can't be used: {error.strerror}") from None
            self._rows = sqlite3.connect(self._path, isolation_level=None, timeout=0.5)
            self._open()

    def _open(self) -> None:
        self._rows.execute("PRAGMA locking_mode = EXCLUSIVE")
        self._rows.execute("PRAGMA journal_mode = WAL")  # a row is kept at once, and costs little
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

    def known(self, path: str) -> str | None:
        """Return the fingerprint that a campaign had when its row was made, if it has one."""
        with self._told():
            found = self._rows.execute(
                "SELECT fingerprint FROM rows WHERE path = ?", (_key(path),)
            ).fetchone()
        return found[0] if found else None

    def found(self, campaigns: Iterable[tuple[str, bool]]) -> None:
        """Take note of the campaigns of this call: the path of each, and whether its row holds."""
        with self._told():
            self._rows.execute("BEGIN")
            try:
                for path, holds in campaigns:
                    kept = "" if holds else ", fingerprint = NULL, failed = NULL, cells = NULL"
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
        """Keep the row of a campaign. One with no fingerprint is done again by the next call."""
        text = json.dumps(cells, allow_nan=False, separators=(",", ":"))
        with self._told():
            self._rows.execute(
                "UPDATE rows SET fingerprint = ?, failed = ?, cells = ? WHERE path = ?",
                (fingerprint, failed, text, _key(path)),
            )

    def counts(self) -> tuple[int, int, int]:
        """Return how many campaigns this call has found, how many have a row, and have failed."""
        with self._told():
            found = self._rows.execute(
                "SELECT count(*), count(fingerprint), sum(failed) FROM rows WHERE round = ?",
                (self._round,),
            ).fetchone()
        return found[0], found[1], found[2] or 0

    def cells(self) -> Iterator[list[Any]]:
        """Yield the rows of this call in the order of their paths."""
        for _, text in self._in_order("path, cells", "fingerprint IS NOT NULL"):
            yield json.loads(text)

    def forget_others(self) -> None:
        """Forget the campaigns that this call has not found."""
        with self._told():
            self._rows.execute("DELETE FROM rows WHERE round < ?", (self._round,))

    def _in_order(self, columns: str, which: str) -> Iterator[tuple]:
        last = b""
        while True:
            with self._told():
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
    def _told(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            if "locked" in str(error):
                raise ConfigError(
                    f"{self._path}: another hbench is at work with it", "Wait until it has ended."
                ) from None
            raise DataError(
                f"{self._path}: can't be used: {error}",
                "Check the free space; or delete the file, and all campaigns are done again.",
            ) from None


def _key(path: str) -> bytes:
    return os.fsencode(path)
