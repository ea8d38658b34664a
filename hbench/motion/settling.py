"""The settled part of a section of constant speed."""

import numpy as np

_ROUNDING = 1e-9


def settled(
    t_s: np.ndarray, x_m: np.ndarray, section: slice, settle_s: float, settle_m: float
) -> slice:
    """Return ``section`` after ``settle_s`` and after a travel of ``settle_m``; may be empty.

    Both are needed, because pressures settle in time but the seals' presliding settles in travel.
    """
    t, x = t_s[section], x_m[section]
    if not len(t):
        return slice(0, 0)
    in_time = t - t[0] >= settle_s - _ROUNDING
    after = in_time & (np.abs(x - x[0]) >= settle_m - _ROUNDING)
    if not after.any():
        return slice(0, 0)
    return slice(section.start + int(np.argmax(after)), section.stop)
