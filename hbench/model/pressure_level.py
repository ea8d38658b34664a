"""Travel in which the pressure level of the test cylinder follows a reversal.

The symmetric valve leads both pressures to a line (``initial_state`` of ``plant.py``) that differs
between extension and retraction. After a reversal they approach the other line while the piston
moves, at constant force. With r = A_r / A_p, a = sqrt(P_s - P_p), b = sqrt(P_r - P_t), the columns
l_p = V_p / A_p and l_r = V_r / A_r, and P_p A_p - P_r A_r constant, 2.1 to 2.14 give in extension

    dP_r/dx = -beta / r (b - r a) / (l_r a + l_p b)

which is zero on the line b = r a. It depends on the distance, not on the speed.
"""

import numpy as np
from scipy.integrate import trapezoid

from hbench.model.cylinders import extending_volumes
from hbench.model.parameters import PlantParameters

_STEPS = 400


def level_travel(par: PlantParameters, remaining_pa: float) -> float:
    """Return the travel [m] after which P_r deviates by ``remaining_pa`` from its line.

    Extension without load from the line of retraction, the volumes those at half the stroke. 0
    where the lines are no further apart.
    """
    test, supply = par.test, par.supply
    r = test.area_rod_m2 / test.area_piston_m2
    v_p, v_r = extending_volumes(0.5 * test.stroke_m - test.offset_m, test)
    l_p, l_r = v_p / test.area_piston_m2, v_r / test.area_rod_m2
    available = supply.pressure_pa - supply.tank_pa
    # Above the tank pressure, without a force: P_p = r P_r.
    start, end = available / (1 + r**3), r**2 * available / (1 + r**3)
    if start - end <= remaining_pa:
        return 0.0
    p_r = np.linspace(start, end + remaining_pa, _STEPS)
    a, b = np.sqrt(available - r * p_r), np.sqrt(p_r)
    per_pa = r / par.bulk_modulus_pa * (l_r * a + l_p * b) / (b - r * a)
    return float(-trapezoid(per_pa, p_r))
