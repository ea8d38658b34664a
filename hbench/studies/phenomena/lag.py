"""Friction lag (figure 3.8): friction follows a changing velocity late."""

from math import exp, pi
from typing import Any

import numpy as np

from hbench.model.parameters import FrictionParameters
from hbench.records import Finding, Panel, Phenomenon
from hbench.studies.phenomena.driven_friction import prescribed_friction
from hbench.studies.phenomena.laws import LEUVEN, LUGRE, TUSTIN, line

MEAN_M_S, SWING_M_S = 0.015, 0.002


def lag_width(frequency_hz: float, law: FrictionParameters) -> float:
    """Return the loop's signed width [N] at its middle: accelerating less decelerating.

    v = v_0 + a sin(2 pi f t), settled.
    """
    per_cycle = 20_000
    cycles = 4 + int(0.5 * frequency_hz)  # the first ones settle
    force, _ = _lag_cycle(frequency_hz, law, cycles, per_cycle)
    return float(force[0] - force[per_cycle // 2])


def _lag_cycle(
    frequency_hz: float, law: FrictionParameters, cycles: int, per_cycle: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return friction and velocity over the last cycle; it begins at v_0, accelerating."""
    phase = 2 * pi * np.arange(cycles * per_cycle) / per_cycle
    v = MEAN_M_S + SWING_M_S * np.sin(phase)
    force = prescribed_friction(v, 1 / (frequency_hz * per_cycle), law)
    return force[-per_cycle:], v[-per_cycle:]


def lag() -> Phenomenon:
    """Show loops of friction over velocity, and how their width grows with the rate."""
    rates = np.array([0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0])
    fine = np.geomspace(rates[0], rates[-1], 100)
    dry = TUSTIN.stiction - TUSTIN.coulomb
    fallen = dry * exp(-MEAN_M_S / TUSTIN.stribeck_velocity)
    steepness = -fallen / TUSTIN.stribeck_velocity
    tau = (TUSTIN.coulomb + fallen) / (LUGRE.bristle_stiffness * MEAN_M_S)

    def theory(f: Any) -> Any:
        turn = 2 * pi * f * tau
        return -2 * SWING_M_S * steepness * turn / (1 + turn**2)

    widths = {
        name: np.array([lag_width(f, law) for f in rates])
        for name, law in (("LuGre", LUGRE), ("Leuven", LEUVEN), ("Tustin", TUSTIN))
    }
    loops = []
    for f in (0.02, 0.5, 2.0):
        force, v = _lag_cycle(f, LUGRE, 4, 2000)
        loops.append(line(f"{f:g} Hz", 1e3 * v, force))
    return Phenomenon(
        name="lag",
        title="Friction lag",
        text=(
            "The velocity swings sinusoidally on the falling part of the Stribeck curve, without "
            "reversal. Friction follows it late: it is larger while the piston accelerates than "
            "while it slows down, at the same velocity. The faster the swing, the wider the loop; "
            "at a slow swing it closes onto the static curve. A static law has no loop.",
            "For small swings LuGre's dry part is a first-order lag of the static slope: "
            "F_dry'(v) / (1 + s tau), tau = F_dry(v) / (sigma_0 v). Leuven's exponent n = 20 "
            "makes its lag far shorter.",
        ),
        panels=(
            Panel(
                "loops",
                "Friction around a mean speed",
                "Velocity v (mm/s)",
                "Friction F (N)",
                tuple(loops),
            ),
            Panel(
                "width",
                "Width of the loop over rate",
                "Frequency (Hz)",
                "Width of the loop (N)",
                (
                    line("LuGre, small swings", fine, theory(fine)),
                    *(line(name, rates, width, True) for name, width in widths.items()),
                ),
                x_log=True,
            ),
        ),
        findings=(
            *(
                Finding(
                    f"LuGre's width at {f:g} Hz",
                    "N",
                    width,
                    float(theory(f)),
                    "-2 a F_dry' w tau / (1 + w^2 tau^2)",
                )
                for f, width in zip(rates, widths["LuGre"], strict=True)
            ),
            Finding("Tustin's width at 2 Hz", "N", widths["Tustin"][-1], 0.0, "no state, no lag"),
        ),
    )
