"""Loading through an STM32's boot ROM: the flash gets the image, or the user the right message."""

import socket
import struct
import threading

import pytest

from hbench.errors import ConfigError, DataError, DeviceError, ExitCode
from hbench.rig.flash import stm32_rom
from hbench.rig.flash.stm32_image import FLASH, is_stm32_image, read_stm32_image
from tests.support.board.stm32_rom_standin import RomLine, Stm32Rom

SIZE = 16_600  # of two sectors
CODE = struct.pack("<2I", 0x20000800, 0x08000189) + b"stm32f4\0"
CODE += bytes((7 * i * i) % 251 for i in range(SIZE - len(CODE)))


def elf(*segments, machine=40, kind=b"\x01\x01"):
    """An ELF file with loadable segments (address, octets), and an empty one."""
    content = b"\x7fELF" + kind + bytes(10)
    count = len(segments) + 1
    content += struct.pack("<2H5I6H", 2, machine, 1, 0, 52, 0, 0, 52, 32, count, 0, 0, 0)
    offset, table, data = 52 + 32 * count, b"", b""
    for address, octets in segments:
        at = offset + len(data)
        table += struct.pack("<8I", 1, at, address, address, len(octets), len(octets), 5, 4)
        data += octets
    return content + table + struct.pack("<8I", 1, offset, 0x20000000, 0, 0, 99, 6, 4) + data


def read(tmp_path, content):
    path = tmp_path / "image.elf"
    path.write_bytes(content)
    return read_stm32_image(path)


@pytest.fixture
def image(tmp_path):
    return read(tmp_path, elf((FLASH.start, CODE[:800]), (FLASH.start + 800, CODE[800:])))


def test_the_flash_gets_the_image_and_the_program_is_started(image):
    rom = Stm32Rom()
    assert stm32_rom.flash(image, RomLine(rom)) == "STM32F446"
    assert rom.flash[:SIZE] == CODE == image.octets[:SIZE]
    assert rom.erased == [0, 1]
    assert rom.flash[32 << 10 :] == b"\xa5" * (len(rom.flash) - (32 << 10))  # other sectors remain
    assert rom.started == FLASH.start


def octet_of_block(number, at):
    """Number of an octet to the ROM: 0x7F, id, erasure, then blocks of data."""
    per_block = 2 + 5 + 1 + 256 + 1
    return 1 + 2 + 2 + 7 + number * per_block + 2 + 5 + 1 + at + 1


