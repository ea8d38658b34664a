"""Indices of the plant's state: m, m/s; Pa; spools in V and V/s; supply in Pa and m^3/s."""

from hbench.model.compiled import inlined
from hbench.model.parameters import PlantParameters

X, V, P_TP, P_TR, P_LP, P_LR = 0, 1, 2, 3, 4, 5
SPOOL_T, SPOOL_L1, SPOOL_L2, RATE_T, RATE_L1, RATE_L2 = 6, 7, 8, 9, 10, 11
P_S, PUMP_COMMAND, PUMP_FLOW = 12, 13, 14
Z_T, Z_L = 15, 16  # bristles in m, at every second index from here; then the effects' states


@inlined
def bristles_end(par: PlantParameters) -> int:
    """Return the index after the bristles; a constant of the parameters' type."""
    return Z_T + 2 * max(len(par.test.friction.elements), len(par.load.friction.elements))
