"""What the data does not determine, and which measurements would: the Fisher information.

    I = J'J / s^2,  C = I^-1                the covariance that all parameters have, bounds aside
    C_jj -> C_jj - (C g)_j^2 / (s^2 + g'Cg) with one more point, where friction's gradient is g

A parameter is not determined if its 95 % interval is wider than its value, and what that leaves of
friction more than a tenth of the largest friction. Candidates for the further point are speeds from
a tenth of the lowest to three times the highest one, at the mean pressures, and pressures from none
to three times the highest, at the mean speed. The best of them is named.
"""

from typing import NamedTuple

import numpy as np

from hbench.analysis.fitting.fittable_law import Law
from hbench.analysis.rounding import ROUNDING

_PRIOR = 100.0  # typical sizes: what is known of a direction that the data does not see
_PART = 0.1  # of the typical size
_NO_GAIN = 0.05  # a point that narrows by less than this determines nothing
_CANDIDATES = 60


class Information(NamedTuple):
    """A law at its best parameters: derivatives (n, p) in units of s, and sizes (p,)."""

    law: Law
    x: np.ndarray
    jacobian: np.ndarray
    variance: float  # s^2, or that of rounding where the fit is exact
    scale: np.ndarray
    inputs: np.ndarray


def covariance_of_all(seen: Information) -> np.ndarray:
    """Return C (p, p) with a prior of a hundred typical sizes, so that it exists."""
    j = seen.jacobian * seen.scale
    _, s, directions = np.linalg.svd(j / np.sqrt(max(seen.variance, 1e-300)))
    s = np.pad(s, (0, len(seen.x) - len(s)))  # points may be fewer than parameters
    inverse = (directions.T / (s**2 + _PRIOR**-2)) @ directions
    return inverse * np.outer(seen.scale, seen.scale)


def identification_messages(
    seen: Information, factor: float, profiled: np.ndarray | None = None
) -> list[str]:
    """Return a sentence on each parameter that the data does not determine.

    ``factor`` is Student's; ``profiled`` (p,) half-widths of the profile's intervals, which see
    further than the information at one point: the wider of the two counts.
    """
    spread = covariance_of_all(seen)
    half = factor * np.sqrt(np.diag(spread))
    half = half if profiled is None else np.fmax(half, profiled)
    unknown = (half > np.abs(seen.x)) & (half > _PART * seen.scale)
    return [_sentence(seen, spread, i) for i in np.flatnonzero(unknown).tolist()]


def _sentence(seen: Information, spread: np.ndarray, number: int) -> str:
    name = seen.law.names[number]
    speed, p_p, p_r = seen.inputs
    low, high = float(speed.min()), float(speed.max())
    speeds = np.geomspace(0.1 * low, 3 * high, _CANDIDATES)
    best, left = _best(seen, spread, number, _at(seen, speeds, 0))
    if seen.law.pressures:
        for row, words in ((1, "piston-side pressures"), (2, "rod-side pressures")):
            pressures = np.linspace(0.0, 3 * float(seen.inputs[row].max()), _CANDIDATES)
            there, left_there = _best(seen, spread, number, _at(seen, pressures, row))
            if left_there < left - _NO_GAIN:
                bar = f"{pressures[there] / 1e5:.3g} bar"
                return (
                    f"other {words} are missing: this data does not determine {name} "
                    f"(a point at {bar} would narrow its interval to {100 * left_there:.0f} %)"
                )
    if left > 1 - _NO_GAIN:
        return (
            f"this data does not determine {name}, and no single velocity would: friction hardly "
            "depends on it here"
        )
    at = speeds[best]
    if at > high:
        where = f"velocities above {high:.3g} m/s"
    elif at < low:
        where = f"velocities below {low:.3g} m/s"
    else:
        where = f"more velocities near {at:.2g} m/s"
    return (
        f"{where} are missing: this data does not determine {name} "
        f"(a point at {at:.2g} m/s would narrow its interval to {100 * left:.0f} %)"
    )


def _at(seen: Information, values: np.ndarray, row: int) -> np.ndarray:
    """Return inputs (3, k) that are the mean of those measured, but for ``values`` in a row."""
    inputs = np.repeat(seen.inputs.mean(axis=1)[:, None], len(values), axis=1)
    inputs[row] = values
    return inputs


def _best(
    seen: Information, spread: np.ndarray, number: int, inputs: np.ndarray
) -> tuple[int, float]:
    """Return which candidate narrows the interval most, and what part of its width is left."""
    g = seen.law.jacobian(inputs, seen.x)
    along = g @ spread
    gain = along[:, number] ** 2 / (seen.variance + np.sum(along * g, axis=1))
    left = np.sqrt(np.maximum(1 - gain / spread[number, number], 0.0))
    best = int(np.flatnonzero(left <= left.min() + ROUNDING)[0])
    return best, float(left[best])
