"""Parquet files."""

import io
from functools import partial
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.files.bounded_read import LARGEST_UNPACKED
from hbench.store.formats.arrays import Arrays, Signal
from hbench.store.formats.packages import require_package

if TYPE_CHECKING:
    from pandas import DataFrame

_FEW = 100  # rows read at a time: a text can be repeated in many rows


def open_parquet(file: BinaryIO, source: str, layout: Format) -> Arrays:
    """Return the columns of a file, read one by one."""
    from pyarrow.parquet import ParquetFile

    content = ParquetFile(file)
    return Arrays({field.name: _signal(content, field) for field in content.schema_arrow}, source)


def _signal(content: Any, field: Any) -> Signal | None:
    """Return a column of numbers or date-times; None for another."""
    from pyarrow import types

    kinds = (types.is_integer, types.is_floating, types.is_timestamp)
    if not any(is_kind(field.type) for is_kind in kinds):
        return None
    return Signal(content.metadata.num_rows, partial(_samples, content, field.name))


def _samples(content: Any, name: str) -> np.ndarray:
    return content.read(columns=[name], use_threads=False).column(name).to_numpy()


def read_parquet(data: bytes, source: str) -> "DataFrame":
    """Return a Parquet file's data frame. Raises ``DataError`` and others."""
    import pyarrow
    from pyarrow.parquet import ParquetFile

    content, batches, size = ParquetFile(io.BytesIO(data)), [], 0
    for batch in content.iter_batches(_FEW, use_threads=False):
        batches.append(batch)
        size += batch.nbytes
        if size > LARGEST_UNPACKED:
            raise DataError(
                f"{source}: unpacks to more than {LARGEST_UNPACKED / 1e6:g} MB",
                "Check that it is the right file; save fewer columns, or split it.",
            )
    table = pyarrow.Table.from_batches(batches, content.schema_arrow)
    return table.to_pandas(use_threads=False)


def require_pyarrow() -> None:
    """Raise ``ConfigError`` if pyarrow is not installed."""
    require_package("pyarrow", "Parquet", "parquet")
