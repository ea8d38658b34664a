"""Detection time and stopping distance of each fault on the simulated bench.

``pytest -s tests/firmware/test_safety_on_the_plant.py`` prints the table of firmware/README.md.
"""

import pytest

from tests.support.board.moving_rig import BENCH, MovingRig

LOADED = {1: (5000.0, 15e5), -1: (-5000.0, 110e5)}  # opposes extension, opposes retraction
V = 0.2
HEARTBEAT_S = 0.3  # shorter than the bench's 2 s, in which the piston would reach the end
TRAVEL = {1: {"travel_max_m": 0.25}, -1: {"travel_min_m": 0.15}}
ROWS = []


def at_speed(side, **changes):
    return MovingRig(side * V, *LOADED[side], x_at=0.2, **changes)


def silence(side):
    rig = at_speed(side, heartbeat_s=HEARTBEAT_S)
    rig.board_state()  # the last request
    return rig, rig.stop(silent=True)


def overrun(side):
    rig = at_speed(side)
    rig.overrun()
    return rig, rig.stop()


def broken_wire(side):
    rig = at_speed(side)
    rig.break_sensor("x", counts=0)
    return rig, rig.stop()


def frozen_sensor(side):
    rig = at_speed(side)
    rig.break_sensor("x")
    return rig, rig.stop()


def scale_valves(rig, factor):
    valve = rig.par.valve
    rig.vary(valve=valve._replace(flow_gain=factor * valve.flow_gain))


def dead_valve(side):
    """A tenth of the valve flow gain."""
    rig = at_speed(side)
    scale_valves(rig, 0.1)
    return rig, rig.stop()


def relief_valve_stuck(side):
    """The supply rises above the limit; its transducer clips at 237 bar."""
    rig = at_speed(side)
    rig.raise_supply(235e5)
    return rig, rig.stop()


def limit_ahead(side):
    """The board predicts the violation, so there is no time from an event to the fault."""
    limit = TRAVEL[side]["travel_max_m" if side > 0 else "travel_min_m"]
    travel = (0.03, limit) if side > 0 else (limit, 0.35)
    rig = at_speed(side, travel=travel, **TRAVEL[side])
    return rig, rig.stop()


def valve_runs_away(side):
    """Ten times the valve flow gain."""
    rig = at_speed(side)
    scale_valves(rig, 10.0)
    return rig, rig.stop()


CASES = [
    # name, fault, event, upper limit of the ticks until detection
    ("no frame from the host", "heartbeat", silence, None),
    ("overrun", "overrun", overrun, 1),
    ("position wire breaks", "sensor", broken_wire, 1),
    ("limit ahead", "travel", limit_ahead, None),
    ("supply at 235 bar", "pressure", relief_valve_stuck, 30),
    ("valve flow gain x 10", "speed", valve_runs_away, 100),
    ("position frozen", "speed_error", frozen_sensor, 550),
    ("valve flow gain / 10", "speed_error", dead_valve, 700),
]


@pytest.fixture(scope="module", autouse=True)
def table():
    ROWS.clear()
    yield
    print(f"\n{'':47}to fault  to neutral  speed   moves  at rest  pressure")
    print(f"{'event':34}{'fault':17}ms       ticks   mm/s      mm       ms      +bar")
    print("\n".join(ROWS))


@pytest.mark.parametrize("side", [1, -1], ids=["extending", "retracting"])
@pytest.mark.parametrize(("name", "fault", "happen", "most"), CASES, ids=[c[0] for c in CASES])
def test_valves_are_neutral_in_the_tick_of_the_fault_and_the_piston_stays_in_its_travel(
    name, fault, happen, most, side
):
    rig, stop = happen(side)
    detection = f"{0.1 * stop.detection_ticks:.1f}" if fault != "travel" else "-"
    rise = (stop.p_highest_pa - stop.p_before_pa).max()
    ROWS.append(
        f"{name + (', extending' if side > 0 else ', retracting'):34}{fault:12}"
        f"{detection:>9}{stop.neutral_ticks:11}{1e3 * stop.v_m_s:7.0f}"
        f"{1e3 * stop.distance_m:9.2f}{0.1 * stop.rest_ticks:9.0f}{rise / 1e5:9.1f}"
    )
    assert stop.fault == fault
    assert stop.neutral_ticks == 0
    if fault == "heartbeat":
        assert stop.detection_ticks == round(HEARTBEAT_S * 1e4) + 1
    elif fault != "travel":
        assert stop.detection_ticks <= most
    assert stop.distance_m <= abs(stop.v_m_s) * BENCH.limits.stopping_time
    low, high = BENCH.limits.travel_min, BENCH.limits.travel_max
    if fault == "travel":
        low, high = TRAVEL[side].get("travel_min_m", low), TRAVEL[side].get("travel_max_m", high)
    assert low <= min(rig.x, stop.x_m) and max(rig.x, stop.x_m) <= high
    assert stop.p_highest_pa.max() < BENCH.limits.pressure_max
    rig.close()
