"""Random scripts of requests, ticks, silences and overruns, compared with a model of the board.

The model states the allowed effects of each on the board's state. Requests are right, wrong or
repeated.
"""

import binascii
import struct

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from hypothesis.stateful import run_state_machine_as_test as run_machine

from hbench.protocol.dictionary import CRC_START, FAULTS, INPUTS, PHASES, SENSORS, SETTINGS, STATES
from tests.support.board.kinematic import T, drive

HEARTBEAT_TICKS = 200
BENCH = {
    **{"heartbeat_s": HEARTBEAT_TICKS * T, "speed_error_time_s": 0.01, "speed_error_max_m_s": 0.1},
    **{"return_speed_m_s": 0.3, "acceleration_m_s2": 5.0, "pressure_slew_pa_s": 1e9},
    **{"log_divider": 10.0, "travel_min_m": 0.01},
}
UNUSABLE = ({"heartbeat_s": 0.0}, {"travel_min_m": 0.5}, {"log_divider": 0.0})  # refused by "start"
SEGMENTS = st.fixed_dictionaries(
    {
        "valves": st.sampled_from((0, 0, 0, 1, 2, 3)),
        "v_m_s": st.sampled_from((0.1, -0.1, 0.0)),
        "a_m_s2": st.sampled_from((2.0, 1e4)),
        "duration_s": st.sampled_from((1e-4, 0.004, 0.02)),
        "force_rate_n_s": st.sampled_from((1e3, -1e6)),
        "displacement_m": st.sampled_from((0.0, 1e-4, 0.1)),
    }
)
STEP = {
    **{"trials": 2, "segments": 1, "cycles": 2, "until": 1, "within": 0.5, "hold_s": 0.005},
    **{"p_lr_ref_pa": 15e5, "p_lp_ref_pa": 40e5, "x_min_m": 0.02},
}
TICKS = st.sampled_from((1, 30, 400, 1300, 1700, 4000))  # the return alone takes 1000
# Refused in every state.
INVALID = (
    ("write_settings", struct.pack("<Hf", len(SETTINGS), 0.0)),
    ("write_settings", struct.pack("<Hf", 0, float("nan"))),
    ("write_segment", struct.pack("<HH5f", 200, 0, 0.1, 1.0, 1.0, 0.0, 0.0)),
    ("write_segment", struct.pack("<HH5f", 0, 7, 0.1, 1.0, 1.0, 0.0, 0.0)),
    ("write_segment", struct.pack("<HH5f", 0, 2, 0.0, 1.0, 1.0, float("inf"), 0.0)),
    ("write_segment", struct.pack("<HH5f", 0, 2, 0.0, 1.0, 1.0, 1e3, -1e-3)),
    ("write_step", b"\0\0"),
    ("start", b"\0"),
    ("stop", b"\1"),
    ("clear_fault", b"\1\2"),
)


