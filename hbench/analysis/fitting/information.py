"""Parameters that the data does not determine, and measurements that would (Fisher information).

    I = J'J / s^2,  C = I^-1                covariance of all parameters without bounds
    C_jj -> C_jj - (C g)_j^2 / (s^2 + g'Cg) with a further point, where friction's gradient is g

A parameter is not determined if the half-width of its 95 % interval exceeds a tenth of its typical
size, and exceeds its value too or is cut off by a bound of the fit. Candidates for the further
point are speeds from a tenth of the lowest to three times the highest, at the mean pressures, and
pressures from zero to three times the highest, at the mean speed, as far as the bench reaches. The
best candidate is reported.
"""

from typing import NamedTuple

import numpy as np

from hbench.analysis.fitting.fittable_law import FittableLaw
from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.intervals import has_effect, too_wide
from hbench.config.setup import ANYWHERE, Reach
from hbench.sentences import listed

_PRIOR = 100.0  # typical sizes: standard deviation in undetermined directions
_NO_GAIN = 0.05  # a point that narrows the interval by less is of no use
_CANDIDATES = 60
_ABOVE = "velocities above"
_UNKNOWN_REACH = " (whether the bench reaches this speed is not known)"
_FARTHEST = 3.0  # times the highest measured speed or pressure


class Information(NamedTuple):
    """A law at its fitted parameters: derivatives (n, p) in units of s, and typical sizes (p,)."""

    law: FittableLaw
    x: np.ndarray
    jacobian: np.ndarray
    variance: float  # s^2, or that of rounding where the fit is exact
    scale: np.ndarray
    inputs: np.ndarray
    reach: Reach = ANYWHERE  # of the bench: no further point lies beyond


def covariance_of_all(info: Information) -> np.ndarray:
    """Return C (p, p), made regular by a prior of a hundred typical sizes."""
    j = info.jacobian * info.scale / np.sqrt(max(info.variance, 1e-300))
    missing = max(len(info.x) - len(j), 0)  # points may be fewer than parameters
    j = np.pad(j, ((0, missing), (0, 0)))
    _, s, directions = np.linalg.svd(j, full_matrices=False)
    inverse = (directions.T / (s**2 + _PRIOR**-2)) @ directions
    return inverse * np.outer(info.scale, info.scale)


def undetermined(
    info: Information,
    factor: float,
    profiled: np.ndarray | None = None,
    ends_at_bound: np.ndarray | bool = False,
) -> np.ndarray:
    """Return which parameters (p,) bool have an interval too wide to be determined.

    ``factor`` is Student's; ``profiled`` (p,) are half-widths of the profile's intervals, which
    include nonlinearity: the wider of the two counts. ``ends_at_bound`` (p,) as in ``too_wide``.
    """
    half = factor * np.sqrt(np.diag(covariance_of_all(info)))
    half = half if profiled is None else np.fmax(half, profiled)
    return too_wide(half, info.x, info.scale, ends_at_bound)


def identification_messages(info: Information, unknown: np.ndarray) -> list[str]:
    """Return a sentence on each missing measurement, with the parameters that it would determine.

    ``unknown`` (p,) bool are the parameters not determined, from ``undetermined``.
    """
    spread = covariance_of_all(info)
    wanted: dict[tuple[str, str], list[tuple[str, float]]] = {}
    for number in np.flatnonzero(unknown).tolist():
        missing, at, left = _missing(info, spread, number)
        wanted.setdefault((missing, at), []).append((info.law.names[number], left))
    high = float(info.inputs[0].max())
    unlimited = np.isinf(info.reach.speed_m_s)
    limited = _FARTHEST * high > info.reach.speed_m_s  # more might be known beyond
    end = f" up to {_mm_s(info.reach.speed_m_s)}, the highest of this bench" if limited else ""
    return [
        _sentence(missing, at, end, found)
        + (_UNKNOWN_REACH if unlimited and missing.startswith(_ABOVE) else "")
        for (missing, at), found in wanted.items()
    ]


def _sentence(missing: str, at: str, end: str, found: list[tuple[str, float]]) -> str:
    names = listed([name for name, _ in found])
    several = len(found) > 1
    if not missing:
        return (
            f"this data does not determine {names}, nor would another velocity{end}: friction "
            f"hardly depends on {'them' if several else 'it'}"
        )
    shares = listed([f"{100 * left:.0f} %" for _, left in found])
    return (
        f"{names} {'need' if several else 'needs'} {missing}: a point at {at} would narrow "
        f"{'their intervals' if several else 'its interval'} to {shares} of the width"
    )


def _missing(info: Information, spread: np.ndarray, number: int) -> tuple[str, str, float]:
    """Return what narrows a parameter's interval most: the range, the point, and what remains.

    Range and point are empty where no velocity would narrow it.
    """
    speed = info.inputs[0]
    low, high = float(speed.min()), float(speed.max())
    farthest = min(_FARTHEST * high, max(high, info.reach.speed_m_s))
    speeds = np.geomspace(0.1 * low, farthest, _CANDIDATES)
    best, left = _best(info, spread, number, _at(info, speeds, 0))
    if info.law.pressures:
        for row, side in ((1, "piston-side"), (2, "rod-side")):
            highest = float(info.inputs[row].max())
            top = min(_FARTHEST * highest, max(highest, info.reach.pressure_pa))
            pressures = np.linspace(0.0, top, _CANDIDATES)
            candidate, left_at = _best(info, spread, number, _at(info, pressures, row))
            if left_at < left - _NO_GAIN:
                return f"other {side} pressures", f"{pressures[candidate] / 1e5:.3g} bar", left_at
    if left > 1 - _NO_GAIN:
        return "", "", left
    at = speeds[best]
    if at > high:
        where = f"{_ABOVE} {_mm_s(high)}"
    elif at < low:
        where = f"velocities below {_mm_s(low)}"
    else:
        where = f"more velocities near {_mm_s(at)}"
    return where, _mm_s(at), left


def _mm_s(speed_m_s: float) -> str:
    return f"{float(f'{1e3 * speed_m_s:.2g}'):g} mm/s"


def _at(info: Information, values: np.ndarray, row: int) -> np.ndarray:
    """Return inputs (3, k) with the measured means, and ``values`` in one row."""
    inputs = np.repeat(info.inputs.mean(axis=1)[:, None], len(values), axis=1)
    inputs[row] = values
    return inputs


def _best(
    info: Information, spread: np.ndarray, number: int, inputs: np.ndarray
) -> tuple[int, float]:
    """Return the candidate that narrows the interval most, and the remaining share of its width."""
    g = info.law.jacobian(inputs, info.x)
    if not has_effect(g, info.scale)[number]:
        return 0, 1.0
    projected = g @ spread
    gain = projected[:, number] ** 2 / (info.variance + np.sum(projected * g, axis=1))
    left = np.sqrt(np.maximum(1 - gain / spread[number, number], 0.0))
    best = int(np.flatnonzero(left <= left.min() + ROUNDING)[0])
    return best, float(left[best])
