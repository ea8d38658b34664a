"""A process in a pseudo-terminal, and what its screen shows in the end."""

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
import time

_PARTS = re.compile(r"\x1b\[(\d*)([A-Za-z])|(\r)|(\n)|([^\r\n\x1b]+)")


class Terminal:
    """``hbench`` with its terminal, a context manager that kills it in the end."""

    def __init__(self, arguments, cwd, columns=100):
        self.shown = b""
        self._window, terminal = pty.openpty()
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
        self.process = subprocess.Popen(
            [sys.executable, "-m", "hbench", *map(str, arguments)],
            stdin=terminal,
            stdout=terminal,
            stderr=terminal,
            cwd=cwd,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "TERM": "xterm"},
            start_new_session=True,
        )
        os.close(terminal)

    def wait_for(self, words: bytes, patience_s=60.0):
        """Read until ``words`` are there, or the process has ended."""
        deadline = time.monotonic() + patience_s
        while words not in self.shown and self._read(0.1):
            assert time.monotonic() < deadline, self.shown

    def end(self) -> int:
        """Read to the end; return the exit code."""
        while self._read(60.0):
            pass
        return self.process.wait(60.0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self._window)

    def _read(self, timeout_s) -> bool:
        if not select.select([self._window], [], [], timeout_s)[0]:
            return True
        try:
            data = os.read(self._window, 65536)
        except OSError:  # nobody has it open any more
            return False
        self.shown += data
        return bool(data)


def screen(shown: bytes) -> list[str]:
    """Return the lines that a terminal shows after ``shown``; only what is used is known."""
    lines, row, column = [""], 0, 0
    text = shown.decode()
    position = 0
    while position < len(text):
        match = _PARTS.match(text, position)
        assert match, repr(text[position : position + 20])
        number, code, carriage_return, line_feed, words = match.groups()
        position = match.end()
        if code == "A":
            row -= int(number or 1)
            assert row >= 0, "above the first line"
        elif code == "J":
            lines[row] = lines[row][:column]
            del lines[row + 1 :]
        elif carriage_return:
            column = 0
        elif line_feed:
            row += 1
            lines += [""] * (row + 1 - len(lines))
        else:
            assert not code, f"unknown sequence {code}"
            lines[row] = (
                lines[row][:column].ljust(column) + words + lines[row][column + len(words) :]
            )
            column += len(words)
    return [line.rstrip() for line in lines]
