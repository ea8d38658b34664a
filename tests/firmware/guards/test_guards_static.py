"""Static checks of the core: cppcheck, MISRA C:2012, and its size on the C28x."""

import os
import re
import shutil
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
CORE = ROOT / "firmware" / "core"
CPPCHECK = (
    "--enable=warning,style,performance,portability --error-exitcode=1 --std=c99 --inline-suppr -q"
)
# Memory for program, context and log ring, in words of 16 bits. M0 and M1 are for the stack.
L0_TO_HALF_OF_L2 = 4096 + 4096 + 2048
HALF_OF_L2_TO_L3 = 2048 + 4096
L4_TO_L7 = 4 * 4096
PORT = 1024  # buffers and constants of the port

OBJECTS = """
#include "link.h"
hb_core core;
hb_link link;
hb_log_record ring[1024];
"""
# An ARM lays structs out as a C28x does if octets and bools have 16 bits: integers of 16 bits one
# word, floats, longs and pointers two, on even addresses.
LIKE_C28X = ["-DHB_OCTET=unsigned short", "-D_Bool=unsigned short"]
# Substitutes for a C28x compiler. A Thumb-2 core with FPU is closest: instructions of 16 bits.
STAND_INS = {
    "arm-none-eabi-": "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard",
    "avr-": "-mmcu=atmega1284p",
}


@pytest.mark.parametrize("platform", ["native", Path(__file__).with_name("c28x.xml")])
def test_cppcheck_reports_nothing(platform, run, require_tool):
    cppcheck = require_tool("cppcheck")
    options = [*CPPCHECK.split(), f"--platform={platform}", "-I", CORE]
    if b"--check-level" in run(cppcheck, "--help").stdout:  # from 2.11, which else skips branches
        options.append("--check-level=exhaustive")
    run(cppcheck, *options, CORE, ROOT / "firmware" / "ports" / "host")


@pytest.mark.slow
def test_misra_reports_only_the_deviations_that_are_documented(run, require_tool):
    """``pytest -s -m slow -k misra tests/firmware/guards`` prints their number for each rule."""
    command = [require_tool("cppcheck"), "--addon=misra", "--std=c99", "-q", "-I", CORE, CORE]
    found = Counter(re.findall(r"\[misra-c2012-([\d.]+)\]", run(*command).stderr.decode()))
    print("MISRA C:2012:", dict(sorted(found.items(), key=lambda rule: -rule[1])))
    table = (ROOT / "firmware" / "MISRA.md").read_text()
    assert set(re.findall(r"^\| D\d+ \| (\d+\.\d+) \|", table, re.M)) == found.keys()


@pytest.mark.nightly
@pytest.mark.skipif(shutil.which("frama-c") is None, reason="no frama-c")
def test_frames_are_proved_to_be_read_and_written_within_their_memory(run, tmp_path):
    """``wire.c``, whatever octets are received: its contracts, memory, overflows, terminations.

    Needs the packages frama-c-base, why3, z3 and cvc4.
    """
    home = os.environ | {"HOME": str(tmp_path)}
    run("why3", "config", "detect", env=home)
    libc = run("frama-c", "-print-share-path").stdout.decode().strip()
    proved = run(
        *"frama-c -wp -wp-rte -wp-model Typed+cast -wp-prover z3,cvc4 -wp-timeout 30".split(),
        *("-machdep", "gcc_x86_64", f"-cpp-extra-args=-std=c99 -I{CORE} -I{libc}/libc"),
        CORE / "wire.c",
        env=home,
    ).stdout.decode()
    done, of = re.search(r"Proved goals: +(\d+) / (\d+)", proved).groups()
    print(f"proved goals: {done} of {of}")
    assert done == of and int(of) > 190, proved[-3000:]


def test_core_link_and_log_ring_fit_the_ram_of_an_f28335(run, tmp_path, require_tool):
    (tmp_path / "objects.c").write_text(OBJECTS)
    options = ["-std=c99", "-ffreestanding", *LIKE_C28X, "-I", CORE, "-c", "objects.c"]
    run(require_tool("arm-none-eabi-gcc"), *options, cwd=tmp_path)
    table = run(require_tool("arm-none-eabi-nm"), "-P", tmp_path / "objects.o").stdout.decode()
    rows = (line.split() for line in table.splitlines())
    words = {name: int(octets, 16) // 2 for name, _, _, octets in rows}
    print("C28x words:", words)
    assert words["ring"] <= L4_TO_L7
    assert words["core"] + words["link"] <= HALF_OF_L2_TO_L3 - PORT


def test_code_as_dense_as_thumb_2_fits_the_ram_too(run, tmp_path, require_tool):
    words = {}
    for tools, target in STAND_INS.items():
        options = [*target.split(), "-std=c99", "-O2", "-ffreestanding", "-r", "-nostdlib"]
        image = tmp_path / f"{tools}core.o"
        run(require_tool(tools + "gcc"), *options, *CORE.glob("*.c"), "-o", image)
        words[tools] = int(run(require_tool(tools + "size"), image).stdout.split()[6]) // 2
    print("code and constants in words of 16 bits:", words)
    assert words["arm-none-eabi-"] <= L0_TO_HALF_OF_L2
