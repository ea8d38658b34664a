"""Schedules on a kinematic plant whose speed and pressures follow the commands."""

from itertools import groupby

import numpy as np
import pytest

from hbench.protocol.dictionary import INPUTS, PHASES, STATES
from tests.support.board.kinematic import (
    AT_REFERENCE,
    LAST,
    SENSOR_SATURATED,
    VALVE_SATURATED,
    WORD,
    WORD_V_M_S,
    T,
    drive,
    read_all,
    run_to_the_end,
    signed,
)

RUN_PHASES = ["return", "hold", "accelerate", "steady", "brake"]


@pytest.fixture(scope="module")
def campaign(new_board):
    """Two steps of two trials: extending for 0.4 s, retracting until x_min."""
    board = new_board()
    board.write_settings()
    board.write_motion(0, run=1, trials=2, a_m_s2=1.03)
    retract = {"v_m_s": -0.2, "x_start_m": 0.2, "x_min_m": 0.14, "duration_s": 5.0}
    board.write_motion(1, run=10, trials=2, a_m_s2=2.0, **retract)
    board.rest(0.05, x=0.08)
    return run_to_the_end(board)


def test_every_trial_has_all_phases_in_order(campaign):
    trace, _ = campaign
    seen = [(s["run"], PHASES[s["phase"]], s["step"]) for s in trace]
    expected = [(run, phase, run // 10) for run in (1, 2, 10, 11) for phase in RUN_PHASES]
    assert [key for key, _ in groupby(seen)] == [*expected, (11, "none", 1)]
    assert STATES[trace[-1]["state"]] == "done"


def test_runs_done_counts_each_run_at_the_end_of_its_motion(campaign):
    trace, _ = campaign
    for run, done in ((1, 0), (2, 1), (10, 2), (11, 3)):
        for status in (s for s in trace if s["run"] == run and s["state"] == 1):
            after = PHASES[status["phase"]] == "brake"
            assert status["runs_done"] == done + after


def test_motion_starts_at_rest_within_a_millimetre_of_the_start(campaign):
    trace, _ = campaign
    holds = [s for s in trace if PHASES[s["phase"]] == "hold"]
    for run, x_start in ((1, 0.05), (2, 0.05), (10, 0.2), (11, 0.2)):
        last = [s for s in holds if s["run"] == run][-1]
        assert last["x_m"] == pytest.approx(x_start, abs=1e-3)
        assert last["v_ref_m_s"] == 0.0
        assert abs(last["v_m_s"]) < 5e-3


def test_the_return_stays_within_its_speed_and_never_overshoots(campaign):
    trace, _ = campaign
    for run, x_start in ((2, 0.05), (10, 0.2), (11, 0.2)):
        returns = [s for s in trace if s["run"] == run and PHASES[s["phase"]] == "return"]
        side = np.sign(x_start - returns[0]["x_m"])
        assert max(abs(s["v_ref_m_s"]) for s in returns) <= 0.15 + 1e-6
        assert min(side * (x_start - s["x_m"]) for s in returns) > -1e-4


def test_references_change_no_faster_than_their_limits(campaign):
    trace, _ = campaign
    limits = {"accelerate": {1: 1.03, 2: 1.03, 10: 2.0, 11: 2.0}}
    for before, after in zip(trace, trace[1:], strict=False):
        phases = {PHASES[before["phase"]], PHASES[after["phase"]]}
        limit = max(limits.get(phase, {}).get(after["run"], 0.5) for phase in phases)
        assert abs(after["v_ref_m_s"] - before["v_ref_m_s"]) <= 1.001 * limit * 20 * T + 1e-9


def test_motion_ends_by_time_or_by_position(campaign):
    trace, _ = campaign
    for run in (1, 2):
        ticks = [s["tick"] for s in trace if s["run"] == run and s["phase"] in (3, 4)]
        assert ticks[-1] - ticks[0] == pytest.approx(4000, abs=40)
    for run in (10, 11):
        moving = [s for s in trace if s["run"] == run and s["phase"] in (3, 4)]
        braking = [s for s in trace if s["run"] == run and PHASES[s["phase"]] == "brake"]
        assert moving[-1]["x_m"] > 0.14 - 1e-5
        assert braking[0]["x_m"] == pytest.approx(0.14, abs=0.2 * 20 * T)


def test_each_run_is_logged_from_zero_on_with_one_last_record(campaign):
    _, log = campaign
    for run in (1, 2, 10, 11):
        rows = log[log[:, WORD["run"]] == run]
        assert rows[:, WORD["index"]].tolist() == list(range(len(rows)))
        last = (rows[:, WORD["flags"]] & LAST) > 0
        assert last.tolist() == [False] * (len(rows) - 1) + [True]
    runs = log[:, WORD["run"]]
    assert [key for key, _ in groupby(runs)] == [1, 2, 10, 11]
    assert np.sum(runs == 1) == np.sum(runs == 2) == 40, "0.4 s at 100 Hz"


def test_logged_reference_is_the_ramp_and_the_flag_marks_its_end(campaign):
    _, log = campaign
    for run, v, a in ((1, 0.1, 1.03), (10, -0.2, 2.0)):
        rows = log[log[:, WORD["run"]] == run]
        t = 0.01 * (rows[:, WORD["index"]] + 1.0)
        expected = np.sign(v) * np.minimum(a * t, abs(v))
        np.testing.assert_allclose(
            WORD_V_M_S * signed(rows[:, WORD["v_ref"]]), expected, atol=2.1e-5
        )
    rows = log[log[:, WORD["run"]] == 1]
    at_reference = (rows[:, WORD["flags"]] & AT_REFERENCE) > 0
    # The ramp takes 97.1 ms, so record 10 is the first entirely after it.
    assert at_reference.tolist() == [index >= 10 for index in range(40)]


def test_logged_speed_settles_at_the_reference_and_integrates_to_the_distance(campaign):
    _, log = campaign
    rows = log[log[:, WORD["run"]] == 2]
    v, x = WORD_V_M_S * signed(rows[:, WORD["v"]]), 7e-6 * rows[:, WORD["x"]]
    # 800 V/m (60 ms s + 1)/s on 50 mm/s/V leaves a pole at -40 / 3.4 = -11.8 rad/s; the ramp's
    # lag of 1.03/40 m/s has decayed to under 1 mm/s 0.3 s after it.
    assert v[-1] == pytest.approx(0.1, abs=1e-3)
    # Means of x over 10 ms, a record apart, differ by the distance between; the filter lags 2 ms.
    distances = np.diff(x[25:])
    between = (v[25:-1] + v[26:]) / 2
    np.testing.assert_allclose(distances / 0.01, between, atol=1e-3)
    assert np.all(rows[:, WORD["flags"]] & (SENSOR_SATURATED | VALVE_SATURATED) == 0)


def test_records_hold_the_means_of_their_ticks(board):
    board.write_motion(duration_s=0.2)
    assert board.start() == b""
    words, v, u = [], [], []
    while board.status()["state"] == 1:
        board.temp_word = 20_000 + len(words)
        words.append(board.words())
        commands = drive(board, 1)
        status = board.status()
        if PHASES[status["phase"]] in ("accelerate", "steady"):
            v.append(status["v_m_s"])
            u.append(commands)
        else:
            words.pop()
    log = read_all(board)
    assert len(words) == 2000
    sums = np.array(words).reshape(20, 100, len(INPUTS)).sum(axis=1)
    inputs = log[:, WORD["x"] : WORD["auxiliary"] + 1]
    np.testing.assert_array_equal(inputs, (sums + 50) // 100)
    v_means = np.array(v).reshape(20, 100).mean(axis=1)
    np.testing.assert_allclose(signed(log[:, WORD["v"]]), v_means / WORD_V_M_S, atol=0.6)
    u_means = np.array(u).reshape(20, 100, 3).mean(axis=1)
    logged = signed(log[:, WORD["u_t"] : WORD["u_l2"] + 1])
    np.testing.assert_allclose(logged, 1e3 * u_means, atol=0.5 + 1e3 * 5 / 2048)


def test_an_incomplete_record_is_dropped(board):
    board.write_motion(duration_s=0.1055)
    _, log = run_to_the_end(board)
    assert len(log) == 10
    assert log[-1, WORD["flags"]] & LAST


def test_a_fast_return_does_not_overshoot(board):
    board.write_settings(return_speed_m_s=0.38, speed_max_m_s=1.0)
    board.write_motion(duration_s=0.01, x_start_m=0.3)
    trace, _ = run_to_the_end(board)
    positions = [s["x_m"] for s in trace if PHASES[s["phase"]] == "return"]
    assert max(s["v_ref_m_s"] for s in trace) > 0.25
    assert max(positions) < 0.301


def test_a_hold_of_zero_length_still_waits_for_the_load(board):
    board.write_motion(p_lp_ref_pa=75e5, hold_s=0.0, duration_s=0.01)
    trace, _ = run_to_the_end(board)
    begin = next(s for s in trace if PHASES[s["phase"]] == "accelerate")
    assert (begin["tick"] - trace[0]["tick"]) * T == pytest.approx(0.35, abs=0.01)


def test_load_pressures_ramp_to_their_references_and_the_hold_waits_for_them(board):
    board.write_motion(p_lr_ref_pa=35e5, p_lp_ref_pa=75e5, hold_s=0.1, duration_s=0.1)
    trace, _ = run_to_the_end(board)
    begin = next(s for s in trace if PHASES[s["phase"]] == "accelerate")
    # 35 bar at 100 bar/s, then the hold of 0.1 s.
    assert (begin["tick"] - trace[0]["tick"]) * T == pytest.approx(0.45, abs=0.01)
    assert begin["p_lr"] == pytest.approx(35e5, rel=0.02)
    assert begin["p_lp"] == pytest.approx(75e5, rel=0.02)
    ramp = [s for s in trace if (s["tick"] - trace[0]["tick"]) * T < 0.2]
    slope = (ramp[-1]["p_lr"] - ramp[len(ramp) // 2]["p_lr"]) / (
        (ramp[-1]["tick"] - ramp[len(ramp) // 2]["tick"]) * T
    )
    assert slope == pytest.approx(1e7, rel=0.1)


def test_flags_mark_a_saturated_sensor_and_valve(board):
    board.si["f_applied"] = 32760.0  # full scale
    board.write_motion(p_lr_ref_pa=15e5)
    board.write_settings(voltage_limit_v=0.5)
    _, log = run_to_the_end(board)
    flags = log[:, WORD["flags"]]
    assert np.all(flags & SENSOR_SATURATED)
    assert np.any(flags & VALVE_SATURATED)


@pytest.mark.parametrize("end", ["stop", "fault"])
def test_an_interrupted_run_keeps_its_records_without_a_last_flag(board, end):
    board.start()
    while board.status()["phase"] != PHASES.index("steady"):
        drive(board, 50)
    drive(board, 1000)
    if end == "stop":
        board.request("stop")
    else:
        board.si["p_s"] = 260e5
        board.rest(0.01, x=board.si["x"])
    log = read_all(board)
    assert len(log) >= 19
    assert log[:, WORD["index"]].tolist() == list(range(len(log)))
    assert not np.any(log[:, WORD["flags"]] & LAST)
    assert board.status()["runs_done"] == 0


def test_the_same_inputs_give_the_same_log_to_the_bit(new_board):
    logs = []
    for _ in range(2):
        board = new_board()
        board.write_settings()
        board.write_motion()
        board.rest(0.05, x=0.06)
        logs.append(run_to_the_end(board)[1].tobytes())
    assert logs[0] == logs[1]
