"""The three loops as the board closes them at 10 kHz: sampled plant, filters, D.18.

At a tick the board takes the sensors, filters them (D.11, D.29), computes the commands (D.18) and
sets the valves, which hold them until the next tick. All of that is exact here: the plant goes
through the matrix exponential, the rest are the source's difference equations.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from hbench.control.linearisation import N_STATES, P_LP, P_LR, V
from hbench.control.merits import DIVERGED
from hbench.model.plant import TICK_S

T, L1, L2 = range(3)  # loops, by their valve: velocity, rod and piston pressure

Pi = tuple[float, float]  # K_c and tau_c of 4.36


@dataclass(frozen=True)
class SampledPlant:
    """Plant with valves from tick to tick: s' = f s + g u; y = h s, one output a loop.

    Outputs: mean velocity over the last tick (the position's difference), P_Lr, P_Lp.
    """

    f: np.ndarray  # (12, 12)
    g: np.ndarray  # (12, 3)
    h: np.ndarray  # (3, 12)
    filters_s: tuple[float, float, float]  # first-order lags of the measurements


def sample_plant(
    a: np.ndarray, b: np.ndarray, velocity_filter_s: float, pressure_filter_s: float
) -> SampledPlant:
    """Sample the linear bench A (11, 11), B (11, 3) of ``linearisation.state_space``."""
    n, way = N_STATES, N_STATES
    whole = np.zeros((n + 4, n + 4))  # state, distance travelled by the piston, commands
    whole[:n, :n], whole[:n, n + 1 :], whole[way, V] = a, b, 1.0
    moved = expm(whole * TICK_S)
    moved[way, way] = 0.0  # of the last tick alone
    moved[way] /= TICK_S
    h = np.zeros((3, n + 1))
    h[T, way] = h[L1, P_LR] = h[L2, P_LP] = 1.0
    filters = (velocity_filter_s, pressure_filter_s, pressure_filter_s)
    return SampledPlant(moved[: n + 1, : n + 1], moved[: n + 1, n + 1 :], h, filters)


def measurement_response(plant: SampledPlant, omega: np.ndarray) -> np.ndarray:
    """Return the response (n, 3, 3) of the filtered measurements to the commands."""
    z = np.exp(1j * omega * TICK_S)
    size = len(plant.f)
    states = np.linalg.solve(z[:, None, None] * np.eye(size) - plant.f, plant.g.astype(complex))
    lag = np.array([_filter(tau, z) for tau in plant.filters_s]).T
    return lag[:, :, None] * (plant.h @ states)


def _filter(tau_s: float, z: np.ndarray) -> np.ndarray:
    """D.29 (and D.11 behind its difference): y = (T x + tau y/z) / (T + tau)."""
    return TICK_S / (TICK_S + tau_s - tau_s / z)


def controller(pi: Pi, z: np.ndarray) -> np.ndarray:
    """D.18: K_c tau_c + K_c T z / (z - 1)."""
    gain, tau = pi
    return gain * (tau + TICK_S * z / (z - 1))


def broken_loop(
    response: np.ndarray, omega: np.ndarray, loops: Sequence[Pi], broken: int
) -> np.ndarray:
    """Return the open loop (n,) at valve ``broken``, with the other two loops closed.

    L_i = C_i (G_ii - G_iJ (1 + C_J G_JJ)^-1 C_J G_Ji), with G of ``measurement_response``.
    """
    z = np.exp(1j * omega * TICK_S)
    i, (j, k) = broken, [loop for loop in range(3) if loop != broken]
    c = [controller(pi, z) for pi in loops]
    g = np.ascontiguousarray(np.moveaxis(response, 0, 2))
    # Cramer's rule for the two loops that are closed.
    jj, jk, kj, kk = 1 + c[j] * g[j, j], c[j] * g[j, k], c[k] * g[k, j], 1 + c[k] * g[k, k]
    to_j, to_k = c[j] * g[j, i], c[k] * g[k, i]
    u_j, u_k = kk * to_j - jk * to_k, jj * to_k - kj * to_j
    through = (g[i, j] * u_j + g[i, k] * u_k) / (jj * kk - jk * kj)
    return c[i] * (g[i, i] - through)


def closed_loop_matrices(
    plant: SampledPlant, loops: Sequence[Pi], closed: Sequence[int] = (T, L1, L2)
) -> tuple[np.ndarray, np.ndarray]:
    """Return the closed loops from tick to tick, M and N of s' = M s + N r.

    State: plant (12), filtered measurements (3), sums of errors (3), commands left at rest where
    a loop is not among ``closed``; those keep no state. ``r`` (3,) are the references.
    """
    n, k = len(plant.f), len(closed)
    tau = np.array([plant.filters_s[i] for i in closed])
    keep, take = tau / (TICK_S + tau), TICK_S / (TICK_S + tau)
    gain, zero = np.array([loops[i] for i in closed]).T
    h, g = plant.h[list(closed)], plant.g[:, list(closed)]
    # y, q: filtered measurement and sum of errors at this tick, from the state before it.
    y = np.hstack([take[:, None] * h, np.diag(keep), np.zeros((k, k))])
    q = np.hstack([np.zeros((k, n + k)), np.eye(k)]) - TICK_S * y
    u = gain[:, None] * (q - zero[:, None] * y)
    u_r = np.diag(gain * (zero + TICK_S))
    plant_row = np.hstack([plant.f, np.zeros((n, 2 * k))]) + g @ u
    return np.vstack([plant_row, y, q]), np.vstack([g @ u_r, np.zeros((k, k)), TICK_S * np.eye(k)])


def modulus(plant: SampledPlant, loops: Sequence[Pi], closed: Sequence[int] = (T, L1, L2)) -> float:
    """Return the largest modulus of the closed loops' poles: below 1, they are stable."""
    return float(np.abs(np.linalg.eigvals(closed_loop_matrices(plant, loops, closed)[0])).max())


def sampled_step(
    plant: SampledPlant, loops: Sequence[Pi], loop: int, seconds: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return times [s] and the response of ``loop`` to a unit step of its reference, all closed.

    The output is the measurement before its filter; it is NaN once a state exceeds ``DIVERGED``.
    """
    m, n = closed_loop_matrices(plant, loops)
    count = round(seconds / TICK_S)
    state, y = np.zeros(len(m)), np.full(count, np.nan)
    for i in range(count):
        if not state @ state < DIVERGED**2:
            break
        y[i] = plant.h[loop] @ state[: len(plant.f)]
        state = m @ state + n[:, loop]
    return TICK_S * np.arange(count), y
