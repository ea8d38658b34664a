"""Loading an STM32F4 through its boot ROM: the chip gets the image, or the user the cause."""

import gc
import re
import socket
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hbench.errors import DataError, DeviceError, ExitCode
from hbench.rig.flash.boot import flash
from hbench.rig.flash.identity import NotInBoot
from hbench.rig.flash.stm32f4.boot_rom import ROM, send_image
from hbench.rig.flash.stm32f4.elf_image import parse_elf_image
from tests.support.board.boot_rom_standin import FIRMWARE, PROGRAM_BAUD
from tests.support.board.stm32_rom_standin import (
    FLASH,
    SECTORS,
    RomLine,
    Stm32Rom,
    elf,
    program,
    running,
)

BAUD = 57_600
PROGRAM = program()
IMAGE = parse_elf_image(elf([(FLASH, PROGRAM)]), "image.elf")
SMALL = parse_elf_image(elf([(FLASH, program(600))]), "image.elf")


def flashed(rom, image=IMAGE, **faults):
    lines = []

    def opened(baud):
        assert all(line.closed for line in lines)
        lines.append(RomLine(rom, baud, **(faults if not lines else {})))
        return lines[-1]

    try:
        return flash(ROM, image, opened, opened, BAUD, PROGRAM_BAUD)
    finally:
        assert all(line.closed for line in lines)


def failure(rom, image=IMAGE, **faults) -> DeviceError:
    with pytest.raises(DeviceError) as caught:
        flashed(rom, image, **faults)
    assert caught.value.exit_code == ExitCode.DEVICE
    assert caught.value.message.startswith("bench: ") and caught.value.hint
    return caught.value


def test_the_flash_holds_the_image_its_sectors_are_erased_and_it_runs():
    rom = Stm32Rom(program=running())
    identity = flashed(rom)
    assert (identity.firmware, identity.board) == (FIRMWARE, "stm32f4")
    assert rom.flash[: len(PROGRAM)] == PROGRAM
    assert rom.erased == [0, 1, 2] and rom.started == FLASH
    assert set(rom.flash[sum(SECTORS[:3]) :]) == {0x5A}  # other sectors keep what they hold


@pytest.mark.parametrize("size", [200, 256, 257, 16_384, 16_385, 70_000])
def test_images_of_any_size_are_written_whole(size):
    rom = Stm32Rom()
    content = program(size)
    send_image(RomLine(rom, BAUD), parse_elf_image(elf([(FLASH, content)]), "image.elf"))
    assert rom.flash[:size] == content


def test_a_rom_that_was_synchronised_before_is_used():
    rom = Stm32Rom(program=running())
    rom.feed(0x7F, BAUD)
    assert flashed(rom).firmware == FIRMWARE


def test_parts_of_an_image_are_joined_with_erased_octets():
    content = program(600)
    parts = [(FLASH + 1024, b"second"), (FLASH, content)]
    image = parse_elf_image(elf(parts), "image.elf")
    assert image.content == content.ljust(1024, b"\xff") + b"second"


