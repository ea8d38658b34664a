"""Relations between logged signals that show which quantities they are."""

import numpy as np

_SAME = 1e-3  # of a signal's range: root mean square of what a straight line leaves
_INTEGRAL = 0.05  # of the travel: the same between position and integral of velocity
_OFFSET = 0.2  # of its range: largest offset of a velocity, which is near zero at rest
_STEP_S = 0.05  # over which a position moves little
_MOST_SAMPLES = 20_000


def is_constant(values: np.ndarray) -> bool:
    """Return whether a signal (n,) has a single value."""
    known = values[np.isfinite(values)]
    return len(known) == 0 or bool(np.ptp(known) == 0)


def are_proportional(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether two signals (n,) are one sensor's, such as volts and bar."""
    if len(a) != len(b):
        return False
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < 4 or is_constant(a[known]) or is_constant(b[known]):
        return False
    slope, offset = np.polyfit(a[known], b[known], 1)
    rest = b[known] - slope * a[known] - offset
    return bool(np.std(rest) < _SAME * np.ptp(b[known]) + 1.0 * _resolution(b[known]))


def velocity_factor(t_s: np.ndarray, x: np.ndarray, v: np.ndarray) -> float | None:
    """Return c if x = x_0 + c * integral of v dt, None if it is not.

    ``v`` may have a small offset. A large one is that of a pressure behind an orifice.
    """
    if not len(t_s) == len(x) == len(v):
        return None
    known = np.isfinite(t_s) & np.isfinite(x) & np.isfinite(v)
    t, y, w = t_s[known], x[known] - x[known][0], v[known]
    if len(t) < 10 or is_constant(y) or is_constant(w):
        return None
    integral = np.concatenate(([0.0], np.cumsum(np.diff(t) * (w[1:] + w[:-1]) / 2)))
    basis = np.column_stack([integral, t - t[0], np.ones(len(t))])
    scale = np.abs(basis).max(axis=0) + 1e-300
    fitted, *_ = np.linalg.lstsq(basis / scale, y, rcond=None)
    c, offset, _ = fitted / scale
    rest = y - basis @ (fitted / scale)
    line = y - np.polyval(np.polyfit(t, y, 1), t)
    if np.std(rest) > _INTEGRAL * np.ptp(y) or np.std(rest) > 0.3 * np.std(line):
        return None
    return None if abs(offset) > _OFFSET * abs(c) * np.ptp(w) else float(c)


def roughness(t_s: np.ndarray, values: np.ndarray) -> float:
    """Return the largest change of a signal (n,) within 0.05 s, as a part of its range.

    A position has no jumps, unlike forces and pressures at a reversal. It is infinite for a
    constant.
    """
    if len(t_s) != len(values):
        return np.inf
    known = np.isfinite(t_s) & np.isfinite(values)
    t, y = t_s[known], values[known]
    if len(t) < 10 or is_constant(y):
        return np.inf
    step = max(1, -(-len(t) // _MOST_SAMPLES))
    t, y = t[::step], y[::step]
    k = max(1, round(_STEP_S / max(float(np.median(np.diff(t))), 1e-9)))
    if k >= len(t):
        return np.inf
    lasts = t[k:] - t[:-k]
    near = lasts < 3 * _STEP_S + 3 * np.median(lasts)
    return float(np.quantile(np.abs(y[k:] - y[:-k])[near], 0.999) / np.ptp(y))


def _resolution(values: np.ndarray) -> float:
    steps = np.abs(np.diff(np.unique(values)))
    return float(steps.min()) if len(steps) else 0.0
