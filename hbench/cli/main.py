"""The application: commands, signals, and the one place that reports errors."""

import atexit
import errno
import gc
import os
import sys
from collections.abc import Callable
from typing import NoReturn

import typer

from hbench import __version__
from hbench.cli.commands import (
    analyze,
    compare,
    conformity,
    design,
    export,
    flash,
    fleet,
    identify,
    imports,
    init,
    ports,
    reconcile,
    rig,
    run,
    simulate,
    watch,
)
from hbench.cli.interrupts import end_as_by_ctrl_c
from hbench.cli.once import OnceCommand
from hbench.cli.standard_streams import open_standard_streams
from hbench.errors import NO_MEMORY, ConfigError, DataError, HbenchError
from hbench.parallel.one_thread import ONE_THREAD
from hbench.untrusted_text import printable

# Flags of the group that are not given: typer takes 0.05 s to convert their None to a bool.
_NOT_GIVEN = dict.fromkeys(("help", "install_completion", "show_completion"), False)

# Refusals of a path by the operating system: a user can correct these.
_REFUSED = frozenset(
    (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENAMETOOLONG, errno.ELOOP, errno.ENOTDIR)
)
_LONGEST_PATH = 100  # characters in a message

_LAST_SECOND = 253_402_300_799  # of the year 9999, after 1970

_NEW_OBJECTS = 200_000  # between two collections: at most some tens of megabytes

app = typer.Typer(
    name="hbench",
    help="Friction and efficiency of hydraulic cylinders, from a bench to a data sheet.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"default_map": _NOT_GIVEN},
)
_COMMANDS: dict[str, Callable[..., None]] = {
    "init": init.init,
    "flash": flash.flash,
    "ports": ports.ports,
    "rig": rig.rig,
    "run": run.run,
    "watch": watch.watch,
    "import": imports.import_,
    "export": export.export,
    "analyze": analyze.analyze,
    "report": analyze.report,
    "accept": conformity.accept,
    "certificate": conformity.certificate,
    "compare": compare.compare,
    "fleet": fleet.fleet,
    "identify": identify.identify,
    "reconcile": reconcile.reconcile,
    "design": design.design,
    "simulate": simulate.simulate,
}
for _name, _command in _COMMANDS.items():
    app.command(_name, cls=OnceCommand)(_command)


def _version(wanted: bool) -> None:
    if wanted:
        print(__version__)
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Print the version."
    ),
) -> None:
    pass


def _limit_threads() -> None:
    """Give linear algebra one thread, unless the user's environment has a number of them."""
    for name, number in ONE_THREAD.items():
        os.environ.setdefault(name, number)


def _limit_garbage_collection() -> None:
    """Collect cyclic garbage less often, and not at exit.

    A collection traverses all that was imported, which takes a tenth of a short command's time.
    """
    gc.set_threshold(_NEW_OBJECTS)
    atexit.register(gc.freeze)


def _check_source_date() -> None:
    """Refuse a ``SOURCE_DATE_EPOCH`` that is no time: numpy and matplotlib read it as they load.

    Raises ``ConfigError``.
    """
    text = os.environ.get("SOURCE_DATE_EPOCH")
    if text is None:
        return
    try:
        known = 0 <= int(text) <= _LAST_SECOND
    except ValueError:
        known = False
    if not known:
        raise ConfigError(
            f"SOURCE_DATE_EPOCH is {text[:_LONGEST_PATH]!r}; it must be a whole number of seconds "
            "after 1970",
            "Correct this environment variable, or unset it.",
        )


def main() -> None:
    """Run the command line; exit with the codes of ``ExitCode``.

    Raises ``KeyboardInterrupt`` before a command begins; during one, typer exits with 130.
    """
    open_standard_streams()
    end_as_by_ctrl_c()
    _limit_threads()
    _limit_garbage_collection()
    try:
        _check_source_date()
        app()
    except HbenchError as error:
        _end(error)
    except MemoryError:
        _end(DataError("not enough memory", NO_MEMORY))
    except OSError as error:
        if error.errno not in _REFUSED or not isinstance(error.filename, str | bytes):
            raise
        path = os.fsdecode(error.filename)
        path = path if len(path) <= _LONGEST_PATH else f"{path[:_LONGEST_PATH]}..."
        long = error.errno == errno.ENAMETOOLONG
        hint = "Choose a shorter name." if long else "Check the path and its permissions."
        _end(DataError(f"{path}: {error.strerror}", hint))


def _end(error: HbenchError) -> NoReturn:
    """Print an error with its hint, and exit with its code."""
    from hbench.config.files.key_lines import with_lines

    print(f"error: {printable(with_lines(error.message))}", file=sys.stderr)
    if error.hint:
        print(f"hint: {printable(error.hint)}", file=sys.stderr)
    sys.exit(error.exit_code)
