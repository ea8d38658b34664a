"""Errors that users see: one root, an exit code and a hint each, caught once around the app."""

import copyreg
from enum import IntEnum
from typing import Any


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
    """Root of all errors with a cause the user can act on.

    ``message`` names the file, the key or run, the value and the limit;
    ``hint`` says what to do next.
    """

    exit_code = ExitCode.BUG

    def __init__(self, message: str, hint: str = ""):
        super().__init__(message)
        self.message = message
        self.hint = hint
        if hint:
            self.add_note(f"hint: {hint}")  # for those who see the traceback

    def __reduce__(self) -> tuple[Any, ...]:
        # Between processes: as it is, whatever a subclass is made from.
        new = copyreg.__newobj__  # type: ignore[attr-defined]
        return new, (type(self), *self.args), self.__dict__


class ConfigError(HbenchError):
    """A bench, schedule or map file, or a command line, that can't be used as it is."""

    exit_code = ExitCode.USAGE


class DeviceError(HbenchError):
    """The board or the line to it failed or refused."""

    exit_code = ExitCode.DEVICE


class DataError(HbenchError):
    """A log, campaign or firmware image that can't be read or used."""

    exit_code = ExitCode.DATA


class ConvergenceError(HbenchError):
    """A computation that did not converge."""

    exit_code = ExitCode.NOT_CONVERGED
