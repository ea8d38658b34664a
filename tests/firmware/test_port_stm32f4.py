"""The STM32F4 port in QEMU: the image, except for its clock file, on an emulated STM32F405.

The emulator models no clock tree, DMA, inputs of the ADC, pins, watchdog or supply: what depends on
them is tested as far as the writes to their registers go. Nothing here ran on hardware.
"""

import re
import struct
import subprocess
import time
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.rig.emulator import EmulatedFirmware
from hbench.rig.firmware import HostFirmware
from tests.support.board import stm32f4_emulator as emulator
from tests.support.board.f28335_board import ROOT
from tests.support.board.kinematic import drive, read_all

README = ROOT / "firmware" / "ports" / "stm32f4" / "README.md"
TICK_NS = 99_999  # the emulated timer's period is its reload value, a count short of the chip's
TICKS = 20_000
NEUTRAL = (0, 0, 0)
STACK_END = 0x20000000  # RAM that no test reaches
SUPPLY_BIT = 1 << 1


def upload(board, **settings):
    assert board.write_settings(log_divider=20.0, **settings) == b""
    assert board.write_motion(trials=2, duration_s=0.18) == b""


@pytest.fixture(scope="module")
def image(stm32f4_images, require_tool):
    """Image for the emulator."""
    require_tool(emulator.PROGRAM)
    return stm32f4_images / "hbench-stm32f4-emulated.elf"


@pytest.fixture(scope="module")
def symbols(image, require_tool):
    """Addresses of the image's functions and variables, and of two instructions."""
    command = [require_tool("arm-none-eabi-nm"), image]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    addresses = {name: int(address, 16) for address, _, name in map(str.split, lines)}
    text = image.with_suffix(".bin").read_bytes()
    stop = addresses["board_stop"] - 0x08000000
    hang = text.index(b"\xfe\xe7", stop)  # its last instruction, a jump to itself
    assert hang % 2 == 0 and hang < stop + 64
    store = next(at for at in range(0, len(text), 2) if text[at : at + 2] == b"\x01\x60")
    return addresses | {"hang": 0x08000000 + hang, "store": 0x08000000 + store}


@pytest.fixture(scope="module")
def rows(new_board):
    """Converter words of a schedule in closed loop, from its start to its end."""
    board, rows = new_board(), []
    board.rest(0.002, x=0.05)
    upload(board)
    tick = board.firmware.tick
    board.firmware.tick = lambda words: rows.append(words) or tick(words)
    assert board.start() == b""
    while board.cause()[0] == "running":
        drive(board, 100)
    assert board.cause() == ("done", "none")
    return np.array(rows)


@pytest.fixture(scope="module")
def played(image, rows, new_board, tmp_path_factory):
    """The schedule on the emulated board: its trace, the requests, and the log."""
    folder = tmp_path_factory.mktemp("played")
    machine = emulator.Machine(image, folder, rows, all_writes=False)
    try:
        board = new_board(on=machine)
        upload(board, heartbeat_s=10.0)
        assert board.start() == b""
        machine.advance()
        while board.cause()[0] == "running":
            time.sleep(0.1)
        assert board.cause() == ("done", "none")
        requests, replies = machine.frames.copy(), machine.replies
        trace = machine.trace()
        return SimpleNamespace(trace=trace, requests=requests, replies=replies, log=read_all(board))
    finally:
        machine.close()


def replay(played, rows, twin):
    """Execute a trace's ticks and requests on another board; return its codes and replies."""
    requests, ticks = iter(played.requests), iter(played.trace.ticks)
    codes, replies = [], b""
    for event in played.trace.events:
        if event == "tick":
            codes.append(tuple(twin.tick(rows[next(ticks).row].tolist())))
        else:
            twin.receive(next(requests))
            twin.poll()
            replies += twin.transmit()
    assert next(requests, None) is None
    return codes, replies


@pytest.mark.parametrize("other", ["host", "mps2"])
def test_20_000_ticks_have_the_codes_and_replies_of_the_other_ports_bit_for_bit(
    played, rows, new_board, mps2_build, other
):
    """Each tick and request in the order in which the emulated board executed them."""
    if other == "host":
        twin = HostFirmware(boots=0)
    else:
        twin = EmulatedFirmware(mps2_build / "hbench-mps2.elf")
    try:
        codes, replies = replay(played, rows, twin)
        log = read_all(new_board(on=twin))
    finally:
        twin.close()
    assert codes == played.trace.codes
    assert replies == played.replies
    assert np.array_equal(log, played.log) and len(log) > 150

    assert len(codes) > TICKS
    assert all(len(set(valve)) > 50 for valve in zip(*codes, strict=True))
    print(f"{len(codes)} ticks, {len(played.requests)} requests, {len(log)} records")


