"""Hysteresis loops: closed forms, another integration of LuGre, and the rig's own states."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.curves.hysteresis import hysteresis
from hbench.analysis.screening.screen import screen
from hbench.config.schedule import Screening
from hbench.model.plant import V, X, forces
from hbench.records import ScreenedRun
from hbench.rig.firmware import HostFirmware
from hbench.rig.stepped import SteppedRig
from hbench.workflow import board
from tests.support.analysis.moving import TICK_S, filtered, moving_run, records, triangle_velocity
from tests.support.analysis.other_plant import OTHER_MASS_KG, OTHER_PLANT

A, TOP = 0.4, 0.2  # m/s^2, m/s
TAU_S = 0.02


def static(v):
    """Tustin's law with a continuous sign, far narrower than the velocities where it is read."""
    dry = 120 + 260 * np.exp(-np.abs(v) / 0.06)
    return dry * np.tanh(v / 1e-3) + 2400 * v


def lugre(v, stiffness=1.5e4):
    """Bristles by Euler's rule at 10 kHz; another integration than the product's."""
    z, out = 0.0, np.empty(len(v))
    for i, speed in enumerate(v):
        dry = 120 + 260 * np.exp(-abs(speed) / 0.06)
        z += TICK_S * (speed - stiffness * abs(speed) / dry * z)
        out[i] = stiffness * z + 2400 * speed
    return out


def loop_of(*runs, mass_kg=0.0):
    (loop,), notes = hysteresis([ScreenedRun(run, (), None) for run in runs], mass_kg)
    assert notes == ()
    return loop


def triangle(friction, cycles=3, **options):
    v = triangle_velocity(A, TOP, cycles)
    return moving_run("triangle", v, friction(v), v_ref=v, **options)


def test_a_static_friction_has_no_width_but_has_one_over_the_filtered_velocity():
    v = triangle_velocity(A, TOP, 3)
    loop = loop_of(triangle(static, v_board=filtered(v, TAU_S), mass_kg=6.0), mass_kg=6.0)
    assert len(loop.widths) == 6
    for width in loop.widths:
        slope = 2400 - 260 / 0.06 * np.exp(-abs(width.v_m_s) / 0.06)
        made_by_filter = 2 * TAU_S * A * slope
        assert width.width_n == pytest.approx(0, abs=0.3)
        assert width.board_n == pytest.approx(made_by_filter, abs=0.15 * 2 * TAU_S * A * 2400)
    assert max(abs(width.board_n) for width in loop.widths) > 25


def test_the_inertia_opens_a_loop_where_it_is_not_taken_off():
    run = triangle(static, mass_kg=6.0)
    for width in loop_of(run).widths:  # rising v adds m a; |F| falls with it where v < 0
        assert width.width_n == pytest.approx(2 * 6.0 * A, abs=0.4)


def test_energy_of_a_cycle_is_coulombs_and_the_viscous_closed_form():
    def law(v):
        return 300 * np.tanh(v / 1e-4) + 2000 * v

    way, squared = 2 * TOP**2 / A, 4 * TOP**3 / (3 * A)
    loop = loop_of(triangle(law))
    assert loop.area_j == pytest.approx(300 * way + 2000 * squared, rel=2e-3)
    assert (loop.cycles, loop.trials, loop.unit) == (2, 1, "cycle")


