"""Reads whole files, and refuses one of a size that none of its kind has."""

from pathlib import Path

from hbench.config.files.regular_file import FileTooLarge, read_regular_file
from hbench.errors import DataError

# In bytes, such that reading one takes less than 500 MB of memory.
LARGEST_LOG = 40_000_000  # an hour and a half of a board's log at 100 Hz
LARGEST_JOURNAL = 8_000_000  # some nine thousand runs


def read_file(path: Path, largest: int = LARGEST_LOG, hint: str = "") -> bytes:
    """Return a file's bytes. Raises ``DataError``, before it is read if it is too large."""
    try:
        return read_regular_file(path, largest)
    except FileTooLarge as error:
        raise DataError(
            f"{path}: {error}", "Is it the right file? A longer log can be split."
        ) from None
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}", hint) from None


def check_inside(folder: Path, path: Path) -> None:
    """Raise ``DataError`` where ``path`` leads out of ``folder``, such as by a link."""
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (ValueError, OSError, RuntimeError):  # no path: a NUL, too long, links in a circle
        raise DataError(f"{folder}: {str(path)[-60:]!r} can't be a path") from None
    if not inside:
        raise DataError(
            f"{path}: leads out of {folder}",
            "A link there goes elsewhere; put the file itself in its place.",
        )
