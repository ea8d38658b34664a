"""Integration of the plant's laws over the records of logs, compiled; see ``along.py``.

The spool (2.16) follows the limited command by the exact solution of its equation over a step,
LuGre's bristles likewise. Other states take an exponential step, which no lag is too short for:
z -> z + r (exp(J h) - 1) / J, with the rate r and its derivative J by the state itself, at fixed
openings of the valves: moved with the other states, they would count as part of J. Short steps of
a record share J. The laws have the mean over the step.
"""

from typing import NamedTuple

import numpy as np

from hbench.model.compiled import compiled, inlined
from hbench.model.cylinders import extending_volumes, retracting_volumes
from hbench.model.effects.applied import flow_effects, friction_effects, oil, openings
from hbench.model.effects.couplings import ChamberFlows, OilProperties, Openings
from hbench.model.friction.laws import deflection_under, exact_step
from hbench.model.friction.parabola import parabola, value_at
from hbench.model.parameters import PlantParameters
from hbench.model.plant import n_states, valve_flows
from hbench.model.states import P_LP, P_LR, P_S, P_TP, P_TR, SPOOL_T, V, X, bristles_end
from hbench.model.valves import clamp

SIGNALS = 10  # x, v, P_Tp, P_Tr, P_Lp, P_Lr, P_s, u_T, u_L1, u_L2
_SUPPLY, _COMMANDS = 6, 7
# Rows of the means, as in ``AlongLog``; flows and compression have one for each chamber.
PER_VOLUME, COMPRESSION, DRAWN, SUPPLY_MEAN, FRICTION_T, FRICTION_L = 0, 4, 8, 9, 10, 11
MEANS = 12
_NUDGE = 1e-6  # of a state, for J
_SLOPES_LAST_S = 1.5e-3  # a play that begins to move in a longer step would go too far


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


class Logs(NamedTuple):
    """What the logs end to end show, of n records."""

    signals: np.ndarray  # (10, n)
    levels: np.ndarray  # (2, n) of dry friction


class Parts(NamedTuple):
    """Laws to evaluate: of flows with the supply, and of friction."""

    flows: bool = True
    friction: bool = True

    def both(self, other: "Parts") -> "Parts":
        """Return the laws that are in both."""
        return Parts(self.flows and other.flows, self.friction and other.friction)


class Step(NamedTuple):
    """Division of a record, and what is evaluated in it."""

    h_s: float
    per_record: int
    spool: np.ndarray  # (2, 2) transition of a spool over a step
    states_act: bool  # those of effects; else they keep their values
    supply_sags: bool  # of a source, which changes no flow: the valves have the measured pressure
    parts: Parts


class Work(NamedTuple):
    """What an integration changes."""

    state: np.ndarray  # (s,) of the plant
    rates: np.ndarray  # (s,)
    slopes: np.ndarray  # (s,) of the rates, each by its own state
    others: np.ndarray  # (s,) rates that are not needed
    spools: np.ndarray  # (3, 2) positions and rates
    curves: np.ndarray  # (10, 3) parabolas of the signals in a record
    z_t: np.ndarray  # bristles
    z_l: np.ndarray
    bristles_t: np.ndarray  # memory of their step
    bristles_l: np.ndarray


def new_work(par: PlantParameters) -> Work:
    """Return the memory of an integration, so that it allocates nothing."""
    state, rates, slopes, others = np.zeros((4, n_states(par)))
    spools, curves = np.zeros((3, 2)), np.zeros((SIGNALS, 3))
    z_t, z_l = (np.zeros(2 * len(each.friction.elements)) for each in (par.test, par.load))
    bristles_t, bristles_l = (np.zeros((2, len(each))) for each in (z_t, z_l))
    return Work(state, rates, slopes, others, spools, curves, z_t, z_l, bristles_t, bristles_l)


