"""Valves, oil and leaks of the hidden plants. Each law is neutral where its amounts are 0."""

from math import copysign, exp, pi, sin, sqrt

from hbench.model.compiled import inlined
from hbench.model.effects.couplings import ChamberFlows, OilProperties, Openings
from hbench.model.states import P_LP, P_LR, P_S, P_TP, P_TR, SPOOL_T, V, X


@inlined
def power(p, at, exponent):
    """(p / at)^exponent with the sign of p, smooth within 1 bar of 0."""
    bar = 1e5 / at
    r = p / at
    return r * (r * r + bar * bar) ** (0.5 * (exponent - 1.0))


@inlined
def second_order(y, u, rates, state, at, time, damping):
    """Write the rates of an opening y that follows u with two poles; return y."""
    omega = 2.0 * damping / time
    rates[at] = state[at + 1]
    rates[at + 1] = omega * (omega * (u - state[at]) - 2.0 * damping * state[at + 1])
    return state[at]


def valve_lag(u, c, state, at, rates, par):
    """Pilot stage of second order; its delay is ``time`` at low frequency."""
    time, damping = c
    if time == 0.0:
        for i in range(6):
            rates[at + i] = 0.0
        return u
    return Openings(
        second_order(u.test, u.test, rates, state, at, time, damping),
        second_order(u.load_1, u.load_1, rates, state, at + 2, time, damping),
        second_order(u.load_2, u.load_2, rates, state, at + 4, time, damping),
    )


@inlined
def soft_lap(u, width):
    """Opening of a spool with rounded edges: a hyperbola that ends ``width`` below u."""
    return copysign(sqrt(u * u + width * width) - width, u)


@inlined
def follow(y, u, width, rates, at):
    """A spool that friction holds with +-``width`` against a spring, and that creeps within it."""
    ahead = abs(u - y) / width if width > 0.0 else 2.0
    rates[at] = (u - y) / 2e-3 * min(max(0.0, ahead - 1.0) + 1e-4, 1.0)
    return u if width == 0.0 else y


def valve_hysteresis(u, c, state, at, rates, par):
    """Sticky spools: an opening depends on where it came from."""
    test, load = c
    if test == 0.0 and load == 0.0:
        rates[at] = rates[at + 1] = rates[at + 2] = 0.0
        return u
    return Openings(
        follow(state[at], u.test, test, rates, at),
        follow(state[at + 1], u.load_1, load, rates, at + 1),
        follow(state[at + 2], u.load_2, load, rates, at + 2),
    )


def valve_deadband(u, c, state, at, rates, par):
    test, load = c
    return Openings(soft_lap(u.test, test), soft_lap(u.load_1, load), soft_lap(u.load_2, load))


@inlined
def uneven(u, share, knee):
    """An even part that grows with the square of small openings, then in proportion."""
    return u + share * u * u / sqrt(u * u + knee * knee)


def valve_asymmetry(u, c, state, at, rates, par):
    test, load, knee = c
    if test == 0.0 and load == 0.0:
        return u
    return Openings(
        uneven(u.test, test, knee), uneven(u.load_1, load, knee), uneven(u.load_2, load, knee)
    )


def valve_spread(u, c, state, at, rates, par):
    """Background: each valve has its own gain error g and null n [V], (1 + g) (u + n)."""
    test, load_1, load_2, null_test, null_1, null_2 = c
    return Openings(
        (1.0 + test) * (u.test + null_test),
        (1.0 + load_1) * (u.load_1 + null_1),
        (1.0 + load_2) * (u.load_2 + null_2),
    )


def gain_curvature(u, c, state, at, rates, par):
    """Background: the gain of every valve falls a little with its opening."""
    (share,) = c
    return Openings(
        u.test * (1.0 - share * min(abs(u.test) / 3.0, 1.0)),
        u.load_1 * (1.0 - share * min(abs(u.load_1) / 3.0, 1.0)),
        u.load_2 * (1.0 - share * min(abs(u.load_2) / 3.0, 1.0)),
    )


