"""Signs, feedforward and limits of the three commands, with prescribed sensor values."""

import pytest

WORD_M = 7e-6
C_ROD, C_PISTON = 5.7205, 34.0682
DAC_STEP_V = 10 / 2048


@pytest.fixture
def pushed(board):
    """Commands of a running board whose position moves by a whole number of words each tick.

    The load's pressures equal their references (15 and 40 bar, whole words), so its PIs have
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


@pytest.mark.parametrize("words", [-5, 5])
def test_feedforward_beyond_the_limit_saturates_without_wind_up(pushed, words):
    assert C_PISTON * 5 * WORD_M / 1e-4 > 10.0
    u_l2 = pushed(words, feedforward_on=1.0)[2]
    assert u_l2 == pytest.approx(-10.0 if words > 0 else 10.0, abs=1.01 * DAC_STEP_V)
    assert pushed(0)[2] == pytest.approx(0.0, abs=DAC_STEP_V)


@pytest.mark.parametrize("words", [-1, 1])
@pytest.mark.parametrize("p_lp", [1e5, 200e5])
def test_feedforward_and_error_together_use_the_whole_range_and_no_more(board, words, p_lp):
    board.write_settings(feedforward_on=1.0, voltage_limit_v=4.0, heartbeat_s=10.0)
    board.rest(0.05, x=0.2)
    board.start()
    board.si["p_lp"] = p_lp
    for _ in range(5000):
        board.si["x"] += words * WORD_M / 5
        u = board.tick()[2]
        assert abs(u) <= 4.0 + DAC_STEP_V / 2
    assert u == pytest.approx(4.0 if p_lp < 40e5 else -4.0, abs=DAC_STEP_V / 2)


@pytest.mark.parametrize(("x_start", "sign"), [(0.3, 1), (0.01, -1)])
def test_test_valve_opens_towards_the_start_position(board, x_start, sign):
    board.write_motion(x_start_m=x_start)
    board.rest(0.02, x=0.1)
    board.start()
    board.rest(0.05, x=0.1)
    assert sign * board.tick()[0] > 0.1


@pytest.mark.parametrize(("change", "valve"), [("p_lr_ref_pa", 1), ("p_lp_ref_pa", 2)])
@pytest.mark.parametrize("difference", [-8e5, 8e5])
def test_load_valve_opens_to_its_chamber_if_the_pressure_is_too_low(
    board, change, valve, difference
):
    now = {"p_lr_ref_pa": 15e5, "p_lp_ref_pa": 40e5}[change]
    board.write_motion(**{change: now + difference})
    board.start()
    board.rest(0.1, x=0.05)
    commands = board.tick()
    assert commands[valve] * difference > 0.0
    assert commands[3 - valve] == 0.0


def test_full_voltage_is_the_last_dac_code_on_either_side(board):
    board.write_motion(p_lr_ref_pa=100e5, p_lp_ref_pa=1e5, hold_s=10.0)
    board.write_settings(pressure_slew_pa_s=1e9, heartbeat_s=10.0)
    board.rest(0.01, x=0.05)
    board.start()
    board.rest(2.0, x=0.05)
    board.si["p_lp"] = 200e5
    board.rest(0.1, x=0.05)
    _, u_l1, u_l2 = board.tick()
    assert (u_l1, u_l2) == (2047 / 204.8, -2048 / 204.8)


def test_each_start_is_from_neutral_valves(board):
    board.start()
    board.si.update(p_lr=10e5, p_lp=50e5)
    board.rest(0.15, x=0.05)
    assert all(board.tick()[1:])
    board.request("stop")
    board.si.update(p_lr=15e5, p_lp=40e5)
    board.rest(0.05, x=0.05)
    board.start()
    assert board.tick() == [0, 0, 0]


def test_load_references_start_from_the_measured_pressures(board):
    board.write_motion(p_lr_ref_pa=60e5, p_lp_ref_pa=90e5)
    board.start()
    commands = board.tick()
    # One tick of slew is 0.01 bar: K_c tau_c times that is 4 and 16 mV, not the whole 45 bar.
    assert 0.0 <= commands[1] < 0.01
    assert 0.0 <= commands[2] < 0.025
