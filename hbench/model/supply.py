"""Hydraulic supply: constant pressures, and the flow that the valves draw from it."""

from typing import TYPE_CHECKING

from hbench.model.compiled import compiled
from hbench.model.valves import port_flow

if TYPE_CHECKING:
    from hbench.model.parameters import PlantParameters


@compiled
def pressures(par: "PlantParameters") -> tuple[float, float]:
    """Supply and tank pressure [Pa] at the valves; both constant."""
    return par.p_supply_pa, par.p_tank_pa


@compiled
def drawn_flow(
    spools: tuple[float, float, float],
    chambers: tuple[float, float, float, float],
    par: "PlantParameters",
) -> float:
    """Flow [m^3/s] from the supply line into the chambers that are open to it.

    ``spools``: T, L1, L2 in volts. ``chambers``: P_Tp, P_Tr, P_Lp, P_Lr in Pa.
    """
    p_supply, p_tank = pressures(par)
    t, l1, l2 = spools
    p_tp, p_tr, p_lp, p_lr = chambers
    flow = 0.0
    for opening, pressure in ((t, p_tp), (-t, p_tr), (l2, p_lp), (l1, p_lr)):
        if opening > 0.0:
            flow += port_flow(opening, pressure, p_supply, p_tank, par.valve)
    return flow
