"""Speed of the plant beside the same equations in plain C, and beside scipy's integrators.

CPU time, the best of many runs in turn, so that a busy machine slows both alike. The figures are
printed (``pytest -s tests/benchmarks/test_plant_speed.py``).
"""

from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from hbench.config.bench import parse_plant
from hbench.config.files.loading import read_yaml
from hbench.model.build import plant_parameters
from hbench.model.compiled import compiled
from hbench.model.plant import (
    P_LR,
    TICK_S,
    V,
    derivatives,
    forces,
    initial_state,
    new_work,
    step,
)
from hbench.model.simulation import simulate
from tests.support.benchmarks import BENCH, CLEAR, STATES_IN_C, best_seconds, commands

TOLERANCES = 10.0 ** -np.arange(3.0, 10.0, 0.25)
METHODS = ("RK23", "RK45", "DOP853", "LSODA")


@compiled
def advance(state, u, levels, par, work):
    for i in range(len(u)):
        on_masses = forces(state, levels, par, work[0])
        step(state, u[i], on_masses, levels, par, TICK_S, work)


def test_the_plant_takes_at_most_1_1_times_the_time_of_plain_c(par, start, plant_in_c):
    u, levels, work = commands(10_000), np.ones(2), new_work(par)
    state, in_c = start.copy(), start[STATES_IN_C]
    advance(state, u, levels, par, work)
    plant_in_c(in_c, u)
    assert state[STATES_IN_C] == pytest.approx(in_c, rel=1e-9, abs=1e-12)
    plant_s, c_s = best_seconds(
        lambda: advance(start.copy(), u, levels, par, work),
        lambda: plant_in_c(start[STATES_IN_C], u),
    )
    ns = 1e9 / len(u)
    print(f"plant {plant_s * ns:.0f} ns a tick, C {c_s * ns:.0f} ns: ratio {plant_s / c_s:.2f}")
    assert plant_s < 1.1 * c_s


# Of the test cylinder; the load cylinder keeps its LuGre law.
STRIBECK = {"coulomb": "80 N", "stiction": "450 N", "stribeck_velocity": "60 mm/s"}
LINES = {"low_force": "450 N", "low_slope": "-2 kN s/m", "high_force": "250 N"}
LINES |= {"high_slope": "2 kN s/m"}
FRICTION = {
    "tustin": STRIBECK,
    "marton_lantos": {"extend": LINES, "retract": LINES},
    "pressure_based": {"stribeck_force": "370 N", "stribeck_rate": "-16 s/m"},
    "lugre": STRIBECK | {"bristle_stiffness": "3e5 N/m"},
    "leuven": STRIBECK | {"elements": ["100 N", "100 N", "400 N"], "presliding": "2 mm"},
}


def test_a_law_with_a_memory_takes_less_than_half_of_tustins_time():
    """Static laws are stiff at rest and take 8 steps a tick; those with bristles take one."""
    bench, levels = read_yaml(BENCH), np.ones(2)
    u = commands(10_000)
    runs, substeps = [], []
    for law, keys in FRICTION.items():
        own = {"friction": {"test": {"law": law, "viscous": "2500 N s/m"} | keys}}
        if law == "marton_lantos":
            del own["friction"]["test"]["viscous"]
        par = plant_parameters(parse_plant(bench, own, law))
        start, work = initial_state(par, 0.1, 15e5, 20e5), new_work(par)
        runs.append(lambda p=par, s=start, w=work: advance(s.copy(), u, levels, p, w))
        substeps.append(par.substeps)
        runs[-1]()
    seconds = best_seconds(*runs, rounds=15)
    ratios = dict(zip(FRICTION, np.array(seconds) / seconds[0], strict=True))
    for (law, ratio), one, steps in zip(ratios.items(), seconds, substeps, strict=True):
        ns = 1e9 * one / len(u)
        print(f"{law:15}{ns:6.0f} ns a tick, {ns / steps:5.0f} a step: {ratio:.2f} of tustin's")
    assert ratios["lugre"] < 0.5 and ratios["leuven"] < 0.5
    assert all(0.5 < ratios[law] < 1.5 for law in ("marton_lantos", "pressure_based"))


