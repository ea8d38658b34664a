"""Signs, feedforward and limits of the three commands, with the sensors led by hand."""

import pytest

WORD_M = 7e-6
C_ROD, C_PISTON = 5.7205, 34.0682
DAC_STEP_V = 10 / 2048


@pytest.fixture
def pushed(board):
    """Return the commands of a running board that is pushed a whole number of words each tick.

    The load's pressures stand at their references (15 and 40 bar, whole words), so its PIs have
    nothing to do.
    """

    def push(words, ticks=200, **settings):
        board.write_settings(**settings)
        if board.status()["state"] != 1:
            board.rest(0.05, x=0.1)
            board.start()
        for _ in range(ticks):
            board.si["x"] += words * WORD_M
            commands = board.tick()
        return commands

    return push


@pytest.mark.parametrize("words", [-3, -2, 2, 3])
def test_feedforward_brings_oil_to_the_rod_side_and_takes_it_from_the_piston_side(pushed, words):
    v = words * WORD_M / 1e-4
    _, u_l1, u_l2 = pushed(words, feedforward_on=1.0)
    assert u_l1 == pytest.approx(C_ROD * v, abs=DAC_STEP_V)
    assert u_l2 == pytest.approx(-C_PISTON * v, abs=DAC_STEP_V)


def test_without_feedforward_motion_alone_moves_no_load_valve(pushed):
    assert pushed(2)[1:] == [0, 0]


def test_feedforward_beyond_the_limit_stops_at_it_and_winds_nothing_up(pushed):
    assert C_PISTON * 5 * WORD_M / 1e-4 > 10.0
    assert pushed(5, feedforward_on=1.0)[2] == -10.0
    assert pushed(0)[2] == pytest.approx(0.0, abs=DAC_STEP_V)


def test_voltage_limit_holds_with_feedforward_and_error_together(board):
    board.write_settings(feedforward_on=1.0, voltage_limit_v=4.0)
    board.write_step(p_lp_ref_pa=10e5)
    board.rest(0.05, x=0.1)
    board.start()
    lowest = 0.0
    for _ in range(3000):
        board.si["x"] += 2 * WORD_M / 5
        lowest = min(lowest, *board.tick())
    assert lowest == pytest.approx(-4.0, abs=DAC_STEP_V)


@pytest.mark.parametrize(("x_start", "sign"), [(0.3, 1), (0.01, -1)])
def test_test_valve_opens_towards_the_start_position(board, x_start, sign):
    board.write_step(x_start_m=x_start)
    board.rest(0.02, x=0.1)
    board.start()
    board.rest(0.05, x=0.1)
    assert sign * board.tick()[0] > 0.1


@pytest.mark.parametrize(("change", "valve"), [("p_lr_ref_pa", 1), ("p_lp_ref_pa", 2)])
@pytest.mark.parametrize("difference", [-8e5, 8e5])
def test_load_valve_lets_oil_in_where_pressure_is_missing(board, change, valve, difference):
    now = {"p_lr_ref_pa": 15e5, "p_lp_ref_pa": 40e5}[change]
    board.write_step(**{change: now + difference})
    board.start()
    board.rest(0.1, x=0.05)
    commands = board.tick()
    assert commands[valve] * difference > 0.0
    assert commands[3 - valve] == 0.0


def test_full_voltage_is_the_last_dac_code_on_either_side(board):
    board.write_step(p_lr_ref_pa=100e5, p_lp_ref_pa=1e5, hold_s=10.0)
    board.write_settings(pressure_slew_pa_s=1e9, heartbeat_s=10.0)
    board.rest(0.01, x=0.05)
    board.start()
    board.rest(2.0, x=0.05)
    board.si["p_lp"] = 200e5
    board.rest(0.1, x=0.05)
    _, u_l1, u_l2 = board.tick()
    assert (u_l1, u_l2) == (2047 / 204.8, -2048 / 204.8)


def test_loads_references_start_at_the_pressures_that_there_are(board):
    board.write_step(p_lr_ref_pa=60e5, p_lp_ref_pa=90e5)
    board.start()
    commands = board.tick()
    # One tick of slew is 0.01 bar: K_c tau_c times that is 4 and 16 mV, not the whole 45 bar.
    assert 0.0 <= commands[1] < 0.01
    assert 0.0 <= commands[2] < 0.025
