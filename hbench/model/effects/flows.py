"""Effects of ports, oil, leaks and lines; see ``catalogue.py`` for how a law is called.

Each is neutral, to the bit, where its coefficient is 0.
"""

from math import copysign, exp

import numpy as np

from hbench.model.compiled import inlined
from hbench.model.effects.couplings import ChamberFlows, Coefficients, OilProperties, PortFlows
from hbench.model.effects.shapes import power_law
from hbench.model.parameters import PlantParameters
from hbench.model.states import P_LP, P_LR, P_S, P_TP, P_TR
from hbench.model.valves import signed_root

FLOW_M3_S = 10e-3 / 60  # where laws with another exponent stay the same
PRESSURE_PA = 50e5
LEAST_DROP_PA = 1e3  # across a port
GAP_V = 0.3  # opening at which a closed edge leaks half as much as at null: assumed
ATMOSPHERE_PA = 1.013e5  # the plant's pressures are gauge pressures


def uneven_ports(
    flows: PortFlows, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> PortFlows:  # fmt: skip
    """Ports are no sharp orifices, not equal, and behind hoses; closed edges leak. c: see
    ``openings.valve_trim``; the last six are used here.

    Q grows with dP^(1/2 + n), the same at 50 bar: the edges of a real spool are rounded, and small
    drops laminar (Merritt 1967, section 3.4). The test valve's port to the piston side lets a share
    more through and the other one less, and its inlets a share more than its outlets. A hose takes
    R Q of the drop across its port. Both edges of a port leak through the clearance of the spool,
    as if open by l + l_0 / (1 + (u / w)^2): l is that of edges which are never closed, l_0 that of
    a gap which grows longer as the spool leaves its null.
    """
    n, ports, inlets, hose, leak, at_null = c[8], c[9], c[10], c[11], c[12], c[13]
    if n != 0.0 or ports != 0.0 or inlets != 0.0 or hose != 0.0:
        flows = _uneven(flows, n, ports, inlets, hose, state)
    if leak == 0.0 and at_null == 0.0:
        return flows
    test = leak + through_gap(flows.opened.test, at_null)
    load_1 = leak + through_gap(flows.opened.load_1, at_null)
    load_2 = leak + through_gap(flows.opened.load_2, at_null)
    return _with_leaks(flows, test, load_1, load_2, state, par)


@inlined
def through_gap(u: float, at_null: float) -> float:
    """Opening [V] as which the closed edges leak at the opening ``u``."""
    share = u / GAP_V
    return at_null / (1.0 + share * share)


@inlined
def _uneven(
    flows: PortFlows, n: float, ports: float, inlets: float, hose: float, state: np.ndarray
) -> PortFlows:
    q, opened, p_t = flows
    p_s = state[P_S]
    of_tp = 1.0 + ports + (inlets if q.tp > 0.0 else -inlets)
    of_tr = 1.0 - ports + (inlets if q.tr > 0.0 else -inlets)
    tp = port_flow_behind_hose(q.tp * of_tp, state[P_TP], p_s, p_t, n, hose)
    tr = port_flow_behind_hose(q.tr * of_tr, state[P_TR], p_s, p_t, n, hose)
    lp = port_flow_behind_hose(q.lp, state[P_LP], p_s, p_t, n, hose)
    lr = port_flow_behind_hose(q.lr, state[P_LR], p_s, p_t, n, hose)
    more = max(tp, 0.0) + max(tr, 0.0) + max(lp, 0.0) + max(lr, 0.0)
    more -= max(q.tp, 0.0) + max(q.tr, 0.0) + max(q.lp, 0.0) + max(q.lr, 0.0)
    total = (tp + tr + lp + lr) - (q.tp + q.tr + q.lp + q.lr)
    drawn, returned = q.drawn + more, q.returned + more - total
    q = ChamberFlows(tp, tr, lp, lr, drawn, returned, q.fluidity)
    return PortFlows(q, opened, p_t)


@inlined
def port_flow_behind_hose(
    q: float, p: float, p_supply: float, p_tank: float, n: float, hose: float
) -> float:
    """Flow of a port with the flow ``q`` of a sharp one, from the drop across it and its hose.

    The hose's share of the drop is that of a sharp port: Q^2 = q^2 (1 - R Q / dP).
    """
    drop = max(abs(p_supply - p if q > 0.0 else p - p_tank), LEAST_DROP_PA)
    q *= (drop / PRESSURE_PA) ** n
    lost = 0.5 * hose * abs(q) / drop
    return q * ((1.0 + lost * lost) ** 0.5 - lost)


def through_underlap(
    flows: PortFlows, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> PortFlows:  # fmt: skip
    """Flows of the edges that should be closed: null leakage of valves whose spools underlap.

    Both edges of a port are open, one by a and the other by b < a: a - b = |u|, the opening of
    ``openings.overlapped``, and a b = w^2. ``flows`` contain the flow of u. The law adds that of
    two edges which are both open by b: k b (root(P_s - P) - root(P - P_t)). It brings a port with
    closed valve towards (P_s + P_t) / 2. c: see ``openings.valve_deadband``.

    Merritt 1967, sections 5.3 and 5.4 (open centre, and leakage of the critical centre).
    """
    test, load, _ = c
    if test >= 0.0 and load >= 0.0:
        return flows
    opened = flows.opened
    of_test, of_load_1 = closing_edge(opened.test, test), closing_edge(opened.load_1, load)
    return _with_leaks(flows, of_test, of_load_1, closing_edge(opened.load_2, load), state, par)


@inlined
def _with_leaks(
    flows: PortFlows,
    test: float,
    load_1: float,
    load_2: float,
    state: np.ndarray,
    par: PlantParameters,
) -> PortFlows:
    """Flows of ports of which both edges are open further, by an opening [V] for each valve."""
    q, opened, p_t = flows
    p_s, gain = state[P_S], par.valve.flow_gain
    in_tp, out_tp = _across(gain * test, state[P_TP], p_s, p_t)
    in_tr, out_tr = _across(gain * test, state[P_TR], p_s, p_t)
    in_lp, out_lp = _across(gain * load_2, state[P_LP], p_s, p_t)
    in_lr, out_lr = _across(gain * load_1, state[P_LR], p_s, p_t)
    q = ChamberFlows(
        q.tp + in_tp - out_tp,
        q.tr + in_tr - out_tr,
        q.lp + in_lp - out_lp,
        q.lr + in_lr - out_lr,
        q.drawn + in_tp + in_tr + in_lp + in_lr,
        q.returned + out_tp + out_tr + out_lp + out_lr,
        q.fluidity,
    )
    return PortFlows(q, opened, p_t)


@inlined
def closing_edge(u: float, width: float) -> float:
    """Opening [V] of the smaller edge at the difference ``u`` of both; 0 where none underlaps."""
    if width >= 0.0:
        return 0.0
    return 2.0 * width * width / (abs(u) + (u * u + 4.0 * width * width) ** 0.5)


@inlined
def _across(k: float, p: float, p_supply: float, p_tank: float) -> tuple[float, float]:
    """Flows [m^3/s] from the supply into a port and from it into the tank, k both edges' gain."""
    return k * signed_root(p_supply - p), k * signed_root(p - p_tank)


@inlined
def with_air(beta: float, p: float, fraction: float) -> float:
    """Bulk modulus [Pa] of oil with free air: 1 / (1 / beta + alpha p_0 / (p_0 + p)^2).

    ``fraction`` alpha of the volume at atmospheric pressure p_0; isothermal. The air's volume is
    V alpha p_0 / (p_0 + p), its compliance minus the derivative (Merritt 1967, section 2.5;
    Wylie and Streeter, Fluid Transients, 1993, section 1.3).
    """
    if fraction == 0.0:
        return beta
    absolute = ATMOSPHERE_PA + max(p, 0.0)
    return 1.0 / (1.0 / beta + fraction * ATMOSPHERE_PA / (absolute * absolute))


def entrained_air(
    oil: OilProperties, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> OilProperties:  # fmt: skip
    """Softer oil at low pressure, in every chamber; see ``with_air``. c: alpha [1]."""
    (fraction,) = c
    return OilProperties(
        oil.tank_pa,
        with_air(oil.beta_tp, state[P_TP], fraction),
        with_air(oil.beta_tr, state[P_TR], fraction),
        with_air(oil.beta_lp, state[P_LP], fraction),
        with_air(oil.beta_lr, state[P_LR], fraction),
    )


def tank_back_pressure(
    oil: OilProperties, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> OilProperties:  # fmt: skip
    """Raise the tank pressure at the valves by the return line's, which is a state."""
    return OilProperties(
        oil.tank_pa + state[at], oil.beta_tp, oil.beta_tr, oil.beta_lp, oil.beta_lr
    )


def return_line(
    q: ChamberFlows, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> ChamberFlows:  # fmt: skip
    """Pressure p of the common return line: tau dp/dt = R Q |Q| - p, Q the valves' return flow.

    c: R [Pa s^2/m^6], turbulent (Merritt 1967, section 3.2), tau [s], of the line's hose, and
    an exponent other than 2: the same at 10 l/min.
    """
    resistance, tau, exponent = c
    if resistance == 0.0:
        rates[at] = 0.0
    else:
        flow = abs(q.returned)
        drop = resistance * flow * flow
        if exponent != 2.0 and flow > 0.0:
            drop *= (flow / FLOW_M3_S) ** (exponent - 2.0)
        rates[at] = (copysign(drop, q.returned) - state[at]) / tau
    return q


def supply_droop(
    q: ChamberFlows, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> ChamberFlows:  # fmt: skip
    """Supply pressure falls with the flow drawn: tau dP_s/dt = P_0 - k Q - P_s.

    c: k [Pa s/m^3], the regulation's slope, tau [s], and an exponent of Q other than 1: the same
    at 10 l/min. Instead of a constant supply; a pump (``model/supply.py``) has a slope of its own,
    and can't have this one.
    """
    slope, tau, exponent = c
    if slope != 0.0:
        fall = slope * power_law(q.drawn, FLOW_M3_S, exponent)
        rates[P_S] = (par.supply.pressure_pa - fall - state[P_S]) / tau
    return q


def warmth(
    q: ChamberFlows, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> ChamberFlows:  # fmt: skip
    """Oil warms by theta: tau d theta/dt = theta_0 + R P - theta; fluidity grows by exp(k theta).

    P = P_s Q drawn from the supply: all of it ends as heat. So does what the pump drives over its
    relief valve, whatever the bench draws: theta_0, from the session's start on. c: R [K/W],
    theta_0 [K], tau [s], k [1/K]; the exponential is that of Vogel and Barus near one temperature.
    Fluidity scales laminar leaks. A sensor in the tank shows ``oil.temperature`` + theta.
    """
    rise, pump, tau, k = c
    if rise == 0.0 and pump == 0.0:
        rates[at] = 0.0
        return q
    rates[at] = (pump + rise * state[P_S] * q.drawn - state[at]) / tau
    return ChamberFlows(q.tp, q.tr, q.lp, q.lr, q.drawn, q.returned, exp(k * state[at]))


@inlined
def leaking(drop: float, exponent: float) -> float:
    """Pressure drop [Pa] as a leak follows it."""
    if exponent == 1.0:
        return drop
    return copysign(power_law(abs(drop), PRESSURE_PA, exponent), drop)


def internal_leakage(
    q: ChamberFlows, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> ChamberFlows:  # fmt: skip
    """Laminar leak across the piston, G (P_p - P_r): leaves one chamber and enters the other.

    c: G [m^3/(s Pa)] of the test and the load cylinder (Merritt 1967, section 6.1), and an
    exponent of the drop other than 1, that of an orifice being 0.5: the same at 50 bar.
    """
    g_t, g_l, exponent = c
    across_t = g_t * q.fluidity * leaking(state[P_TP] - state[P_TR], exponent)
    across_l = g_l * q.fluidity * leaking(state[P_LP] - state[P_LR], exponent)
    return ChamberFlows(
        q.tp - across_t, q.tr + across_t, q.lp - across_l, q.lr + across_l,
        q.drawn, q.returned, q.fluidity,
    )  # fmt: skip


def external_leakage(
    q: ChamberFlows, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> ChamberFlows:  # fmt: skip
    """Laminar leak out of a chamber, G P, past its rod seal or fittings: it is lost.

    c: G [m^3/(s Pa)] of Tp, Tr, Lp, Lr (Merritt 1967, section 6.1), and an exponent of the
    pressure other than 1: the same at 50 bar.
    """
    g_tp, g_tr, g_lp, g_lr, n = c
    f = q.fluidity
    return ChamberFlows(
        q.tp - g_tp * f * leaking(state[P_TP], n), q.tr - g_tr * f * leaking(state[P_TR], n),
        q.lp - g_lp * f * leaking(state[P_LP], n), q.lr - g_lr * f * leaking(state[P_LR], n),
        q.drawn, q.returned, f,
    )  # fmt: skip
