"""Sequences of segments, their cycles and end conditions, compared with closed forms."""

import numpy as np
import pytest

from hbench.protocol.dictionary import CONDITIONS, PHASES, STATES, VALVES
from tests.support.board.kinematic import (
    AT_REFERENCE,
    LAST,
    SETTLED,
    WORD,
    WORD_V_M_S,
    T,
    drive,
    read_all,
    run_to_the_end,
    signed,
)

A_P, A_R = 1.25664e-3, 7.65763e-4  # as in the settings
CODE = {name: number for number, name in enumerate(VALVES)}


def logged(log, name, scale):
    return scale * signed(log[:, WORD[name]])


def piecewise(row, t_s):
    """v_ref of a cycle of (target, slope, duration) at the times ``t_s``, from rest."""
    v, begin, out = 0.0, 0.0, np.zeros_like(t_s)
    while begin < t_s[-1]:
        for target, a, duration in row:
            here = (t_s > begin + 1e-9) & (t_s <= begin + duration + 1e-9)
            reach = np.minimum(a * (t_s - begin), abs(target - v))
            out[here] = (v + np.sign(target - v) * reach)[here]
            v += np.sign(target - v) * min(a * duration, abs(target - v))
            begin += duration
    return out


ROW = ((0.1, 1.0, 0.2), (0.04, 0.25, 0.1), (-0.1, 2.0, 0.15), (0.0, 0.5, 0.25))


def as_segments(row):
    return [{"v_m_s": v, "a_m_s2": a, "duration_s": seconds} for v, a, seconds in row]


@pytest.mark.parametrize("cycles", [1, 3])
def test_the_reference_follows_the_segments_for_the_given_number_of_cycles(board, cycles):
    assert board.write_row(*as_segments(ROW), cycles=cycles, x_min_m=0.02) == b""
    trace, log = run_to_the_end(board)
    assert len(log) == cycles * 70, "0.7 s at 100 Hz"
    assert log[:, WORD["index"]].tolist() == list(range(len(log))), "one run"
    t_s = 0.01 * (log[:, WORD["index"]] + 1.0)
    expected = piecewise(ROW, t_s)
    np.testing.assert_allclose(logged(log, "v_ref", WORD_V_M_S), expected, atol=2.5e-5)
    flags = log[:, WORD["flags"]]
    assert np.flatnonzero(flags & LAST).tolist() == [len(log) - 1]
    assert not np.any(flags & SETTLED)
    seen = {s["cycle"] for s in trace if PHASES[s["phase"]] in ("accelerate", "steady")}
    assert seen == set(range(cycles))
    assert trace[-1]["runs_done"] == 1


def test_at_reference_flag_is_set_at_the_speed_of_the_segment(board):
    board.write_row(*as_segments(ROW), x_min_m=0.02)
    _, log = run_to_the_end(board)
    there = np.flatnonzero(log[:, WORD["flags"]] & AT_REFERENCE)
    # 0.1 s after its begin at 0; never, which leaves 75 mm/s; 0.0875 s after 0.3; 0.2 s after 0.45.
    assert there.tolist() == [*range(10, 20), *range(39, 45), *range(65, 70)]


def test_a_triangle_uses_its_whole_travel_and_returns_to_its_start(board):
    """v rises to V in V/a and falls again: the distance is V^2 / a, and the same back."""
    v, travel = 0.1, 0.02
    a = v**2 / travel
    row = ((v, a, v / a), (-v, a, 2 * v / a), (0.0, a, v / a))
    board.write_row(*as_segments(row), cycles=2)
    trace, log = run_to_the_end(board, every=10)
    moving = [s for s in trace if PHASES[s["phase"]] in ("accelerate", "steady")]
    x = np.array([s["x_m"] for s in moving])
    assert len(log) == 160
    # The PI's lag a / 40 s^-1 = 12.5 mm/s reverses within its 85 ms: about 1 mm.
    assert x.max() - x[0] == pytest.approx(travel, abs=1.5e-3)
    for cycle in (0, 1):
        end = [s["x_m"] for s in moving if s["cycle"] == cycle][-1]
        assert end == pytest.approx(x[0], abs=1.5e-3)
    np.testing.assert_allclose(
        np.trapezoid(logged(log, "v_ref", WORD_V_M_S), dx=0.01), 0, atol=1e-4
    )


def test_a_segment_ends_at_the_limit_of_its_travel_and_the_next_begins(board):
    row = ((0.2, 2.0, 5.0), (-0.1, 2.0, 0.2))
    board.write_row(*as_segments(row), x_max_m=0.08)
    trace, log = run_to_the_end(board, every=5)
    moving = [s for s in trace if PHASES[s["phase"]] in ("accelerate", "steady")]
    v_ref = np.array([s["v_ref_m_s"] for s in moving])
    turn = int(np.argmax(np.diff(v_ref) < 0)) + 1
    assert moving[turn - 1]["x_m"] == pytest.approx(0.08, abs=0.2 * 10 * T)
    assert v_ref[-1] == pytest.approx(-0.1)
    seconds = (moving[-1]["tick"] - moving[turn]["tick"]) * T
    assert seconds == pytest.approx(0.2, abs=1.5e-3), "the whole of the second segment"
    assert log[-1, WORD["flags"]] & LAST


