"""Laws of the plant along a log: flows, friction and supply under the measured signals.

Position, velocity, pressures and commands are those of the log; only what no sensor shows is
integrated: spools, bristles, and the states of the effects. So a law is evaluated where the bench
was, whoever controlled it. A record is divided into steps of at most 1 ms, in which all signals
are parabolas with the record's mean, so that means of products such as u sqrt(dP) are correct.

The spool (2.16) follows the limited command by the exact solution of its equation over a step,
LuGre's bristles likewise. Other states take an exponential step, which no lag is too short for:
z -> z + r (exp(J h) - 1) / J, with the rate r and its derivative J by the state itself, at fixed
openings of the valves: moved with the other states, they would count as part of J. The laws have
the mean over the step.
"""

from functools import cache
from math import ceil
from typing import NamedTuple

import numpy as np

from hbench.model.compiled import compiled, inlined
from hbench.model.cylinders import extending_volumes, retracting_volumes
from hbench.model.effects.applied import flow_effects, friction_effects, oil, openings
from hbench.model.effects.couplings import ChamberFlows, OilProperties, Openings
from hbench.model.friction.laws import deflection_under, exact_step
from hbench.model.friction.parabola import parabola, value_at
from hbench.model.parameters import PlantParameters, ValveParameters
from hbench.model.plant import n_states, valve_flows
from hbench.model.states import P_LP, P_LR, P_S, P_TP, P_TR, SPOOL_T, V, X, bristles_end
from hbench.model.valves import clamp
from hbench.parallel.process_pool import usable_cores
from hbench.parallel.threads import map_on_threads

STEP_S = 1e-3  # at most
SIGNALS = 10  # x, v, P_Tp, P_Tr, P_Lp, P_Lr, P_s, u_T, u_L1, u_L2
_SUPPLY, _COMMANDS = 6, 7
_NUDGE = 1e-6  # of a state, for J


class AlongLog(NamedTuple):
    """Means over each record of a log of n records, for the chambers Tp, Tr, Lp, Lr."""

    per_volume: np.ndarray  # (4, n) Q / V [1/s]
    log_volume: np.ndarray  # (4, n) ln(V / 1 m^3) at the mean position
    compression: np.ndarray  # (4, n) integral of dP / beta since the start [1]
    drawn: np.ndarray  # (n,) flow from the supply line [m^3/s]
    supply_pa: np.ndarray  # (n,) supply pressure of a source without pump
    friction_test: np.ndarray  # (n,) N
    friction_load: np.ndarray  # (n,) N


class Starts(NamedTuple):
    """What the logs start with, r of them end to end."""

    edges: np.ndarray  # (r + 1,) first record of each log, and the number of records
    friction_n: np.ndarray  # (r, 2) measured, of the test and the load cylinder
    states: np.ndarray  # (r, s) of the effects
    builds_up: np.ndarray  # (s,) states that go on from one log to the next, but for the first

    def divided(self, most: int) -> "list[Starts]":
        """Return the starts of up to ``most`` parts of similar length, if no state builds up."""
        if self.builds_up.any():
            return [self]
        shares = np.linspace(self.edges[0], self.edges[-1], most + 1)
        at = np.unique(np.searchsorted(self.edges, shares))
        return [
            Starts(self.edges[i : j + 1], self.friction_n[i:j], self.states[i:j], self.builds_up)
            for i, j in zip(at[:-1], at[1:], strict=True)
        ]


def single_start(records: int, par: PlantParameters) -> Starts:
    """Return the start of a single log without friction, with the effects' states at 0."""
    states = n_states(par) - bristles_end(par)
    none = np.zeros(states)
    return Starts(np.array([0, records]), np.zeros((1, 2)), none[None], none.astype(bool))


def along(
    signals: np.ndarray,
    dt_s: float,
    par: PlantParameters,
    starts: Starts,
    levels: np.ndarray,
    step_s: float = STEP_S,
) -> AlongLog:
    """Return the means along logs of n records in all, on all cores.

    ``signals`` (10, n) are x, v, four chamber pressures, supply pressure and three commands in SI;
    ``levels`` (2, n), or (2, 1), are those of dry friction. Spools start at rest at their first
    command, bristles with the measured friction less what the effects add to it.
    """
    steps = max(1, ceil(dt_s / step_s - 1e-9))
    h = dt_s / steps
    elements = len(par.test.friction.elements), len(par.load.friction.elements)
    transition, out = _spool_step(par.valve, h), np.zeros((12, signals.shape[1]))
    levels = np.ascontiguousarray(np.broadcast_to(levels, (2, signals.shape[1])))

    def integrate(part: Starts) -> None:
        z = [np.zeros(2 * count) for count in elements]
        work = [np.zeros((2, 2 * count)) for count in elements]
        scratch = np.zeros((4, n_states(par))), np.zeros((3, 2)), np.zeros((SIGNALS, 3))
        _integrate_logs(signals, h, steps, transition, par, levels, *part, *z, *work, *scratch, out)

    map_on_threads(integrate, starts.divided(usable_cores()))
    volumes = (*extending_volumes(signals[X], par.test), *retracting_volumes(signals[X], par.load))
    return AlongLog(out[:4], np.log(volumes), out[4:8], *out[8:])