@pytest.mark.parametrize(
    ("file", "words"),
    [
        (elf([(FLASH, PROGRAM)], machine=62), "another processor"),
        (elf([(FLASH, PROGRAM)], bits=2), "another processor"),
        (elf([(FLASH, PROGRAM)])[:-1], "truncated"),
        (elf([(FLASH, PROGRAM)])[:60], "truncated"),
        (b"\x7fELF", "truncated"),
        (elf([(FLASH - 4, PROGRAM)]), "outside the flash"),
        (elf([(FLASH + 512 * 1024 - 8, PROGRAM)]), "outside the flash"),
        (elf([(0x2000_0000, PROGRAM)]), "outside the flash"),
        (elf([(FLASH, PROGRAM), (FLASH + 100, b"x")]), "overlap"),
        (elf([(FLASH + 256, PROGRAM)]), "no vector table"),
        (elf([]), "no vector table"),
        (elf([(FLASH, b"\0" * 64)]), "no vector table"),
        (elf([(FLASH, program(board="mps2"))]), "'stm32f4'"),
        (elf([(FLASH, program(board="stm32f4-emulated"))]), "'stm32f4'"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_image_for_something_else_is_refused(file, words):
    with pytest.raises(DataError, match=words) as caught:
        parse_elf_image(file, "image.elf")
    assert caught.value.message.startswith("image.elf: ") and caught.value.hint


@given(st.binary(max_size=200), st.integers(0, 300))
def test_no_octets_are_anything_but_an_image_or_a_data_error(octets, at):
    file = bytearray(elf([(FLASH, program(200))]))
    file[at : at + len(octets)] = octets
    try:
        parse_elf_image(bytes(file), "image.elf")
    except DataError:
        pass


def test_another_chip_is_named_and_nothing_is_erased():
    rom = Stm32Rom(product=0x431)
    assert re.search(r"0x431 \(STM32F411.*STM32F446", failure(rom).message)
    assert not rom.erased


def test_a_protected_chip_is_told():
    rom = Stm32Rom(protected=True)
    assert "read-protected" in failure(rom).message and not rom.erased


def test_a_running_firmware_is_told_as_wrong_boot_pins():
    error = failure(Stm32Rom(program=running("hbench-core 0.0"), boots_from_flash=True))
    assert isinstance(error, NotInBoot) and "hbench-core 0.0" in error.message


def test_no_board_is_no_answer():
    error = failure(Stm32Rom(boots_from_flash=True))
    assert isinstance(error, NotInBoot) and "PC10" in error.hint


def test_a_flash_octet_that_can_not_be_written_is_read_back_and_nothing_is_started():
    rom = Stm32Rom(program=running())
    rom.stuck = {20_000}
    assert f"0x{FLASH + 20_000:08X}" in failure(rom).message and rom.started is None


def test_a_program_that_does_not_answer_or_is_another_one_is_told():
    assert "no firmware answers" in failure(Stm32Rom()).message
    assert "'hbench-core 8.8'" in failure(Stm32Rom(program=running("hbench-core 8.8"))).message
    assert "'f28335'" in failure(Stm32Rom(program=running(board="f28335"))).message


def octets_of_a_good_load() -> tuple[int, int]:
    line = RomLine(Stm32Rom(), BAUD)
    send_image(line, SMALL)
    return line.sent, line.received


SENT, RECEIVED = octets_of_a_good_load()


@pytest.mark.parametrize("fault", ["silence", "refusal", "flip"])
def test_every_moment_of_a_fault_ends_in_its_message_and_starts_nothing_wrong(fault):
    """At each octet of the load; what is started is the whole image in any case."""
    whole = SMALL.content
    said = set()
    for number in range(2, (RECEIVED if fault == "flip" else SENT) + 1):
        rom, faults = Stm32Rom(program=running()), {}
        if fault == "silence":
            rom.silent_at = number
        elif fault == "refusal":
            rom.nack_at = number
        else:
            faults = {"flips": {number: 0x80}}
        message = failure(rom, SMALL, **faults).message
        assert rom.started is None or rom.flash[: len(whole)] == whole
        said.add(re.sub(r"0x[0-9A-F]+|\d+", "N", message))
        if number % 100 == 0:
            gc.collect()  # the traceback keeps the chip: 0.5 MB
    wanted = {"silence": "no answer", "refusal": "refuses", "flip": "read back"}[fault]
    assert any(wanted in words for words in said)
    steps = ("get ID", "erase of sector", "write at", "read at", "start")
    for step in steps:
        assert any(step in words for words in said)


@pytest.mark.parametrize("sent", range(1, SENT, 20))
def test_after_a_killed_flash_the_next_one_is_complete_or_asks_for_a_reset(sent):
    """The boot ROM still waits for the rest of a command, or has a part of the image."""

    class Killed(Exception):
        pass

    class CutLine(RomLine):
        def write(self, data):
            super().write(data[: max(sent - self.sent, 0)])
            if self.sent >= sent:
                raise Killed

    rom = Stm32Rom(program=running())
    with pytest.raises(Killed):
        send_image(CutLine(rom, BAUD), SMALL)
    assert rom.started is None
    try:
        flashed(rom, SMALL)
    except DeviceError as error:
        assert "no answer to the boot ROM" in error.message
        assert "reset the board and try again" in error.hint
        reset = Stm32Rom(program=running())
        reset.flash = rom.flash
        rom = reset
        flashed(rom, SMALL)
    assert rom.started and rom.flash[: len(SMALL.content)] == SMALL.content


@pytest.fixture
def served():
    """Return a function that puts a chip behind a socket and names the port.

    A pseudo-terminal has no parity: its second setting is an error of the system.
    """
    servers = []

    def serve(server, rom):
        while True:
            try:
                line, _ = server.accept()
            except OSError:
                return
            with line:
                while data := line.recv(512):
                    for octet in data:
                        if answer := rom.feed(octet, PROGRAM_BAUD):
                            line.sendall(answer)

    def connect(rom):
        servers.append(socket.create_server(("127.0.0.1", 0)))
        threading.Thread(target=serve, args=(servers[-1], rom), daemon=True).start()
        return f"socket://127.0.0.1:{servers[-1].getsockname()[1]}"

    yield connect
    for server in servers:
        server.close()


def test_the_command_flashes_a_served_chip_and_prints_who_runs(
    served, tmp_path, monkeypatch, capsys
):
    from hbench.cli.main import main

    path = tmp_path / "image.elf"
    path.write_bytes(elf([(FLASH, PROGRAM)]))
    rom = Stm32Rom(program=running())
    device = served(rom)
    monkeypatch.setattr("sys.argv", ["hbench", "flash", str(path), "--port", device])
    with pytest.raises(SystemExit) as end:
        main()
    out, err = capsys.readouterr()
    assert end.value.code == 0, err
    assert re.fullmatch(rf"{device}: .*'{FIRMWARE}' .*'stm32f4'\n", out)
    assert re.search(r"39\.1 kB, about 15 s", err)
    assert rom.flash[: len(PROGRAM)] == PROGRAM


class Wire:
    """A serial connection as stm32loader wants it; its modem lines are not connected."""

    timeout = 1

    def __init__(self, rom):
        self.line = RomLine(rom, BAUD)
        self.received = b""

    def write(self, octets):
        self.line.write(octets)

    def read(self, count=1):
        self.received += self.line.read(0.0)
        taken, self.received = self.received[:count], self.received[count:]
        return taken

    def flush_input_buffer(self):
        pass

    def enable_reset(self, enable=True):
        pass

    def enable_boot0(self, enable=True):
        pass


def test_another_client_loads_the_stand_in_with_the_same_result(monkeypatch):
    """stm32loader, written by others from the same document."""
    bootloader = pytest.importorskip("stm32loader.bootloader")
    monkeypatch.setattr(bootloader.time, "sleep", lambda seconds: None)
    rom = Stm32Rom()
    other = bootloader.Stm32Bootloader(Wire(rom), "F4", verbosity=0)
    other.reset_from_system_memory()
    other.get()
    assert other.get_id() == 0x421
    other.erase_memory([0, 1, 2])
    other.write_memory_data(FLASH, PROGRAM)
    assert other.read_memory_data(FLASH, len(PROGRAM)) == PROGRAM
    other.go(FLASH)
    assert rom.flash[: len(PROGRAM)] == PROGRAM and rom.started == FLASH
    ours = Stm32Rom()
    send_image(RomLine(ours, BAUD), IMAGE)
    assert ours.flash == rom.flash
