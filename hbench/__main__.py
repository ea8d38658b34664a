"""Entry point of ``hbench`` and ``python -m hbench``."""

import sys

from hbench.cli.interrupts import end_as_by_ctrl_c, end_at_once

_INTERRUPTED = 130  # exit code, as by a shell


def main() -> None:
    """Load the command line and run it; an interrupt ends it without a traceback.

    After an interrupt another one ends the process at once, also while the interpreter shuts down.
    """
    try:
        end_as_by_ctrl_c()
        from hbench.cli.main import main as command_line

        command_line()
    except KeyboardInterrupt:
        sys.exit(_INTERRUPTED)
    finally:
        end_at_once()


if __name__ == "__main__":
    main()
