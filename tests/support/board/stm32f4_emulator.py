"""The STM32F4 port in QEMU (machine netduinoplus2), with a trace of its writes to registers.

The trace has each write in its order: the reports of ``firmware/ports/stm32f4/emulated.c``, masks
of the control interrupt, and, if all writes are traced, the words to the DAC, the services of the
watchdog, and the pin that releases the outputs.
"""

import os
import re
import select
import socket
import struct
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

PROGRAM = "qemu-system-arm"
ROWS = 0x08080000
NS_PER_INSTRUCTION = 8  # -icount shift=3
PATIENCE_S = 60.0

RELEASE_PIN, SYNC_PIN = 1 << 1, 1 << 12  # of GPIOB
GPIOB_BSRR, SPI2_DR, IWDG_KR = 0x40020418, 0x4000380C, 0x40003000
NVIC_ENABLE, NVIC_DISABLE, NVIC_PEND, TIM2_BIT = 0xE000E100, 0xE000E180, 0xE000E200, 1 << 28
TIM2_CR1 = 0x40000000
EXTI, REPORT_CODES, REPORT_BEGIN, REPORT_END = 0x40013C00, 0x04, 0x0C, 0x10

# Trace of all writes, or of those to EXTI and NVIC, whose addresses are then offsets.
_ALL = ("memory_region_ops_write",)
_REPORTS = ("stm32f4xx_exti_write", "nvic_sysreg_write")
_WRITE = re.compile(
    rb"^(memory|nvic|stm32f4xx_exti)\S+ .*?addr:? 0x([0-9a-f]+) (?:value|data|val:) 0x([0-9a-f]+)",
    re.MULTILINE,
)
_BASES = {b"memory": 0, b"nvic": 0xE000E000, b"stm32f4xx_exti": EXTI}


class Tick(NamedTuple):
    """A control interrupt."""

    begin_ns: int  # modulo 2^32
    instructions: int
    codes: tuple[int, int, int]
    row: int  # of the converter words that it has read
    dac: tuple[int, ...]  # words to the DAC, if all writes are traced


class Trace:
    """What the writes since a mark mean."""

    def __init__(self, writes: Iterator[tuple[int, int]]):
        self.ticks: list[Tick] = []
        self.events: list[str] = []  # "tick" or "request"
        self.words: list[int] = []  # of the DAC
        self.services: list[int] = []  # of the watchdog: number of ticks before each
        self.released: list[tuple[int, bool]] = []  # number of ticks before, outputs released
        octets, row, begin, first_word, codes, masked = b"", 0, None, 0, 0, False
        for address, value in writes:
            if address == EXTI + REPORT_BEGIN:
                begin, first_word = value, len(self.words)
            elif address == EXTI + REPORT_CODES:
                codes = value
            elif address == EXTI + REPORT_END and begin is not None:
                self.events.append("tick")
                both = map(_signed, (codes, codes >> 12, value))
                duration = (value >> 12) // NS_PER_INSTRUCTION
                dac = tuple(self.words[first_word:])
                self.ticks.append(Tick(begin, duration, tuple(both), row, dac))
                row += codes >> 31
            elif address == SPI2_DR:
                octets += bytes([value])
            elif address == GPIOB_BSRR and value == SYNC_PIN and octets:
                self.words.append(int.from_bytes(octets, "big"))
                octets = b""
            elif address == GPIOB_BSRR and value in (RELEASE_PIN, RELEASE_PIN << 16):
                self.released.append((len(self.ticks), value == RELEASE_PIN))
            elif address == IWDG_KR and value == 0xAAAA:
                self.services.append(len(self.ticks))
            elif address == NVIC_DISABLE and value == TIM2_BIT:
                masked = True
            elif address == NVIC_ENABLE and value == TIM2_BIT and masked:
                self.events.append("request")
                masked = False

    @property
    def codes(self) -> list[tuple[int, int, int]]:
        """The ticks' valve codes."""
        return [tick.codes for tick in self.ticks]


def _signed(bits: int) -> int:
    """A code of 12 bits."""
    return (bits & 0xFFF) - ((bits & 0x800) << 1)


