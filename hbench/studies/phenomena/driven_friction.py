"""Friction laws alone: under a prescribed motion, and on a driven mass."""

from typing import NamedTuple

import numpy as np

from hbench.model.compiled import compiled, inlined
from hbench.model.friction.laws import friction, hold_slipped, midpoint_step
from hbench.model.parameters import FrictionParameters

_MEAN_PRESSURE_PA = 0.0  # of both chambers: the laws here have no seal terms


def prescribed_friction(v_m_s: np.ndarray, dt_s: float, par: FrictionParameters) -> np.ndarray:
    """Return friction [N] at the middle of each step of a motion (n,).

    Each velocity is held for ``dt_s``.

    The law starts relaxed. Midpoint rule: second order in ``dt_s``.
    """
    v = np.ascontiguousarray(v_m_s, dtype=float)
    force = np.empty(len(v))
    states = 2 * len(par.elements)
    _along(v, dt_s, par, np.zeros(states), np.zeros((2, states)), force)
    return force


@compiled
def _along(
    v: np.ndarray,
    dt: float,
    par: FrictionParameters,
    state: np.ndarray,
    work: np.ndarray,
    force: np.ndarray,
) -> None:
    p = _MEAN_PRESSURE_PA
    for k in range(len(v)):
        force[k] = midpoint_step(v[k], state, p, p, 1.0, dt, par, work)


class Driven(NamedTuple):
    """Motion of a driven mass; samples at k dt, k = 0..n."""

    x_m: np.ndarray  # (n + 1,)
    v_m_s: np.ndarray
    friction_n: np.ndarray


def driven_mass(
    force_n: np.ndarray,
    stiffness_n_m: float,
    mass_kg: float,
    dt_s: float,
    par: FrictionParameters,
    v0_m_s: float = 0.0,
    z0_m: float = 0.0,
) -> Driven:
    """Simulate m dv/dt = force - K x - F_friction, from x = 0.

    ``force_n`` (n + 1,) at k dt, in straight lines between. A mass that a spring K pulls at the
    speed V has force = K V t. ``v0_m_s`` and ``z0_m``: velocity and deflection at the start.
    Runge-Kutta of fourth order.
    """
    size = 2 + 2 * len(par.elements)
    state = np.zeros(size)
    state[1], state[2::2] = v0_m_s, z0_m
    force = np.ascontiguousarray(force_n, dtype=float)
    out = np.empty((3, len(force)))
    _driven(force, stiffness_n_m, mass_kg, dt_s, par, state, np.zeros((3, size)), out)
    return Driven(*out)


@inlined
def _slopes(
    state: np.ndarray,
    force: float,
    stiffness: float,
    mass: float,
    par: FrictionParameters,
    out: np.ndarray,
) -> float:
    """Write the rates of (x, v, deflections) into ``out``; return the friction [N]."""
    p = _MEAN_PRESSURE_PA
    for i in range(len(out)):
        out[i] = 0.0
    against = friction(state[1], state, 2, p, p, 1.0, par, out)
    out[0] = state[1]
    out[1] = (force - stiffness * state[0] - against) / mass
    return against


@compiled
def _driven(
    force: np.ndarray,
    stiffness: float,
    mass: float,
    dt: float,
    par: FrictionParameters,
    state: np.ndarray,
    work: np.ndarray,
    out: np.ndarray,
) -> None:
    slope, total, trial = work[0], work[1], work[2]
    x, v, f = out[0], out[1], out[2]
    for k in range(len(force)):
        x[k], v[k] = state[0], state[1]
        f[k] = _slopes(state, force[k], stiffness, mass, par, slope)
        if k + 1 == len(force):
            break
        rise = force[k + 1] - force[k]
        for i in range(len(state)):
            trial[i], total[i] = state[i], 0.0
        for weight, at, reach in (
            (1.0, 0.0, 0.5),
            (2.0, 0.5, 0.5),
            (2.0, 0.5, 1.0),
            (1.0, 1.0, 0.0),
        ):
            _slopes(trial, force[k] + at * rise, stiffness, mass, par, slope)
            for i in range(len(state)):
                total[i] += weight * slope[i]
                trial[i] = state[i] + reach * dt * slope[i]
        for i in range(len(state)):
            state[i] += dt / 6.0 * total[i]
        hold_slipped(state, 2, par)
