"""Weak form: a balance averaged over smooth windows, so that nothing measured is differentiated.

A window phi(t) is T = 0.16 s wide, its integral is 1, and it ends with three derivatives of zero:

    phi(t) = 315/256 (1 - s^2)^4 / h,   s = (t - t_0) / h,  |s| <= 1,  h = T/2

Integrated by parts, with nothing left at the ends, the weighted means of a signal's derivatives
come from the signal itself:

    <y> = int phi y dt,    <y'> = - int phi' y dt,    <y''> = int phi'' y dt

A log's samples are means over their intervals dt. That is the same filter on every signal, so a
balance that is linear in its signals holds between the means too; the sums in place of the
integrals are corrected to be exact for parabolas. White noise of standard deviation sigma a sample
leaves, in <y'>, sigma sqrt(dt int phi'^2 dt), where int phi'^2 dt = 630 / (143 h^3).
"""

from typing import NamedTuple

import numpy as np

from hbench.errors import DataError
from hbench.records import Run

WIDTH_S = 0.16


class Window(NamedTuple):
    """The window's samples: weights (k,) of <y>, of <y'> [1/s] and of <y''> [1/s^2].

    Windows follow one another by half their width, ``step`` samples.
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

    def mean(self, y: np.ndarray) -> np.ndarray:
        """Return <y> (m,) of the samples (n,)."""
        return self._over(y, self.value)

    def rate(self, y: np.ndarray) -> np.ndarray:
        """Return <y'> (m,), in the unit of y a second."""
        return self._over(y, self.slope)

    def second(self, y: np.ndarray) -> np.ndarray:
        """Return <y''> (m,), in the unit of y a second squared."""
        return self._over(y, self.bend)

    def _over(self, y: np.ndarray, weights: np.ndarray) -> np.ndarray:
        if len(y) < len(weights):
            return np.zeros(0)
        return np.lib.stride_tricks.sliding_window_view(y, len(weights))[:: self.step] @ weights


def window(dt_s: float, width_s: float = WIDTH_S) -> Window:
    """Return the window for samples ``dt_s`` apart; at least 8 samples wide, an even number."""
    k = max(8, 2 * round(width_s / dt_s / 2))
    half = k * dt_s / 2
    s = (2 * np.arange(k) + 1) / k - 1
    t = half * s
    rest = 1 - s**2
    value, slope, bend = rest**4, s * rest**3, rest**2 * (7 * s**2 - 1)
    # Exact for 1, t and t^2: the sums over these must be those of the integrals.
    value = value / value.sum()
    slope = slope / (slope @ t)
    bend = bend - value * bend.sum()
    return Window(dt_s, value, slope, 2 * bend / (bend @ t**2), k // 2)


def sampling(run: Run) -> float:
    """Return the time between a run's samples [s]. Raises ``DataError`` if it is not constant."""
    steps = np.diff(run.t_s)
    if not len(steps):
        raise DataError(f"run {run.plan.run}: {len(run.t_s)} samples; windows need more")
    dt = float(np.median(steps))
    if np.abs(steps - dt).max() > 0.01 * dt:
        raise DataError(
            f"run {run.plan.run}: its samples are not evenly spaced ({steps.min():.4g} to "
            f"{steps.max():.4g} s)",
            "Import it with `resample`, or leave it out.",
        )
    return dt
