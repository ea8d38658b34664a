"""Motion of a driven mass in a model under the measured drive force, from a run's first sample.

    m x'' = F_drive - F_applied - F_friction(v, ...)

The forces are linear between the samples. Steps of at most 0.1 ms are semi-implicit: the velocity
advances with the force, then the position and the law's bristles with the new velocity. The dry
part of a law without bristles acts as an impulse that stops the mass at most, so a mass at rest
sticks. Nothing corrects the position, so an error of the force accumulates in it.
"""

from math import ceil

import numpy as np

from hbench.model.compiled import compiled
from hbench.model.effects.applied import friction_effects
from hbench.model.friction.laws import (
    deflection_under,
    exact_step,
    friction,
    is_dynamic,
    steady_parts,
)
from hbench.model.parameters import PlantParameters
from hbench.model.plant import n_states
from hbench.model.states import P_TP, V, X, bristles_end
from hbench.reconcile.measured.balances import BalanceModel, driving_signals, starts, true_values
from hbench.reconcile.measured.session import Session

_STEP_S = 1e-4


def open_loop_positions(session: Session, model: BalanceModel) -> np.ndarray:
    """Return the simulated positions (n,) [m] at the samples of all runs of a session."""
    par = model.par
    signals = driving_signals(session, model)
    drive = signals[2] * par.test.area_piston_m2
    applied = true_values(session, "f_applied_n", model, "f_applied")
    at_start = starts(session, signals, model, (drive - applied, 0 * drive))
    steps = max(1, ceil(session.window.dt_s / _STEP_S - 1e-9))
    out, elements = np.empty_like(drive), len(par.test.friction.elements)
    first, size = bristles_end(par), n_states(par)
    for r, (start, stop) in enumerate(zip(session.edges[:-1], session.edges[1:], strict=True)):
        state = np.zeros(size)
        state[X], state[V] = signals[0, start], signals[1, start]
        state[P_TP] = signals[2, start]
        state[first:] = at_start.states[r]
        _simulate(
            drive[start:stop],
            applied[start:stop],
            session.window.dt_s / steps,
            steps,
            par,
            is_dynamic(par.test.friction),
            float(at_start.friction_n[r, 0]),
            state,
            np.zeros(2 * elements),
            np.zeros((2, 2 * elements)),
            np.zeros(size),
            out[start:stop],
        )
    return out


@compiled
def _simulate(
    drive: np.ndarray,
    applied: np.ndarray,
    h: float,
    steps: int,
    par: "PlantParameters",
    dynamic: bool,
    friction_n: float,
    state: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    rates: np.ndarray,
    out: np.ndarray,
) -> None:
    own, first, per_mass = par.test.friction, bristles_end(par), 1.0 / par.mass_test_kg
    _, _, more, _ = friction_effects(1.0, 1.0, state, par, par.effects, rates)
    z[0] = deflection_under(friction_n - more, state[V], own)
    out[0] = state[X]
    for k in range(len(drive) - 1):
        for i in range(steps):
            share = (i + 0.5) / steps
            force = drive[k] + share * (drive[k + 1] - drive[k])
            net = force - applied[k] - share * (applied[k + 1] - applied[k])
            state[P_TP] = force / par.test.area_piston_m2
            v, p = state[V], state[P_TP]
            level, _, more, _ = friction_effects(1.0, 1.0, state, par, par.effects, rates)
            for j in range(first, len(state)):
                state[j] += h * rates[j]
            if dynamic:
                v += h * per_mass * (net - more - friction(v, z, 0, p, 0.0, level, own, work[0]))
                exact_step(v, z, p, 0.0, level, h, own, work)
            else:
                dry, viscous = steady_parts(v, p, 0.0, level, own)
                v += h * per_mass * (net - more - viscous)
                stopping = h * per_mass * abs(dry)
                v = max(v - stopping, 0.0) if v > 0.0 else min(v + stopping, 0.0)
            state[V] = v
            state[X] += h * v
        out[k + 1] = state[X]
