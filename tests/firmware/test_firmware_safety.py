"""Each limit stops the board in the tick in which it is exceeded, and the fault is latched."""

import pytest

from hbench.protocol.dictionary import FAULTS, PHASES, STATES
from hbench.protocol.frames import Frame, encode

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


def frame(sequence, code, payload):
    return encode(Frame(sequence, code, payload))


UNKNOWN, TOO_LONG, TOO_SHORT = 0x7E, 0x08, 0x09  # status with a payload, read_log without


@pytest.mark.parametrize(
    "octets",
    [b"", b"\x07\x07\x07\0", b"\0" * 9]
    + [frame(1, code, payload) for code, payload in ((UNKNOWN, b""), (TOO_LONG, b"?"))]
    + [frame(1, TOO_SHORT, b"")],
    ids=["silence", "damaged", "zeros", "unknown", "too long", "too short"],
)
def test_what_is_no_request_of_this_protocol_is_no_heartbeat(board, octets):
    board.write_settings(heartbeat_s=0.02)
    board.start()
    for _ in range(250):
        board.exchange(octets)
        board.tick()
    assert board.cause() == ("fault", "heartbeat")


@pytest.mark.parametrize("name", ["status", "start", "write_settings"])
def test_a_request_is_a_heartbeat_also_if_it_is_refused(board, name):
    board.write_settings(heartbeat_s=0.02)
    board.start()
    payload = {"status": b"", "start": bytes(4), "write_settings": bytes(6)}[name]
    for _ in range(5):
        for _ in range(150):
            board.tick()
        assert board.request(name, payload) == "busy" or name == "status"
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


def test_a_load_that_is_not_reached_in_time_is_a_latched_fault(board):
    """From -1e9 Pa, as a wrong offset gives, a step of 10 Pa a tick is lost in rounding.

    2 x (1e5 Pa / (1e5 Pa/s) + 0.15 m/s / (0.5 m/s^2)) + 0.1 s = 2.7 s.
    """
    board.write_settings(
        pressure_max_pa=1e5, pressure_slew_pa_s=1e5, heartbeat_s=60.0, offset_p_lr=-1e9
    )
    board.write_motion(p_lr_ref_pa=1e5, p_lp_ref_pa=0.0)
    board.si.update(dict.fromkeys(("p_tp", "p_tr", "p_lp", "p_lr", "p_s"), 0.0))
    board.rest(0.1, x=0.05)
    assert board.start() == b""
    ticks = 0
    while board.status()["phase"] != PHASES.index("hold"):
        board.tick()
    while board.status()["state"] == STATES.index("running"):
        codes = [board.tick() for _ in range(100)][-1]
        ticks += 100
        assert ticks < 50_000
    assert board.status()["fault"] == FAULTS.index("load")
    assert ticks == 27_100 and codes == [0, 0, 0]
