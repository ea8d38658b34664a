"""Each limit stops the board in the tick in which it is exceeded, and the fault is latched."""

import pytest

from hbench.protocol.dictionary import FAULTS, STATES

TRIPS = [
    ("travel", {"x": 0.0049}),
    ("travel", {"x": 0.3951}),
    *(("pressure", {name: 260e5}) for name in ("p_tp", "p_tr", "p_lp", "p_lr", "p_s")),
    ("speed", {"x": 0.0612}),
    ("speed", {"x": 0.0588}),
]


@pytest.mark.parametrize(("fault", "change"), TRIPS, ids=str)
def test_an_exceeded_limit_makes_the_valves_neutral_at_once_and_latches_the_fault(
    moving, fault, change
):
    # A step of x between two ticks gives v = dx / (tau + T) = 1.2 mm / 2.1 ms; a pressure
    # passes a filter of 0.5 ms.
    moving.si.update(change)
    ticks = 0
    while any(moving.tick()):
        ticks += 1
        assert moving.cause() == ("running", "none")
        assert ticks < 20
    assert ticks == 0 or fault == "pressure"
    assert moving.cause() == ("fault", fault)


@pytest.mark.parametrize(("fault", "change"), TRIPS[:3], ids=str)
def test_a_fault_remains_until_cleared_even_without_its_cause(moving, fault, change):
    before = dict(moving.si)
    moving.si.update(change)
    for _ in range(30):
        moving.tick()
    moving.si.update(before)
    for _ in range(100):
        assert moving.tick() == [0, 0, 0]
    assert moving.cause() == ("fault", fault)
    assert moving.start() == "fault_latched"
    moving.request("stop")
    assert moving.cause() == ("fault", fault), "a stop does not hide it"
    assert moving.request("clear_fault") == b""
    assert moving.request("clear_fault") == b"", "again, without effect"
    assert moving.cause() == ("idle", "none")
    assert moving.tick() == [0, 0, 0]
    assert moving.start() == b""


def test_pressure_trips_when_its_filtered_value_passes_the_limit(moving):
    # D.29 from 60 bar towards 260 bar: 60 + 200 (1 - (5/6)^n) > 230 from n = 11 on.
    moving.si["p_tp"] = 260e5
    for _ in range(10):
        assert any(moving.tick())
    assert not any(moving.tick())


def test_values_just_inside_the_limits_are_no_fault(moving):
    moving.si.update(p_tp=229e5, p_s=229e5, x=0.0607)
    for _ in range(200):
        moving.tick()
    assert moving.cause() == ("running", "none")


def test_silence_of_the_host_stops_the_board_after_the_heartbeat(board):
    board.write_settings(heartbeat_s=0.02)
    board.rest(0.05, x=0.06)
    board.start()
    for _ in range(200):
        commands = board.tick()
    assert any(commands)
    assert not any(board.tick())
    assert board.cause() == ("fault", "heartbeat")


@pytest.mark.parametrize("octets", [b"", b"\x07\x07\x07\0", b"\0" * 9])
def test_garbage_is_no_heartbeat(board, octets):
    board.write_settings(heartbeat_s=0.02)
    board.start()
    for _ in range(250):
        board.exchange(octets)
        board.tick()
    assert board.cause() == ("fault", "heartbeat")


def test_any_valid_frame_is_a_heartbeat(board):
    board.write_settings(heartbeat_s=0.02)
    board.start()
    for _ in range(5):
        for _ in range(150):
            board.tick()
        board.exchange(board.frame(1, 0x7E))
    assert board.cause() == ("running", "none")


def test_silence_at_rest_is_no_fault(board):
    board.write_settings(heartbeat_s=0.02)
    for _ in range(500):
        board.tick()
    assert board.cause() == ("idle", "none")
    assert board.start() == b""
    board.tick()
    assert board.cause() == ("running", "none")


def test_a_return_that_exceeds_its_time_is_a_latched_fault(board):
    """The piston is held: 3 x 0.39 m / (0.15 m/s) + 10 s + 8 / (5/s) = 19.4 s."""
    board.write_motion(x_start_m=0.2)
    assert board.start() == b""
    seconds = 0
    while board.status()["state"] == STATES.index("running"):
        for _ in range(10_000):
            codes = board.tick()
        seconds += 1
        assert seconds < 30
    assert board.status()["fault"] == FAULTS.index("return")
    assert seconds == 20 and tuple(codes) == (0, 0, 0)
