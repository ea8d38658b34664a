"""The model alone: the plant under given valve commands."""

from dataclasses import dataclass

import numpy as np

from hbench.model.compiled import compiled, inlined
from hbench.model.noise import new_noise
from hbench.model.parameters import PlantParameters
from hbench.model.plant import (
    TICK_S,
    MassForces,
    V,
    drawn_flow,
    forces,
    n_states,
    new_work,
    step,
)
from hbench.model.scatter import new_levels, update_levels


@dataclass(frozen=True)
class Trajectory:
    """A simulated motion: n commands, n + 1 samples, 100 us apart."""

    t_s: np.ndarray  # (n + 1,)
    state: np.ndarray  # (n + 1, states), columns as named in plant.py
    u_v: np.ndarray  # (n, 3), row i held from sample i to i + 1
    friction_test_n: np.ndarray  # (n + 1,)
    friction_load_n: np.ndarray  # (n + 1,)
    f_applied_n: np.ndarray  # (n + 1,), what the load cell carries
    q_supply_m3_s: np.ndarray  # (n + 1,), drawn from the supply line


def simulate(
    par: PlantParameters, state0: np.ndarray, u_v: np.ndarray, seed: int | None = None
) -> Trajectory:
    """Run the plant from ``state0`` (states,) under the commands ``u_v`` (n, 3), each held 100 us.

    ``seed`` turns on the scatter of friction from stroke to stroke; without it friction is
    nominal. The same seed gives the same bytes.
    """
    commands = np.ascontiguousarray(u_v, dtype=float)
    states = np.empty((len(commands) + 1, len(state0)))
    states[0] = state0
    outputs = np.empty((len(commands) + 1, 4))
    noise, scatter = new_noise(seed or 0), seed is not None
    levels = new_levels(noise, par) if scatter else np.ones(3)
    _run(par, states, commands, outputs, levels, noise, scatter, new_work(par))
    return Trajectory(np.arange(len(states)) * TICK_S, states, commands, *outputs.T)


@compiled
def _run(
    par: PlantParameters,
    states: np.ndarray,
    commands: np.ndarray,
    outputs: np.ndarray,
    levels: np.ndarray,
    noise: np.ndarray,
    scatter: bool,
    work: np.ndarray,
) -> None:
    on_masses = forces(states[0], levels, par, work[0])
    _observe(states[0], on_masses, par, outputs[0], work[3])
    for i in range(len(commands)):
        for k in range(n_states(par)):
            states[i + 1, k] = states[i, k]
        step(states[i + 1], commands[i], on_masses, levels, par, TICK_S, work)
        if scatter:
            update_levels(levels, states[i + 1, V], noise, par)
        on_masses = forces(states[i + 1], levels, par, work[0])
        _observe(states[i + 1], on_masses, par, outputs[i + 1], work[3])


@inlined
def _observe(
    state: np.ndarray,
    on_masses: MassForces,
    par: PlantParameters,
    output: np.ndarray,
    rates: np.ndarray,
) -> None:
    """Write the trajectory's last four fields."""
    output[0] = on_masses.friction_test
    output[1] = on_masses.friction_load
    output[2] = on_masses.applied
    output[3] = drawn_flow(state, par, rates)
