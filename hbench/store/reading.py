"""Reads whole files, and refuses one of a size that none of its kind has."""

from pathlib import Path

from hbench.errors import DataError

# In bytes, such that reading one takes less than 500 MB of memory.
LARGEST_LOG = 40_000_000  # an hour and a half of a board's log at 100 Hz
LARGEST_JOURNAL = 8_000_000  # some nine thousand runs


def read_file(path: Path, largest: int = LARGEST_LOG, hint: str = "") -> bytes:
    """Return a file's bytes. Raises ``DataError``, before it is read if it is too large."""
    try:
        size = path.stat().st_size
        if size > largest:
            raise DataError(
                f"{path}: is {size / 1e6:.6g} MB large; limit {largest / 1e6:g} MB",
                "Is it the right file? A longer log can be split.",
            )
        return path.read_bytes()
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}", hint) from None
