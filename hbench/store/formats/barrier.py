"""The one place where the exceptions of readers become errors for the user."""

from collections.abc import Iterator
from contextlib import contextmanager

from hbench.errors import NO_MEMORY, DataError, HbenchError

_LONGEST = 300  # characters of an exception's text


@contextmanager
def reader_errors(source: str, name: str = "") -> Iterator[None]:
    """Raise ``DataError`` for any exception of a reader, with its type and text.

    ``source`` is the file, or a part of it; ``name`` is that of the format. Errors for the user
    pass.
    """
    try:
        yield
    except HbenchError:
        raise
    except Exception as error:
        fault = f"{type(error).__name__}: {' '.join(str(error).split())[:_LONGEST]}"
        hint = (
            "Check that the file is complete and has the ending of its format; or save it again, "
            "for example as CSV."
        )
        if isinstance(error, MemoryError):
            fault, hint = "MemoryError: not enough memory", NO_MEMORY
        raise DataError(
            f"{source}: can't be read{f' as {name}' if name else ''}: {fault}", hint
        ) from error
