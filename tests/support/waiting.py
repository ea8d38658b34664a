"""Waiting for threads and processes."""

import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def wait_until(holds: Callable[[], object], patience_s: float) -> None:
    """Wait until something holds, at most for ``patience_s``."""
    deadline = time.monotonic() + patience_s
    while not holds():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.01)


@contextmanager
def killed_in_the_end(process: subprocess.Popen) -> Iterator[subprocess.Popen]:
    """Give a test a process that does not outlive it, whether the test passes or fails."""
    with process:
        try:
            yield process
        finally:
            process.kill()
