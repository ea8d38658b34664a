"""Standard streams: a failure of stderr is ignored, that of stdout is an error."""

import io
import os
import sys
from contextlib import suppress
from typing import TextIO

from hbench.errors import DataError


def open_standard_streams() -> None:
    """Replace the standard streams by ones that a full disk or a closed terminal can't disturb.

    Progress and messages on stderr are lost where it takes nothing: a measurement goes on. A
    result that stdout does not take raises ``DataError``; a reader that has ended, such as
    ``head``, is no error: the command completes with its own exit code. Characters that an
    encoding does not have are escaped, since paths contain any. A stream that was closed takes
    and gives nothing: otherwise a campaign's file would be opened in its place.
    """
    while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(handle, True)
    os.close(handle)
    sys.stdout = _opened(sys.stdout, 1, _Result)
    sys.stderr = _opened(sys.stderr, 2, _Messages)


def _opened(before: TextIO | None, number: int, kind: type[io.TextIOWrapper]) -> TextIO:
    if before is not None and not _is(before, number):  # replaced by a caller
        if isinstance(before, io.TextIOWrapper):
            before.reconfigure(errors="backslashreplace")
        return before
    return kind(
        io.BufferedWriter(io.FileIO(number, "wb", closefd=False)),
        encoding=before.encoding if before else "utf-8",
        errors="backslashreplace",
        line_buffering=True,
    )


def _is(stream: TextIO, number: int) -> bool:
    with suppress(OSError, AttributeError):
        return stream.fileno() == number
    return False


# Both act on the text, not on the octets: an interrupt between the system's write and the return
# of a Python function for octets would leave them in the buffer, and they would be written twice.
# Both are flushed once more as Python exits, when this module's names may be gone.
class _Messages(io.TextIOWrapper):
    """Output that nobody needs."""

    def write(self, text: str) -> int:
        try:
            super().write(text)
        except OSError:
            pass
        return len(text)

    def flush(self) -> None:
        try:
            super().flush()
        except OSError:
            pass


class _Result(io.TextIOWrapper):
    """Output that a caller needs."""

    def write(self, text: str) -> int:
        try:
            super().write(text)
        except OSError as error:
            self._fail(error)
        return len(text)

    def flush(self) -> None:
        try:
            super().flush()
        except OSError as error:
            self._fail(error)

    def _fail(self, error: OSError) -> None:
        """Drop what was not written and what follows. Raises ``DataError`` if a reader waits."""
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, self.fileno())
        os.close(nothing)
        if not isinstance(error, BrokenPipeError):
            raise DataError(
                f"stdout: can't be written: {error.strerror}",
                "Check the free space where the output goes.",
            ) from None