_NO_FLOWS = ChamberFlows(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
_NO_OIL = OilProperties(0.0, np.inf, np.inf, np.inf, np.inf)
_CLOSED = Openings(0.0, 0.0, 0.0)


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
    parts: Parts,
    level_t: float,
    level_l: float,
    rates: np.ndarray,
) -> _Laws:
    """Evaluate the laws behind the valves' openings; write the rates of their states.

    Valves have the measured supply pressure in ``state``, the source its own, ``supply``.
    """
    rates[P_S] = 0.0
    fluid, q, friction = _NO_OIL, _NO_FLOWS, (level_t, level_l, 0.0, 0.0)
    if parts.friction:
        friction = friction_effects(level_t, level_l, state, par, par.effects, rates)
    if parts.flows:
        measured = state[P_S]
        fluid = oil(state, par, par.effects, rates)
        q = valve_flows(state, opened, fluid.tank_pa, par, rates)
        state[P_S] = supply
        q = flow_effects(q, state, par, par.effects, rates)
        state[P_S] = measured
    return _Laws(q, fluid, friction)


@compiled
def integrate_logs(
    logs: Logs,
    step: Step,
    par: "PlantParameters",
    starts: Starts,
    work: Work,
    out: np.ndarray,
) -> None:
    """Write the means over the records of logs, rows of ``out`` (12, n)."""
    state, first = work.state, bristles_end(par)
    for r in range(len(starts.edges) - 1):
        start, stop = starts.edges[r], starts.edges[r + 1]
        for j in range(first):
            state[j] = logs.signals[j, start] if j < 6 else 0.0
        for j in range(first, len(state)):
            if r == 0 or not starts.builds_up[j - first]:
                state[j] = starts.states[r, j - first]
        for j in range(3):
            work.spools[j, 0] = clamp(logs.signals[_COMMANDS + j, start], par.valve.limit_v)
            work.spools[j, 1] = 0.0
        _, _, more_t, more_l = friction_effects(
            logs.levels[0, start], logs.levels[1, start], state, par, par.effects, work.rates
        )
        v, (on_test, on_load) = logs.signals[V, start], starts.friction_n[r]
        work.z_t[:], work.z_l[:] = 0.0, 0.0
        work.z_t[0] = deflection_under(on_test - more_t, v, par.test.friction)
        work.z_l[0] = deflection_under(on_load - more_l, v, par.load.friction)
        _integrate(logs, start, stop, step, par, work, out)


@inlined
def _integrate(
    logs: Logs,
    start: int,
    stop: int,
    step: Step,
    par: "PlantParameters",
    work: Work,
    out: np.ndarray,
) -> None:
    """Write the means over the records from ``start`` to ``stop``, one log."""
    signals, state, rates, slopes = logs.signals, work.state, work.rates, work.slopes
    first, h, parts, opened = bristles_end(par), step.h_s, step.parts, _CLOSED
    supply, share = par.supply.pressure_pa, 1.0 / step.per_record
    c_tp, c_tr, c_lp, c_lr = 0.0, 0.0, 0.0, 0.0
    o_tp, o_tr, o_lp, o_lr = (
        signals[P_TP, start], signals[P_TR, start], signals[P_LP, start], signals[P_LR, start]
    )  # fmt: skip
    for k in range(start, stop):
        level_t, level_l = logs.levels[0, k], logs.levels[1, k]
        before, after = max(k - 1, start), min(k + 1, stop - 1)
        for j in range(SIGNALS):
            a, b, c = parabola(signals[j, before], signals[j, k], signals[j, after])
            work.curves[j, 0], work.curves[j, 1], work.curves[j, 2] = a, b, c
        for i in range(step.per_record):
            _move_to((i + 0.5) * share, step, par, work)
            if parts.flows:
                opened = openings(state, par, par.effects, rates)
            q, fluid, friction = _laws(opened, supply, state, par, parts, level_t, level_l, rates)
            if i == 0 or h > _SLOPES_LAST_S:
                if step.states_act or (step.supply_sags and k == start):
                    _find_slopes(opened, supply, par, parts, level_t, level_l, work)
            moving = (step.states_act or step.supply_sags) and _moves(first, rates, slopes)
            mean = supply
            if moving:
                mean += _mean_change(rates[P_S], slopes[P_S], h)
            if moving and step.states_act:  # the laws have their means, as of the signals
                for j in range(first, len(state)):
                    state[j] += _mean_change(rates[j], slopes[j], h)
                if parts.flows:
                    opened = openings(state, par, par.effects, work.others)
                q, fluid, friction = _laws(
                    opened, mean, state, par, parts, level_t, level_l, work.others
                )
            v, p_tp, p_tr, p_lp, p_lr = state[V], state[P_TP], state[P_TR], state[P_LP], state[P_LR]
            out[SUPPLY_MEAN, k] += share * mean
            if parts.friction:
                of_t, of_l, f_t, f_l = friction
                law_t, law_l = par.test.friction, par.load.friction
                f_t += exact_step(v, work.z_t, p_tp, p_tr, of_t, h, law_t, work.bristles_t)
                f_l += exact_step(v, work.z_l, p_lp, p_lr, of_l, h, law_l, work.bristles_l)
                out[FRICTION_T, k] += share * f_t
                out[FRICTION_L, k] += share * f_l
            if parts.flows:
                c_tp += (p_tp - o_tp) / fluid.beta_tp
                c_tr += (p_tr - o_tr) / fluid.beta_tr
                c_lp += (p_lp - o_lp) / fluid.beta_lp
                c_lr += (p_lr - o_lr) / fluid.beta_lr
                o_tp, o_tr, o_lp, o_lr = p_tp, p_tr, p_lp, p_lr
                v_tp, v_tr = extending_volumes(state[X], par.test)
                v_lp, v_lr = retracting_volumes(state[X], par.load)
                out[PER_VOLUME, k] += share * q.tp / v_tp
                out[PER_VOLUME + 1, k] += share * q.tr / v_tr
                out[PER_VOLUME + 2, k] += share * q.lp / v_lp
                out[PER_VOLUME + 3, k] += share * q.lr / v_lr
                out[COMPRESSION, k] += share * c_tp
                out[COMPRESSION + 1, k] += share * c_tr
                out[COMPRESSION + 2, k] += share * c_lp
                out[COMPRESSION + 3, k] += share * c_lr
                out[DRAWN, k] += share * q.drawn
            if moving:
                supply = mean + _change_from_mean(rates[P_S], slopes[P_S], h)
            if moving and step.states_act:
                for j in range(first, len(state)):
                    state[j] += _change_from_mean(rates[j], slopes[j], h)