def test_a_segment_of_zero_speed_beyond_the_travel_is_not_cut(board):
    row = ((0.2, 2.0, 5.0), (0.0, 2.0, 0.3))
    board.write_row(*as_segments(row), x_max_m=0.08)
    _, log = run_to_the_end(board)
    v_ref = logged(log, "v_ref", WORD_V_M_S)
    assert np.sum(v_ref == 0.0) == pytest.approx(20, abs=1), "0.3 s less the brake's 0.1 s"


# ---- closed valves -----------------------------------------------------------------------------


def test_closed_valves_are_neutral_while_the_log_continues(board):
    closed = {"valves": 1, "v_m_s": 0.0, "duration_s": 0.3}
    board.write_row(closed, {"v_m_s": 0.0, "duration_s": 0.1}, p_lr_ref_pa=15e5)
    board.start()
    while PHASES[board.status()["phase"]] != "closed":
        drive(board, 1)
    for _ in range(2999):
        board.si["p_lr"] -= 4e5 / 3000  # leakage
        board.si["p_lp"] += 4e5 / 3000
        assert board.tick() == [0, 0, 0]
    assert PHASES[board.status()["phase"]] == "closed"
    first = board.tick()
    assert PHASES[board.status()["phase"]] == "accelerate"
    # The references start from the measured pressures: 1000 Pa per tick, 16 V/MPa. From their old
    # values, 4 bar away, the command would jump to 6.5 V.
    assert np.abs(first).max() <= 0.02
    for _ in range(2000):
        drive(board, 1)
    assert board.si["p_lr"] == pytest.approx(15e5, abs=1e5), "4 bar at 100 bar/s, and 0.16 s"
    log = read_all(board)
    rest = log[:30]
    for name in ("u_t", "u_l1", "u_l2", "v_ref"):
        assert not np.any(rest[:, WORD[name]])
    assert not np.any(rest[:, WORD["flags"]] & AT_REFERENCE)
    fall = 400.0 * (rest[0, WORD["p_lr"]].astype(float) - rest[29, WORD["p_lr"]])
    assert fall == pytest.approx(4e5 * 29 / 30, rel=0.02)
    assert len(log) == 40 and log[-1, WORD["flags"]] & LAST


# ---- pushing -----------------------------------------------------------------------------------

PUSH = {"valves": CODE["pushing"], "v_m_s": 0.0, "duration_s": 2.0}


def f_test(board):
    return A_P * board.si["p_tp"] - A_R * board.si["p_tr"]


def push(board, ticks, stiffness):
    """Ticks of a resting piston whose chambers integrate the valve's flow; F_T after each."""
    forces = []
    for _ in range(ticks):
        u_t, _, _ = board.tick()
        board.si["p_tp"] += stiffness * u_t * T
        board.si["p_tr"] -= 1.3 * stiffness * u_t * T
        forces.append(f_test(board))
    return np.array(forces)


@pytest.mark.parametrize("rate", [500.0, -200.0, 20.0])
def test_a_push_raises_the_force_at_its_rate_whatever_the_stiffness_of_the_oil(board, rate):
    for stiffness in (5e6, 2e7):  # Pa/s per V: a factor of two around the loop's design
        board.write_row({**PUSH, "force_rate_n_s": rate, "displacement_m": 0.01})
        board.start()
        while PHASES[board.status()["phase"]] != "push":
            drive(board, 1)
        force = push(board, 15_000, stiffness)
        t = T * np.arange(len(force))
        settled = t > 0.5  # of the first-order lag, 1 / (K c)
        slope = np.polyfit(t[settled], force[settled], 1)[0]
        # One code of the converter is 24 N/s in the softer oil; it moves to and fro between two.
        assert slope == pytest.approx(rate, rel=0.02, abs=1.0)
        assert PHASES[board.status()["phase"]] == "push"
        board.request("stop")


def test_a_push_ends_once_the_piston_has_moved_and_the_velocity_loop_goes_on(board):
    board.write_row({**PUSH, "force_rate_n_s": -1e3, "displacement_m": 2e-3})
    board.start()
    while PHASES[board.status()["phase"]] != "push":
        drive(board, 1)
    first = board.tick()[0]
    assert abs(first) < 0.02, "from neutral"
    push(board, 3000, 5e6)
    begin = board.si["x"]
    while PHASES[board.status()["phase"]] == "push":
        board.si["x"] -= 4e-6  # 40 mm/s
        board.tick()
    assert begin - board.si["x"] == pytest.approx(2e-3, abs=1e-5)
    assert PHASES[board.status()["phase"]] == "brake"
    drive(board, 3000)
    assert board.cause() == ("done", "none")
    log = read_all(board)
    assert log[-1, WORD["flags"]] & LAST and not np.any(log[:, WORD["v_ref"]])