@cache
def _spool_step(valve: ValveParameters, h: float) -> np.ndarray:
    """Return the transition matrix (2, 2) of the spool over ``h`` [s] at a constant command.

    Its states are the position less the command, and the rate.
    """
    from scipy.linalg import expm

    omega = valve.natural_frequency_rad_s
    return expm(h * np.array([[0.0, 1.0], [-(omega**2), -2 * valve.damping * omega]]))


class _Laws(NamedTuple):
    """What the laws say at one moment."""

    flows: ChamberFlows
    fluid: OilProperties
    friction: tuple[float, float, float, float]  # levels of both cylinders, forces to add


@inlined
def _laws(
    opened: Openings,
    supply: float,
    state: np.ndarray,
    par: PlantParameters,
    level_t: float,
    level_l: float,
    rates: np.ndarray,
) -> _Laws:
    """Evaluate the laws behind the valves' openings; write the rates of their states.

    Valves have the measured supply pressure in ``state``, the source its own, ``supply``.
    """
    measured, rates[P_S] = state[P_S], 0.0
    fluid = oil(state, par, par.effects, rates)
    q = valve_flows(state, opened, fluid.tank_pa, par)
    friction = friction_effects(level_t, level_l, state, par, par.effects, rates)
    state[P_S] = supply
    q = flow_effects(q, state, par, par.effects, rates)
    state[P_S] = measured
    return _Laws(q, fluid, friction)


@compiled
def _integrate_logs(
    signals: np.ndarray,
    h: float,
    steps: int,
    a: np.ndarray,
    par: "PlantParameters",
    levels: np.ndarray,
    edges: np.ndarray,
    friction_n: np.ndarray,
    states: np.ndarray,
    builds_up: np.ndarray,
    z_t: np.ndarray,
    z_l: np.ndarray,
    work_t: np.ndarray,
    work_l: np.ndarray,
    scratch: np.ndarray,
    spools: np.ndarray,
    curves: np.ndarray,
    out: np.ndarray,
) -> None:
    state, first = scratch[3], bristles_end(par)
    for r in range(len(edges) - 1):
        start, stop = edges[r], edges[r + 1]
        for j in range(first):
            state[j] = signals[j, start] if j < 6 else 0.0
        for j in range(first, len(state)):
            if r == 0 or not builds_up[j - first]:
                state[j] = states[r, j - first]
        for j in range(3):
            spools[j, 0] = clamp(signals[_COMMANDS + j, start], par.valve.limit_v)
            spools[j, 1] = 0.0
        _, _, more_t, more_l = friction_effects(
            levels[0, start], levels[1, start], state, par, par.effects, scratch[0]
        )
        v = signals[V, start]
        z_t[:], z_l[:] = 0.0, 0.0
        z_t[0] = deflection_under(friction_n[r, 0] - more_t, v, par.test.friction)
        z_l[0] = deflection_under(friction_n[r, 1] - more_l, v, par.load.friction)
        _integrate(
            signals, start, stop, h, steps, a, par, levels, state, spools, z_t, z_l, work_t, work_l,
            scratch, curves, out,
        )  # fmt: skip