class Machine:
    """An emulated board with the interface of ``HostFirmware``, except that its time runs freely.

    ``rows``, an array (n, 8) of converter words, begins at ``advance``; before and without it the
    words are those of the first row, or the middle of the range.
    """

    def __init__(self, image: Path, folder: Path, rows: np.ndarray | None = None, all_writes=True):
        self._log = folder / "trace.log"
        self._debugger = folder / "gdb"
        self._expected, self._received = 0, bytearray()
        self.frames: list[bytes] = []  # all that were sent
        self.replies = b""  # all that were received
        self._uart, far = socket.socketpair()
        self._go, far_go = socket.socketpair()
        loaded = []
        if rows is not None:
            table = folder / "rows.bin"
            table.write_bytes(struct.pack("<I", len(rows)) + rows.astype("<u2").tobytes())
            loaded = ["-device", f"loader,file={table},addr={ROWS:#x},force-raw=on"]
        events = _ALL if all_writes else _REPORTS
        command = [
            *(PROGRAM, "-M", "netduinoplus2", "-kernel", str(image), *loaded),
            *("-nic", "none", "-display", "none", "-monitor", "none"),
            *("-icount", "shift=3,sleep=off", "-D", str(self._log)),
            *(option for event in events for option in ("-trace", event)),
            *("-chardev", f"socket,id=go,fd={far_go.fileno()}", "-serial", "chardev:go"),
            *("-chardev", f"socket,id=uart,fd={far.fileno()}", "-serial", "chardev:uart"),
            *("-chardev", f"socket,id=gdb,path={self._debugger},server=on,wait=off"),
            *("-gdb", "chardev:gdb"),
        ]
        self._log.touch()
        with (folder / "stderr").open("w") as errors:
            self._process = subprocess.Popen(
                command, pass_fds=(far.fileno(), far_go.fileno()), stderr=errors
            )
        far.close()
        far_go.close()
        try:
            self.await_trace(lambda trace: trace.ticks)  # octets before are lost, as on the chip
        except BaseException:
            self.close()
            raise

    def receive(self, octets: bytes) -> None:
        """Send frames to the board."""
        self.frames.append(octets)
        self._expected += octets.count(0)
        self._uart.sendall(octets)

    def poll(self) -> int:
        """Wait for the replies to all frames."""
        deadline = time.monotonic() + PATIENCE_S
        while self._received.count(0) < self._expected:
            if not select.select([self._uart], [], [], max(deadline - time.monotonic(), 0))[0]:
                raise TimeoutError("the emulated board does not answer")
            octets = self._uart.recv(4096)
            assert octets, "the emulator has ended"
            self._received += octets
        return len(self._received)

    def transmit(self) -> bytes:
        """Return the octets from the board, and forget them."""
        octets = bytes(self._received)
        self.replies += octets
        self._expected -= octets.count(0)
        self._received.clear()
        return octets

    def advance(self) -> None:
        """Let the words follow the rows from now on."""
        self._go.sendall(b"\1")

    def debugger(self, address: int) -> "Debugger":
        """Stop the processor at an instruction and return a debugger."""
        debugger = Debugger(self._debugger)
        debugger.run_to(address)
        return debugger

    def close(self) -> None:
        """End the emulator."""
        self._process.kill()
        self._process.wait()
        self._uart.close()
        self._go.close()

    def mark(self) -> int:
        """The trace's present end."""
        return self._log.stat().st_size

    def trace(self, since: int = 0) -> Trace:
        """The writes from a mark until now."""
        with self._log.open("rb") as file:
            file.seek(since)
            text = file.read()
        return Trace(
            (_BASES[source] + int(address, 16), int(value, 16))
            for source, address, value in _WRITE.findall(text, 0, text.rfind(b"\n") + 1)
        )

    def await_trace(self, holds, since: int = 0) -> Trace:
        """Wait until something holds for the trace since a mark; return the trace."""
        deadline = time.monotonic() + PATIENCE_S
        while not holds(trace := self.trace(since)):
            assert self._process.poll() is None, "the emulator has ended"
            assert time.monotonic() < deadline, "it does not happen"
            time.sleep(0.02)
        return trace


class Debugger:
    """A client of the emulator's debugger (GDB remote serial protocol)."""

    def __init__(self, path: Path):
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(PATIENCE_S)
        self._socket.connect(os.fspath(path))
        self._text = b""
        # The connection has stopped the processor; QEMU before 8.1 reports that first.
        answer = self._ask("qXfer:features:read:target.xml:0,ffb")  # else no access to registers
        if answer.startswith("T02"):
            answer = self._answer()
        assert answer[:1] in ("l", "m"), answer

    def _ask(self, packet: str) -> str:
        octets = packet.encode()
        self._socket.sendall(b"+$%s#%02x" % (octets, sum(octets) % 256))
        return self._answer()

    def _answer(self) -> str:
        while not (answer := re.search(rb"\$([^#]*)#..", self._text)):
            octets = self._socket.recv(4096)
            assert octets, "the emulator has ended"
            self._text += octets
        self._text = self._text[answer.end() :]
        return answer[1].decode()

    def register(self, number: int) -> int:
        """Value of r0 to r15."""
        return int.from_bytes(bytes.fromhex(self._ask(f"p{number:x}")), "little")

    def set_register(self, number: int, value: int) -> None:
        """Set r0 to r15."""
        assert self._ask(f"P{number:x}={value.to_bytes(4, 'little').hex()}") == "OK"

    def write(self, address: int, value: int) -> None:
        """Write a word of 32 bits to the RAM."""
        assert self._ask(f"M{address:x},4:{value.to_bytes(4, 'little').hex()}") == "OK"

    def poke(self, store: int, address: int, value: int) -> None:
        """Write to a register of the chip, by the instruction ``str r1, [r0]`` at ``store``."""
        saved = {number: self.register(number) for number in (0, 1, 15)}
        for number, content in ((0, address), (1, value), (15, store)):
            self.set_register(number, content)
        self.step()
        for number, content in saved.items():
            self.set_register(number, content)

    def step(self) -> None:
        """Execute one instruction. Not while the processor sleeps: interrupts are off meanwhile."""
        assert self._ask("s").startswith("T05")

    def run_to(self, address: int) -> None:
        """Continue until an instruction; if it is the present one, until it comes again."""
        if self.register(15) == address:
            self.step()
        assert self._ask(f"Z0,{address:x},2") == "OK"
        assert self._ask("c").startswith("T05")
        assert self._ask(f"z0,{address:x},2") == "OK"

    def reset(self) -> None:
        """Reset the chip, as its watchdog would."""
        assert self._ask("qRcmd," + b"system_reset".hex()) == "OK"

    def leave(self) -> None:
        """Let the processor run."""
        assert self._ask("D") == "OK"
        self._socket.close()
