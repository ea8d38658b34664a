"""Servo valves: flow through a port (2.13, 2.14, 2.17, 2.18) and the spool's dynamics (2.16)."""

from math import copysign, sqrt

from hbench.model.compiled import inlined
from hbench.model.parameters import ValveParameters

REGULARISATION_PA = 1e3  # pressure drop below which an orifice turns linear


@inlined
def signed_root(dp: float) -> float:
    """sign(dp) sqrt|dp| [sqrt(Pa)], smooth at zero: dp / (dp^2 + eps^2)^(1/4), eps = 1e3 Pa.

    Above 1e3 eps the two differ by less than 3e-7, so one root does.
    """
    if abs(dp) > 1e3 * REGULARISATION_PA:
        return copysign(sqrt(abs(dp)), dp)
    return dp / sqrt(sqrt(dp * dp + REGULARISATION_PA * REGULARISATION_PA))


@inlined
def clamp(value: float, limit: float) -> float:
    """Limit ``value`` to +-``limit``."""
    return min(max(value, -limit), limit)


@inlined
def port_flow(
    spool: float, p_chamber: float, p_supply: float, p_tank: float, valve: ValveParameters
) -> float:
    """Return the flow [m^3/s] from the valve into a chamber.

    Q = k_s u root(P_s - P)  for u >= 0 (to supply),
    Q = k_s u root(P - P_t)  for u < 0 (to tank; Q is negative).

    ``spool`` u in volts; its opening ends at the valve's limit. Where the drop is negative the
    oil runs the other way: above supply pressure out of an open chamber. Equations 2.13, 2.17
    and 2.18 as they stand; 2.14 is ``-port_flow(-u_T, ...)``, flow out of the rod chamber.
    """
    opening = clamp(spool, valve.limit_v)
    drop = p_supply - p_chamber if opening >= 0.0 else p_chamber - p_tank
    return valve.flow_gain * opening * signed_root(drop)


@inlined
def spool_acceleration(command: float, spool: float, rate: float, valve: ValveParameters) -> float:
    """Return the spool's second derivative [V/s^2]: 2.16 with the command limited.

    w^2 (u - y) - 2 zeta w dy/dt
    """
    omega = valve.natural_frequency_rad_s
    error = clamp(command, valve.limit_v) - spool
    return omega * (omega * error - 2.0 * valve.damping * rate)