@inlined
def _move_to(s: float, step: Step, par: "PlantParameters", work: Work) -> None:
    """Give the state the signals at the part ``s`` of a record, and the spools' means of a step."""
    for j in range(6):
        work.state[j] = value_at(work.curves[j], s)
    work.state[P_S] = value_at(work.curves[_SUPPLY], s)
    a = step.spool
    for j in range(3):
        command = clamp(value_at(work.curves[_COMMANDS + j], s), par.valve.limit_v)
        off, rate = work.spools[j, 0] - command, work.spools[j, 1]
        work.spools[j, 0] = command + a[0, 0] * off + a[0, 1] * rate
        work.spools[j, 1] = a[1, 0] * off + a[1, 1] * rate
        work.state[SPOOL_T + j] = 0.5 * (off + command + work.spools[j, 0])


@inlined
def _find_slopes(
    opened: Openings,
    supply: float,
    par: "PlantParameters",
    parts: Parts,
    level_t: float,
    level_l: float,
    work: Work,
) -> None:
    """Find the slope of each own state's rate by a small step of the state.

    One step of all together would do, but for openings: a play follows the lag before it.
    """
    state, rates, slopes, others = work.state, work.rates, work.slopes, work.others
    own = range(bristles_end(par), len(state))
    for j in own:
        slopes[j] = _NUDGE * max(1.0, abs(state[j]))
        state[j] += slopes[j]
    step = _NUDGE * supply
    if parts.flows:
        openings(state, par, par.effects, others)  # their rates; the laws keep ``opened``
    _laws(opened, supply + step, state, par, parts, level_t, level_l, others)
    for j in own:
        state[j] -= slopes[j]
    slopes[P_S] = (others[P_S] - rates[P_S]) / step
    for j in own:
        nudge = slopes[j]
        if parts.flows and (rates[j] != 0.0 or others[j] != 0.0):
            state[j] += nudge
            openings(state, par, par.effects, others)
            state[j] -= nudge
        slopes[j] = (others[j] - rates[j]) / nudge


@inlined
def _moves(first: int, rates: np.ndarray, slopes: np.ndarray) -> bool:
    """Return whether the supply or a state from ``first`` on moves."""
    moving = rates[P_S] != 0.0 or slopes[P_S] != 0.0
    for j in range(first, len(rates)):
        moving = moving or rates[j] != 0.0 or slopes[j] != 0.0
    return moving


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
