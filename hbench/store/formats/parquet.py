"""Parquet files."""

import io
from typing import TYPE_CHECKING, BinaryIO

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.files.bounded_read import LARGEST_UNPACKED, read_whole
from hbench.store.formats.arrays import Arrays
from hbench.store.formats.packages import require_package

if TYPE_CHECKING:
    from pandas import DataFrame


def open_parquet(file: BinaryIO, source: str, layout: Format) -> Arrays:
    """Return the columns of a file. Raises ``DataError``, ``ConfigError``."""
    frame = read_parquet(read_whole(file, source), source)
    return Arrays({str(name): frame[name].to_numpy() for name in frame.columns}, source)


def read_parquet(data: bytes, source: str) -> "DataFrame":
    """Return a Parquet file's data frame. Raises ``DataError``, ``ConfigError``."""
    require_pyarrow()
    import pandas as pd
    from pyarrow.parquet import ParquetFile

    try:
        about = ParquetFile(io.BytesIO(data)).metadata
        groups = [about.row_group(i).total_byte_size for i in range(about.num_row_groups)]
        size = max(8 * about.num_rows * about.num_columns, sum(groups))
        if size > LARGEST_UNPACKED:
            raise DataError(
                f"{source}: unpacks to {size / 1e6:.6g} MB; limit {LARGEST_UNPACKED / 1e6:g} MB",
                "Check that it is the right file; save fewer columns, or split it.",
            )
        return pd.read_parquet(io.BytesIO(data), engine="pyarrow")
    except DataError:
        raise
    except Exception as error:  # of many kinds
        raise DataError(f"{source}: can't be read as a Parquet file: {error}") from None


def require_pyarrow() -> None:
    """Raise ``ConfigError`` if pyarrow is not installed."""
    require_package("pyarrow", "Parquet", "parquet")
