"""Conditions of each fault, to the tick, and the precedence of simultaneous faults."""

import numpy as np
import pytest

from hbench.protocol.dictionary import FAULTS, PHASES, RECORD, SENSORS, STATES
from tests.support.board.kinematic import LAST, SENSOR_SATURATED, WORD, T, drive, read_all

TOP = 65520  # 4095 counts in sixteenths
MARGIN = 256  # 16 counts
SPEED_ERROR_M_S = 0.050025  # between two values of a reference that moves by 0.05 mm/s a tick
PRESSURES = [name for name in SENSORS if name.startswith("p_")]


# ---- sensors out of range ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "raw",
    [{"x": word} for word in (0, 3, MARGIN, TOP - MARGIN, TOP)]
    + [{name: word} for name in PRESSURES for word in (TOP - MARGIN, TOP)],
    ids=str,
)
def test_a_word_outside_the_sensor_range_stops_the_board_in_its_tick(moving, raw):
    moving.raw = raw
    assert moving.tick() == [0, 0, 0]
    assert moving.cause() == ("fault", "sensor")


@pytest.mark.parametrize(
    ("raw", "fault"),
    [({"x": MARGIN + 1}, "travel"), ({"x": TOP - MARGIN - 1}, "travel"), ({"p_s": 0}, None)]
    + [({name: TOP - MARGIN - 1}, "pressure") for name in PRESSURES],
    ids=str,
)
def test_a_word_just_inside_the_sensor_range_is_a_normal_value(moving, raw, fault):
    moving.raw = raw
    for _ in range(50):
        moving.tick()
    assert moving.cause() == (("fault", fault) if fault else ("running", "none"))


@pytest.mark.parametrize("raw", [{"p_s": 0}, {"f_applied": 0}, {"f_applied": TOP}], ids=str)
def test_zero_pressure_and_a_saturated_load_cell_are_flagged_but_no_fault(board, raw):
    board.start()
    while PHASES[board.status()["phase"]] != "accelerate":
        drive(board, 10)
    board.raw = raw
    drive(board, 1000)
    assert board.cause() == ("running", "none")
    flags = read_all(board)[:, WORD["flags"]]
    assert len(flags) >= 9 and np.all(flags & SENSOR_SATURATED)


# ---- travel ------------------------------------------------------------------------------------


@pytest.mark.parametrize("stopping_time", [0.0, 0.01, 0.05])
@pytest.mark.parametrize(("v", "limit"), [(0.3, 0.395), (-0.3, 0.005), (0.05, 0.395)])
def test_the_board_stops_at_speed_times_stopping_time_from_the_limit(
    board, v, limit, stopping_time
):
    board.write_settings(stopping_time_s=stopping_time, speed_error_max_m_s=1.0)
    board.rest(0.05, x=limit - v * 0.2)
    board.start()
    for _ in range(3000):
        board.si["x"] += v * T
        if board.tick() == [0, 0, 0] and board.status()["state"] == STATES.index("fault"):
            break
    assert board.cause() == ("fault", "travel")
    # x has a resolution of 7 um, which causes a ripple of v of 7 um / 2.1 ms = 3.3 mm/s.
    assert limit - board.si["x"] == pytest.approx(
        v * stopping_time, abs=7e-6 + abs(v) * T + 0.0034 * stopping_time
    )


# ---- speed error -------------------------------------------------------------------------------


def held_until_the_fault(board, jerk_at=None):
    """Hold the piston 0.25 m from its start; returns v_ref and v as the board computes them.

    At the tick ``jerk_at`` it slips by 0.7 mm.
    """
    board.write_settings(speed_error_max_m_s=SPEED_ERROR_M_S, speed_error_time_s=0.02)
    board.rest(0.05, x=0.3)
    board.start()
    v_ref, v, x = [], [0.0], board.words()[0]
    commands = [0.0]
    while len(v_ref) < 100 or any(commands):  # the first commands are below one code
        if len(v_ref) == jerk_at:
            board.si["x"] -= 7e-4
        v_ref.append(min(0.5 * T * len(v_ref), 0.15))  # 0.5 m/s^2, a tick old, towards the start
        commands = board.tick()
        before, x = x, board.words()[0]
        v.append(7e-6 * (before - x) / (2e-3 + T) + v[-1] * 2e-3 / (2e-3 + T))  # D.11
        assert len(v_ref) < 3000
    assert board.cause() == ("fault", "speed_error")
    return np.array(v_ref), np.array(v[1:])


def test_a_speed_error_is_a_fault_when_it_has_lasted_longer_than_its_time(board):
    v_ref, v = held_until_the_fault(board)
    too_large = np.flatnonzero(v_ref - v > SPEED_ERROR_M_S)
    assert len(v_ref) - 1 == too_large[0] + 200, "20 ms later"


def test_one_tick_of_small_speed_error_restarts_its_time(board):
    v_ref, v = held_until_the_fault(board, jerk_at=1150)
    small = np.flatnonzero(np.abs(v_ref - v) <= SPEED_ERROR_M_S)
    assert small[-1] >= 1150, "the slip was seen"
    assert len(v_ref) - 1 == small[-1] + 201


# ---- inputs that are only logged ---------------------------------------------------------------


