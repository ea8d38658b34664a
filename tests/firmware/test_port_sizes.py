"""RAM and code of each port, compared with the table in firmware/README.md.

``pytest -s tests/firmware/test_port_sizes.py`` prints the table's rows.
"""

import re
import subprocess
import sys

import pytest

from tests.support.board.f28335_board import COMPILER, CORE, ROOT, data_sizes, data_words

README = ROOT / "firmware" / "README.md"
PORTS = ROOT / "firmware" / "ports"
COLUMNS = ("code", "core", "link", "ring", "other")
TOLERANCE = {"code": 0.1, "core": 0.02, "link": 0.02, "ring": 0.0, "other": 0.1}


def table() -> dict[str, dict[str, int | None]]:
    """Octets by port and column; None where a cell is no number."""
    ports = {}
    for row in re.findall(r"^\| `(\w+)` \|(.*)\|$", README.read_text(), re.MULTILINE):
        cells = [cell.replace(" ", "") for cell in row[1].split("|")]
        sizes = [int(cell) if cell.isdigit() else None for cell in cells[-len(COLUMNS) :]]
        ports[row[0]] = dict(zip(COLUMNS, sizes, strict=True))
    return ports


def compare(port: str, **measured: int):
    print(
        port,
        " | ".join(f"{name} {octets:,}".replace(",", " ") for name, octets in measured.items()),
    )
    for column, octets in measured.items():
        stated = table()[port][column]
        assert stated == pytest.approx(octets, rel=TOLERANCE[column]), (port, column)


def split(sizes: dict[str, int]) -> dict[str, int]:
    """Sizes of the core's three objects, and the sum of all others."""
    named = {column: sizes[column] for column in ("core", "link", "ring")}
    return named | {"other": sum(sizes.values()) - sum(named.values())}


def test_table_has_a_row_for_each_port():
    assert set(table()) == {path.name for path in PORTS.iterdir() if path.is_dir()}


def compare_image(port, image, require_tool):
    size = [require_tool("arm-none-eabi-size"), image]
    row = subprocess.run(size, capture_output=True, text=True, check=True).stdout.splitlines()[1]
    sizes = data_sizes(image, require_tool("arm-none-eabi-nm"))
    compare(port, code=int(row.split()[0]), **split(sizes))


def test_mps2(mps2_build, require_tool):
    compare_image("mps2", mps2_build / "hbench-mps2.elf", require_tool)


def test_stm32f4(stm32f4_images, require_tool):
    compare_image("stm32f4", stm32f4_images / "hbench-stm32f4.elf", require_tool)


def test_f28335(tmp_path, require_tool):
    gcc, nm = require_tool("arm-none-eabi-gcc"), require_tool("arm-none-eabi-nm")
    words = data_words(tmp_path, gcc, nm)
    names = {"board.core": "core", "board.link": "link", "board.log_ring": "ring"}
    sizes = {names.get(name, name): 2 * count for name, count in words.items()}
    compare("f28335", **split(sizes))


@pytest.mark.skipif(sys.maxsize < 2**32, reason="the table gives sizes with pointers of 64 bits")
def test_host(tmp_path, require_tool):
    source = tmp_path / "objects.c"
    source.write_text(
        '#include "host.c"\nhb_core core;\nhb_link link;\n'
        "hb_log_record ring[RING_RECORDS];\nstruct hb_host host;\n"
    )
    command = [COMPILER, "-std=c99", "-fno-common", f"-I{CORE}", f"-I{PORTS / 'host'}"]
    subprocess.run([*command, "-c", source, "-o", tmp_path / "x.o"], check=True)
    sizes = data_sizes(tmp_path / "x.o", require_tool("nm"))
    sizes["host"] -= sizes["core"] + sizes["link"]  # which it contains
    compare("host", **split(sizes))
