"""Small errors that every bench has: within the class of its valves and sensors, so no effect."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

VALVES = ("test", "load_1", "load_2")
PRESSURES = ("p_tp", "p_tr", "p_lp", "p_lr", "p_s")
SIDES = ("test", "load")
BAR = 1e5

# Limits of uniform draws about 0, each an independent draw for every valve or sensor.
_VALVE_GAIN = 0.05
_VALVE_NULL_V = 0.05  # 0.5 % of 10 V
_PRESSURE_OFFSET_PA = 0.08 * BAR
_PRESSURE_DRIFT_PA = 0.05 * BAR  # over the campaign
_PRESSURE_GAIN = 1e-3
_CELL_OFFSET_N = 5.0
_CELL_GAIN = 3e-3

# Limits of uniform draws.
_TRANSITION_PA = (0.5 * BAR, 2.0 * BAR)
_WANDER = (0.01, 0.03)

WANDER_CORRELATION = 0.8  # from one run to the next


@dataclass(frozen=True)
class Background:
    """Small errors of one bench."""

    valve_gain: dict[str, float]  # relative, by valve
    valve_null_v: dict[str, float]  # added to the spool's position, by valve
    transition_pa: float  # pressure drop below which the valves' flow is laminar
    pressure_offset_pa: dict[str, float]  # by transducer
    pressure_drift_pa: dict[str, float]  # from the first run to the last, linear
    pressure_gain: dict[str, float]  # relative, by transducer
    cell_offset_n: float
    cell_gain: float  # relative
    wander: dict[str, float]  # standard deviation of friction's level between runs, by cylinder


def draw_background(seed: int) -> Background:
    """Draw the small errors of a bench."""
    rng = np.random.default_rng([seed, 22])

    def each(names: Sequence[str], low: float, high: float) -> dict[str, float]:
        return {name: rng.uniform(low, high) for name in names}

    return Background(
        valve_gain=each(VALVES, -_VALVE_GAIN, _VALVE_GAIN),
        valve_null_v=each(VALVES, -_VALVE_NULL_V, _VALVE_NULL_V),
        transition_pa=rng.uniform(*_TRANSITION_PA),
        pressure_offset_pa=each(PRESSURES, -_PRESSURE_OFFSET_PA, _PRESSURE_OFFSET_PA),
        pressure_drift_pa=each(PRESSURES, -_PRESSURE_DRIFT_PA, _PRESSURE_DRIFT_PA),
        pressure_gain=each(PRESSURES, -_PRESSURE_GAIN, _PRESSURE_GAIN),
        cell_offset_n=rng.uniform(-_CELL_OFFSET_N, _CELL_OFFSET_N),
        cell_gain=rng.uniform(-_CELL_GAIN, _CELL_GAIN),
        wander=each(SIDES, *_WANDER),
    )


def wandering(spread: float, runs: int, rng: np.random.Generator) -> np.ndarray:
    """Return the relative change of a level (runs,): AR(1) with the standard deviation ``spread``.

    w_0 = s n_0,  w_k = r w_(k-1) + sqrt(1 - r^2) s n_k
    """
    change = spread * rng.standard_normal(runs)
    change[1:] *= np.sqrt(1 - WANDER_CORRELATION**2)
    for k in range(1, runs):
        change[k] += WANDER_CORRELATION * change[k - 1]
    return change