def test_ticks_come_at_10_khz_of_the_emulated_timer(played):
    begin = np.array([tick.begin_ns for tick in played.trace.ticks], dtype=np.uint32)
    periods = np.diff(begin).astype(np.int64)  # the time wraps at 2^32
    assert np.mean(periods) == pytest.approx(TICK_NS, abs=1)
    late = np.cumsum(periods - TICK_NS)
    # An octet's reception delays a tick, and so does a request, which masks the control interrupt.
    # Only "start", at rest, takes longer than 20 us: it checks settings and schedule. QEMU begins a
    # period when it handles the end of the last one, rarely some 0.5 us late, and some 10 us late
    # where the machine that emulates was paused.
    assert np.mean(late - late.min() > 20_000) < 1e-3 and np.ptp(late) < 50_000
    assert np.mean(periods == TICK_NS) > 0.5
    print(f"{np.mean(periods == TICK_NS):.1%} of the periods exact, range {np.ptp(late)} ns")


def test_instructions_of_a_tick_fit_its_budget(played):
    """At most an instruction in each of two cycles of the 168 MHz; the README has the figures.

    They are those of a run. At rest a tick may also contain the reception of an upload's octets,
    how many depends on the host.
    """
    assert max(tick.instructions for tick in played.trace.ticks) < 168e6 / 10e3 / 2
    instructions = [tick.instructions for tick in played.trace.ticks if tick.row > 0]
    assert len(instructions) > 0.9 * TICKS
    figures = {"median": int(np.median(instructions)), "worst": max(instructions)}
    print(figures)
    stated = dict(re.findall(r"\| (median|worst) tick \| ([\d ]+) \|", README.read_text()))
    for name, count in figures.items():
        assert int(stated[name].replace(" ", "")) == pytest.approx(count, rel=0.1), name


@pytest.fixture
def machine(image, rows, tmp_path):
    """An emulated board whose piston stays at the schedule's start; all writes are traced."""
    machine = emulator.Machine(image, tmp_path, rows[:1])
    yield machine
    machine.close()


@pytest.fixture
def board(machine, new_board):
    """The board with a schedule whose load pressures move the valves at once."""
    board = new_board(on=machine)
    assert board.write_settings(heartbeat_s=10.0) == b""
    assert board.write_motion(p_lr_ref_pa=20e5, p_lp_ref_pa=45e5) == b""
    return board


def run(board, machine):
    """Start the schedule; return as the valves have codes other than neutral."""
    mark = machine.mark()
    assert board.start() == b""
    machine.await_trace(lambda trace: any(map(any, trace.codes)), mark)
    return mark


def test_outputs_are_neutral_and_cut_until_the_first_tick_has_ended(machine):
    trace = machine.trace()
    # CLEAR; clear to 0 V; +-10 V on all; code 0 on all; A, B, C and reference on; code 0 on all.
    start = [0x1C0000, 0x190000, 0x0C0004, 0x040000, 0x100017, 0x040000]
    assert trace.words[: len(start)] == start
    assert trace.released == [(0, False), (1, True)]
    assert trace.codes[0] == NEUTRAL


def test_a_silent_host_stops_the_valves_at_the_heartbeats_tick(board, machine):
    assert board.write_settings(heartbeat_s=0.05) == b""
    mark = run(board, machine)
    trace = machine.await_trace(lambda trace: trace.codes[-1] == NEUTRAL, mark)
    silent = trace.events[::-1].index("request")  # ticks since "start"
    moving = [any(codes) for codes in trace.codes[-silent:]]
    assert all(moving[400:500]) and not any(moving[500:])
    assert board.cause() == ("fault", "heartbeat")
    # The codes as words of the DAC: channel, code left-justified in 16 bits.
    for tick in trace.ticks:
        t, l1, l2 = (code % 4096 << 4 for code in tick.codes)
        assert tick.dac == (t, 0x10000 + l1, 0x20000 + l2)
    # The watchdog is serviced once after each tick.
    assert trace.services[1:] == sorted(set(trace.services[1:]))
    assert len(trace.services) > len(trace.ticks) - 10