def test_a_piston_that_breaks_away_may_jump_and_is_braked_from_the_speed_that_it_has(board):
    """60 ms at 0.2 m/s, ten times the limit of the speed's error and six times its time."""
    board.write_settings(speed_error_max_m_s=0.02, speed_error_time_s=0.01, acceleration_m_s2=2.0)
    board.write_row({**PUSH, "force_rate_n_s": 1e3, "displacement_m": 12e-3})
    board.start()
    while PHASES[board.status()["phase"]] != "push":
        drive(board, 1)
    while PHASES[board.status()["phase"]] == "push":
        board.si["x"] += 0.2 * T
        board.tick()
    assert board.cause() == ("running", "none")
    assert board.status()["v_ref_m_s"] == pytest.approx(0.2, abs=0.01), "the speed that it finds"


def test_a_push_ends_after_its_time_if_nothing_moves(board):
    board.write_row({**PUSH, "duration_s": 0.3, "force_rate_n_s": 1e3, "displacement_m": 2e-3})
    board.start()
    for _ in range(20_000):
        board.tick()
    assert board.cause() == ("done", "none")
    assert len(read_all(board)) == 30


# ---- venting -----------------------------------------------------------------------------------

VENT = ({"valves": CODE["venting"], "duration_s": 1.0}, {"valves": 1, "duration_s": 0.2})


@pytest.mark.parametrize(("limit_v", "opened_v"), [(10.0, 0.5), (0.2, 0.2)])
def test_venting_begins_where_the_piston_is_and_opens_all_valves_to_either_side(
    board, limit_v, opened_v
):
    board.write_settings(voltage_limit_v=limit_v)
    board.write_row(*VENT, x_start_m=0.2, x_min_m=0.2, x_max_m=0.2)
    board.si["p_s"] = 2e5
    board.rest(0.05, x=0.06)
    board.start()
    commands = np.array([board.tick() for _ in range(12_000)])
    expected = opened_v * np.repeat([1, -1, 1, -1, 0], [2500, 2500, 2500, 2500, 2000])
    for valve in range(3):
        # The first tick of a segment has number 1; the last one of the venting belongs to the next.
        assert np.sum(np.abs(commands[:, valve] - expected) > 0.003) <= 5
    drive(board, 5)
    assert board.cause() == ("done", "none")
    log = read_all(board)
    assert len(log) == 120 and log[-1, WORD["flags"]] & LAST


def test_venting_with_the_supply_on_is_a_fault_and_no_valve_opens(board):
    board.write_row(*VENT)
    board.rest(0.05, x=0.06)
    board.start()
    assert not any(any(board.tick()) for _ in range(200))
    assert board.cause() == ("fault", "supply")


@pytest.mark.parametrize("high_s, cause", [(0.9, ("running", "none")), (1.1, ("fault", "supply"))])
def test_the_chambers_may_raise_the_supplys_pressure_for_a_second(board, high_s, cause):
    board.write_row({**VENT[0], "duration_s": 3.0}, VENT[1])
    board.si["p_s"] = 2e5
    board.rest(0.05, x=0.06)
    board.start()
    for _ in range(4000):
        assert any(board.tick())
    board.si["p_s"] = 60e5
    opened = [any(board.tick()) for _ in range(round(high_s / T))]
    board.si["p_s"] = 2e5
    board.tick()
    assert board.cause() == cause
    assert sum(opened) == pytest.approx(min(high_s, 1.0) / T, abs=20), "the pressure filter's lag"


# ---- end conditions ----------------------------------------------------------------------------

CYCLE_TICKS = 500
Q, SIZE, WITHIN = 0.5, 0.4, 0.01


def cycles_until_settled(size, q, within):
    """Cycle means m_k = 1 + size q^k, k = 0, 1, ...: the run ends with the second consecutive
    cycle for which |m_k - m_(k-1)| = size q^(k-1) (1 - q) <= within m_k."""
    k = np.arange(1, 50)
    calm = size * q ** (k - 1) * (1 - q) <= within * (1 + size * q**k)
    return int(k[np.argmax(calm)]) + 2


