"""What differs between a hidden plant and the model, drawn from a seed."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tests.support.hidden.background import Background, draw_background
from tests.support.hidden.sizes import KNOWN, OUTSIDE, WITHIN_CLASS, Size

# Factors on a bench file's values, each drawn between 1 - s and 1 + s.
_SPREADS = {
    "oil.bulk_modulus": 0.10,
    **{
        f"{cylinder}.dead_volume_{side}": 0.15
        for cylinder in ("test_cylinder", "load_cylinder")
        for side in ("piston", "rod")
    },
    "moving_mass.test": 0.10,
    "moving_mass.load": 0.10,
    "valve.gain": 0.04,
    "valve.bandwidth": 0.05,
    **{
        f"friction.{side}.{name}": spread
        for side in ("test", "load")
        for name, spread in {
            "coulomb": 0.15,
            "stiction": 0.15,
            "stribeck_velocity": 0.15,
            "viscous": 0.15,
            "bristle_stiffness": 0.15,
            "stribeck_exponent": 0.10,
            "piston_seal": 0.10,  # 8 N at 50 bar, a third of the mildest seal friction hidden
            "rod_seal": 0.10,
        }.items()
    },
}


@dataclass(frozen=True)
class Drawn:
    """One hidden plant."""

    effects: dict[str, dict[str, float]]  # coefficients in SI, by the names of sizes.py
    factors: dict[str, float]  # on the bench file's values
    leuven: bool  # Leuven's law of friction, instead of the bench file's
    scatter: float  # of friction's level from stroke to stroke
    noise: float  # factor on the converter's
    gain_curvature: float  # share by which the valves' gains fall over 3 V
    ripple_share: float  # of dry friction along both bores ...
    ripple_period_m: float
    ripple_phase: float
    gauge_curvature: float  # of the load cell, at 6 kN
    tank_pa: float  # from here on, standard deviations between passes
    bulk_modulus: float
    valve_gain: float
    zero_counts: float
    background: Background
    own: Mapping[str, Mapping[str, str]] = field(default_factory=dict)  # the catalogue's laws


def drawn(effects: Mapping[str, float], seed: int) -> Drawn:
    """Draw a plant with effects of these severities."""
    rng = np.random.default_rng([seed, 20])
    factors = {path: 1 + spread * rng.uniform(-1, 1) for path, spread in _SPREADS.items()}
    return Drawn(
        factors=factors,
        leuven=bool(rng.random() < 0.3),
        scatter=rng.uniform(0.01, 0.03),
        noise=rng.uniform(0.7, 1.5),
        gain_curvature=rng.uniform(-0.003, 0.003),
        ripple_share=rng.uniform(0.01, 0.02),
        ripple_period_m=rng.uniform(0.08, 0.25),
        ripple_phase=rng.uniform(0, 2 * np.pi),
        gauge_curvature=rng.uniform(-5e-4, 5e-4),
        tank_pa=rng.uniform(2e3, 5e3),
        bulk_modulus=0.005,
        valve_gain=0.001,
        zero_counts=0.5,
        background=draw_background(seed),
        effects={
            name: _coefficients((KNOWN | OUTSIDE | WITHIN_CLASS)[name], severity, rng)
            for name, severity in effects.items()
        },
    )


def _coefficients(size: Size, severity: float, rng: np.random.Generator) -> dict[str, float]:
    names = list(size.amounts)
    chosen = rng.permutation(len(names))[: 1 if size.one else rng.integers(1, len(names) + 1)]
    found = dict.fromkeys(names, 0.0)
    for i in sorted(chosen):
        sign = rng.choice([-1, 1]) if size.signed else 1
        found[names[i]] = float(sign * severity * rng.uniform(0.8, 1.2) * size.amounts[names[i]])
    return found | {key: float(rng.uniform(*limits)) for key, limits in size.shape.items()}
