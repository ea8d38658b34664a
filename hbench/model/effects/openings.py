"""Effects of the valves' openings; see ``catalogue.py`` for how a law is called.

Each is neutral, to the bit, where its coefficient is 0.
"""

from math import copysign

import numpy as np

from hbench.model.compiled import inlined
from hbench.model.effects.couplings import Coefficients, Openings
from hbench.model.effects.shapes import soft_edge
from hbench.model.parameters import PlantParameters
from hbench.model.valves import clamp

LEAST_LAG_S = 5e-5  # that the steps of the virtual rig, of 0.1 ms, can follow
_DRIVES_S = 1e-3  # in which a spool beyond its play is driven; its opening follows at once
SMALL_OPENING_V = 2.0  # a fifth of a valve's stroke


def valve_trim(
    u: Openings, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> Openings:  # fmt: skip
    """Valves of one type are not equal: u (1 + g + k |u|) + u_0. c: g [1], then u_0 [V], of T, L1,
    L2, the curvature k [1/V] and the kink s [1] of all, and six coefficients for
    ``flows.uneven_ports``.

    g is the deviation from the gain of the bench file, u_0 the null bias. Within 2 V the slope is
    lower by s: a spool's edges have notches or a radius for fine control.
    """
    g_t, g_1, g_2, null_t, null_1, null_2, k, kink, _, _, _, _, _, _ = c
    return Openings(
        trimmed(u.test, g_t, null_t, k, kink),
        trimmed(u.load_1, g_1, null_1, k, kink),
        trimmed(u.load_2, g_2, null_2, k, kink),
    )


@inlined
def trimmed(u: float, gain: float, null: float, curvature: float, kink: float) -> float:
    """Opening [V] of one valve; u itself, to the bit, where all is 0."""
    small = max(-SMALL_OPENING_V, min(u, SMALL_OPENING_V))
    return u + (gain + curvature * abs(u)) * u + null - kink * small


def valve_lag(
    u: Openings, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> Openings:  # fmt: skip
    """Lag of each opening behind its spool of 2.16: tau dy/dt = u - y. c: tau [s], and a share s.

    A pilot stage slower than the data sheet (Merritt, Hydraulic Control Systems, 1967, ch. 7). A
    share other than 0 divides tau into two lags in a row, (1 - s) tau and s tau: the response then
    begins slowly, as that of a stage of second order or behind a dead time. Their parallel form
    (partial fractions) has the two as states that are independent of each other.
    """
    tau, share = c
    if tau == 0.0:
        for i in range(6):
            rates[at + i] = 0.0
        return u
    weight = share / (1.0 - 2.0 * share)
    return Openings(
        lagging(u.test, tau, share, weight, state, at, rates),
        lagging(u.load_1, tau, share, weight, state, at + 1, rates),
        lagging(u.load_2, tau, share, weight, state, at + 2, rates),
    )


@inlined
def lagging(
    u: float, tau: float, share: float, weight: float, state: np.ndarray, at: int, rates: np.ndarray
) -> float:
    """Opening [V] of one valve; its slower lag is the state ``at``, its faster one three on."""
    slow, fast = state[at], state[at + 3]
    rates[at] = (u - slow) / ((1.0 - share) * tau)
    if share == 0.0:
        rates[at + 3] = 0.0
        return slow
    rates[at + 3] = (u - fast) / max(share * tau, LEAST_LAG_S)
    return slow + weight * (slow - fast)


def valve_hysteresis(
    u: Openings, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> Openings:  # fmt: skip
    """Play between command and spool: its opening stays until u is w away. c: w [V] of the test
    valve and of both load valves, half the width of the loop.

    Friction of a spool without position feedback, or a worn linkage. The play operator of
    Krasnosel'skii and Pokrovskii (Systems with Hysteresis, 1989).
    """
    test, load = c
    return Openings(
        with_play(u.test, test, state, at, rates),
        with_play(u.load_1, load, state, at + 1, rates),
        with_play(u.load_2, load, state, at + 2, rates),
    )


@inlined
def with_play(u: float, width: float, state: np.ndarray, at: int, rates: np.ndarray) -> float:
    """Opening [V] of one valve; the state ``at`` is where the play's middle was last driven to."""
    if width == 0.0:
        rates[at] = 0.0
        return u
    ahead = u - state[at]
    inside = clamp(ahead, width)
    rates[at] = (ahead - inside) / _DRIVES_S
    return u - inside


@inlined
def overlapped(u: float, width: float, softness: float) -> float:
    """Opening [V] of a spool with overlap: u less ``width`` towards 0, and 0 within it.

    A worn or rounded edge opens softly; the opening is 0 at u = 0 and never larger than u. With
    underlap, a negative width, both edges are open in the middle: there the slope is 2, and far
    from it the opening is larger than u by the underlap. What leaks through both edges is added to
    the port's flow (``flows.through_underlap``).
    """
    if width == 0.0:
        return u
    if width < 0.0:
        return u - width * u / (abs(u) - width)
    soft = softness * width
    closed = soft_edge(-width, soft)
    return copysign(min(soft_edge(abs(u) - width, soft) - closed, abs(u)), u)


def valve_deadband(
    u: Openings, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> Openings:  # fmt: skip
    """Overlap: sign(u) max(|u| - w, 0). c: w [V] of the test valve and of both load valves, and
    the softness of the edge in parts of w.

    Merritt 1967, section 5.5 (closed-centre valves).
    """
    test, load, soft = c
    return Openings(
        overlapped(u.test, test, soft),
        overlapped(u.load_1, load, soft),
        overlapped(u.load_2, load, soft),
    )


@inlined
def uneven(u: float, share: float, knee: float) -> float:
    """Opening [V] with an even part: ``share`` of |u|, and less where |u| is below ``knee``."""
    size = abs(u)
    return u + share * size if knee == 0.0 else u + share * size * size / (size + knee)


def valve_asymmetry(
    u: Openings, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> Openings:  # fmt: skip
    """Unequal gain of the two directions: u (1 + k sign u). c: k [1] of the test valve and the mean
    of the load valves, then by how much L1 is above this mean and L2 below.

    A knee [V] other than 0 makes small openings more equal: k |u| / (|u| + knee).
    """
    test, load, apart, knee = c
    return Openings(
        uneven(u.test, test, knee),
        uneven(u.load_1, load + apart, knee),
        uneven(u.load_2, load - apart, knee),
    )