@inlined
def _integrate(
    signals: np.ndarray,
    start: int,
    stop: int,
    h: float,
    steps: int,
    a: np.ndarray,
    par: "PlantParameters",
    levels: np.ndarray,
    state: np.ndarray,
    spools: np.ndarray,
    z_t: np.ndarray,
    z_l: np.ndarray,
    work_t: np.ndarray,
    work_l: np.ndarray,
    scratch: np.ndarray,
    curves: np.ndarray,
    out: np.ndarray,
) -> None:
    first, end = bristles_end(par), len(state)
    rates, slopes, others = scratch[0], scratch[1], scratch[2]
    supply, share = par.supply.pressure_pa, 1.0 / steps
    c_tp, c_tr, c_lp, c_lr = 0.0, 0.0, 0.0, 0.0
    o_tp, o_tr, o_lp, o_lr = (
        signals[P_TP, start], signals[P_TR, start], signals[P_LP, start], signals[P_LR, start]
    )  # fmt: skip
    for k in range(start, stop):
        before, after = max(k - 1, start), min(k + 1, stop - 1)
        for j in range(len(curves)):
            curves[j, 0], curves[j, 1], curves[j, 2] = parabola(
                signals[j, before], signals[j, k], signals[j, after]
            )
        for i in range(steps):
            s = (i + 0.5) * share
            for j in range(6):
                state[j] = value_at(curves[j], s)
            state[P_S] = value_at(curves[_SUPPLY], s)
            for j in range(3):
                command = clamp(value_at(curves[_COMMANDS + j], s), par.valve.limit_v)
                off, rate = spools[j, 0] - command, spools[j, 1]
                spools[j, 0] = command + a[0, 0] * off + a[0, 1] * rate
                spools[j, 1] = a[1, 0] * off + a[1, 1] * rate
                state[SPOOL_T + j] = 0.5 * (off + command + spools[j, 0])
            opened = openings(state, par, par.effects, rates)
            q, fluid, friction = _laws(
                opened, supply, state, par, levels[0, k], levels[1, k], rates
            )
            if i == 0:  # slopes of the rates, from a small step of all own states
                moving = False
                for j in range(first, end):
                    slopes[j] = _NUDGE * max(1.0, abs(state[j]))
                    state[j] += slopes[j]
                step = _NUDGE * supply
                openings(state, par, par.effects, others)  # their rates; the laws keep ``opened``
                _laws(opened, supply + step, state, par, levels[0, k], levels[1, k], others)
                for j in range(first, end):
                    state[j] -= slopes[j]
                    slopes[j] = (others[j] - rates[j]) / slopes[j]
                    moving = moving or slopes[j] != 0.0 or rates[j] != 0.0
                slopes[P_S] = (others[P_S] - rates[P_S]) / step
                moving = moving or slopes[P_S] != 0.0
            mean = supply
            if moving:  # the laws have the means of the states, as of the signals
                mean += _mean_change(rates[P_S], slopes[P_S], h)
                for j in range(first, end):
                    state[j] += _mean_change(rates[j], slopes[j], h)
                opened = openings(state, par, par.effects, others)
                q, fluid, friction = _laws(
                    opened, mean, state, par, levels[0, k], levels[1, k], others
                )
            level_t, level_l, more_t, more_l = friction
            v, p_tp, p_tr, p_lp, p_lr = state[V], state[P_TP], state[P_TR], state[P_LP], state[P_LR]
            f_t = exact_step(v, z_t, p_tp, p_tr, level_t, h, par.test.friction, work_t) + more_t
            f_l = exact_step(v, z_l, p_lp, p_lr, level_l, h, par.load.friction, work_l) + more_l
            c_tp += (p_tp - o_tp) / fluid.beta_tp
            c_tr += (p_tr - o_tr) / fluid.beta_tr
            c_lp += (p_lp - o_lp) / fluid.beta_lp
            c_lr += (p_lr - o_lr) / fluid.beta_lr
            o_tp, o_tr, o_lp, o_lr = p_tp, p_tr, p_lp, p_lr
            v_tp, v_tr = extending_volumes(state[X], par.test)
            v_lp, v_lr = retracting_volumes(state[X], par.load)
            out[0, k] += share * q.tp / v_tp
            out[1, k] += share * q.tr / v_tr
            out[2, k] += share * q.lp / v_lp
            out[3, k] += share * q.lr / v_lr
            out[4, k] += share * c_tp
            out[5, k] += share * c_tr
            out[6, k] += share * c_lp
            out[7, k] += share * c_lr
            out[8, k] += share * q.drawn
            out[9, k] += share * mean
            out[10, k] += share * f_t
            out[11, k] += share * f_l
            if moving:
                supply = mean + _change_from_mean(rates[P_S], slopes[P_S], h)
                for j in range(first, end):
                    state[j] += _change_from_mean(rates[j], slopes[j], h)


@inlined
def _mean_change(rate: float, slope: float, h: float) -> float:
    """Return the mean over ``h`` of a state's change in an exponential step.

    r h (exp(x) - 1 - x) / x^2, x = J h. With it a lag of any length, also one far shorter than a
    step, delays a ramp by itself.
    """
    x = slope * h
    if abs(x) < 1e-3:
        return rate * h * (0.5 + x / 6.0)
    return rate * h * (np.expm1(x) - x) / (x * x)


@inlined
def _change_from_mean(rate: float, slope: float, h: float) -> float:
    """Return the difference between a state at the end of an exponential step and its mean."""
    x = slope * h
    change = rate * h * (1.0 + 0.5 * x) if abs(x) < 1e-6 else rate * np.expm1(x) / slope
    return change - _mean_change(rate, slope, h)