@pytest.fixture(scope="module")
def rates(par):
    """Return the compiled ``rates(y, u, out)``, in which the parameters are constants.

    Handing them over at each call would take longer than the equations.
    """
    levels = np.ones(2)

    @njit(error_model="numpy")
    def constant_par(y, u, levels, out):
        derivatives(y, u, levels, par, out)

    return lambda y, u, out: constant_par(y, u, levels, out)


class Scipy:
    """``solve_ivp`` on the compiled right-hand side, from one change of the commands to the next.

    A tolerance is relative to each state's size in the run.
    """

    def __init__(self, par, rates, start, u):
        changes = np.flatnonzero(np.any(np.diff(u, axis=0), axis=1)) + 1
        self.edges = [0, *changes, len(u)]
        self.rates, self.start, self.u = rates, start, u
        self.sizes = np.abs(simulate(par, start, u).state).max(axis=0) + 1e-12

    def rhs(self, t, y, u):
        out = np.empty_like(y)
        self.rates(y, u, out)
        return out

    def states(self, method, tolerance):
        """Return the states at each tick (n + 1, states)."""
        states = [self.start[None]]
        for first, last in pairwise(self.edges):
            t = np.arange(first, last + 1) * TICK_S
            solution = solve_ivp(
                self.rhs, (t[0], t[-1]), states[-1][-1], method, t, args=(self.u[first],),
                rtol=tolerance, atol=tolerance * self.sizes,
            )  # fmt: skip
            states.append(solution.y.T[1:])
        return np.concatenate(states)


def error(states, reference):
    """Largest error of velocity and pressures, relative to each one's range over the run."""
    columns = slice(V, P_LR + 1)
    worst = np.abs(states - reference)[:, columns].max(axis=0)
    return np.max(worst / np.ptp(reference[:, columns], axis=0))


def fastest_at_the_plants_accuracy(par, rates, start, u, least):
    """Return scipy's best method, its tolerance and how many times longer it takes.

    Where that is clearly more than ``least``, few rounds determine it.
    Of each method the loosest tolerance counts whose error is at most the plant's.
    """
    scipy = Scipy(par, rates, start, u)
    reference = scipy.states("DOP853", 1e-12)
    allowed = error(simulate(par, start, u).state, reference)
    assert allowed < 1e-5
    found = []
    for method in METHODS:
        for tolerance in TOLERANCES:
            if error(scipy.states(method, tolerance), reference) <= allowed:
                found.append((method, tolerance))
                break
    levels, work = np.ones(2), new_work(par)
    plant_s, *scipy_s = best_seconds(
        lambda: advance(start.copy(), u, levels, par, work),
        *(lambda choice=choice: scipy.states(*choice) for choice in found),
        clear=lambda plant_s, *scipy_s: least * plant_s < CLEAR * min(scipy_s),
        rounds=5,
    )
    best = int(np.argmin(scipy_s))
    return *found[best], scipy_s[best] / plant_s


def test_solve_ivp_takes_20_times_longer_at_the_plants_accuracy(par, rates, start):
    """Under commands as the plant gets them in the loop."""
    u, least = commands(300), 20
    method, tolerance, ratio = fastest_at_the_plants_accuracy(par, rates, start, u, least)
    print(f"other commands each tick: {method} at {tolerance:g} takes {ratio:.0f} times as long")
    assert ratio > least


def test_solve_ivp_takes_longer_under_commands_that_stay(par, rates, start):
    """There its steps grow longer than a tick, as they can't in the loop: about ten times."""
    u = np.repeat(
        [[0.7, 0.3, -1.4], [-0.8, -1.0, 0.5], [0.0, 0.0, 0.0]], (4000, 5000, 4000), axis=0
    )
    least = 4
    method, tolerance, ratio = fastest_at_the_plants_accuracy(par, rates, start, u, least)
    print(f"three commands in 1.3 s: {method} at {tolerance:g} takes {ratio:.0f} times as long")
    assert ratio > least
