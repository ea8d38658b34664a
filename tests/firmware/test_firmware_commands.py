"""Effect of each request, and of its repetition."""

import binascii
import struct

import numpy as np
import pytest

from hbench.protocol.codec import BY_NAME, pack_settings, unpack
from hbench.protocol.dictionary import (
    CRC_START,
    PROTOCOL,
    RECORD,
    SETTING_RANGES,
    SETTINGS,
    dictionary_hash,
)

SEGMENT_OCTETS = 2 + 3 * 4
STEP_OCTETS = 6 * 2 + 7 * 4
DEPENDENT = {  # on each other, on the DAC or on the schedule
    *("voltage_limit_v", "travel_min_m", "travel_max_m"),
    *("pressure_max_pa", "speed_max_m_s"),
}


def test_identify_reports_dictionary_firmware_and_boots(new_board):
    reply = unpack(BY_NAME["identify"].reply, new_board(boots=41).request("identify"))
    assert reply == {
        "protocol": PROTOCOL,
        "dictionary": dictionary_hash(),
        "firmware": "hbench-core 0.1",
        "board": "host",
        "boots": 41,
        "rate_hz": 10_000,
        "ring_records": 1024,
        "max_steps": 128,
        "max_segments": 104,
    }


def test_a_board_from_reset_is_idle_and_not_ready(new_board):
    board = new_board()
    assert board.cause() == ("idle", "none")
    assert board.tick() == [0, 0, 0]
    assert board.request("start", bytes(4)) == "not_ready"
    board.write_settings()
    assert board.request("start", bytes(4)) == "not_ready", "there is no step"


def test_settings_may_be_sent_in_two_parts(new_board):
    board = new_board()
    assert board.write_settings(first=20) == b""
    board.write_motion()
    assert board.start() == "not_ready"
    head = struct.pack("<20f", *np.arange(20))
    assert board.request("write_settings", struct.pack("<H", 0) + head) == b""
    assert board.start() == "settings_differ", "the host believes in other values"
    assert board.write_settings() == b""
    assert board.start() == b""


@pytest.mark.parametrize(
    ("payload", "refusal"),
    [
        (b"\0", "bad_payload"),
        (struct.pack("<Hfh", 0, 1.0, 1), "bad_payload"),
        (struct.pack("<Hf", len(SETTINGS), 1.0), "out_of_range"),
        (struct.pack("<Hff", len(SETTINGS) - 1, 1.0, 1.0), "out_of_range"),
        (struct.pack("<Hff", 0, 1.0, float("nan")), "out_of_range"),
        (struct.pack("<Hf", 0, float("inf")), "out_of_range"),
    ],
)
def test_settings_out_of_range_are_refused_and_change_nothing(board, payload, refusal):
    assert board.request("write_settings", payload) == refusal
    assert board.start() == b"", "the CRCs on the board are unchanged"


@pytest.mark.parametrize(
    "change",
    [
        {"velocity_gain_v_m": 2e6},  # gains in a wrong unit
        {"velocity_gain_v_m": -800.0},
        {"rod_gain_v_pa_s": 1.25},
        {"piston_gain_v_pa_s": 0.0},
        {"force_gain_v_n": -1e-3},
        {"feedforward_rod_v_s_m": -5.7},
        {"gain_p_s": 0.0},  # its limit would never be exceeded
        {"gain_x": -7e-6},
        {"pressure_max_pa": 39e5},  # the load's pressure is 40 bar
        {"speed_max_m_s": 0.09},  # the segment's is 0.1
        {"voltage_limit_v": 10.1},
        {"voltage_limit_v": 0.0},
        {"velocity_filter_s": -1e-4},
        {"travel_min_m": 0.4},
        {"heartbeat_s": 0.0},
        {"log_divider": 0.0},
        {"log_divider": 65536.0},
        {"acceleration_m_s2": 0.0},
        {"pressure_slew_pa_s": -1.0},
        {"travel_max_m": 0.3},  # the step ends at 0.35
    ],
    ids=str,
)
def test_start_is_refused_with_unusable_settings(board, change):
    assert board.write_settings(**change) == b""
    board.tick()
    assert board.start() == "out_of_range"
    assert board.write_settings() == b""
    assert board.start() == b""


@pytest.mark.parametrize("limit", [0, 1])
def test_a_setting_just_beyond_its_range_is_refused_and_at_its_limit_it_is_not(board, limit):
    for name, limits in SETTING_RANGES.items():
        value = np.float32(limits[limit])
        for allowed in (value, np.nextafter(value, np.float32((-1) ** (1 - limit) * np.inf))):
            board.write_settings(**{name: allowed})
            refused = board.start() == "out_of_range"
            if allowed == value:  # limits that also depend on other values
                assert not refused or name in DEPENDENT, name
            else:
                assert refused, name
            board.request("stop")