FAULTS = {
    "no board": (Stm32Rom(), {"silent_from": 1}, "no answer of the boot ROM"),
    "program runs": (Stm32Rom(), {"flips_from": {1: 0x10}}, "expected 79"),
    "other chip": (Stm32Rom(chip=0x431), {}, r"chip 0x431 is not one of"),
    "protected": (Stm32Rom(protected=True), {}, "refused the erasure: .*protected"),
    "command damaged": (Stm32Rom(), {"flips_to": {2: 0x01}}, "refused the request for the chip"),
    "answer damaged": (Stm32Rom(), {"flips_from": {2: 0x01}}, "with 0x78; expected 0x79"),
    "data damaged": (
        Stm32Rom(),
        {"flips_to": {octet_of_block(3, 100): 0x04}},
        "refused the block at 0x08000300: wrong checksum",
    ),
    "line cut": (
        Stm32Rom(),
        {"silent_from": octet_of_block(5, 0)},
        "no answer to the block at 0x08000500",
    ),
    "defective flash": (
        Stm32Rom(stuck={1000: 0xFF}),
        {},
        r"0x080003E8 reads back 0xFF; written was 0x[0-9A-F]{2}",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_has_its_message_and_starts_no_program(image, fault):
    rom, line, message = FAULTS[fault]
    with pytest.raises(DeviceError, match=message) as caught:
        stm32_rom.flash(image, RomLine(rom, **line))
    assert caught.value.exit_code == ExitCode.DEVICE and caught.value.hint
    assert rom.started is None
    others = [text for name, (_, _, text) in FAULTS.items() if name != fault]
    assert not any(text in caught.value.message for text in others)


def test_a_rom_that_has_measured_the_rate_already_is_accepted(image):
    rom = Stm32Rom()
    rom.feed(0x7F)
    rom.feed(0x00)  # half of a command
    assert stm32_rom.flash(image, RomLine(rom)) == "STM32F446"


@pytest.mark.parametrize(
    "content, message",
    [
        (elf((FLASH.start, CODE), machine=8), "Arm architecture"),
        (elf((FLASH.start, CODE), kind=b"\x02\x01"), "Arm architecture"),
        (elf((0x20000000, CODE)), "outside of the flash"),
        (elf((FLASH.stop - 16, CODE)), "outside of the flash"),
        (elf((FLASH.start, CODE))[:-1], "truncated"),
        (elf((FLASH.start, CODE))[:40], "truncated"),
        (elf((FLASH.start, bytes(16) + CODE)), "stack pointer 0x00000000"),
        (elf((FLASH.start, CODE.replace(b"stm32f4", b"mps2\0\0\0"))), "another board"),
        (elf((FLASH.start, CODE.replace(b"stm32f4\0", b"stm32f4-"))), "another board"),
        (elf(), "truncated"),
    ],
)
def test_an_image_that_is_not_for_the_board_is_refused(tmp_path, content, message):
    with pytest.raises(DataError, match=message):
        read(tmp_path, content)


def test_a_missing_image_is_a_configuration_error(tmp_path):
    assert not is_stm32_image(tmp_path / "none.elf")
    with pytest.raises(ConfigError, match=r"none\.elf"):
        read_stm32_image(tmp_path / "none.elf")


def test_the_command_flashes_over_a_socket_and_prints_the_chip(tmp_path, monkeypatch, capsys):
    from hbench.cli.main import main

    rom = Stm32Rom(chip=0x413)
    server = socket.create_server(("localhost", 0))

    def serve():
        line, _ = server.accept()
        with line:
            while octets := line.recv(4096):
                line.sendall(b"".join(map(rom.feed, octets)))

    thread = threading.Thread(target=serve)
    thread.start()
    path = tmp_path / "image.elf"
    path.write_bytes(elf((FLASH.start, CODE)))
    port = f"socket://localhost:{server.getsockname()[1]}"
    monkeypatch.setattr("sys.argv", ["hbench", "flash", str(path), "--port", port])
    with pytest.raises(SystemExit) as end:
        main()
    thread.join()
    server.close()
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith(f"{port}: {SIZE} octets written to the STM32F405")
    assert rom.flash[:SIZE] == CODE and rom.started == FLASH.start


class Connection:
    """Line of stm32loader's client to the stand-in."""

    timeout = 1

    def __init__(self, rom):
        self.rom, self.coming = rom, b""

    def write(self, data):
        for octet in data:
            self.coming += self.rom.feed(octet)

    def read(self, length=1):
        data, self.coming = self.coming[:length], self.coming[length:]
        return data

    def flush_input_buffer(self):
        self.coming = b""

    def enable_reset(self, enable):
        pass

    def enable_boot0(self, enable):
        pass


def test_the_client_of_stm32loader_writes_and_reads_the_same_flash(image):
    bootloader = pytest.importorskip("stm32loader.bootloader")
    rom = Stm32Rom()
    client = bootloader.Stm32Bootloader(Connection(rom), verbosity=0)
    client.reset_from_system_memory()
    assert client.get_id() == 0x421
    client.get()
    client.extended_erase_memory([0, 1])
    client.write_memory_data(FLASH.start, image.octets)
    assert bytes(client.read_memory_data(FLASH.start, len(image.octets))) == image.octets
    client.go(FLASH.start)
    assert rom.started == FLASH.start
    by_hbench = Stm32Rom()
    stm32_rom.flash(image, RomLine(by_hbench))
    assert by_hbench.flash == rom.flash
