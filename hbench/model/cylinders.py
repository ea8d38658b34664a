"""Cylinders: chamber volumes, pressure gradients (2.1 to 2.8), forces and end-stops."""

from hbench.model.compiled import inlined
from hbench.model.parameters import CylinderParameters, EndStopParameters

CAVITATION_PA = 1e5  # below it a chamber's pressure stops falling


@inlined
def extending_volumes(x: float, cylinder: CylinderParameters) -> tuple[float, float]:
    """Piston and rod side [m^3] of the test cylinder: V_p0 + A_p x, V_r0 + A_r (stroke - x)."""
    position = x + cylinder.offset_m
    return (
        cylinder.dead_volume_piston_m3 + cylinder.area_piston_m2 * position,
        cylinder.dead_volume_rod_m3 + cylinder.area_rod_m2 * (cylinder.stroke_m - position),
    )


@inlined
def retracting_volumes(x: float, cylinder: CylinderParameters) -> tuple[float, float]:
    """Piston and rod side [m^3] of the load cylinder, which retracts as x grows (2.5, 2.6)."""
    position = x + cylinder.offset_m
    return (
        cylinder.dead_volume_piston_m3 + cylinder.area_piston_m2 * (cylinder.stroke_m - position),
        cylinder.dead_volume_rod_m3 + cylinder.area_rod_m2 * position,
    )


@inlined
def pressure_rate(pressure: float, volume: float, inflow: float, bulk_modulus: float) -> float:
    """Pressure gradient [Pa/s] beta / V (Q - dV/dt), ``inflow`` being Q - dV/dt [m^3/s].

    Oil bears no tension: below 1 bar a fall slows down in proportion to the pressure, so that the
    pressure tends to zero and never passes it. The cavity's volume is not kept: the pressure
    rises again as soon as oil flows in. A run that cavitates is out of the model's range.
    """
    rate = bulk_modulus / volume * inflow
    if rate < 0.0 and pressure < CAVITATION_PA:
        rate *= max(pressure, 0.0) * (1.0 / CAVITATION_PA)  # a division, always made, takes 3 %
    return rate


@inlined
def pressure_force(p_p: float, p_r: float, cylinder: CylinderParameters) -> float:
    """F = P_p A_p - P_r A_r [N]."""
    return p_p * cylinder.area_piston_m2 - p_r * cylinder.area_rod_m2


@inlined
def end_stop_force(
    x: float, v: float, cylinder: CylinderParameters, stop: EndStopParameters
) -> float:
    """Return the heads' force [N] on the piston, along +x: k depth + c d(depth)/dt.

    Only while the piston presses into a head, and only away from it: a head never pulls.
    """
    position = x + cylinder.offset_m
    if position < 0.0:
        return max(0.0, -stop.stiffness_n_m * position - stop.damping_n_s_m * v)
    depth = position - cylinder.stroke_m
    if depth > 0.0:
        return -max(0.0, stop.stiffness_n_m * depth + stop.damping_n_s_m * v)
    return 0.0
