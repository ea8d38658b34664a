"""Reading of whole files up to a size limit."""

from pathlib import Path

from hbench.config.files.regular_file import FileTooLarge, read_regular_file
from hbench.errors import DataError

# In bytes: reading a file of this size takes less than 500 MB of memory.
LARGEST_LOG = 40_000_000  # an hour and a half of a board's log at 100 Hz
LARGEST_JOURNAL = 8_000_000  # some nine thousand runs


def read_file(path: Path, largest: int = LARGEST_LOG, hint: str = "") -> bytes:
    """Return a file's bytes. Raises ``DataError``; a too large file is refused before reading."""
    try:
        return read_regular_file(path, largest)
    except FileTooLarge as error:
        raise DataError(
            f"{path}: {error}", "Check that it is the right file; split a longer log."
        ) from None
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}", hint) from None


def check_inside(folder: Path, path: Path) -> None:
    """Raise ``DataError`` if ``path`` is outside ``folder``, for example through a link."""
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (ValueError, OSError, RuntimeError):  # a NUL, too long, or a loop of links
        raise DataError(f"{folder}: {str(path)[-60:]!r} is not a valid path") from None
    if not inside:
        raise DataError(
            f"{path}: is outside {folder}",
            "Put the file itself into the folder; links and paths out of it are refused.",
        )