def test_a_pressed_emergency_stop_ends_the_schedule_in_one_tick(board, machine, symbols):
    """The emulator has no pins: a debugger presses it for one tick."""
    run(board, machine)
    debugger, mark = machine.debugger(symbols["hb_link_poll"]), machine.mark()
    debugger.run_to(symbols["emergency_stop_is_pressed"])
    debugger.set_register(0, 1)
    debugger.set_register(15, debugger.register(14) & ~1)
    debugger.leave()
    assert board.cause() == ("fault", "sensor")
    codes = machine.trace(mark).codes
    assert codes and not any(map(any, codes))


def test_a_late_tick_is_an_overrun(board, machine, symbols):
    run(board, machine)
    debugger = machine.debugger(symbols["hb_link_poll"])
    debugger.poke(symbols["store"], emulator.NVIC_DISABLE, emulator.TIM2_BIT)
    debugger.run_to(symbols["board_supervision_interrupt"])  # within a millisecond
    debugger.poke(symbols["store"], emulator.NVIC_ENABLE, emulator.TIM2_BIT)
    debugger.leave()
    assert board.cause() == ("fault", "overrun")


def test_one_missing_conversion_does_not_stop_the_board(board, machine, symbols):
    """As may happen in the tick after a late one. The debugger's stop makes the tick late."""
    run(board, machine)
    debugger, mark = machine.debugger(symbols["hb_link_poll"]), machine.mark()
    debugger.run_to(symbols["adc_read"])
    debugger.write(symbols["adc_conversions"] + 4 * 64 + 124, 0xFFFF0000)
    debugger.leave()
    assert board.cause() == ("fault", "overrun")
    assert machine.trace(mark).released == []


def block_idle(debugger, symbols):
    debugger.write(STACK_END, 0xE7FEE7FE)  # a jump to itself
    debugger.set_register(15, STACK_END)


def stop_timer(debugger, symbols):
    debugger.poke(symbols["store"], emulator.TIM2_CR1, 0)


def jump_into_nowhere(debugger, symbols):
    debugger.set_register(15, 0x50000000)


def overflow_stack(debugger, symbols):
    debugger.set_register(13, STACK_END)


def stop_dma(debugger, symbols):
    """The last conversion is missing at two ticks; at one it would not be a failure."""
    for _ in range(2):
        debugger.run_to(symbols["adc_read"])
        debugger.write(symbols["adc_conversions"] + 4 * 64 + 124, 0xFFFF0000)


def drop_supply(debugger, symbols):
    debugger.poke(symbols["store"], emulator.NVIC_PEND, SUPPLY_BIT)


FAILURES = [block_idle, stop_timer, jump_into_nowhere, overflow_stack, stop_dma, drop_supply]


@pytest.mark.parametrize("cause", FAILURES, ids=lambda cause: cause.__name__)
def test_a_failure_cuts_the_outputs_and_leaves_the_watchdog_unserviced(
    board, machine, symbols, cause
):
    run(board, machine)
    debugger, mark = machine.debugger(symbols["hb_link_poll"]), machine.mark()
    cause(debugger, symbols)
    debugger.run_to(symbols["hang"])
    trace = machine.trace(mark)
    ((ticks, released),) = trace.released
    assert not released and ticks <= 51
    assert trace.words[-2:] == [0x1C0000, 0x040000]  # CLEAR, code 0 on all
    assert all(service <= ticks for service in trace.services)
    mark = machine.mark()
    debugger.step()
    assert debugger.register(15) == symbols["hang"] and machine.mark() == mark  # for ever


def test_after_the_watchdogs_reset_the_board_waits_at_rest_with_another_number(
    machine, new_board, symbols
):
    """The emulator's reset stands in for that by the watchdog, which it does not have."""
    board = new_board(on=machine)
    before = boots(board)
    debugger, mark = machine.debugger(symbols["hb_link_poll"]), machine.mark()
    stop_timer(debugger, symbols)
    debugger.run_to(symbols["hang"])
    debugger.reset()
    debugger.leave()
    trace = machine.await_trace(lambda trace: trace.released[-1:] and trace.released[-1][1], mark)
    assert boots(board) == before + 1 and board.cause() == ("idle", "none")
    assert [released for _, released in trace.released] == [False, False, True]
    assert not any(map(any, trace.codes))


def boots(board):
    return struct.unpack_from("<H", board.request("identify"), 6 + 16 + 16)[0]