@inlined
def compliance(beta, p, fraction, dissolved):
    """Bulk modulus with polytropic air, less and less of it free as the pressure rises."""
    absolute = 1.013e5 + max(p, 0.0)
    free = fraction * exp(-p / dissolved) * (1.013e5 / absolute) ** (1.0 / 1.3)
    return 1.0 / (1.0 / beta + free / (1.3 * absolute))


def entrained_air(oil, c, state, at, rates, par):
    fraction, dissolved = c
    if fraction == 0.0:
        return oil
    return OilProperties(
        oil.tank_pa,
        compliance(oil.beta_tp, state[P_TP], fraction, dissolved),
        compliance(oil.beta_tr, state[P_TR], fraction, dissolved),
        compliance(oil.beta_lp, state[P_LP], fraction, dissolved),
        compliance(oil.beta_lr, state[P_LR], fraction, dissolved),
    )


@inlined
def through_port(q, p, p_supply, p_tank, transition):
    """Flow of a port whose edge is sharp for large drops alone: q sqrt(|dp| / (|dp| + p_t))."""
    drop = abs(p_supply - p if q > 0.0 else p - p_tank)
    return q * sqrt(drop / (drop + transition))


def laminar_ports(q, c, state, at, rates, par):
    """Background: the valves' flow is laminar below a pressure drop, Q ~ dp / sqrt(|dp| + p_t)."""
    (transition,) = c
    if transition == 0.0:
        return q
    p_s, p_t = state[P_S], par.supply.tank_pa
    tp = through_port(q.tp, state[P_TP], p_s, p_t, transition)
    tr = through_port(q.tr, state[P_TR], p_s, p_t, transition)
    lp = through_port(q.lp, state[P_LP], p_s, p_t, transition)
    lr = through_port(q.lr, state[P_LR], p_s, p_t, transition)
    drawn = max(tp, 0.0) + max(tr, 0.0) + max(lp, 0.0) + max(lr, 0.0)
    return ChamberFlows(tp, tr, lp, lr, drawn, drawn - (tp + tr + lp + lr), q.fluidity)


@inlined
def past_lands(p, u, p_s, p_t, conductance, overlap):
    """Leaks of a port from the supply and to the tank: laminar, largest at the spool's null."""
    gap = conductance * overlap / (overlap + abs(u))
    return gap * (p_s - p), gap * (p - p_t)


def spool_leak(q, c, state, at, rates, par):
    """Radial clearance of the spools, a gap along each land."""
    conductance, overlap = c
    if conductance == 0.0:
        return q
    p_s, p_t = state[P_S], par.supply.tank_pa
    u_t, u_1, u_2 = state[SPOOL_T], state[SPOOL_T + 1], state[SPOOL_T + 2]
    tp, from_tp = past_lands(state[P_TP], u_t, p_s, p_t, conductance, overlap)
    tr, from_tr = past_lands(state[P_TR], u_t, p_s, p_t, conductance, overlap)
    lp, from_lp = past_lands(state[P_LP], u_2, p_s, p_t, conductance, overlap)
    lr, from_lr = past_lands(state[P_LR], u_1, p_s, p_t, conductance, overlap)
    return ChamberFlows(
        q.tp + tp - from_tp, q.tr + tr - from_tr, q.lp + lp - from_lp, q.lr + lr - from_lr,
        q.drawn + tp + tr + lp + lr, q.returned + from_tp + from_tr + from_lp + from_lr,
        q.fluidity,
    )  # fmt: skip


def raised_tank(oil, c, state, at, rates, par):
    return OilProperties(
        oil.tank_pa + state[at], oil.beta_tp, oil.beta_tr, oil.beta_lp, oil.beta_lr
    )


