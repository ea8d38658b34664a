"""Weak form: balances averaged over smooth windows, without differentiating a measured signal.

A window phi(t) is T = 0.16 s wide, has the integral 1, and ends with three zero derivatives:

    phi(t) = 315/256 (1 - s^2)^4 / h,   s = (t - t_0) / h,  |s| <= 1,  h = T/2

Integration by parts, whose end terms are zero, gives the weighted means of a signal's derivatives
from the signal itself:

    <y> = int phi y dt,    <y'> = - int phi' y dt,    <y''> = int phi'' y dt

A log's samples are means over their intervals dt. This is the same filter on every signal, so a
balance that is linear in its signals also holds between the means. The sums that replace the
integrals are corrected to be exact for parabolas. White noise with a standard deviation sigma per
sample causes a standard deviation sigma sqrt(dt int phi'^2 dt) in <y'>, where
int phi'^2 dt = 630 / (143 h^3).
"""

from typing import NamedTuple

import numpy as np

from hbench.errors import DataError
from hbench.records import Run

WIDTH_S = 0.16
EVEN = 0.01  # of the usual time between samples; it may differ by so much


class Window(NamedTuple):
    """Sampled window: weights (k,) of <y>, of <y'> [1/s] and of <y''> [1/s^2].

    Successive windows are half a width apart, ``step`` samples.
    """

    dt_s: float
    value: np.ndarray
    slope: np.ndarray
    bend: np.ndarray
    step: int

    def count(self, n: int) -> int:
        """Return the number of windows in ``n`` samples."""
        return max(0, (n - len(self.value)) // self.step + 1)

    def starts(self, n: int) -> np.ndarray:
        """Return the first sample of each window (m,)."""
        return np.arange(self.count(n)) * self.step


def window(dt_s: float, width_s: float = WIDTH_S) -> Window:
    """Return the window for samples ``dt_s`` apart: an even number of samples, at least 8."""
    k = max(8, 2 * round(width_s / dt_s / 2))
    half = k * dt_s / 2
    s = (2 * np.arange(k) + 1) / k - 1
    t = half * s
    rest = 1 - s**2
    value, slope, bend = rest**4, s * rest**3, rest**2 * (7 * s**2 - 1)
    # Make the sums over 1, t and t^2 equal to the integrals.
    value = value / value.sum()
    slope = slope / (slope @ t)
    bend = bend - value * bend.sum()
    return Window(dt_s, value, slope, 2 * bend / (bend @ t**2), k // 2)


def sampling(run: Run) -> float:
    """Return the time between a run's samples [s]. Raises ``DataError`` if it is not constant."""
    steps = np.diff(run.t_s)
    if not len(steps):
        raise DataError(f"run {run.plan.run}: {len(run.t_s)} samples, at least 2 are required")
    dt = float(np.median(steps))
    if np.abs(steps - dt).max() > EVEN * dt:
        raise DataError(
            f"run {run.plan.run}: the sample interval is not constant ({steps.min():.4g} to "
            f"{steps.max():.4g} s; limit: 1 % of {dt:.4g} s)",
            f"Write 'resample: {0.5 / dt:.2g} Hz' in the import map and import again.",
        )
    return dt