def test_a_schedule_is_refused_once_half_of_the_record_numbers_are_used(board):
    """At 100 Hz after 248 days of motion. They would wrap to 0, and the host would lose records."""
    for number, reply in ((2**31, b""), (2**31 + 1, "reset_needed")):
        board.skip_records(number)
        assert board.start() == reply
        board.request("stop")


def test_crcs_are_those_of_the_host_codec(board):
    values = dict(zip(SETTINGS, np.linspace(-3, 70, len(SETTINGS)), strict=True))
    octets = pack_settings(values)
    board.request("write_settings", struct.pack("<H", 0) + octets)
    assert board.start() == "settings_differ"
    board.settings_crc = binascii.crc_hqx(octets, CRC_START)
    assert board.start() == "out_of_range", "past the CRC, stopped by the values"


def test_start_is_refused_when_the_steps_differ(board):
    board.write_step(1, run=2)
    board.steps_octets = board.steps_octets[:STEP_OCTETS]
    assert board.start() == "steps_differ"


def test_start_is_refused_when_the_segments_differ(board):
    board.write_segment(1)
    board.segments_octets = board.segments_octets[:SEGMENT_OCTETS]
    assert board.start() == "steps_differ"


@pytest.mark.parametrize(
    "change",
    [
        {"valves": 4},
        {"v_m_s": float("nan")},
        {"a_m_s2": 0.0},
        {"a_m_s2": float("inf")},
        {"duration_s": 0.0},
        {"duration_s": float("nan")},
        {"force_rate_n_s": float("nan")},
        {"force_rate_n_s": -2e9},
        {"displacement_m": -1e-3},
    ],
    ids=str,
)
def test_a_segment_out_of_range_is_refused(board, change):
    assert board.write_segment(1, **change) == "out_of_range"


@pytest.mark.parametrize(
    "change",
    [
        {"trials": 0},
        {"segments": 0},
        {"cycles": 0},
        {"until": 3},
        {"within": -0.1},
        {"run": 65535, "trials": 2},
        {"p_lr_ref_pa": -1.0},
        {"p_lp_ref_pa": float("inf")},
        {"x_max_m": float("nan")},
        {"hold_s": -0.1},
    ],
    ids=str,
)
def test_a_step_out_of_range_is_refused(board, change):
    assert board.write_step(1, **change) == "out_of_range"


def test_steps_are_accepted_in_order_up_to_the_limit(board):
    assert board.write_step(2) == "out_of_range", "step 1 is missing"
    for index in range(1, 128):
        assert board.write_step(index, run=index + 1) == b""
    assert board.write_step(128) == "out_of_range"
    board.steps_octets = board.steps_octets[: 128 * STEP_OCTETS]
    assert board.start() == b""


def test_segments_are_accepted_in_order_up_to_the_limit(board):
    assert board.write_segment(2) == "out_of_range", "segment 1 is missing"
    for index in range(1, 104):
        assert board.write_segment(index, v_m_s=1e-3 * index) == b""
    assert board.write_segment(104) == "out_of_range"


def test_the_last_segment_may_be_repeated_but_not_changed(board):
    assert board.write_segment(1, v_m_s=0.2) == b""
    assert board.write_segment(1, v_m_s=0.2) == b""
    assert board.write_segment(1, v_m_s=0.3) == "out_of_range"


def test_segment_zero_starts_a_new_schedule(board):
    assert board.write_segment(0) == b""
    assert board.request("start", bytes(4)) == "not_ready", "the steps are gone"


@pytest.mark.parametrize(
    "change", [{"segment": 1}, {"segments": 2}, {"segment": 65535, "segments": 65535}], ids=str
)
def test_start_is_refused_if_a_step_has_missing_segments(board, change):
    assert board.write_step(0, **change) == b""
    assert board.start() == "out_of_range"


def test_the_last_step_may_be_repeated_but_not_changed(board):
    assert board.write_step(1, run=2) == b""
    assert board.write_step(1, run=2) == b""
    assert board.write_step(1, run=3) == "out_of_range"
    board.write_step(0)
    board.write_step(1, run=2)
    assert board.start() == b""


def test_step_zero_starts_a_new_list(board):
    board.write_step(1, run=2)
    assert board.write_step(0, run=7) == b""
    assert board.start() == b""
    assert board.status()["run"] == 7


