"""Loading through the boot ROM: the chip gets the image, or the user the one right message."""

import math
import os
import pty
import re
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hbench import workflow
from hbench.errors import ConfigError, DeviceError, ExitCode
from hbench.rig.flash.boot import flash
from hbench.rig.flash.f28335.boot_image import parse_boot_image
from hbench.rig.flash.f28335.boot_rom import ECHO_WINDOW, ROM, send_image
from hbench.rig.flash.identity import NotInBoot
from tests.support.board.boot_rom_standin import (
    FIRMWARE,
    PROGRAM_BAUD,
    Babble,
    BootLine,
    BootRom,
    Program,
    stream_of,
    text_of,
)

BAUD = 57_600
ID_WORDS = [ord(character) for character in FIRMWARE + "f28335"]
STREAM = stream_of(0x8000, [(0x8000, [*range(1, 400)]), (0x9000, [*ID_WORDS, 0])])
IMAGE = parse_boot_image(text_of(STREAM), "image.txt")
WORDS = st.lists(st.integers(0, 0xFFFF), min_size=1, max_size=40)
PLACES = st.one_of(st.integers(0x50, 0x7FF - 40), st.integers(0x8000, 0xFFFF - 40))


class Bench:
    """Opens lines to one board and remembers them."""

    def __init__(self, rom, **faults):
        self.rom, self.faults, self.lines = rom, faults, []

    def open(self, baud):
        assert all(line.closed for line in self.lines)
        self.lines.append(BootLine(self.rom, baud, **self.faults))
        return self.lines[-1]

    def flash(self):
        try:
            return flash(ROM, IMAGE, self.open, self.open, BAUD, PROGRAM_BAUD)
        finally:
            assert all(line.closed for line in self.lines)


def failure(bench) -> DeviceError:
    with pytest.raises(DeviceError) as caught:
        bench.flash()
    assert caught.value.exit_code == ExitCode.DEVICE
    assert caught.value.message.startswith("bench: ")
    assert caught.value.hint
    return caught.value


@given(st.lists(st.tuples(PLACES, WORDS), min_size=1, max_size=5), st.booleans())
def test_the_chip_gets_exactly_the_words_of_any_image(blocks, marks):
    entry = blocks[0][0]
    image = parse_boot_image(text_of(stream_of(entry, blocks), marks=marks), "image.txt")
    rom = BootRom()
    send_image(BootLine(rom, BAUD, latency_s=0.004), image)
    expected = {address + i: w for address, words in blocks for i, w in enumerate(words)}
    assert rom.memory == expected
    assert (rom.state, rom.entry) == ("ram", entry)


def test_the_first_bytes_on_the_line_are_a_then_the_header():
    line = BootLine(BootRom(), BAUD)
    send_image(line, IMAGE)
    assert line.written[:23] == b"A" + bytes.fromhex("AA08" + 16 * "00" + "00000080")
    assert line.written == b"A" + STREAM


def test_the_loaded_firmware_is_asked_at_its_own_rate():
    bench = Bench(BootRom(ram_program=Program()))
    assert bench.flash().firmware == FIRMWARE
    assert [line.baud for line in bench.lines] == [BAUD, PROGRAM_BAUD]


def test_the_window_hides_the_latency_and_stays_in_its_bounds():
    latency_s = 0.016
    line = BootLine(BootRom(), BAUD, latency_s)
    send_image(line, IMAGE)
    total = len(STREAM)
    on_the_line = total * 10 / BAUD
    stop_and_wait = total * (latency_s + 20 / BAUD)
    assert 32 <= line.most_on_the_way == ECHO_WINDOW <= 64
    assert on_the_line < line.time
    windows = math.ceil(total / ECHO_WINDOW)
    assert line.time < 0.1 + (windows + 3) * (latency_s + (ECHO_WINDOW + 2) * 10 / BAUD)
    assert line.time < stop_and_wait / 10


def test_a_board_that_is_reset_late_is_still_found():
    rom = BootRom(boots_from_flash=True)
    line = BootLine(rom, BAUD)
    read, silences = line.read, []

    def read_and_reset(timeout_s):
        data = read(timeout_s)
        silences.append(not data)
        if len(silences) == 3:
            rom.state = "autobaud"
        return data

    line.read = read_and_reset
    send_image(line, IMAGE)
    assert silences[:4] == [True, True, True, False]
    assert rom.entry == IMAGE.entry


def test_no_board_is_no_echo():
    bench = Bench(BootRom(boots_from_flash=True))
    error = failure(bench)
    assert isinstance(error, NotInBoot)
    assert "power" in error.hint and "1110" in error.hint
    assert set(bench.lines[0].written) == set(b"A")
    assert bench.lines[0].time == pytest.approx(5.0)


@pytest.mark.parametrize("protocol", [1, 99])
def test_a_running_firmware_is_told_as_wrong_boot_pins(protocol):
    flashed = Program("hbench-core 0.0", protocol)
    error = failure(Bench(BootRom(flash_program=flashed, boots_from_flash=True)))
    assert isinstance(error, NotInBoot)
    assert isinstance(error, NotInBoot) and "hbench-core 0.0" in error.message


def test_a_program_that_talks_is_told_from_the_rom():
    bench = Bench(BootRom(flash_program=Babble(), boots_from_flash=True))
    error = failure(bench)
    assert isinstance(error, NotInBoot) and re.search(r"'A'.* 3F 21.* 41", error.message)
    assert bench.lines[0].written == b"A"


