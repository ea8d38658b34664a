"""Errors of the hidden plants' sensors: in the loop where a loop uses them, else on the log."""

import numpy as np

from hbench.model.sensors import FRACTION, SENSORS, SensorParameters
from hbench.protocol.dictionary import RECORD
from tests.support.hidden.draws import Drawn

_COLUMN = {word.name: i for i, word in enumerate(RECORD)}
_FORCE = SENSORS.index("f_applied")


def astray(
    sensors: SensorParameters, hidden: Drawn, zero_counts: np.ndarray, session: float
) -> SensorParameters:
    """Return the pressure transducers' errors, and zeros that are off by ``zero_counts`` (7,).

    A transducer whose offset is an effect has a little of a gain error too, and the other way
    round. ``session`` goes from 0 to 1.
    """
    errors, effects = hidden.background, hidden.effects
    offsets, gains = dict(errors.pressure_offset_pa), dict(errors.pressure_gain)
    for name, pa in effects.get("pressure_offset", {}).items():
        offsets[name] += pa
        gains[name] += 0.1 * pa / 50e5
    for name, share in effects.get("pressure_gain", {}).items():
        gains[name] += share
        offsets[name] += 0.1 * share * 50e5
    for drift in (errors.pressure_drift_pa, effects.get("pressure_drift", {})):
        for name, pa in drift.items():
            offsets[name] += pa * session
    per_unit = [
        counts * (1 + gains.get(name, 0.0))
        for name, counts in zip(SENSORS, sensors.per_unit, strict=True)
    ]
    zero = [
        at_zero + float(shift) + counts * offsets.get(name, 0.0)
        for name, at_zero, shift, counts in zip(
            SENSORS, sensors.zero, zero_counts, sensors.per_unit, strict=True
        )
    ]
    return sensors._replace(per_unit=tuple(per_unit), zero=tuple(zero))


def rewritten(
    words: np.ndarray, hidden: Drawn, sensors: SensorParameters, rate_hz: float, session: float
) -> np.ndarray:
    """Return a log with the errors of the load cell, which no loop uses, and of the filter."""
    words = words.copy()
    column = _COLUMN["f_applied"]
    counts = words[:, column] / FRACTION
    force = (counts - sensors.zero[_FORCE]) / sensors.per_unit[_FORCE]
    force = force + _load_cell_error(force, words, hidden, sensors, session)
    counts = np.clip(force * sensors.per_unit[_FORCE] + sensors.zero[_FORCE], 0, sensors.top)
    words[:, column] = np.round(FRACTION * counts)
    delay_s = 0.5 * hidden.effects.get("velocity_filter_lag", {}).get("time", 0.0)
    if delay_s and len(words) > 3:
        column = _COLUMN["v"]
        later = _delayed(words[:, column].view(np.int16), delay_s * rate_hz)
        words[:, column] = np.round(later).astype(np.int16).view(np.uint16)
    return words


def _load_cell_error(
    force: np.ndarray, words: np.ndarray, hidden: Drawn, sensors: SensorParameters, session: float
) -> np.ndarray:
    """Gain that grows with the force, offset that drifts, pressure that gets in; the background."""
    effects = hidden.effects
    error = hidden.gauge_curvature * force * np.abs(force) / 6e3
    error = error + hidden.background.cell_offset_n + hidden.background.cell_gain * force
    error = error + effects.get("load_cell_gain", {}).get("error", 0.0) * force * (
        1 + 0.2 * force / 5e3
    )
    offset = effects.get("load_cell_offset", {}).get("force", 0.0)
    error = error + offset * (1 + 0.3 * (2 * session - 1))
    for name, share in effects.get("cell_crosstalk", {}).items():
        i = SENSORS.index(name)
        counts = words[:, _COLUMN[name]] / FRACTION
        error = error + share * (counts - sensors.zero[i]) / sensors.per_unit[i]
    return error


def _delayed(samples: np.ndarray, records: float) -> np.ndarray:
    """Shift by a part of a record, as a second pole of the filter does."""
    from scipy.interpolate import CubicSpline

    at = np.arange(len(samples), dtype=float)
    return CubicSpline(at, samples.astype(float))(np.maximum(at - records, 0.0))