def test_a_running_board_refuses_uploads_and_a_second_start(board):
    assert board.start() == b""
    assert board.write_settings() == "busy"
    assert board.write_step() == "busy"
    assert board.write_segment() == "busy"
    assert board.request("clear_fault") == "busy"
    assert board.start() == "busy"
    assert board.cause() == ("running", "none")


def test_a_repeated_start_is_answered_without_effect(board):
    board.start()
    board.rest(0.3, x=0.05)
    before = board.status()
    board.sequence -= 1  # the request of the start
    assert board.start(again=True) == b""
    after = board.status()
    assert before["phase"] == after["phase"] != 1
    assert board.cause() == ("running", "none")


def test_stop_makes_the_valves_neutral_and_reports_stopped_until_the_next_start(board):
    board.start()
    board.rest(0.2, x=0.05)
    assert board.tick()[0] > 0.1, "it accelerates"
    assert board.request("stop") == b""
    assert board.tick() == [0, 0, 0]
    assert board.cause() == ("idle", "stopped")
    assert board.request("stop") == b"", "again, without effect"
    assert board.cause() == ("idle", "stopped")
    assert board.start() == b""
    assert board.cause() == ("running", "none")


@pytest.mark.parametrize("name", ["identify", "stop", "clear_fault", "status"])
def test_an_unexpected_payload_is_refused(board, name):
    assert board.request(name, b"\1") == "bad_payload"


@pytest.mark.parametrize("name", ["start", "read_log", "write_step", "write_segment"])
def test_a_payload_that_ends_early_is_refused(board, name):
    assert board.request(name, b"\1\2\3") == "bad_payload"


def test_an_unknown_message_is_refused_with_its_number(board):
    assert board.exchange(board.frame(4, 0x7E)) == [(4, 0xFF, struct.pack("<HH", 0x7E, 1))]


def test_status_shows_the_live_values(board):
    board.tick()
    status = board.status()
    assert status["x_m"] == pytest.approx(0.05, abs=7e-6)
    for name in ("p_tp", "p_tr", "p_lp", "p_lr", "p_s"):
        assert status[f"{name}_pa"] == pytest.approx(board.si[name], abs=400)
    assert status["f_applied_n"] == pytest.approx(500.0, abs=1.0)
    assert status["tick"] == 101


def test_a_changed_calibration_causes_no_jump_of_speed_or_pressure(board):
    board.write_settings(gain_x=8e-6, gain_p_s=500.0)
    board.tick()
    status = board.status()
    assert status["v_m_s"] == 0.0
    assert status["x_m"] == pytest.approx(0.05 * 8 / 7, abs=8e-6)
    assert status["p_s_pa"] == pytest.approx(150e5 * 5 / 4, abs=500)


@pytest.fixture
def logged(board):
    """A board at rest that has logged 1500 records, 476 more than its ring holds."""
    board.write_settings(log_divider=1, velocity_gain_v_m=1.0)
    board.write_motion(hold_s=0.0, duration_s=0.15)
    board.start()
    board.rest(0.5, x=0.05)
    return board


def test_overwritten_records_are_skipped_and_the_rest_are_contiguous(logged):
    status = logged.status()
    assert (status["log_first"], status["log_next"]) == (1500 - 1024, 1500)
    first, following, words = logged.read_log(10)
    assert (first, following) == (1500 - 1024, 1500)
    number, rows = first, []
    while number < following:
        at, _, words = logged.read_log(number)
        assert at == number
        assert 0 < len(words) <= 8, "one frame holds eight"
        rows.append(words)
        number += len(words)
    index = np.concatenate(rows)[:, [word.name for word in RECORD].index("index")]
    assert index.tolist() == list(range(1500 - 1024, 1500)), "record n of the only run has index n"


def test_any_part_of_the_log_may_be_read_repeatedly(logged):
    first, _, once = logged.read_log(1200, count=3)
    again = logged.read_log(1200, count=3)[2]
    assert (first, len(once)) == (1200, 3)
    np.testing.assert_array_equal(once, again)
    np.testing.assert_array_equal(logged.read_log(1201, count=1)[2][0], once[1])


def test_future_records_are_not_returned(logged):
    assert logged.read_log(1498)[2].shape == (2, 16)
    assert logged.read_log(1500)[2].shape == (0, 16)
    assert logged.read_log(99_999)[2].shape == (0, 16)
    assert logged.read_log(1000, count=0)[2].shape == (0, 16)


def test_record_numbers_go_on_from_one_schedule_to_the_next(logged):
    assert logged.cause() == ("done", "none")
    logged.start()
    logged.rest(0.5, x=0.05)
    assert logged.status()["log_next"] == 3000
