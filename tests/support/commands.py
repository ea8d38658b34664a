"""``hbench`` called in this process: as fast as a function, with the exit code of a command."""

import io
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from subprocess import CompletedProcess
from unittest import mock

from hbench import workflow
from hbench.cli.main import main


def hbench(*arguments) -> CompletedProcess[str]:
    """Run the command line; return its exit code, stdout and stderr."""
    words = [str(argument) for argument in arguments]
    out, err = io.StringIO(), io.StringIO()
    code = 0
    argv = mock.patch.object(sys, "argv", ["hbench", *words])
    with argv, redirect_stdout(out), redirect_stderr(err), _signals_restored():
        try:
            main()
        except SystemExit as ended:
            code = int(ended.code or 0)
    return CompletedProcess(words, code, out.getvalue(), err.getvalue())


@contextmanager
def _signals_restored() -> Iterator[None]:
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = [signal.getsignal(number) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


def computed_once(monkeypatch, name: str) -> None:
    """Let ``workflow.name`` return its first result at each call: two commands show the same."""
    compute, found = getattr(workflow, name), []

    def once(*arguments, **options):
        if not found:
            found.append(compute(*arguments, **options))
        return found[0]

    monkeypatch.setattr(workflow, name, once)