def play(board, until, v, within, cycles, size=SIZE, q=Q):
    """Run one step whose condition value decays from cycle to cycle; returns its log."""
    sign = np.sign(v)
    step = {"cycles": cycles, "until": CONDITIONS.index(until), "within": within}
    x_start = 0.2
    board.write_row({"v_m_s": v, "a_m_s2": 1e4, "duration_s": CYCLE_TICKS * T},
                    x_start_m=x_start, **step)  # fmt: skip
    board.rest(0.05, x=x_start)
    assert board.start() == b""
    while PHASES[board.status()["phase"]] not in ("accelerate", "steady"):
        drive(board, 1)
    tick = 1  # one of the run has been
    while STATES[board.status()["state"]] == "running" and tick < (cycles + 5) * CYCLE_TICKS:
        value = 1 + size * q ** (tick // CYCLE_TICKS)
        if until == "friction":
            force = A_P * board.si["p_tp"] - A_R * board.si["p_tr"]
            board.si["f_applied"] = force - sign * 1000.0 * value
            drive(board, 1)
        else:
            board.si["x"] += (v - sign * 0.02 * value) * T
            board.tick()
        tick += 1
    return read_all(board)


@pytest.mark.parametrize("until", ["friction", "speed_error"])
@pytest.mark.parametrize("v", [0.1, -0.1])
def test_a_run_ends_in_the_second_consecutive_settled_cycle(board, until, v):
    log = play(board, until, v, WITHIN, cycles=20)
    expected = cycles_until_settled(SIZE, Q, WITHIN)
    assert expected == 8, "from k = 6 on"
    assert len(log) == expected * CYCLE_TICKS // 100
    flags = log[:, WORD["flags"]]
    assert flags[-1] & LAST and flags[-1] & SETTLED
    assert not np.any(flags[:-1] & (LAST | SETTLED))


@pytest.mark.parametrize("until", ["friction", "speed_error"])
def test_an_unsettled_run_ends_with_the_last_cycle_without_the_flag(board, until):
    log = play(board, until, 0.1, WITHIN, cycles=6)
    assert len(log) == 6 * CYCLE_TICKS // 100
    assert log[-1, WORD["flags"]] & LAST
    assert not np.any(log[:, WORD["flags"]] & SETTLED)


def test_a_constant_value_settles_in_three_cycles(board):
    log = play(board, "friction", 0.1, 0.01, cycles=20, size=0.0)
    assert len(log) == 3 * CYCLE_TICKS // 100
    assert log[-1, WORD["flags"]] & SETTLED


def test_a_run_settled_in_its_last_cycle_is_settled(board):
    log = play(board, "friction", 0.1, WITHIN, cycles=8)
    assert len(log) == 8 * CYCLE_TICKS // 100
    assert log[-1, WORD["flags"]] & SETTLED


def test_without_a_condition_a_settled_run_makes_all_cycles(board):
    log = play(board, "cycles", 0.1, 1.0, cycles=6)
    assert len(log) == 6 * CYCLE_TICKS // 100
    assert not np.any(log[:, WORD["flags"]] & SETTLED)


def test_a_triangle_of_many_cycles_does_not_drift(new_board):
    """Cycles over 100 mm about the middle of the travel end at their start."""
    cycles = 10
    board = new_board()
    board.write_settings(log_divider=50.0)
    v, a, middle = 0.2, 0.4, 0.15
    row = (
        {"v_m_s": v, "a_m_s2": a, "duration_s": 1.05 * v / a},
        {"v_m_s": -v, "a_m_s2": a, "duration_s": 2.1 * v / a},
        {"v_m_s": 0.0, "a_m_s2": a, "duration_s": v / a},
    )
    edges = {"x_start_m": 0.1, "x_min_m": middle, "x_max_m": middle}
    board.write_row(*row, cycles=cycles, hold_s=0.0, **edges)
    board.rest(0.05, x=0.1)
    assert board.start() == b""
    turns = {}
    while board.status()["state"] == STATES.index("running"):
        drive(board, 100)
        status = board.status()
        if status["phase"] in (PHASES.index("accelerate"), PHASES.index("steady")):
            low, high = turns.get(status["cycle"], (1.0, 0.0))
            turns[status["cycle"]] = min(low, status["x_m"]), max(high, status["x_m"])
    assert len(turns) == cycles
    lows, highs = zip(*turns.values(), strict=True)
    assert max(lows[1:]) - min(lows[1:]) < 1.5e-4 and max(highs[1:]) - min(highs[1:]) < 1.5e-4
    assert min(lows) > 0.095 and max(highs) < 0.205


def test_a_start_repeated_after_the_end_has_no_effect(board):
    board.write_motion(duration_s=0.05, hold_s=0.0)
    assert board.start() == b""
    sequence = board.sequence
    drive(board, 20_000)
    assert STATES[board.status()["state"]] == "done"
    board.sequence = sequence
    assert board.start(again=True) == b""
    assert STATES[board.status()["state"]] == "done"
    assert board.start() == b"", "with another sequence it is another start"
    assert STATES[board.status()["state"]] == "running"