class Machine(RuleBasedStateMachine):
    """The board and its model."""

    make = None  # a function that returns a board from reset

    def __init__(self):
        super().__init__()
        self.board = self.make()
        self.state, self.fault = "idle", "none"
        self.settings = self.segments = self.steps = None  # octets that the board holds
        self.usable = True  # the settings
        self.status = self.board.status()
        self.last = None  # the last request
        self.started = None  # sequence and payload of the start in effect

    # ---- the host ----

    def request(self, name, payload, again=False):
        reply = self.board.request(name, payload, again)
        self.last = (name, payload, self.board.sequence)
        return reply

    def expect(self, reply, refusal):
        assert reply == (refusal or b"")

    @initialize()
    def a_bench_and_a_run(self):
        self.write_settings(None)
        self.write_schedule([{"valves": 0, "v_m_s": 0.1, "a_m_s2": 2.0, "duration_s": 0.02}])
        self.board.rest(0.01, x=0.05)

    @rule(bad=st.sampled_from((None, None, None, *UNUSABLE)))
    def write_settings(self, bad):
        reply = self.board.write_settings(**{**BENCH, **(bad or {})})
        self.expect(reply, "busy" if self.state == "running" else None)
        if reply == b"":
            self.settings, self.usable = self.board.settings_crc, bad is None
            self.started = None

    @rule(row=st.lists(SEGMENTS, min_size=1, max_size=3))
    def write_schedule(self, row):
        busy = "busy" if self.state == "running" else None
        for index, segment in enumerate(row):
            self.expect(self.board.write_segment(index, **segment), busy)
        self.expect(self.board.write_step(**{**STEP, "segments": len(row)}), busy)
        if not busy:
            octets = self.board.segments_octets + self.board.steps_octets
            self.steps = binascii.crc_hqx(octets, CRC_START)
            self.started = None

    @rule(wrong=st.sampled_from(((0, 0),) * 6 + ((1, 0), (0, 1), (0x8000, 0x8000))))
    def start(self, wrong):
        crcs = struct.pack("<HH", self.settings ^ wrong[0], self.steps ^ wrong[1])
        self.expect_start(self.request("start", crcs), crcs)

    def expect_start(self, reply, crcs):
        sent = struct.unpack("<HH", crcs)
        request = (self.board.sequence, crcs)
        if self.state == "fault":
            self.expect(reply, "fault_latched")
        elif request == self.started:
            self.expect(reply, None)  # the repeated request, which has been obeyed
        elif self.state == "running":
            self.expect(reply, "busy")
        elif sent[0] != self.settings:
            self.expect(reply, "settings_differ")
        elif sent[1] != self.steps:
            self.expect(reply, "steps_differ")
        elif not self.usable:
            self.expect(reply, "out_of_range")
        else:
            self.expect(reply, None)
            self.state, self.fault = "running", "none"
            self.started = request
            self.status["runs_done"] = 0

    @rule()
    def stop(self):
        self.expect(self.request("stop", b""), None)
        if self.state == "running":
            self.state, self.fault = "idle", "stopped"

    @rule()
    def clear_fault(self):
        self.expect(self.request("clear_fault", b""), "busy" if self.state == "running" else None)
        if self.state == "fault":
            self.state, self.fault = "idle", "none"

    @precondition(lambda self: self.last is not None)
    @rule()
    def repeat_the_last_request(self):
        name, payload, sequence = self.last
        if name == "start":
            before, self.board.sequence = self.board.sequence, sequence
            self.expect_start(self.request(name, payload, again=True), payload)
            self.board.sequence = before
        else:
            getattr(self, name)()

    @rule(request=st.sampled_from(INVALID))
    def an_invalid_request(self, request):
        assert self.board.request(*request) in ("bad_payload", "out_of_range", "busy")

    @rule(octets=st.binary(max_size=40))
    def noise_on_the_line(self, octets):
        self.board.firmware.receive(octets + b"\0")
        self.board.firmware.poll()
        self.board.firmware.transmit()

    # ---- time ----

    def tick(self, act):
        """Make a tick; check the state after it and the valves."""
        commands = act()
        before, seen = self.state, self.look()
        if before != "running":
            assert seen == (before, self.fault)
        else:
            self.state, self.fault = seen
        if self.state != "running":
            assert not np.any(commands)
        return commands

    def look(self):
        status = self.board.status()
        state, fault = STATES[status["state"]], FAULTS[status["fault"]]
        return state, fault

    @rule(ticks=TICKS)
    def time_on_a_bench_that_obeys(self, ticks):
        for tick in range(ticks):
            if tick % 50 == 0:
                self.tick(lambda: drive(self.board, 1))
            else:
                commands = drive(self.board, 1)
                assert self.state == "running" or not np.any(commands)
        self.tick(lambda: drive(self.board, 1))

    @rule(ticks=TICKS)
    def a_start_and_time(self, ticks):
        if self.state == "fault":
            self.clear_fault()
        self.start((0, 0))
        self.time_on_a_bench_that_obeys(ticks)

    @rule(kind=st.sampled_from(("any", "dead", "stuck")), data=st.data())
    def sensors_tell_nonsense(self, kind, data):
        if kind == "any":
            words = data.draw(st.lists(st.integers(0, 65535), min_size=8, max_size=8))
            self.board.raw = dict(zip(INPUTS, words, strict=True))
        elif kind == "dead":
            word = data.draw(st.sampled_from((0, 3, 65520)))
            self.board.raw = {data.draw(st.sampled_from(SENSORS)): word}
        else:
            name = data.draw(st.sampled_from(SENSORS))
            self.board.raw = {name: self.board.words()[SENSORS.index(name)]}
        for _ in range(data.draw(st.integers(1, 60))):
            self.tick(lambda: drive(self.board, 1))
        self.board.raw = {}
        if data.draw(st.integers(0, 3)):
            self.let_filters_settle()

    def let_filters_settle(self):
        if self.state != "running":
            for _ in range(200):
                assert not any(self.board.tick())

    @rule(x=st.one_of(st.floats(0.04, 0.06), st.floats(0.02, 0.38)))
    def somebody_moves_the_piston(self, x):
        if self.state != "running":
            self.board.si["x"] = x
            self.let_filters_settle()

    @rule(ticks=st.integers(1, 3 * HEARTBEAT_TICKS))
    def silence(self, ticks):
        for _ in range(ticks):
            commands = drive(self.board, 1)
            assert self.state == "running" or not np.any(commands)
        if self.state == "running":
            self.state, self.fault = self.look()
            if ticks > HEARTBEAT_TICKS:
                assert self.state != "running" and not np.any(commands)

    @rule()
    def overrun(self):
        self.board.firmware.overrun()
        if self.state == "running":
            self.state, self.fault = "fault", "overrun"

    # ---- invariants ----

    @invariant()
    def the_status_is_that_of_the_model_and_moves_one_way(self):
        before, self.status = self.status, self.board.status()
        now = self.status
        assert (STATES[now["state"]], FAULTS[now["fault"]]) == (self.state, self.fault)
        allowed = {
            "idle": ("none", "stopped"),
            "running": ("none",),
            "done": ("none",),
            "fault": [fault for fault in FAULTS if fault not in ("none", "stopped")],
        }
        assert self.fault in allowed[self.state]
        assert (PHASES[now["phase"]] == "none") == (self.state != "running")
        assert self.state == "running" or now["v_ref_m_s"] == 0.0
        assert now["tick"] >= before["tick"]
        assert before["runs_done"] <= now["runs_done"] <= STEP["trials"]
        assert before["log_next"] <= now["log_next"]
        assert max(0, now["log_next"] - 1024) == now["log_first"]
        assert now["cycle"] < STEP["cycles"]


def run(new_board, examples):
    machine = type("BoardMachine", (Machine,), {"make": staticmethod(new_board)})
    checks = list(HealthCheck)
    run_machine(
        machine,
        settings=settings(
            max_examples=examples,
            stateful_step_count=40,
            derandomize=True,
            database=None,
            suppress_health_check=checks,
        ),
    )


def test_random_requests_sensors_and_silences_agree_with_the_model(new_board):
    run(new_board, examples=20)


@pytest.mark.slow
def test_many_more_random_scripts_agree_with_the_model(new_board):
    run(new_board, examples=400)
