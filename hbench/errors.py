"""Errors for users: one root class, each with an exit code and a hint; caught once in the CLI."""

import copyreg
from enum import IntEnum
from typing import Any

NO_MEMORY = (  # hint
    "Free memory, raise the limit of the process (ulimit -v), or split large files; a damaged file "
    "may also state a size that it does not have."
)


class ExitCode(IntEnum):
    """Exit codes of every command."""

    OK = 0
    BUG = 1
    USAGE = 2
    DEVICE = 3
    DATA = 4
    NOT_CONVERGED = 5
    NEGATIVE = 6


class HbenchError(Exception):
    """Root of all errors that the user can correct.

    ``message`` states the fault, the file, the key or run, the value and the limit;
    ``hint`` is one instruction.
    """

    exit_code = ExitCode.BUG

    def __init__(self, message: str, hint: str = ""):
        super().__init__(message)
        self.message = message
        self.hint = hint
        if hint:
            self.add_note(f"hint: {hint}")  # for tracebacks

    def __reduce__(self) -> tuple[Any, ...]:
        # Keeps message and hint between processes, whatever a subclass's constructor takes.
        new = copyreg.__newobj__  # type: ignore[attr-defined]
        return new, (type(self), *self.args), self.__dict__


class ConfigError(HbenchError):
    """An invalid bench, schedule or map file, or command line."""

    exit_code = ExitCode.USAGE


class DeviceError(HbenchError):
    """A failure or refusal of the board, or of the line to it."""

    exit_code = ExitCode.DEVICE


class DataError(HbenchError):
    """An unreadable or invalid log, campaign or firmware image."""

    exit_code = ExitCode.DATA


class ConvergenceError(HbenchError):
    """A computation that did not converge."""

    exit_code = ExitCode.NOT_CONVERGED
