"""Files that an export would replace."""

from pathlib import Path

from hbench.errors import ConfigError


def refuse_replacing(path: Path, data: bytes) -> None:
    """Raise ``ConfigError`` if a file has other content: a log, or a bench file that was edited."""
    if path.exists() and not (path.is_file() and path.read_bytes() == data):
        raise ConfigError(
            f"{path}: exists already with other content, and an export of runs replaces no file",
            "Choose another folder, or delete the earlier export.",
        )
