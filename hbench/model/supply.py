"""Hydraulic supply: a constant pressure, or a pump whose pressure sags with the drawn flow.

    C_s dP_s/dt = Q_p - Q_drawn - G_l P_s - K_r max(P_s - P_relief, 0)

The pump's compensator asks for Q_max (P_cut - P_s) / band, limited to 0..Q_max; the flow follows
through two lags. C_s is the line's and the accumulator's capacity, gas volume over pressure.
"""

from hbench.model.compiled import inlined
from hbench.model.parameters import SupplyParameters


@inlined
def pump_rates(
    p_supply: float, command: float, flow: float, drawn: float, par: SupplyParameters
) -> tuple[float, float, float]:
    """Return the rates of supply pressure [Pa/s], compensator's command and flow [m^3/s^2]."""
    if not par.has_pump:
        return 0.0, 0.0, 0.0
    asked = par.flow_m3_s * (par.cut_off_pa - p_supply) / par.band_pa
    asked = min(max(asked, 0.0), par.flow_m3_s)
    relief = par.relief_gain * max(p_supply - par.relief_pa, 0.0)
    net = flow - drawn - par.leakage * p_supply - relief
    return (
        net / par.capacity,
        (asked - command) / par.compensator_lag_s,
        (command - flow) / par.swash_lag_s,
    )


def switched_off(par: SupplyParameters) -> SupplyParameters:
    """Return the supply with its pump off; a constant pressure is then the tank's."""
    return par._replace(pressure_pa=par.tank_pa, flow_m3_s=0.0)


def rest_flow(par: SupplyParameters) -> tuple[float, float]:
    """Return the supply pressure [Pa] and flow [m^3/s] in equilibrium without drawn flow."""
    if not par.has_pump:
        return par.pressure_pa, 0.0
    slope = par.flow_m3_s / par.band_pa
    pressure = min(par.cut_off_pa * slope / (slope + par.leakage), par.relief_pa)
    return pressure, par.leakage * pressure
