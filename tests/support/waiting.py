"""Waiting for threads and processes."""

import time
from collections.abc import Callable


def wait_until(holds: Callable[[], object], patience_s: float) -> None:
    """Wait until something holds, at most for ``patience_s``."""
    deadline = time.monotonic() + patience_s
    while not holds():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.01)
