"""The four regimes of figure 3.2: the laws with a state run into the static curve."""

from math import log

import numpy as np
from scipy.optimize import minimize_scalar

from hbench.model.friction.laws import steady_friction
from hbench.model.parameters import FrictionParameters
from hbench.records import Finding, Panel, Phenomenon
from hbench.studies.phenomena.driven_friction import prescribed_friction
from hbench.studies.phenomena.laws import LEUVEN, LUGRE, TUSTIN, line


def steady_curve() -> Phenomenon:
    """Show the steady curve, and where LuGre and Leuven settle."""
    speeds = np.geomspace(1e-4, 0.3, 24)

    def settled(law: FrictionParameters, v: float) -> float:
        way = 30 * law.stiction / LUGRE.bristle_stiffness  # lengths of presliding
        return prescribed_friction(np.full(3000, v), way / v / 3000, law)[-1]

    def tustin(v: float) -> float:
        return steady_friction(v, 0.0, 0.0, TUSTIN)

    drop = TUSTIN.stiction - TUSTIN.coulomb
    lowest = minimize_scalar(
        lambda v: settled(LUGRE, v), bounds=(1e-3, 0.1), method="bounded", options={"xatol": 1e-6}
    )
    v_min = TUSTIN.stribeck_velocity * log(drop / (TUSTIN.viscous * TUSTIN.stribeck_velocity))
    slope = (settled(LUGRE, 0.3) - settled(LUGRE, 0.25)) / 0.05
    top = np.geomspace(1e-4, 0.3, 400)
    return Phenomenon(
        name="stribeck",
        title="Stribeck regimes",
        text=(
            "Each point is a motion at one speed from rest until friction has settled. The laws "
            "with a state end on the static curve (3.13): it falls from stiction to a minimum, "
            "then rises with viscous friction.",
            "Regime I, stiction, is elastic and has no place over velocity (see 'presliding'). II "
            "is boundary, III partial, IV full fluid lubrication. The law has no sharp border "
            "between II and III; it is drawn at a tenth of the Stribeck velocity.",
        ),
        panels=(
            Panel(
                "curve",
                "Friction over speed, at steady state",
                "Speed |v| (mm/s)",
                "Friction F (N)",
                (
                    line("Tustin, 3.13", 1e3 * top, np.array([tustin(v) for v in top])),
                    *(
                        line(name, 1e3 * speeds, np.array([settled(law, v) for v in speeds]), True)
                        for name, law in (("LuGre", LUGRE), ("Leuven", LEUVEN))
                    ),
                ),
                x_log=True,
                marks=(
                    (0.1, "II"),
                    (1e2 * TUSTIN.stribeck_velocity, "III"),
                    (1e3 * v_min, "IV"),
                ),
            ),
        ),
        findings=(
            Finding(
                "speed of least friction",
                "mm/s",
                1e3 * lowest.x,
                1e3 * v_min,
                "v_s ln((F_s - F_C) / (B v_s))",
            ),
            Finding(
                "least friction",
                "N",
                lowest.fun,
                TUSTIN.coulomb + TUSTIN.viscous * (TUSTIN.stribeck_velocity + v_min),
                "F_C + B (v_s + v_min)",
            ),
            Finding("friction at 0.1 mm/s", "N", settled(LUGRE, 1e-4), tustin(1e-4), "3.13"),
            Finding("slope from 250 to 300 mm/s", "N s/m", slope, TUSTIN.viscous, "B"),
        ),
    )
