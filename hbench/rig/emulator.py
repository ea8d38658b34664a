"""The firmware's image for the Cortex-M4 in an emulator (QEMU, machine mps2-an386), in lock-step.

Control ticks and rounds of the idle loop are ordered one at a time over the emulator's standard
input and output, which the image reaches by semihosting; UART0 is one end of a socket pair, whose
octets pass within the orders too. So equal calls have equal results, however the emulator's
threads run.

Orders and answers are the structs of ``firmware/ports/mps2/main.c``.
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

_ORDER = struct.Struct("<8HI")  # code, converter words, octets that UART0 has been sent
_ANSWER = struct.Struct("<H3hI")  # mark, DAC codes, clocks of the SysTick
_TICK, _POLL, _RECEIVE = 1, 2, 3
_NO_WORDS = (0,) * 7
_MARK = b"BH"
_PATIENCE_MS = 30_000  # for an answer; a tick takes some 10 us
_CHUNK = 4096

# An instruction takes 2^10 ns of emulated time, so that the same image always takes the same; the
# emulator does not wait for that time to pass. SysTick counts it at 25 MHz.
_ICOUNT = "shift=10,sleep=off"
_CLOCKS_PER_INSTRUCTION = 1.024e-6 * 25e6


class EmulatedFirmware:
    """One board: an image in its own emulator, with the calls of ``HostFirmware``."""

    def __init__(self, image: Path):
        """Start the emulator.

        Raises ``ConfigError`` without an image, ``DeviceError`` where it can't be started.
        """
        if not image.is_file():
            raise ConfigError(
                f"{image}: no such file", "Build it: make -C firmware/ports/mps2, then see build/."
            )
        self._image = image
        self._said = bytearray()
        self._sent = 0  # octets to UART0
        self._complaints = tempfile.TemporaryFile()
        self._uart, far = socket.socketpair()
        try:
            self._process = subprocess.Popen(
                _command(image, far.fileno()),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._complaints,
                bufsize=0,
                pass_fds=(far.fileno(),),
                start_new_session=True,  # Ctrl-C is for us; when we end, its input does
            )
        except OSError as error:
            self._uart.close()
            self._complaints.close()
            raise DeviceError(
                f"{PROGRAM}: can't be started: {error.strerror or error}",
                "Install QEMU, e.g. `apt install qemu-system-arm`.",
            ) from None
        finally:
            far.close()
        orders, answers = self._process.stdin, self._process.stdout
        assert orders is not None and answers is not None  # pipes, as asked for
        self._order_fd, self._answer_fd = orders.fileno(), answers.fileno()
        self._ends = (orders, answers, self._uart, self._complaints)
        self._ears = select.poll()
        for end in (self._answer_fd, self._uart):
            self._ears.register(end, select.POLLIN)
        self.instructions = 0
        try:
            self.poll()
        except BaseException:
            self.close()
            raise

    def receive(self, data: bytes) -> None:
        """Send octets to the board; what finds no room in its queue (4096) is lost."""
        for first in range(0, len(data), _CHUNK):
            part = data[first : first + _CHUNK]
            with suppress(ConnectionError):  # the order tells of an emulator that has ended
                self._uart.sendall(part)
            self._sent = (self._sent + len(part)) % 2**32
            self._carry_out(_RECEIVE)

    def transmit(self) -> bytes:
        """Take the octets that wait for the host."""
        said = bytes(self._said)
        self._said.clear()
        return said

    def poll(self) -> int:
        """Run the idle loop once; returns the number of octets that wait for the host."""
        self._carry_out(_POLL)
        self._listen()
        return len(self._said)

    def tick(self, adc: Sequence[int]) -> tuple[int, int, int]:
        """Run one control tick: converter words (7, in 1/16 count) to DAC codes (3)."""
        return self._carry_out(_TICK, adc)

    def close(self) -> None:
        """End the emulator; while it waits for an order, it hears no milder signal."""
        self._process.kill()
        self._process.wait()
        for end in self._ends:
            end.close()

    def _carry_out(self, code: int, words: Sequence[int] = _NO_WORDS) -> tuple[int, int, int]:
        try:
            os.write(self._order_fd, _ORDER.pack(code, *words, self._sent))
        except BrokenPipeError:
            raise self._failure("has ended") from None
        while self._answer_fd not in (ready := dict(self._ears.poll(_PATIENCE_MS))):
            if not ready:
                raise self._failure(f"gave no answer in {_PATIENCE_MS // 1000} s")
            self._listen()
        answer = os.read(self._answer_fd, _ANSWER.size)
        if not answer:
            raise self._failure("has ended")
        if len(answer) != _ANSWER.size or answer[:2] != _MARK:
            raise self._failure("does not answer as the firmware's port mps2")
        _, *codes, clocks = _ANSWER.unpack(answer)
        self.instructions = round(clocks / _CLOCKS_PER_INSTRUCTION)
        return tuple(codes)

    def _listen(self) -> None:
        """Take what UART0 has sent; a reply of several frames may be more than the socket holds."""
        with suppress(BlockingIOError, ConnectionError):
            while octets := self._uart.recv(_CHUNK, socket.MSG_DONTWAIT):
                self._said += octets

    def _failure(self, what: str) -> DeviceError:
        self._complaints.seek(0)
        text = self._complaints.read().decode(errors="replace")
        lines = [line for line in text.splitlines() if ": warning: " not in line]
        why = f": {lines[0][:120]}" if lines else ""
        return DeviceError(
            f"{self._image}: the emulated board {what}{why}",
            "Is it the image of firmware/ports/mps2?",
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