def test_a_lugre_friction_has_the_width_and_the_energy_of_its_10_khz_states():
    v = triangle_velocity(A, TOP, 3)
    friction = lugre(v)
    loop = loop_of(triangle(lambda _: friction))
    truth = widths_of_states(v, friction, TOP, len(v) // 3)
    assert [w.width_n for w in loop.widths] == pytest.approx(truth, abs=0.5)
    assert max(abs(t) for t in truth) > 100
    last = slice(len(v) // 3, None)
    assert loop.area_j == pytest.approx(np.sum((friction * v)[last]) * TICK_S / 2, rel=2e-3)


def widths_of_states(v, friction, top, start):
    """Width at each velocity from the crossings of it in 10 kHz states, from ``start`` on."""
    found = []
    for share in (-0.75, -0.5, -0.25, 0.25, 0.5, 0.75):
        above = v[start:] > share * top
        up = start + np.flatnonzero(~above[:-1] & above[1:])
        down = start + np.flatnonzero(above[:-1] & ~above[1:])
        found.append(friction[up].mean() - friction[down].mean())
    return found


def test_intervals_count_trials_where_there_are_some_and_else_cycles():
    rng = np.random.default_rng(2)

    def trial(number, level):
        plan = {"trial": number, "run": f"{number:04d}"}
        return triangle(lambda v: level * static(v), plan=plan, noise_n=2.0, seed=number)

    levels = 1 + 0.03 * rng.standard_normal(4)
    loop = loop_of(*(trial(number, level) for number, level in enumerate(levels, start=1)))
    assert (loop.unit, loop.trials, loop.cycles) == ("trial", 4, 8)
    (one,) = (loop_of(trial(1, 1.0)),)
    assert loop.area_ci95_j == pytest.approx(
        3.182446 * np.std(levels, ddof=1) / 2 * one.area_j, rel=0.05
    )


def test_a_run_without_a_cycle_or_a_pressure_is_left_out_with_its_reason():
    run = triangle(static, cycles=1)
    for changed, reason in (
        (replace(run, v_ref_m_s=None), "contains no complete cycle"),
        (replace(run, p_tp_pa=None), "friction needs p_tp"),
    ):
        loops, notes = hysteresis([ScreenedRun(changed, (), None)], 0.0)
        assert loops == () and f"left out of the hysteresis: run 0001: {reason}" in notes[0]


# ---- the rig -------------------------------------------------------------------------------------

TRIANGLE = {
    "kind": "triangle",
    "p_lr": "15 bar",
    "loads": ["2000 N"],
    "speed": "150 mm/s",
    "cycles": 3,
    "travel": {"start": "140 mm", "end": "240 mm"},
    "hold": "0.3 s",
}


class WatchedRig(SteppedRig):
    """Keeps the plant's states, a tick a row: x, v, true friction of the test cylinder."""

    states = []

    def read(self, timeout_s):
        last = self._tick + max(1, round(timeout_s / TICK_S))
        while self._tick < last:
            said = super().read(TICK_S)
            bench = self._bench
            moment = forces(bench.state, bench.levels, bench.par, bench.work[0])
            self.states.append((bench.state[X], bench.state[V], moment.friction_test))
            if said:
                return said
        return b""


@pytest.fixture
def watched(monkeypatch):
    WatchedRig.states = []
    monkeypatch.setattr(
        board,
        "_virtual_rig",
        lambda bench, physics, seed, baud: WatchedRig(
            "sim", HostFirmware(boots=1), bench, physics, seed
        ),
    )
    return WatchedRig


def begin(x_states, x_log):
    """The tick at which a log begins, from the position."""
    total = np.concatenate(([0.0], np.cumsum(x_states)))
    offsets = np.arange(len(x_states) - 100 * len(x_log))
    error = np.zeros(len(offsets))
    for k in range(0, len(x_log), 7):
        start = offsets + 100 * k
        error += ((total[start + 100] - total[start]) / 100 - x_log[k]) ** 2
    return int(np.argmin(error))


def test_on_the_rig_lugres_loop_is_that_of_the_plants_own_states(rig_runs, watched):
    softer = OTHER_PLANT["friction"]["test"] | {"bristle_stiffness": "5e4 N/m", "scatter": 0.0}
    (run,) = rig_runs([TRIANGLE | {"cycles": 2}], 1, softer, exact=True)
    assert screen(run, Screening()).accepted
    x, v, friction = np.array(watched.states).T
    start = begin(x, run.x_m)
    stop = start + 100 * len(run.x_m)
    assert records(x[start:stop]) == pytest.approx(run.x_m, abs=5e-6)
    loop = loop_of(run, mass_kg=OTHER_MASS_KG)
    cycle = (stop - start) // 2
    truth = widths_of_states(v[:stop], friction[:stop], 0.15, start + cycle)
    assert [w.width_n for w in loop.widths] == pytest.approx(truth, rel=0.01, abs=1.0)
    assert max(abs(t) for t in truth) > 100
    energy = np.sum((friction * v)[start + cycle : stop]) * TICK_S
    assert loop.area_j == pytest.approx(energy, rel=5e-3)


def test_on_the_rig_a_static_friction_has_no_width_within_noise(rig_runs):
    straight = {
        "law": "tustin",
        "coulomb": "330 N",
        "stiction": "330 N",
        "stribeck_velocity": "60 mm/s",
        "viscous": "2400 N s/m",
    }
    runs = rig_runs([TRIANGLE | {"trials": 4}], 3, straight)
    loop = loop_of(*runs, mass_kg=OTHER_MASS_KG)
    assert loop.unit == "trial"
    by_filter = 2 * 0.002 * 0.225 * 2400  # tau, a, dF/dv: 2.2 N
    for width in loop.widths:
        assert abs(width.width_n) < 0.5
        assert width.board_n == pytest.approx(by_filter, abs=0.5)


def without_reference(run):
    return replace(run, v_ref_m_s=None)


def test_without_a_logged_reference_the_reversals_of_the_position_give_the_cycles():
    run = triangle(static, v_board=None)
    logged, found = loop_of(run), loop_of(without_reference(run))
    assert (found.cycles, logged.cycles) == (1, 2)  # its first and last strokes do not end at rest
    assert found.area_j == pytest.approx(logged.area_j, rel=2e-3)
    for width in found.widths:
        assert width.width_n == pytest.approx(0, abs=1.0)


def test_the_lag_of_friction_has_the_same_width_without_a_reference():
    run = triangle(lugre)
    logged, found = loop_of(run), loop_of(without_reference(run))
    widths = {width.v_m_s: width.width_n for width in logged.widths}
    assert {w.v_m_s: w.width_n for w in found.widths} == pytest.approx(widths, rel=0.05, abs=0.5)


def test_motions_of_other_travel_are_no_trials_of_one_loop():
    run = triangle(static)
    short = replace(run, x_m=run.x_m[0] + 0.5 * (run.x_m - run.x_m[0]))
    loops, _ = hysteresis([ScreenedRun(each, (), None) for each in (run, short, run)], 0.0)
    assert sorted(len(loop.runs) for loop in loops) == [1, 2]
