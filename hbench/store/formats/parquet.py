"""Parquet files."""

import io
from functools import partial
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from hbench.config.import_layout import Format
from hbench.store.files.bounded_read import check_unpacked
from hbench.store.formats.arrays import Arrays, Signal
from hbench.store.formats.packages import require_package

if TYPE_CHECKING:
    from pandas import DataFrame


_TOO_LARGE = "Check that it is the right file; save fewer columns, or split it."


def open_parquet(file: BinaryIO, source: str, layout: Format) -> Arrays:
    """Return the columns of a file, read one by one."""
    from pyarrow.parquet import ParquetFile

    content = ParquetFile(file)
    return Arrays({field.name: _signal(content, field) for field in content.schema_arrow}, source)


def _signal(content: Any, field: Any) -> Signal | None:
    """Return a column of numbers, date-times or durations in s; None for another."""
    from pyarrow import types

    kinds = (types.is_integer, types.is_floating, types.is_timestamp, types.is_duration)
    if not any(is_kind(field.type) for is_kind in kinds):
        return None
    unit = "s" if types.is_duration(field.type) else None
    return Signal(content.metadata.num_rows, partial(_samples, content, field.name), unit=unit)


def _samples(content: Any, name: str) -> np.ndarray:
    values = content.read(columns=[name], use_threads=False).column(name).to_numpy()
    return values / np.timedelta64(1, "s") if values.dtype.kind == "m" else values


def read_parquet(data: bytes, source: str) -> "DataFrame":
    """Return a Parquet file's data frame; texts are categories. Raises ``DataError`` and others."""
    from pyarrow import types
    from pyarrow.parquet import ParquetFile, read_schema

    fields = read_schema(io.BytesIO(data))
    texts = [f.name for f in fields if types.is_string(f.type) or types.is_large_string(f.type)]
    content = ParquetFile(io.BytesIO(data), read_dictionary=texts)
    about = content.metadata
    stated = sum(about.row_group(i).total_byte_size for i in range(about.num_row_groups))
    check_unpacked(stated, source, _TOO_LARGE)
    table = content.read(use_threads=False)
    size = sum(_unpacked_size(chunk) for column in table for chunk in column.chunks)
    check_unpacked(size, source, _TOO_LARGE)
    return table.to_pandas(use_threads=False)


def _unpacked_size(values: Any) -> int:
    """Return the bytes of an array whose repeated texts are written in full."""
    from pyarrow import compute, types

    if not types.is_dictionary(values.type):
        return values.nbytes
    lengths = compute.binary_length(values.dictionary).to_numpy(zero_copy_only=False)
    numbers = values.indices.drop_null().to_numpy()
    return 8 * len(values) + int(lengths[numbers].sum())


def require_pyarrow() -> None:
    """Raise ``ConfigError`` if pyarrow is not installed."""
    require_package("pyarrow", "Parquet", "parquet")