def test_a_second_echo_means_a_stray_octet_and_stops_the_loading():
    class Late(BootLine):
        def read(self, timeout_s):
            return b"" if len(self.written) < 2 else super().read(timeout_s)

    line = Late(BootRom(), BAUD)
    with pytest.raises(NotInBoot, match=r"41 41.* 41"):
        send_image(line, IMAGE)
    assert line.written == b"AA"


@pytest.mark.parametrize("latency_s", [0.0, 0.016])
@pytest.mark.parametrize("number", [1, 2, 22, 23, 500, len(STREAM) - 1])
def test_an_echo_mismatch_names_the_byte_and_nothing_is_sent_after_it(number, latency_s):
    bench = Bench(BootRom(), flips={number: 0x80}, latency_s=latency_s)
    error = failure(bench)
    sent = STREAM[number - 1]
    assert f"byte {number} of {len(STREAM)}" in error.message
    assert re.search(rf"0x{sent:02X}\b.*0x{sent ^ 0x80:02X}\b", error.message)
    (line,) = bench.lines
    with_good_echoes = 1 + number - 1  # the 'A' and what came back before
    assert line.written == (b"A" + STREAM)[: with_good_echoes + ECHO_WINDOW]


@pytest.mark.parametrize("number", [1, 2, 23, 700])
def test_silence_in_the_middle_names_the_byte(number):
    bench = Bench(BootRom(), silent_from=number)
    error = failure(bench)
    assert f" byte {number} of {len(STREAM)}" in error.message
    assert len(bench.lines) == 1
    assert bench.lines[0].time < 2.0


def test_an_octet_that_is_no_echo_is_told():
    class Gossip(BootLine):
        def read(self, timeout_s):
            data = b""
            while part := super().read(timeout_s):
                data += part
            return data + (b"\x55" if self.number == 3 * ECHO_WINDOW else b"")

    with pytest.raises(DeviceError, match=rf"0x55 .*byte {3 * ECHO_WINDOW + 1}\b"):
        send_image(Gossip(BootRom(), BAUD), IMAGE)


def test_a_garbled_echo_of_the_last_byte_is_left_to_the_identification():
    bench = Bench(BootRom(ram_program=Program()), flips={len(STREAM): 0xFF})
    assert bench.flash().firmware == FIRMWARE


def test_no_answer_after_loading_is_told_as_such():
    error = failure(Bench(BootRom()))
    assert "image.txt" in error.message and "'identify'" in error.message
    assert "watchdog" in error.hint


def test_another_firmware_than_the_loaded_one_is_found_out():
    error = failure(Bench(BootRom(ram_program=Program("hbench-core 8.8"))))
    assert re.search(r"'hbench-core 8.8'.*image.txt", error.message)


def test_another_board_than_that_of_the_image_is_found_out():
    other = Program()
    other.identity["board"] = "mps2"
    assert re.search(r"'mps2'.*image.txt", failure(Bench(BootRom(ram_program=other))).message)


def test_a_firmware_of_another_protocol_is_refused_by_name():
    assert "protocol 99," in failure(Bench(BootRom(ram_program=Program(protocol=99)))).message


def test_the_virtual_rig_is_not_flashed():
    with pytest.raises(ConfigError, match="--port sim"):
        workflow.flash(IMAGE, "sim", BAUD, PROGRAM_BAUD)


def serve(master, rom, latency_s):
    """Answer on the far end of a pseudo-terminal, which has no rate: a program takes any."""
    line = BootLine(rom, PROGRAM_BAUD, latency_s)
    while True:
        try:
            data = os.read(master, 64)
        except OSError:
            return
        line.write(data)
        while answer := line.read(1.0):
            os.write(master, answer)


@pytest.fixture
def terminal():
    """Return a function that puts a boot ROM behind a pseudo-terminal and names the terminal."""
    ends = []

    def connect(rom):
        master, slave = pty.openpty()
        ends.extend((master, slave))
        threading.Thread(target=serve, args=(master, rom, 0.0), daemon=True).start()
        return os.ttyname(slave)

    yield connect
    for end in reversed(ends):
        os.close(end)


def test_a_serial_device_is_flashed(terminal):
    rom = BootRom(ram_program=Program())
    identity = workflow.flash(IMAGE, terminal(rom), BAUD, PROGRAM_BAUD)
    assert identity.firmware == FIRMWARE
    expected = {0x8000 + i: word for i, word in enumerate(range(1, 400))}
    expected |= {0x9000 + i: word for i, word in enumerate([*ID_WORDS, 0])}
    assert rom.memory == expected


def test_the_command_prints_who_runs(terminal, tmp_path, monkeypatch, capsys):
    from hbench.cli.main import main

    path = tmp_path / "image.txt"
    path.write_text(text_of(STREAM))
    device = terminal(BootRom(ram_program=Program()))
    monkeypatch.setattr("sys.argv", ["hbench", "flash", str(path), "--port", device])
    with pytest.raises(SystemExit) as end:
        main()
    out, err = capsys.readouterr()
    assert end.value.code == 0
    assert re.fullmatch(rf"{device}: .*'{FIRMWARE}' .*'f28335'\n", out)
    assert re.search(rf"\b{399 + len(ID_WORDS) + 1} words\b.*\b2 blocks", err)


def test_the_command_ends_with_the_exit_code_of_a_bad_image(tmp_path, monkeypatch, capsys):
    from hbench.cli.main import main

    path = tmp_path / "image.txt"
    path.write_text("no image")
    monkeypatch.setattr("sys.argv", ["hbench", "flash", str(path), "--port", "/dev/none"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == ExitCode.DATA
    assert re.search(r"^error: .*image\.txt: line 1\b", capsys.readouterr().err, re.MULTILINE)
