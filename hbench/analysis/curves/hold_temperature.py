"""Rate at which the oil was measured to warm or cool while all valves were closed."""

from collections.abc import Sequence

import numpy as np

from hbench.analysis.rounding import distinct
from hbench.analysis.statistics.student import student_factor
from hbench.records import TEMPERATURES, Run

_LEAST = 3  # samples


def measured_rate_k_s(runs: Sequence[Run]) -> float:
    """Return the largest rate [K/s] in the runs, by the sensor nearest to the seal; 0 without one.

    It is the slope of a straight line over the time of a run, less the 95 % interval by the
    scatter about it and less that of one step of the sensor: noise and rounding are no warming.
    """
    return max((_rate_k_s(run) for run in runs), default=0.0)


def _rate_k_s(run: Run) -> float:
    logged = (getattr(run, name) for name in TEMPERATURES)
    temp_k = next((values for values in logged if values is not None), None)
    if temp_k is None:
        return 0.0
    known = np.isfinite(temp_k)
    t, y = run.t_s[known], temp_k[known]
    steps = np.diff(distinct(y))
    if len(t) < _LEAST or not len(steps):
        return 0.0
    tau = t - t.mean()
    spread = float(tau @ tau)
    slope = float(tau @ y) / spread
    residual = y - y.mean() - slope * tau
    se = float(np.sqrt(residual @ residual / (len(t) - 2) / spread))
    step = 1.5 * float(steps.min()) / float(t[-1] - t[0])  # of one in the middle of the run
    return max(0.0, abs(slope) - student_factor(len(t) - 2) * se - step)
