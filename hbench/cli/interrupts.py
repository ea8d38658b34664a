"""Signals that end a command. It imports next to nothing: it is called before all else."""

import signal

NAMES = ("SIGINT", "SIGTERM", "SIGHUP")  # no SIGHUP on Windows


def end_as_by_ctrl_c() -> None:
    """Treat SIGTERM and SIGHUP like Ctrl-C, so that a command stops the bench before it ends."""
    for name in NAMES[1:]:
        number = getattr(signal, name, None)
        if number and signal.getsignal(number) is signal.SIG_DFL:  # nohup ignores SIGHUP
            signal.signal(number, signal.default_int_handler)


def end_at_once() -> None:
    """End the process without a traceback at the next of the signals."""
    for name in NAMES:
        number = getattr(signal, name, None)
        if number and signal.getsignal(number) is signal.default_int_handler:
            signal.signal(number, signal.SIG_DFL)
