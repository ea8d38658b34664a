"""The F28335 port, compiled for the host and run on a simulated chip.

It was never compiled by TI's compiler and never run on hardware: these tests check its accesses to
registers against the documents only.
"""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from hbench.rig import firmware
from tests.support.board.f28335_board import COMPILER, CORE, PORT, SOURCES, OnChip, build
from tests.support.board.f28335_chip import ADC_VECTOR, ILLEGAL_VECTOR, Chip

NEUTRAL = [0x000000, 0x010000, 0x020000]
pytestmark = [
    pytest.mark.skipif(COMPILER is None, reason="no C compiler"),
    pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    port = [source for source in SOURCES if source.name != "main.c"]
    return build(tmp_path_factory.mktemp("f28335"), sources=[*CORE.glob("*.c"), *port])


@pytest.fixture
def chip(library, tmp_path):
    """A chip after power-up; no write to it may be refused."""
    chip = Chip(ctypes.CDLL(str(shutil.copy(library, tmp_path / "own.so"))))
    yield chip
    assert not chip.refused


@pytest.fixture
def board(chip, new_board, monkeypatch):
    """A board on the chip at rest, with settings and a step uploaded."""
    monkeypatch.setattr(firmware, "HostFirmware", lambda boots: OnChip(chip))
    return upload(new_board())


def upload(board):
    board.rest(0.0002, x=0.05)
    assert board.write_settings() == b""
    assert board.write_motion(hold_s=0.002) == b""
    return board


def test_the_valves_are_neutral_before_the_clock_is_set(chip):
    assert chip.start()
    pll = chip.written.index((0x7021, 10))
    before = chip.written[:pll]
    words = [
        (chip.written[i - 1][1] << 16) + low for i, (at, low) in enumerate(before) if at == 0x5003
    ]
    # CLEAR; clear to 0 V; +-10 V on all; code 0 on all; A, B, C and reference on; code 0 on all.
    assert words == [0x1C0000, 0x190000, 0x0C0004, 0x040000, 0x100017, 0x040000]
    assert chip.dac_words[: len(words)] == words
    released = chip.written.index((0x6FC2, 0x40))
    assert released > pll and chip.clear_pin == 1


def test_start_sets_the_clocks_and_rates(chip):
    assert chip.start()
    register = chip.register
    assert register[0x7021] == 10 and register[0x7011] & 0x180 == 0x100  # 30 MHz x 10 / 2
    assert register[0x7011] & 0x48 == 0  # missing-clock detection is on
    assert (register[0x701A], register[0x701B]) == (3, 2)  # 25 MHz, 37.5 MHz
    assert register[0x6805] == 14999  # 10 kHz at 150 MHz
    line = chip.line.register
    assert (line[0x7052], line[0x7053]) == (0, 40)  # 115200
    assert line[0x7050] == 7 and line[0x7051] == 0x23
    assert register[0x7118] == 0x00E0 and "ADC_cal".upper() in chip.executed
    assert register[0x5005] & 0x1800 == 0x1000 and register[0x5009] == 0x80  # SPI, 24 bits
    assert register[0x7029] == 0x002A  # the watchdog is on
    assert len(chip.vectors) == 128


@pytest.mark.parametrize(("baud", "divider"), [(9600, 487), (468750, 9), (937500, 4)])
def test_the_baud_rate_is_a_compiler_option(tmp_path, baud, divider):
    uart = build(tmp_path, f"-DHB_BAUD={baud}UL", sources=[PORT / "uart.c", PORT / "system.c"])
    chip = Chip(ctypes.CDLL(str(uart)))
    chip.program.hb_modules_start()
    chip.program.hb_uart_start()
    assert chip.line.register[0x7052] << 8 | chip.line.register[0x7053] == divider


def test_an_unattainable_baud_rate_does_not_compile(tmp_path):
    with pytest.raises(subprocess.CalledProcessError):
        build(tmp_path, "-DHB_BAUD=2000000UL", sources=[PORT / "uart.c"])


def test_codes_are_sent_as_words_of_the_dac(chip):
    chip.start()
    chip.program.hb_dac_write.restype = ctypes.c_bool
    assert chip.program.hb_dac_write((ctypes.c_int16 * 3)(2047, -2048, -1))
    chip.pass_time(10)
    assert chip.dac_words[-3:] == [0x007FF0, 0x018000, 0x02FFF0]


def test_a_word_is_the_sum_of_sixteen_conversions(board, chip):
    rng = np.random.default_rng(7)
    conversions = rng.integers(0, 4096, (8, 16))
    conversions[5], conversions[6] = 4095, 0
    taken = dict.fromkeys(range(8), 0)

    def convert(channel):
        taken[channel] += 1
        return int(conversions[channel][(taken[channel] - 1) % 16])

    chip.convert = convert
    words = (ctypes.c_uint16 * 8)()
    chip.pass_time(100)  # the time base starts the first pass; its interrupt is pending
    chip.pass_time(2)
    assert ADC_VECTOR in chip.pending
    chip.program.hb_adc_read.restype = ctypes.c_bool
    assert chip.program.hb_adc_read(words)
    assert list(words) == conversions.sum(axis=1).tolist()
    assert words[5] == 65520
    assert all(count == 16 for count in taken.values())


def test_a_run_gives_the_codes_of_the_host_build(board, chip, new_board, monkeypatch):
    monkeypatch.undo()
    twin = upload(new_board())
    at_rest = [word // 16 * 16 for word in twin.words()]
    for _ in range(20):
        twin.firmware.tick(at_rest)
    chip.first_sent_at_tick = None
    assert board.start() == b"" and twin.start() == b""
    for _ in range(chip.ticks - chip.first_sent_at_tick):
        codes = twin.firmware.tick(at_rest)
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(400):
        words = [int(word) // 16 * 16 for word in at_rest + rng.normal(0, 30, 8)]
        codes = list(twin.firmware.tick(words))
        assert board.firmware.tick(words) == codes
        seen.add(tuple(codes))
    assert len(seen) > 100 and board.cause() == twin.cause() == ("running", "none")


def test_requests_in_flight_are_all_answered(board, chip):
    frames = [board.frame(n, 0x01) for n in range(12)]
    assert sum(map(len, frames)) >= 72
    answers = board.exchange(b"".join(frames))
    assert [(sequence, code) for sequence, code, _ in answers] == [(n, 0x81) for n in range(12)]
    assert b"f28335\0" in answers[0][2]


@pytest.mark.parametrize("fault", ["stopped", "overflown"])
def test_a_stopped_receiver_is_restarted(board, chip, fault):
    setattr(chip.line, fault, True)
    chip.run(50)
    assert board.request("identify")


def test_the_receive_queue_holds_octets_until_they_are_read(board, chip):
    frames = [board.frame(n, 0x01) for n in range(20)]
    assert 64 < sum(map(len, frames)) < 256
    chip.receive(b"".join(frames))
    chip.run(2000, idle=False)
    assert not chip.line.to_board and not chip.line.overflown
    assert len(board.exchange(b"")) == 20


def services(chip):
    return chip.written.count((0x7025, 0xAA))


def test_the_watchdog_is_serviced_only_after_a_tick(board, chip):
    chip.interrupts = False
    chip.program.hb_board_idle()
    before = services(chip)
    for _ in range(5):
        chip.program.hb_board_idle()
    assert services(chip) == before
    chip.interrupts = True
    chip.run(120)
    assert services(chip) > before


def test_the_watchdog_does_not_reset_while_loop_and_interrupt_run(board, chip):
    chip.run(60_000)
    assert not chip.was_reset


def start(board):
    assert board.start() == b""
    board.rest(0.05, x=0.0505)
    assert board.cause() == ("running", "none") and board.firmware.last_words() != NEUTRAL


def test_a_tick_longer_than_its_period_is_a_fault(board, chip):
    start(board)
    chip.access_us = 0.7
    chip.run(150)
    chip.access_us = 0.04
    chip.run(400)
    assert board.firmware.last_words() == NEUTRAL
    assert board.cause() == ("fault", "overrun")


def test_a_lost_tick_is_a_fault(board, chip):
    start(board)
    chip.pass_time(170)
    chip.run(60)
    assert board.firmware.last_words() == NEUTRAL
    assert board.cause() == ("fault", "overrun")


def test_ticks_lost_while_start_checks_are_no_fault(board, chip, monkeypatch):
    answer = board.firmware.poll

    def check_for_long():
        while not chip.line.to_host:
            chip.run(1)
        chip.pass_time(1000)  # like a core that masks the control interrupt for this time
        answer()

    monkeypatch.setattr(board.firmware, "poll", check_for_long)
    before = chip.ticks
    assert board.start() == b""
    monkeypatch.undo()
    assert chip.ticks > before and board.cause() == ("running", "none")


def fail(chip, what):
    """Cause a failure within a tick; simulate 6 ms."""
    if what == "instruction":
        chip.vectors[ILLEGAL_VECTOR]()
    elif what == "converter":
        chip.convert = lambda channel: setattr(chip, "adc_dead", True) or 0
    elif what == "time base":
        chip.pwm_dead = True
    elif what == "mcbsp":
        chip.mcbsp_dead = True
    chip.run(6000, idle=what != "idle loop")


@pytest.mark.parametrize("what", ["instruction", "converter", "time base", "idle loop"])
def test_on_a_failure_the_valves_are_neutral_and_the_watchdog_resets(board, chip, what):
    start(board)
    fail(chip, what)
    assert chip.hung and not chip.was_reset and chip.clear_pin == 0
    chip.pass_time(20)
    assert chip.dac_words[-2:] == [0x1C0000, 0x040000]
    chip.pass_time(9000)
    assert chip.was_reset


def test_with_a_failed_mcbsp_the_clear_pin_makes_the_valves_neutral(board, chip):
    start(board)
    fail(chip, "mcbsp")
    assert chip.hung and chip.clear_pin == 0


def test_without_oscillator_or_dac_the_board_does_not_start(chip):
    chip.mcbsp_dead = True
    assert not chip.start() and chip.clear_pin == 0
    chip.reset()
    chip.mcbsp_dead = False
    chip.register[0x7011] |= 0x08
    assert not chip.start() and chip.dac_words[-1] == 0x040000


def test_each_start_has_a_different_number(chip):
    chip.program.hb_boots.restype = ctypes.c_uint16
    ram = (ctypes.c_uint16 * 256).in_dll(chip.program, "hb_boots_entropy")
    kept = (ctypes.c_uint16 * 2).in_dll(chip.program, "hb_boots_kept")
    first = [chip.program.hb_boots() for _ in range(5)]
    assert [b - a for a, b in zip(first, first[1:], strict=False)] == [1] * 4
    powered = set()
    for seed in range(20):
        ram[:] = np.random.default_rng(seed).integers(0, 65536, 256).tolist()
        kept[:] = (seed, seed)
        powered.add(chip.program.hb_boots())
    assert len(powered) == 20
    kept[:] = (0xFFFF, 0)
    assert chip.program.hb_boots() == 0
