"""A process of its own for calls that may crash, or take too much memory or time."""

import atexit
import os
import pickle
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hbench.parallel.one_thread import ONE_THREAD


class CallKilled(Exception):
    """The process has died during a call; the message is the reason."""


class LimitedProcess:
    """A process that calls functions, one at a time, with limits of memory and time.

    It starts with the first call, again after its death, and ends with this process. It has a
    folder of its own for temporary files, which is removed when it ends. Where Python has no module
    ``resource`` (Windows), only the time is limited.
    """

    def __init__(self, memory: int, disk: int, seconds: float):
        self._memory = memory  # bytes that a call may take more than there were before it
        self._disk = disk  # bytes of a temporary file
        self._seconds = seconds  # of a call
        self._process: subprocess.Popen[bytes] | None = None
        self._folder = ""
        self._lock = threading.Lock()
        atexit.register(self.close)

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return ``function(*arguments)``, called in the process.

        The function, its arguments and its result must be picklable. Raises the exceptions of the
        function, and ``CallKilled`` if the process dies or exceeds the time.
        """
        with self._lock:
            try:
                is_result, answer = self._answer((function, arguments))
            except BaseException:  # also Ctrl-C: the answer of this call must not be the next one's
                self.close()
                raise
        if is_result:
            return answer
        raise answer

    @property
    def is_running(self) -> bool:
        """Whether the process has not died since it was started."""
        return self._process is not None

    def close(self) -> None:
        """End the process and remove its temporary files."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None
            shutil.rmtree(self._folder, ignore_errors=True)

    def _answer(self, request: Any) -> tuple[bool, Any]:
        process = self._process or self._start()
        assert process.stdin and process.stdout
        late = threading.Timer(self._seconds, process.kill)
        late.start()
        try:
            pickle.dump(request, process.stdin)
            process.stdin.flush()
            content, sizes = pickle.load(process.stdout)
            buffers = [bytearray(size) for size in sizes]
            for buffer in buffers:
                if process.stdout.readinto(buffer) < len(buffer):  # type: ignore[attr-defined]
                    raise EOFError
            answer: tuple[bool, Any] = pickle.loads(content, buffers=buffers)
            return answer
        except Exception:  # the pipe has ended, or what came through it is damaged
            is_late = not late.is_alive()
            process.kill()
            raise CallKilled(self._reason(process.wait(), is_late)) from None
        finally:
            late.cancel()

    def _start(self) -> subprocess.Popen[bytes]:
        self._folder = tempfile.mkdtemp(prefix="hbench-")
        limits = f"{self._memory}, {self._disk}, {self._seconds}"
        program = (
            f"import sys; sys.path[:] = {sys.path!r}\nfrom {__name__} import serve; serve({limits})"
        )
        self._process = subprocess.Popen(
            [sys.executable, "-c", program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **ONE_THREAD, "TMPDIR": self._folder, "TEMP": self._folder},
        )
        return self._process

    def _reason(self, exit_code: int, is_late: bool) -> str:
        if is_late or exit_code == -getattr(signal, "SIGXCPU", 0):
            return f"it takes longer than {self._seconds:g} s"
        if exit_code >= 0:
            return f"the reader has ended with exit code {exit_code}"
        return f"the reader has crashed ({signal.Signals(-exit_code).name})"


def serve(memory: int, disk: int, seconds: float) -> None:
    """Answer the calls that come from stdin, until it ends. The program of a limited process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that calls
    requests, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):  # what a library prints is no answer
        os.dup2(null, stream)
    while True:
        try:
            function, arguments = pickle.load(requests)
        except EOFError:  # the process that calls has ended without closing this one
            shutil.rmtree(os.environ["TMPDIR"], ignore_errors=True)
            return
        _set_limits(memory, disk, seconds)
        buffers: list[pickle.PickleBuffer] = []  # of arrays, which are not copied
        try:
            content = pickle.dumps((True, function(*arguments)), 5, buffer_callback=buffers.append)
        except Exception as error:
            content, buffers = pickle.dumps((False, error)), []
        parts = [buffer.raw() for buffer in buffers]
        pickle.dump((content, [part.nbytes for part in parts]), answers)
        for part in parts:
            answers.write(part)
        answers.flush()
        del function, arguments, content, buffers, parts


def _set_limits(memory: int, disk: int, seconds: float) -> None:
    """Limit this process to so much more memory and time than it has used so far."""
    try:
        import resource
    except ImportError:  # Windows
        return
    limits = {
        resource.RLIMIT_CPU: int(time.process_time() + seconds) + 1,
        resource.RLIMIT_FSIZE: disk,
        resource.RLIMIT_CORE: 0,
    }
    pages = Path("/proc/self/statm")
    if pages.exists():  # not on macOS, which does not observe this limit either
        used = int(pages.read_text().split()[0]) * resource.getpagesize()
        limits[resource.RLIMIT_AS] = used + memory
    for kind, limit in limits.items():
        hard = resource.getrlimit(kind)[1]
        soft = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
        resource.setrlimit(kind, (soft, hard))
