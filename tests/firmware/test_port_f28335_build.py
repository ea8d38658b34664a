"""The F28335 port: compiled by other compilers, linker areas, memory.

TI's compiler and linker were never used.
"""

import re
import subprocess
from pathlib import Path

import pytest

from hbench.rig.flash.f28335.boot_image import LOADABLE
from tests.support.board.f28335_board import COMPILER, CORE, PORT, SOURCES, data_words

STRICT = (
    "-std=c99 -pedantic -ffreestanding -ffp-contract=off -O2 -Wall -Wextra -Wconversion "
    "-Wsign-conversion -Wdouble-promotion -Wstrict-prototypes -Wmissing-prototypes -Wshadow -Werror"
).split()


def check(folder: Path, compiler: str, *options: str):
    for source in SOURCES:
        command = [compiler, *STRICT, *options, f"-I{CORE}", "-c", source, "-o", folder / "x.o"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def test_the_port_compiles_on_the_host_without_a_warning(tmp_path):
    check(tmp_path, COMPILER)


def test_the_port_compiles_where_int_has_16_bits(tmp_path, require_tool):
    """With half of the log: all of it is an octet more than the largest object there."""
    check(tmp_path, require_tool("avr-gcc"), "-mmcu=atmega128", "-DRING_RECORDS=512u")


def test_the_code_for_tis_compiler_is_valid_c(tmp_path):
    """TI's keywords are removed; only TI's compiler could verify them."""
    keywords = ["-D__TMS320C28XX__", "-D__interrupt=", "-D__cregister="]
    no_pointer_of_22_bits = ["-Wno-int-to-pointer-cast", "-Wno-pointer-to-int-cast"]
    check(
        tmp_path, COMPILER, *keywords, *no_pointer_of_22_bits, "-Wno-unknown-pragmas",
        "-fsyntax-only",
    )  # fmt: skip


def test_each_file_states_that_it_was_never_compiled_by_tis_tools():
    for path in PORT.iterdir():
        head = re.sub(r"[\s*;]+", " ", path.read_text()[:1200])
        assert re.search(r"[Nn]ever (compiled|linked|assembled) by TI's", head), path.name


def areas(name: str) -> dict[str, range]:
    """Memory areas of a linker command file."""
    rows = re.findall(r"(\w+)\s*: origin = (0x\w+), length = (0x\w+)", (PORT / name).read_text())
    return {area: range(int(at, 16), int(at, 16) + int(size, 16)) for area, at, size in rows}


@pytest.mark.parametrize("name", ["ram.cmd", "flash.cmd"])
def test_the_linkers_areas_exist_on_the_chip_and_do_not_overlap(name):
    memory = [range(first, last + 1) for first, last in LOADABLE]
    if name == "flash.cmd":  # except the words before the entry, and the passwords
        memory += [range(0x300000, 0x33FF80), range(0x33FFF6, 0x33FFF8)]
    placed = areas(name)
    for area, words in placed.items():
        assert any(words[0] in part and words[-1] in part for part in memory), area
    ends = sorted((words.start, words.stop) for words in placed.values())
    assert all(stop <= start for (_, stop), (start, _) in zip(ends, ends[1:], strict=False))


def test_the_flash_image_copies_all_objects_except_startup_to_ram():
    moved = re.findall(r"(\w+)\.obj\(\.text\)", (PORT / "flash.cmd").read_text())
    sources = {path.stem for path in [*CORE.glob("*.c"), *SOURCES]}
    assert sorted(moved) == sorted(sources - {"main"}), "name them all in flash.cmd"


def test_the_data_fit_their_areas(tmp_path, require_tool):
    gcc, nm = require_tool("arm-none-eabi-gcc"), require_tool("arm-none-eabi-nm")
    words = data_words(tmp_path, gcc, nm)
    for name, count in sorted(words.items(), key=lambda row: -row[1]):
        print(f"{name:28} {count:6} words")
    assert words["board.log_ring"] == 16384  # 1024 records of 16 words
    kept = sum(count for name, count in words.items() if name.startswith("boots."))
    data = sum(words.values()) - words["board.log_ring"] - kept
    for name in ("ram.cmd", "flash.cmd"):
        area = areas(name)
        assert words["board.log_ring"] <= len(area["LOG"])
        assert kept <= len(area["KEPT"])
        assert 4000 < data + 256 <= len(area["DATA"])  # and constants
