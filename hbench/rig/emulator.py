"""Emulator (QEMU, machine mps2-an386) of the firmware's image for the Cortex-M4, in lock-step.

Commands for single control ticks and idle-loop rounds go over the emulator's standard input and
output, which the image reaches by semihosting; UART0 is one end of a socket pair, whose octets pass
within the commands. Equal calls therefore have equal results, whatever the scheduling of the
emulator's threads.

Commands and answers are the structs of ``firmware/ports/mps2/main.c``.
"""

import os
import select
import socket
import struct
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from hbench.errors import ConfigError, DeviceError

PROGRAM = "qemu-system-arm"

_COMMAND = struct.Struct("<2I8H")  # code, octets that UART0 has been sent, converter words
_ANSWER = struct.Struct("<H3hI")  # mark, DAC codes, clocks of the SysTick
_TICK, _POLL, _RECEIVE = 1, 2, 3
_NO_WORDS = (0,) * 8
_MARK = b"BH"
_TIMEOUT_MS = 30_000  # of an answer; a tick takes some 10 us
_CHUNK = 4096

# An instruction takes 2^10 ns of emulated time, so that timing is reproducible; the emulator does
# not wait for that time to pass. SysTick counts it at 25 MHz.
_ICOUNT = "shift=10,sleep=off"
_CLOCKS_PER_INSTRUCTION = 1.024e-6 * 25e6


class EmulatedFirmware:
    """A board: an image in an emulator of its own, with the interface of ``HostFirmware``."""

    def __init__(self, image: Path):
        """Start the emulator.

        Raises ``ConfigError`` for a missing image, ``DeviceError`` if the emulator can't start.
        """
        if not image.is_file():
            raise ConfigError(
                f"{image}: does not exist",
                "Build it: cd firmware && cmake --preset mps2 && cmake --build --preset mps2.",
            )
        self._image = image
        self._received = bytearray()
        self._sent = 0  # octets to UART0
        self._stderr = tempfile.TemporaryFile()
        self._uart, far = socket.socketpair()
        try:
            self._process = subprocess.Popen(
                _command(image, far.fileno()),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._stderr,
                bufsize=0,
                pass_fds=(far.fileno(),),
                start_new_session=True,  # no Ctrl-C; it ends when its input is closed
            )
        except OSError as error:
            self._uart.close()
            self._stderr.close()
            raise DeviceError(
                f"{PROGRAM}: can't be started: {error.strerror or error}",
                "Install QEMU, for example with apt install qemu-system-arm.",
            ) from None
        finally:
            far.close()
        commands, answers = self._process.stdin, self._process.stdout
        assert commands is not None and answers is not None  # pipes, as requested above
        self._command_fd, self._answer_fd = commands.fileno(), answers.fileno()
        self._files = (commands, answers, self._uart, self._stderr)
        self._poller = select.poll()
        for source in (self._answer_fd, self._uart):
            self._poller.register(source, select.POLLIN)
        self.instructions = 0
        try:
            self.poll()
        except BaseException:
            self.close()
            raise

    def receive(self, data: bytes) -> None:
        """Send octets to the board; those beyond its queue (4096) are lost."""
        for first in range(0, len(data), _CHUNK):
            chunk = data[first : first + _CHUNK]
            with suppress(ConnectionError):  # the next command reports an emulator that has ended
                self._uart.sendall(chunk)
            self._sent = (self._sent + len(chunk)) % 2**32
            self._execute(_RECEIVE)

    def transmit(self) -> bytes:
        """Return the octets for the host, and remove them from the queue."""
        octets = bytes(self._received)
        self._received.clear()
        return octets

    def poll(self) -> int:
        """Run the idle loop once; return the number of octets for the host."""
        self._execute(_POLL)
        self._drain_uart()
        return len(self._received)

    def tick(self, adc: Sequence[int]) -> tuple[int, int, int]:
        """Run one control tick: converter words (8, in 1/16 count) to DAC codes (3)."""
        return self._execute(_TICK, adc)

    def close(self) -> None:
        """Kill the emulator; while it waits for a command, it ignores milder signals."""
        self._process.kill()
        self._process.wait()
        for file in self._files:
            file.close()

    def _execute(self, code: int, words: Sequence[int] = _NO_WORDS) -> tuple[int, int, int]:
        try:
            os.write(self._command_fd, _COMMAND.pack(code, self._sent, *words))
        except BrokenPipeError:
            raise self._failure("has ended") from None
        while self._answer_fd not in (ready := dict(self._poller.poll(_TIMEOUT_MS))):
            if not ready:
                raise self._failure(f"gave no answer in {_TIMEOUT_MS // 1000} s")
            self._drain_uart()
        answer = os.read(self._answer_fd, _ANSWER.size)
        if not answer:
            raise self._failure("has ended")
        if len(answer) != _ANSWER.size or answer[:2] != _MARK:
            raise self._failure("gave an answer that is not of the firmware's port mps2")
        _, *codes, clocks = _ANSWER.unpack(answer)
        self.instructions = round(clocks / _CLOCKS_PER_INSTRUCTION)
        return tuple(codes)

    def _drain_uart(self) -> None:
        """Receive UART0's octets; a reply of several frames can exceed the socket's buffer."""
        with suppress(BlockingIOError, ConnectionError):
            while octets := self._uart.recv(_CHUNK, socket.MSG_DONTWAIT):
                self._received += octets

    def _failure(self, what: str) -> DeviceError:
        self._stderr.seek(0)
        text = self._stderr.read().decode(errors="replace")
        lines = [line for line in text.splitlines() if ": warning: " not in line]
        reason = f": {lines[0][:120]}" if lines else ""
        return DeviceError(
            f"{self._image}: the emulated board {what}{reason}",
            "Give an image of firmware/ports/mps2.",
        )


def _command(image: Path, uart_fd: int) -> list[str]:
    return [
        PROGRAM,
        *("-M", "mps2-an386", "-kernel", str(image)),
        *("-nic", "none", "-display", "none", "-monitor", "none"),
        *("-semihosting-config", "enable=on,target=native"),
        *("-icount", _ICOUNT),
        *("-chardev", f"socket,id=uart0,fd={uart_fd}", "-serial", "chardev:uart0"),
    ]
