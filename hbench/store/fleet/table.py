"""A fleet's table in Parquet, with a row per campaign in the order of their paths.

Each number has six columns: ``NAME`` is the mean over the loads of a direction, or over the bands
of both, ``NAME_low`` and ``NAME_high`` its 95 % interval, ``NAME_se`` its standard error, of the
trials alone, ``NAME_trials`` and ``NAME_dof`` their number and degrees of freedom. The same rows
give the same bytes.
"""

import os
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hbench.errors import DataError
from hbench.records import QUANTITIES, FleetRow, Quantity, Side
from hbench.store.files.atomic import whole_file
from hbench.store.formats.parquet import require_pyarrow
from hbench.untrusted_text import printable

if TYPE_CHECKING:
    import pyarrow as pa

TABLE = "fleet.parquet"
SUFFIXES = ("low", "high", "se", "trials", "dof")
_BATCH = 10_000  # rows
_PLAIN = {
    "path": "string",
    "failed": "string",
    "name": "string",
    "source": "string",
    "bench": "string",
    "label": "string",
    "specimen": "string",
    "operator": "string",
    "mounting": "string",
    "day": "string",
    "seed": "int64",
    "started": "moment",
    "protocol": "string",
    "area_piston_m2": "double",
    "area_rod_m2": "double",
    "stroke_m": "double",
    "quality": "string",
    "drift_possible": "double",
    "weak": "string",
    "missing": "string",
    "logs_sha256": "string",
    "runs": "int64",
    "accepted": "int64",
    "v_m_s": "double",
    "distance_m": "double",
    "friction_work_j": "double",
}


def cells_of(row: FleetRow) -> list[Any]:
    """Return a row as JSON values, in the order of the table's columns."""
    cells: list[Any] = []
    for name, kind in _PLAIN.items():
        value = getattr(row, name)
        if kind == "moment":
            value = value and round(value.timestamp() * 1e6)
        elif name == "path":
            value = shown_path(row.path)
        cells.append(_finite(value))
    for quantity, side in _numbers():
        number = row.numbers.get((quantity.name, side))
        cells.append(_finite(number and number.value))
        cells += [_finite(number and getattr(number, suffix)) for suffix in SUFFIXES]
    return cells


def shown_path(path: str) -> str:
    """Return a path of any bytes as text without control characters."""
    return printable(os.fsencode(path).decode("utf-8", "backslashreplace"))


def write_table(path: Path, rows: Iterable[list[Any]]) -> None:
    """Write rows of ``cells_of`` as Parquet, a batch at a time. Raises ``DataError``."""
    import pyarrow.parquet as pq

    schema = _schema()
    remaining = iter(rows)
    with whole_file(path) as file, pq.ParquetWriter(file, schema, compression="zstd") as writer:
        while batch := list(islice(remaining, _BATCH)):
            writer.write_batch(_batch(batch, schema), row_group_size=_BATCH)


class FleetTable:
    """Reader of a table on disk, one column at a time. Raises ``DataError``, ``ConfigError``."""

    def __init__(self, path: Path):
        require_pyarrow()
        import pyarrow as pa
        import pyarrow.parquet as pq

        self._path = path
        try:
            with path.open("rb") as file:  # pyarrow opens no path that is not UTF-8
                self._metadata = pq.read_metadata(file)
        except (OSError, pa.ArrowException) as error:
            raise DataError(f"{path}: {error}") from None
        self.rows = self._metadata.num_rows

    def column(self, name: str) -> "pa.ChunkedArray":
        """Return a column."""
        import pyarrow.parquet as pq

        with self._path.open("rb") as file:
            table = pq.ParquetFile(file, metadata=self._metadata).read(columns=[name])
            return table.column(0)

    def numbers(self, name: str) -> np.ndarray:
        """Return a column (rows,) of numbers; a missing one is NaN."""
        return np.asarray(self.column(name).to_numpy(), dtype=float)

    def moments(self) -> np.ndarray:
        """Return the campaigns' starts (rows,), in seconds since 1970; NaN if not known."""
        import pyarrow as pa

        started_us = self.column("started").cast(pa.int64()).to_numpy()
        return np.asarray(started_us, dtype=float) / 1e6

    def counts(self, name: str) -> list[tuple[str, int]]:
        """Return a column's distinct texts with their frequencies, the most frequent first."""
        counted = self.column(name).value_counts().to_pylist()
        pairs = [(str(item["values"] or ""), item["counts"]) for item in counted]
        return sorted(pairs, key=lambda pair: (-pair[1], pair[0]))

    def equals(self, name: str, text: str) -> np.ndarray:
        """Return whether a column equals ``text`` (rows,)."""
        import pyarrow.compute as pc

        return np.asarray(pc.equal(self.column(name), text).fill_null(False).to_numpy(), bool)

    def values(self, name: str, rows: np.ndarray) -> list[Any]:
        """Return a column's values in some rows."""
        return self.column(name).take(rows).to_pylist()


def _numbers() -> Iterator[tuple[Quantity, Side]]:
    yield from ((quantity, side) for quantity in QUANTITIES for side in quantity.sides)


def _schema() -> "pa.Schema":
    import pyarrow as pa

    moment = pa.timestamp("us", tz="UTC")
    kinds = {
        "string": pa.string(), "int64": pa.int64(), "double": pa.float64(), "moment": moment,
    }  # fmt: skip
    fields = [(name, kinds[kind]) for name, kind in _PLAIN.items()]
    for quantity, side in _numbers():
        column = quantity.column(side)
        columns = (column, *(f"{column}_{suffix}" for suffix in SUFFIXES))
        fields += [(name, pa.float64()) for name in columns]
    return pa.schema(fields)


def _batch(rows: list[list[Any]], schema: "pa.Schema") -> "pa.RecordBatch":
    import pyarrow as pa

    columns = zip(*rows, strict=True)
    arrays = [pa.array(list(c), type=f.type) for c, f in zip(columns, schema, strict=True)]
    return pa.RecordBatch.from_arrays(arrays, schema=schema)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not np.isfinite(value) else value


def moment_of(seconds: float) -> datetime:
    """Return the moment of a time in seconds since 1970."""
    return datetime.fromtimestamp(seconds, UTC)