@pytest.mark.parametrize("word", [0, 65520])
def test_an_oil_temperature_at_a_limit_of_the_converter_has_no_effect(new_board, word):
    """A board without this sensor has 0 there: no fault, no other command, no flag."""
    boards = new_board(), new_board()
    boards[1].temp_word = word
    for board in boards:
        board.write_settings()
        board.write_motion(hold_s=0.0, duration_s=0.05)
        board.rest(0.01, x=0.05)
        assert board.start() == b""
    assert all(boards[0].tick() == boards[1].tick() for _ in range(3000))
    assert [board.cause() for board in boards] == [("done", "none")] * 2
    logs = [board.read_log(0)[2] for board in boards]
    at = [entry.name for entry in RECORD].index("auxiliary")
    assert set(logs[1][:, at]) == {word}
    assert np.array_equal(*(np.delete(log, at, axis=1) for log in logs))


# ---- overrun -----------------------------------------------------------------------------------


def test_an_overrun_of_the_control_interrupt_stops_the_board(moving):
    moving.firmware.overrun()
    assert moving.cause() == ("fault", "overrun")
    assert moving.tick() == [0, 0, 0]
    moving.firmware.overrun()
    assert moving.start() == "fault_latched"
    assert moving.request("clear_fault") == b""
    assert moving.cause() == ("idle", "none")


def test_an_overrun_does_not_replace_the_cause_that_is_latched(moving):
    moving.raw = {"x": 0}
    moving.tick()
    moving.firmware.overrun()
    assert moving.cause() == ("fault", "sensor")


# ---- precedence -------------------------------------------------------------------------------

LIMITS = {"heartbeat_s": 0.02, "speed_error_time_s": 0.02, "speed_error_max_m_s": SPEED_ERROR_M_S}
TOO_FAST = {"x": 0.30 - 2e-3}  # 2 mm in a tick are 0.95 m/s


@pytest.mark.parametrize(
    ("fault", "raw", "change"),
    [
        ("sensor", {"x": 0}, {"p_tp": 260e5}),
        ("sensor", {"x": TOP}, {}),
        ("sensor", {"p_tp": TOP}, TOO_FAST),
        ("travel", {}, {"x": 0.4, "p_tp": 260e5}),
        ("pressure", {}, {"p_tp": 260e5, **TOO_FAST}),
        ("speed", {}, TOO_FAST),
        ("speed_error", {}, {}),
    ],
    ids=str,
)
def test_of_several_faults_in_a_tick_the_cause_is_reported(board, fault, raw, change):
    """The piston is held so that speed error and heartbeat expire in the same tick. All other
    faults are added in that tick: a broken position sensor also violates speed and travel."""
    board.write_settings(pressure_filter_s=0.0, **LIMITS)
    board.rest(0.05, x=0.3)
    board.start()
    for tick in range(1202):
        # The host sends requests until both have 200 ticks left.
        if tick <= 1001 and tick % 7 == 0 or tick == 1001:
            board.request("status")
        if tick == 1201:
            board.si.update(change)
            board.raw = raw
        assert any(board.tick()) == (100 < tick < 1201) or tick <= 100
    assert board.cause() == ("fault", fault)


def test_silence_of_the_host_is_a_heartbeat_fault(board):
    board.write_settings(heartbeat_s=0.02)
    board.start()
    for _ in range(200):
        drive(board, 1)
    assert board.cause() == ("running", "none")
    drive(board, 201)
    assert board.cause() == ("fault", "heartbeat")


# ---- in every phase ----------------------------------------------------------------------------


def provoke(board, fault):
    if fault == "overrun":
        board.firmware.overrun()
    elif fault == "sensor":
        board.raw = {"x": TOP}
    elif fault == "speed":
        board.si["x"] += 2e-3


@pytest.mark.parametrize("fault", ["overrun", "sensor", "speed"])
@pytest.mark.parametrize("phase", [phase for phase in PHASES[1:] if phase != "vent"])
def test_a_fault_stops_the_board_in_every_phase(board, phase, fault):
    closed = {"valves": 1, "v_m_s": 0.0, "duration_s": 0.05}
    push = {"valves": 2, "v_m_s": 0.0, "duration_s": 0.05, "force_rate_n_s": 1e3}
    push |= {"displacement_m": 0.1}
    assert board.write_row({"duration_s": 0.15}, closed, push, {"duration_s": 0.15}) == b""
    board.rest(0.05, x=0.06)
    assert board.start() == b""
    for _ in range(20_000):
        if PHASES[board.status()["phase"]] == phase:
            break
        drive(board, 1)
    drive(board, 20)
    assert PHASES[board.status()["phase"]] == phase
    provoke(board, fault)
    assert board.tick() == [0, 0, 0]
    status = board.status()
    assert (STATES[status["state"]], FAULTS[status["fault"]]) == ("fault", fault)
    assert PHASES[status["phase"]] == "none" and status["v_ref_m_s"] == 0.0
    board.raw = {}
    for _ in range(300):
        assert board.tick() == [0, 0, 0]
    assert board.cause() == ("fault", fault)
    whole = np.any(read_all(board)[:, WORD["flags"]] & LAST)
    assert whole == (phase == "brake"), "a run cut short has no last record"


@pytest.mark.parametrize("state", ["idle", "done"])
def test_there_are_no_faults_while_nothing_runs(board, state):
    if state == "done":
        board.write_motion(duration_s=0.01)
        board.start()
        drive(board, 3000)
    assert board.cause() == (state, "none")
    for fault in ("overrun", "sensor", "speed"):
        provoke(board, fault)
        board.si["x"] += 0.2
        for _ in range(100):
            assert board.tick() == [0, 0, 0]
        assert board.cause() == (state, "none")