def laminar_return(q, c, state, at, rates, par):
    """A long thin return line: its pressure is in proportion to the flow."""
    resistance, lag = c
    rates[at] = 0.0
    if resistance != 0.0:
        rates[at] = (resistance * q.returned - state[at]) / lag
    return q


def supply_droop(q, c, state, at, rates, par):
    """Supply pressure falls with the square of the flow drawn, as behind a filter."""
    slope, lag = c
    if slope != 0.0:
        rates[P_S] = (par.supply.pressure_pa - slope * q.drawn * q.drawn - state[P_S]) / lag
    return q


@inlined
def exchanged(q, test, load):
    """Flows with what leaves the piston side for the rod side."""
    return ChamberFlows(
        q.tp - test, q.tr + test, q.lp - load, q.lr + load, q.drawn, q.returned, q.fluidity
    )


def internal_leakage(q, c, state, at, rates, par):
    """A scratch in the seal, not laminar."""
    test, load, exponent = c
    if test == 0.0 and load == 0.0:
        return q
    return exchanged(
        q,
        test * power(state[P_TP] - state[P_TR], 30e5, exponent),
        load * power(state[P_LP] - state[P_LR], 30e5, exponent),
    )


def external_leakage(q, c, state, at, rates, par):
    """A gap that the pressure widens."""
    tp, tr, lp, lr, exponent = c
    if tp == 0.0 and tr == 0.0 and lp == 0.0 and lr == 0.0:
        return q
    return ChamberFlows(
        q.tp - tp * power(state[P_TP], 50e5, exponent),
        q.tr - tr * power(state[P_TR], 50e5, exponent),
        q.lp - lp * power(state[P_LP], 50e5, exponent),
        q.lr - lr * power(state[P_LR], 50e5, exponent),
        q.drawn, q.returned, q.fluidity,
    )  # fmt: skip


# ---- what the catalogue does not have


def flow_force(u, c, state, at, rates, par):
    """Flow forces close the test valve in proportion to its pressure drop."""
    (share,) = c
    if share == 0.0:
        return u
    drop = 1.5e7 - copysign(state[P_TP] - state[P_TR], u.test)
    return Openings(u.test * (1.0 - share * drop / 1.5e7), u.load_1, u.load_2)


def position_error(q, c, state, at, rates, par):
    """A position sensor that is not straight: the piston goes (1 + e) times what it shows."""
    bow, wave, period = c
    if bow == 0.0 and wave == 0.0:
        return q
    s = 2.0 * state[X] / par.test.stroke_m - 1.0
    more = state[V] * (bow * s + wave * sin(2.0 * pi * state[X] / period))
    test, load = par.test, par.load
    return ChamberFlows(
        q.tp - test.area_piston_m2 * more, q.tr + test.area_rod_m2 * more,
        q.lp + load.area_piston_m2 * more, q.lr - load.area_rod_m2 * more,
        q.drawn, q.returned, q.fluidity,
    )  # fmt: skip


def hose_volume(q, c, state, at, rates, par):
    """Hoses to the rod sides, each a volume behind a throttle: soft for what is slow alone."""
    tr, lr, time = c
    rates[at] = rates[at + 1] = 0.0
    if tr == 0.0 and lr == 0.0:
        return q
    rates[at] = (state[P_TR] - state[at]) / time
    rates[at + 1] = (state[P_LR] - state[at + 1]) / time
    beta = par.bulk_modulus_pa
    return ChamberFlows(
        q.tp, q.tr - tr / beta * rates[at], q.lp, q.lr - lr / beta * rates[at + 1],
        q.drawn, q.returned, q.fluidity,
    )  # fmt: skip


def worn_bore(q, c, state, at, rates, par):
    """The test cylinder's bore is worn at one place: it leaks there alone."""
    leak, middle, width = c
    if leak == 0.0:
        return q
    away = (state[X] - middle) / width
    return exchanged(q, leak * exp(-away * away) * (state[P_TP] - state[P_TR]) / 30e5, 0.0)
