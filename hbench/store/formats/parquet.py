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
    """Return a Parquet file's data frame. Raises ``DataError``, ``ConfigError`` and others."""
    require_pyarrow()
    from pyarrow.parquet import ParquetFile

    content = ParquetFile(io.BytesIO(data))
    about = content.metadata
    groups = [about.row_group(i).total_byte_size for i in range(about.num_row_groups)]
    size = max(8 * about.num_rows * about.num_columns, sum(groups))
    if size > LARGEST_UNPACKED:
        raise DataError(
            f"{source}: unpacks to {size / 1e6:.6g} MB; limit {LARGEST_UNPACKED / 1e6:g} MB",
            "Check that it is the right file; save fewer columns, or split it.",
        )
    return content.read(use_threads=False).to_pandas(use_threads=False)


def require_pyarrow() -> None:
    """Raise ``ConfigError`` if pyarrow is not installed."""
    require_package("pyarrow", "Parquet", "parquet")
