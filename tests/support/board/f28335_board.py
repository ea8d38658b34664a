"""The F28335 port as a library of the host with simulated registers; the chip as a board."""

import re
import shutil
import subprocess
from pathlib import Path

from tests.support import ROOT

CORE = ROOT / "firmware" / "core"
PORT = ROOT / "firmware" / "ports" / "f28335"
SOURCES = sorted(PORT.glob("*.c"))
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
# On the C28x a bool is as wide as any other word.
STDBOOL = "typedef unsigned short bool;\n#define true 1\n#define false 0\n"
REGISTERS = """
#include "compiler.h"
hb_u16 (*hb_read)(hb_u16);
void (*hb_write)(hb_u16, hb_u16);
void (*hb_write_vector)(hb_u16, hb_handler);
void (*hb_execute)(hb_u16);
hb_u16 hb_ier, hb_ifr;
"""


def build(folder: Path, *options: str, sources: list[Path]) -> Path:
    """Compile sources of the port to a library whose registers a ``Chip`` provides."""
    registers = folder / "registers_of_the_test.c"
    registers.write_text(REGISTERS)
    library = folder / "libport.so"
    command = [COMPILER, "-std=c99", "-O1", "-ffp-contract=off", "-fPIC", "-shared"]
    command += [f"-I{CORE}", f"-I{PORT}", "-DHB_OCTET=unsigned short", *options]
    subprocess.run([*command, *sources, registers, "-o", library], check=True)
    return library


def data_words(folder: Path, gcc: str, nm: str) -> dict[str, int]:
    """Sizes of the port's variables in words of 16 bits, by name.

    An ARM lays structs out as a C28x does if octets and bools have 16 bits: integers of 16 bits
    take one word, floats, longs and pointers two, on even addresses.
    """
    (folder / "stdbool.h").write_text(STDBOOL)
    words = {}
    for source in SOURCES:
        command = [gcc, "-std=c99", "-ffreestanding", "-fno-common", "-DHB_OCTET=unsigned short"]
        command += [f"-I{folder}", f"-I{CORE}", "-c", source, "-o", folder / "x.o"]
        subprocess.run(command, check=True)
        words |= {
            f"{source.stem}.{name}": size // 2
            for name, size in data_sizes(folder / "x.o", nm).items()
        }
    return words


def data_sizes(binary: Path, nm: str) -> dict[str, int]:
    """Sizes of the variables in an object or image in octets, by name."""
    symbols = subprocess.run([nm, "-S", binary], capture_output=True, text=True, check=True).stdout
    rows = re.findall(r"\w+ (\w+) [bBdD] (\w+)", symbols)
    return {name: int(octets, 16) for octets, name in rows}


class OnChip:
    """The chip as the firmware of a test's board."""

    def __init__(self, chip):
        self.chip = chip
        chip.start()
        chip.line.register[0x7053] = 4  # 937500 baud, to shorten the tests

    def receive(self, octets):
        self.chip.receive(octets)

    def poll(self):
        quiet, sent = 0, len(self.chip.line.sent)
        while quiet < 3 and not (self.chip.hung or self.chip.was_reset):
            self.chip.run(500)
            busy = (
                self.chip.line.to_board or self.chip.line.to_host or len(self.chip.line.sent) > sent
            )
            quiet, sent = 0 if busy else quiet + 1, len(self.chip.line.sent)

    def transmit(self):
        sent, self.chip.line.sent = self.chip.line.sent, b""
        return sent

    def tick(self, words):
        self.chip.convert = lambda channel: words[channel] // 16
        before = self.chip.ticks
        while self.chip.ticks == before and not (self.chip.hung or self.chip.was_reset):
            self.chip.run(5)
        self.chip.run(30)  # until the words are sent
        codes = [word - (channel << 16) >> 4 for channel, word in enumerate(self.last_words())]
        return [code - 4096 if code >= 2048 else code for code in codes]

    def last_words(self):
        return self.chip.dac_words[-3:]

    def close(self):
        pass
