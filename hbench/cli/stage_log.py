"""Log of a long command: its stages with time stamps, and a line while a stage lasts."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TextIO

from hbench.store.files.atomic import refused

_EVERY_S = 25.0  # of silence, then the stage is repeated: at least one line each 30 s


class StageLog:
    """Stages of a command, a line each with the time (UTC) and the seconds since the start."""

    def __init__(
        self,
        stream: TextIO,
        clock: Callable[[], float] = time.monotonic,
        now: Callable[[], datetime] = lambda: datetime.now(UTC),
    ):
        self._stream, self._clock, self._now = stream, clock, now
        self._start = self._last = self._began = clock()
        self._stage = self._count = ""
        self._lock = threading.Lock()

    def stage(self, text: str) -> None:
        """Write what begins."""
        with self._lock:
            self._stage, self._count, self._began = text, "", self._clock()
            self._write(text)

    def counted(self, done: int, total: int) -> None:
        """Note the number of finished simulations for the next line."""
        self._count = f", {done} of {total} simulations"

    def repeat(self) -> None:
        """Write how long the present stage has lasted, if nothing was written for a while."""
        with self._lock:
            if self.due_s() <= 0:
                lasted = self._clock() - self._began
                self._write(f"still {self._stage}: {lasted:.0f} s{self._count}")

    @contextmanager
    def repeated(self) -> Iterator[None]:
        """Repeat stages that last, in a thread that ends with the context."""
        ended = threading.Event()
        thread = threading.Thread(target=repeat_until, args=(self, ended.wait), daemon=True)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()

    def due_s(self) -> float:
        """Return the seconds until the next line is due."""
        return self._last + _EVERY_S - self._clock()

    def _write(self, text: str) -> None:
        self._last = self._clock()
        stamp = self._now().strftime("%Y-%m-%dT%H:%M:%SZ")
        with suppress(OSError):  # a full disk: the results' own files report it
            self._stream.write(f"{stamp} {self._last - self._start:7.1f} s  {text}\n")
            self._stream.flush()


def repeat_until(log: StageLog, wait: Callable[[float], bool]) -> None:
    """Repeat stages of ``log`` until ``wait``, which waits some seconds, returns True."""
    while not wait(max(log.due_s(), 0.0)):
        log.repeat()


@contextmanager
def stage_log(path: Path) -> Iterator[StageLog]:
    """Write a log to ``path``, in place of an earlier one, with the end or the error as last line.

    Raises ``DataError`` where the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        stream = path.open("w", encoding="utf-8")
    except OSError as error:
        raise refused(path, error) from error
    log, last = StageLog(stream), "finished"
    try:
        yield log
    except BaseException as error:
        last = f"ended by {type(error).__name__}: {error}".rstrip(": ")
        raise
    finally:
        log.stage(last)
        with suppress(OSError):  # lines that a full disk did not take
            stream.close()
