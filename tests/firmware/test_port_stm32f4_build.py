"""The images of the STM32F4 port: stack, arithmetic, memory, and the one file of the emulator's."""

import re
import subprocess

import pytest

from hbench.errors import DataError
from hbench.protocol.dictionary import INPUTS
from hbench.rig.flash.image import read_image
from tests.support.board.f28335_board import ROOT
from tests.support.board.stack_bound import CallGraph

PORT = ROOT / "firmware" / "ports" / "stm32f4"
FRAME = 26 * 4 + 4  # that the processor saves at an interrupt: with floats, and alignment
HAL = ("uart_read", "uart_write", "mask_control", "unmask_control")


@pytest.fixture(scope="module")
def output(stm32f4_images, require_tool):
    """Function that returns a tool's output for one of the images."""

    def run(tool, *options, image="hbench-stm32f4"):
        command = [require_tool(f"arm-none-eabi-{tool}"), *options, stm32f4_images / f"{image}.elf"]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    return run


def test_the_stack_holds_the_deepest_calls_of_all_interrupts_at_once(stm32f4_images):
    graph = CallGraph(stm32f4_images, indirect=HAL)
    loop = graph.depth("reset")
    control = graph.depth("board_control_interrupt")
    others = max(map(graph.depth, ("uart_receive_interrupt", "board_supervision_interrupt")))
    bound = loop + FRAME + control + FRAME + others
    print(f"loop {loop}, control {control}, the deepest other interrupt {others}: {bound} octets")
    (size,) = map(int, re.findall(r"\. = \. \+ (\d+)K; stack_top", (PORT / "link.ld").read_text()))
    assert bound <= size * 1024
    ((stated, of),) = re.findall(
        r"^\| stack, bound \| ([\d ]+) of ([\d ]+) \|", (PORT / "README.md").read_text(), re.M
    )
    assert int(of.replace(" ", "")) == size * 1024
    assert int(stated.replace(" ", "")) == pytest.approx(bound, rel=0.1)


def test_no_image_has_double_precision_heap_library_or_fused_arithmetic(output):
    for image in ("hbench-stm32f4", "hbench-stm32f4-onchip", "hbench-stm32f4-emulated"):
        symbols = {line.split()[-1] for line in output("nm", image=image).splitlines()}
        assert {"hb_core_tick", "hb_link_poll"} <= symbols
        strange = re.compile(r"__aeabi_|__.*df|malloc|calloc|free|sbrk|printf|_impure")
        assert not [name for name in symbols if strange.search(name)]
    code = output("objdump", "-d")
    assert "vmul.f32" in code and not re.search(r"\bvfn?m[as]\.f32|\.f64", code)


def test_the_emulators_image_differs_in_its_clock_file_only(output):
    """All other functions have the same instructions, apart from addresses."""
    chip, emulated = (
        functions(output("objdump", "-d", "--no-show-raw-insn", image=image))
        for image in ("hbench-stm32f4", "hbench-stm32f4-emulated")
    )
    own = {name for name in emulated if name not in chip or emulated[name] != chip[name]}
    own = {name for name in own if not name.startswith(("clock_", "__wrap_"))}
    assert own <= {"convert", "vectors"}  # a function of emulated.c, and a table of addresses
    assert len(chip) > 100 and not set(chip) - set(emulated)


def functions(text):
    """Instructions of each function, without operands, constants and alignment."""
    bodies = re.findall(r"^\w+ <([^>]+)>:\n((?:.+\n)+)", text, re.MULTILINE)
    return {
        name: [
            instruction
            for instruction in re.findall(r"^ *\w+:\t(\S+)", body, re.MULTILINE)
            if instruction not in (".word", "nop")
        ]
        for name, body in bodies
    }


def test_hbench_flash_reads_the_image_and_refuses_the_emulators(stm32f4_images):
    image = read_image(stm32f4_images / "hbench-stm32f4.elf")
    assert image.content == (stm32f4_images / "hbench-stm32f4.bin").read_bytes()
    with pytest.raises(DataError, match="not built for"):
        read_image(stm32f4_images / "hbench-stm32f4-emulated.elf")


def test_inputs_of_the_core_are_pins_in_the_order_of_the_readme(output):
    rows = re.findall(r"^\| (\w+) \| (P[A-C]\d+) \|", (PORT / "README.md").read_text(), re.M)
    table = re.findall(r"\{GPIO([A-C]), (\d+)u, \d+u\}", (PORT / "adc.c").read_text())
    pins = [f"P{port}{pin}" for port, pin in table]
    assert [name.lower() for name, _ in rows] == list(INPUTS)
    assert [pin for _, pin in rows] == pins
