"""Breakaway force against the rate at which the force rises: a mass that is pushed."""

import numpy as np

from hbench.model.parameters import FrictionParameters
from hbench.records import Finding, Panel, Phenomenon
from hbench.studies.phenomena.driven_friction import driven_mass
from hbench.studies.phenomena.laws import LUGRE, line

MASSES_KG = (5.0, 0.05)
RATES_N_S = np.array([10.0, 30.0, 100.0, 300.0, 1e3])
# The viscous part plays no role in breaking away; damping calms the bristles under the ramp.
PUSHED = LUGRE._replace(viscous=0.0, bristle_damping=500.0)
SLIDES_M_S = 0.3  # ten Stribeck velocities


def breakaway(rate_n_s: float, mass_kg: float, law: FrictionParameters) -> float:
    """Return the simulated largest friction [N] while the force on a mass at rest rises."""
    end_n, dt = 1.3 * law.stiction, 2e-5  # the bristles' own vibration: 4 ms a radian
    force = np.linspace(0.0, end_n, round(end_n / rate_n_s / dt))
    moved = driven_mass(force, 0.0, mass_kg, dt, law)
    away = np.argmax(moved.v_m_s > SLIDES_M_S)
    return float(moved.friction_n[:away].max())


def breakaway_by_formula(rate_n_s: float, law: FrictionParameters) -> float:
    """Return LuGre's breakaway force [N] without mass or damping.

    The maximum over v of F_dry (1 - r / (s0 v)).

    While the force follows the ramp, sigma_0 dz/dt = r, and dz/dt = v (1 - F / F_dry(v)) (3.8).
    Beyond the largest F that some v allows, nothing balances the ramp: it breaks away.
    """
    creep = rate_n_s / law.bristle_stiffness

    v = creep * np.geomspace(1.0, 1e8, 20_000)
    fallen = (law.stiction - law.coulomb) * np.exp(-v / law.stribeck_velocity)
    return float(((law.coulomb + fallen) * (1 - creep / v)).max())


def breakaway_force() -> Phenomenon:
    """Show that breakaway falls as the force rises faster, from F_s towards F_C."""
    fine = np.geomspace(RATES_N_S[0], RATES_N_S[-1], 80)
    simulated = {
        mass: np.array([breakaway(rate, mass, PUSHED) for rate in RATES_N_S]) for mass in MASSES_KG
    }
    theory = np.array([breakaway_by_formula(rate, PUSHED) for rate in fine])
    return Phenomenon(
        name="breakaway",
        title="Breakaway force",
        text=(
            "A force on a mass at rest rises at a constant rate until the mass slides; the largest "
            "friction on the way is the breakaway force. It is stiction if the force rises slowly, "
            "and less if it rises fast: the bristles creep, and the creep's speed is already on "
            "the falling part of the Stribeck curve. A heavy mass breaks away later.",
        ),
        panels=(
            Panel(
                "force",
                "Breakaway over the rate of the force",
                "Rate of the force (N/s)",
                "Breakaway force (N)",
                (
                    line("without mass, closed form", fine, theory),
                    *(
                        line(f"LuGre, {mass:g} kg", RATES_N_S, forces, True)
                        for mass, forces in simulated.items()
                    ),
                ),
                x_log=True,
            ),
        ),
        findings=tuple(
            Finding(
                f"breakaway of {mass:g} kg at {rate:g} N/s",
                "N",
                float(force),
                breakaway_by_formula(rate, PUSHED),
                "max over v of F_dry (1 - r / (sigma_0 v))",
            )
            for mass, forces in simulated.items()
            for rate, force in zip(RATES_N_S, forces, strict=True)
        ),
    )
