"""The core as C: no warnings, freestanding, only types of the C28x, no circles."""

import re
import shutil
import subprocess
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from hbench.protocol.generate import generated_files
from hbench.rig import firmware
from tests.support import shared

ROOT = Path(__file__).parents[2]
CORE = ROOT / "firmware" / "core"
HOST = ROOT / "firmware" / "ports" / "host"
SOURCES = sorted(CORE.glob("*.c"))
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
STRICT = (
    "-std=c99 -pedantic -ffreestanding -ffp-contract=off -O2 -Wall -Wextra -Wconversion "
    "-Wsign-conversion -Wdouble-promotion -Wstrict-prototypes -Wmissing-prototypes -Wshadow -Werror"
).split()
# The header declares some of the names, so it is included before they are forbidden.
POISON = """
#include <stdint.h>
#pragma GCC poison double int8_t uint8_t int64_t uint64_t memcpy memset malloc sqrt sqrtf
"""


@pytest.fixture(scope="session")
def core(tmp_path_factory) -> list[Path]:
    """The core's objects, compiled with ``POISON``."""

    def compile_core() -> list[Path]:
        folder = tmp_path_factory.mktemp("core")
        (folder / "poison.h").write_text(POISON)
        objects = []
        for source in SOURCES:
            objects.append(folder / f"{source.stem}.o")
            command = [COMPILER, *STRICT, "-fno-stack-protector", "-include", folder / "poison.h"]
            command += ["-c", source, "-o", objects[-1]]
            done = subprocess.run(command, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
        return objects

    return shared.once("core", compile_core)


@pytest.mark.parametrize("name, text", generated_files().items())
def test_generated_files_are_up_to_date(name, text):
    assert (CORE / name).read_text() == text, "run: python -m hbench.protocol.generate"


def test_the_core_compiles_without_a_warning_or_a_type_missing_on_the_c28x(core):
    assert len(core) == len(SOURCES) > 10


def test_the_core_includes_only_freestanding_headers():
    for path in [*SOURCES, *CORE.glob("*.h")]:
        for line in path.read_text().splitlines():
            if line.startswith("#include <"):
                assert line[10:-1] in ("limits.h", "stdbool.h", "stdint.h"), f"{path.name}: {line}"


def symbols_of(objects: list[Path], nm: str) -> list[tuple[str, str, str]]:
    """Return (module, symbol, type) of each symbol in the objects."""
    symbols = []
    for path in objects:
        text = subprocess.run([nm, "-P", path], capture_output=True, text=True, check=True).stdout
        for line in text.splitlines():
            name, kind = line.split()[:2]
            symbols.append((path.stem, name.lstrip("_"), kind))
    return symbols


def test_the_core_calls_no_library_and_has_no_variables(core, require_tool):
    symbols = symbols_of(core, require_tool("nm"))
    outside = {name for _, name, kind in symbols if kind == "U"}
    inside = {name for _, name, kind in symbols if kind == "T"}
    # A compiler may call these four to copy or compare a struct.
    assert outside - inside <= {"memcpy", "memset", "memmove", "memcmp"}
    assert not [symbol for symbol in symbols if symbol[2] in "BbDdCc"], "mutable data"


def test_no_circle_of_includes_or_calls_in_the_core(core, require_tool):
    """A module is a .c file with its header; it depends on what either includes or calls."""
    depends = {path.stem: set() for path in [*SOURCES, *CORE.glob("*.h")]}
    for path in [*SOURCES, *CORE.glob("*.h")]:
        included = re.findall(r'^#include "(\w+)\.h"', path.read_text(), re.MULTILINE)
        depends[path.stem] |= set(included) - {path.stem}
    symbols = symbols_of(core, require_tool("nm"))
    home = {name: module for module, name, kind in symbols if kind == "T"}
    for module, name, kind in symbols:
        if kind == "U" and name in home:
            depends[module].add(home[name])
    order = list(TopologicalSorter(depends).static_order())  # raises CycleError
    assert order.index("core") < order.index("commands") < order.index("link")


def test_hal_h_alone_declares_what_a_port_uses(tmp_path):
    """A port compiles against hal.h and the sizes of the two objects that it allocates."""
    port = tmp_path / "port.c"
    port.write_text(
        """
#include "hal.h"

static hb_log_record ring[64];

static bool read(void *context, hb_octet *octet) { (void)context; (void)octet; return false; }
static hb_u16 write(void *context, const hb_octet *octets, hb_u16 count)
{ (void)context; (void)octets; return count; }
static void mask(void *context) { (void)context; }

void start(hb_core *core, hb_link *link);
void start(hb_core *core, hb_link *link)
{
    hb_u16 words[HB_INPUTS] = {0};
    hb_i16 codes[HB_VALVES];
    const hb_hal hal = {"board", 1, {65520, 256}, {10.0f, 204.8f, -2048, 2047}, ring, 64, 0,
                        read, write, mask, mask};

    hb_core_init(core, &hal);
    hb_link_init(link, core);
    hb_core_tick(core, words, codes);
    hb_core_overrun(core);
    hb_link_poll(link);
}
"""
    )
    command = [COMPILER, *STRICT, f"-I{CORE}", "-c", port, "-o", tmp_path / "port.o"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.fixture
def wide_octets(tmp_path):
    """The host library with octets of 16 bits, as on the C28x."""
    library = tmp_path / "libwide.so"
    sources = [*SOURCES, HOST / "host.c"]
    options = ["-std=c99", "-O2", "-fPIC", "-shared", "-DHB_OCTET=unsigned short", f"-I{CORE}"]
    subprocess.run([COMPILER, *options, *sources, "-o", library], check=True)
    return firmware.open_library(library)


def talk(board):
    """A session with every kind of request; returns all replies."""
    replies = [board.request("identify"), board.write_settings(log_divider=7.0)]
    replies += [board.write_motion(n, run=n + 1, hold_s=0.0, duration_s=0.05) for n in range(3)]
    replies += [board.start(), board.request("stop", b"\xff")]
    board.rest(1.2, x=0.05)
    replies += [board.request("status"), board.start(), board.request("clear_fault")]
    replies += [board.request("read_log", bytes([n, 0, 0, 0, 8, 0])) for n in range(0, 200, 8)]
    return replies


def test_sixteen_bit_octets_make_no_difference_on_the_wire(new_board, wide_octets, monkeypatch):
    expected = talk(new_board())
    monkeypatch.setattr(firmware, "load_library", lambda: wide_octets)
    assert talk(new_board()) == expected
    assert len(set(map(str, expected))) > 20, "the session must have different replies"
