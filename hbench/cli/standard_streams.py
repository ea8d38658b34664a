"""Standard streams: a failure of stderr is ignored, that of stdout is an error."""

import io
import os
import sys
from contextlib import suppress
from typing import Any, TextIO

from hbench.errors import DataError


def open_standard_streams() -> None:
    """Replace the standard streams by ones that a full disk or a closed terminal can't disturb.

    Progress and messages on stderr are lost where it takes nothing: a measurement goes on. A
    result that stdout does not take raises ``DataError``; a reader that has ended is no error
    here. Characters that an encoding does not have are escaped, since paths contain any. A stream
    that was closed takes and gives nothing: otherwise a campaign's file would be opened in its
    place.
    """
    while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(handle, True)
    os.close(handle)
    sys.stdout = _opened(sys.stdout, _Result(1, "wb", closefd=False))
    sys.stderr = _opened(sys.stderr, _Messages(2, "wb", closefd=False))


def _opened(before: TextIO | None, raw: io.FileIO) -> TextIO:
    if before is not None and not _is(before, raw.fileno()):  # replaced by a caller
        if isinstance(before, io.TextIOWrapper):
            before.reconfigure(errors="backslashreplace")
        return before
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=before.encoding if before else "utf-8",
        errors="backslashreplace",
        line_buffering=True,
    )


def _is(stream: TextIO, number: int) -> bool:
    with suppress(OSError, AttributeError):
        return stream.fileno() == number
    return False


class _Messages(io.FileIO):
    """Output that nobody needs."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError:
            return len(data)


class _Result(io.FileIO):
    """Output that a caller needs."""

    _failed = False  # once: what is flushed at the end is no second error

    def write(self, data: Any) -> int:
        if self._failed:
            return len(data)
        try:
            return super().write(data)
        except BrokenPipeError:
            raise
        except OSError as error:
            self._failed = True
            raise DataError(
                f"stdout: can't be written: {error.strerror}",
                "Check the free space where the output goes.",
            ) from None
