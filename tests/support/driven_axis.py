"""Made-up logs of a mass on a guide with a motor, with laws that differ from hbench's.

The motion is prescribed, a sum of two sines from rest, and the drive force is that of Newton's law
with the friction

    F = level F_C tanh(v / 2 mm/s) (1 + 0.6 / (1 + (v / 40 mm/s)^2)) + B sign(v) |v|^0.9

whose level wanders from run to run. Effects are functions of the same motion, of another form than
those of the catalogue.
"""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

from hbench.records import Run, RunPlan, Specimen

START = datetime(2026, 1, 1, tzinfo=UTC)
RATE_HZ, FINE = 200, 10  # samples a second, and steps of the generator in each
MASS_KG, COULOMB_N, VISCOUS = 14.0, 22.0, 60.0
CENTRE_M, REACH_M = 0.25, 0.15
# A first guess: another law, and other values.
MODEL: dict[str, Any] = {
    "moving_mass": {"test": "13 kg"},
    "friction": {
        "test": {
            "law": "tustin",
            "coulomb": "12 N",
            "stiction": "25 N",
            "stribeck_velocity": "60 mm/s",
            "viscous": "100 N s/m",
        }
    },
}


@dataclass(frozen=True)
class Motion:
    """Prescribed motion at the generator's steps (n,)."""

    t_s: np.ndarray
    x_m: np.ndarray
    v_m_s: np.ndarray
    a_m_s2: np.ndarray
    dry_n: np.ndarray  # dry friction


Effect = Callable[[Motion], np.ndarray]  # force that the drive needs in addition [N]


def no_effect(motion: Motion) -> np.ndarray:
    return np.zeros_like(motion.t_s)


def asymmetry(motion: Motion) -> np.ndarray:
    """30 % more dry friction while extending, faded in over 10 mm/s."""
    return 0.15 * (1 + np.tanh(motion.v_m_s / 0.01)) * motion.dry_n


def tight_place(motion: Motion) -> np.ndarray:
    """A tight place of the guide, bell-shaped along the position."""
    bell = np.exp(-(((motion.x_m - CENTRE_M - 0.05) / 0.08) ** 2))
    return 9.0 * bell * np.tanh(motion.v_m_s / 2e-3)


def weight(motion: Motion) -> np.ndarray:
    """A weight on the axis."""
    return np.full_like(motion.t_s, 7.0)


def more_mass(motion: Motion) -> np.ndarray:
    """Three times the mass."""
    return 2 * MASS_KG * motion.a_m_s2


def shear(motion: Motion) -> np.ndarray:
    """Eight elements that slip at up to 4 mm replace 16 N of the dry friction."""
    force = np.zeros_like(motion.t_s)
    for limit in np.arange(1, 9) * 0.5e-3:
        deflection = 0.0
        for i, step in enumerate(np.diff(motion.x_m, prepend=motion.x_m[0])):
            deflection = min(max(deflection + step, -limit), limit)
            force[i] += 2.0 * deflection / limit
    return force - 16.0 * np.tanh(motion.v_m_s / 2e-3)


def late_friction(motion: Motion) -> np.ndarray:
    """The rise of the dry friction at low speed follows the speed 100 ms late."""
    late = np.interp(motion.t_s - 0.1, motion.t_s, motion.v_m_s)
    now, then = (0.6 / (1 + (v / 0.04) ** 2) for v in (motion.v_m_s, late))
    return COULOMB_N * np.tanh(motion.v_m_s / 2e-3) * (then - now)


def motion(rng: np.random.Generator, duration_s: float = 12.0) -> Motion:
    t = np.arange(round(duration_s * RATE_HZ * FINE)) / (RATE_HZ * FINE)
    ramp = np.clip(t - 0.3, 0, 1)
    ramp = ramp**3 * (10 - 15 * ramp + 6 * ramp**2)
    slow, fast = rng.uniform(0.12, 0.3), rng.uniform(0.4, 0.9)
    parts = [(rng.uniform(0.5, 0.8) * REACH_M, slow), (rng.uniform(0.1, 0.2) * REACH_M, fast)]
    x = CENTRE_M + ramp * sum(a * np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for a, f in parts)
    v = np.gradient(x, t)
    stribeck = 1 + 0.6 / (1 + (v / 0.04) ** 2)
    dry = rng.normal(1.0, 0.02) * COULOMB_N * np.tanh(v / 2e-3) * stribeck
    return Motion(t, x, v, np.gradient(v, t), dry)


def axis_runs(
    effect: Effect,
    count: int = 15,
    seed: int = 1,
    scale: float = 1.0,
    noise: float = 1.0,
    wander_n: float = 0.0,
) -> tuple[Run, ...]:
    """Return runs with position and drive force.

    ``scale`` multiplies all forces, as on a bench of another size; ``noise`` that of the sensors;
    ``wander_n`` is the standard deviation of a constant force that differs from run to run.
    """
    rng, runs = np.random.default_rng(seed), []
    for i in range(count):
        m = motion(rng)
        viscous = VISCOUS * np.sign(m.v_m_s) * np.abs(m.v_m_s) ** 0.9
        force = MASS_KG * m.a_m_s2 + m.dry_n + viscous + effect(m) + wander_n * rng.normal()
        t, x, force = (y[::FINE] for y in (m.t_s, m.x_m, force))
        x = x + 2e-6 * noise * rng.standard_normal(len(t))
        force = scale * (force + 0.4 * noise * rng.standard_normal(len(t)))
        plan = RunPlan(f"{i + 1:04d}", "triangle", 1, 0.1, Specimen(0.0, 0.0))
        runs.append(Run(plan, t, x, f_drive_n=force))
    return tuple(runs)
