"""Entry point of ``hbench`` and ``python -m hbench``."""

import signal
import sys

_INTERRUPTED = 130  # exit code, as by a shell


def main() -> None:
    """Load the command line and run it; an interrupt ends it without a traceback.

    After an interrupt another one ends the process at once, also while the interpreter shuts down.
    """
    try:
        from hbench.cli.main import main as command_line

        command_line()
    except KeyboardInterrupt:
        sys.exit(_INTERRUPTED)
    finally:
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):  # no SIGHUP on Windows
            number = getattr(signal, name, None)
            if number and signal.getsignal(number) is signal.default_int_handler:
                signal.signal(number, signal.SIG_DFL)


if __name__ == "__main__":
    main()
