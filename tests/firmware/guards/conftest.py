"""Recording of a session with the host library, and the program that repeats it elsewhere."""

import ctypes
import struct
import subprocess
from pathlib import Path

import pytest

from hbench.protocol.dictionary import FAULTS, PHASES, STATES
from hbench.rig.firmware import load_library

ROOT = Path(__file__).parents[3]
FIRMWARE = ROOT / "firmware"
SOURCES = [
    *sorted((FIRMWARE / "core").glob("*.c")),
    FIRMWARE / "ports" / "host" / "host.c",
    Path(__file__).with_name("play.c"),
    Path(__file__).with_name("play_on.c"),
]
TABLES = {"STATES": STATES, "PHASES": PHASES, "FAULTS": FAULTS}
OPTIONS = [
    "-std=c99",
    "-ffp-contract=off",
    *(f"-I{FIRMWARE / folder}" for folder in ("core", "ports/host")),
    *(f"-DPLAY_{name}={len(table)}" for name, table in TABLES.items()),
]


@pytest.fixture(scope="session")
def run():
    """Function that runs a command, which must succeed, and returns its result."""

    def run_command(*command, **kwargs) -> subprocess.CompletedProcess:
        done = subprocess.run([*map(str, command)], capture_output=True, **kwargs)
        assert done.returncode == 0, done.stderr.decode(errors="replace")
        return done

    return run_command


@pytest.fixture(scope="session")
def build(run):
    """Function that compiles the core, the host port and play.c to a program."""

    def compile_to(program: Path, compiler: str, *options: str) -> Path:
        run(compiler, *OPTIONS, *options, *SOURCES, "-o", program, cwd=program.parent)
        return program

    return compile_to


class Recording:
    """Firmware that records its inputs and outputs."""

    def __init__(self, firmware):
        self._firmware = firmware
        self.rows = []  # of the script
        self.output = bytearray()

    @property
    def script(self) -> bytes:
        return b"".join(self.rows)

    def receive(self, octets):
        for at in range(0, len(octets), 255):
            part = octets[at : at + 255]
            self.rows.append(b"R" + bytes((len(part),)) + part)
        return self._firmware.receive(octets)

    def poll(self):
        return self._firmware.poll()

    def transmit(self):
        octets = self._firmware.transmit()
        self.output += octets
        return octets

    def tick(self, words):
        codes = self._firmware.tick(words)
        self.output += struct.pack("<3h", *codes)
        row, count = struct.pack("<8H", *words), 1
        if self.rows and self.rows[-1][:1] == b"T" and self.rows[-1][3:] == row:
            count += int.from_bytes(self.rows.pop()[1:3], "little")
        self.rows.append(b"T" + count.to_bytes(2, "little") + row)
        return codes

    def skip_ticks(self, number):
        """Give the last tick a number, as after so many ticks."""
        skip = load_library().hb_probe_skip_ticks
        skip.restype, skip.argtypes = None, (ctypes.c_void_p, ctypes.c_uint32)
        skip(self._firmware.addresses[2], number)
        self.rows.append(b"N" + number.to_bytes(2, "little"))

    def close(self):
        self._firmware.close()


@pytest.fixture(scope="module")
def recorded_board(new_board):
    """A board that records its ``firmware.script`` (for play.c) and ``firmware.output``."""
    board = new_board()
    board.firmware = Recording(board.firmware)
    return board
