"""Drift of a force's zero: friction that rises in one direction and falls in the other.

A drifting zero of the load cell or of a pressure adds c t to F_T - F_applied in both directions
alike, so that it cancels in the drift d of friction (``drift.py``). Of trial j of point i is

    F_ij = a_i + c t_ij + d t_ij sign(v_i) + e_ij,   F = F_T - F_applied

with the levels, set-ups and degrees of freedom of ``drift.py``, less one for c.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hbench.analysis.statistics.student import student_factor
from hbench.analysis.statistics.within import within
from hbench.analysis.summary.drift import p_value, trials_of
from hbench.analysis.summary.run_clock import RunClock
from hbench.analysis.summary.setups import means_of_setups, sizes_and_sets
from hbench.records import Curve, Drift, QualityCheck, ScreenedRun

_SIGNIFICANT = 0.01
_SMALL_PERCENT = 5.0  # of friction: a smaller change is not reported
_LEAST_DOF = 2


@dataclass(frozen=True)
class ZeroDrift:
    """Significant change of F_T - F_applied in both directions alike, over the campaign."""

    change_n: float  # from the first run to the last
    half_n: float  # half-width of its 95 % interval
    se_n: float
    percent: float  # of friction
    of_unknown_size: bool  # extrapolated from neighbours in an order that may be of names

    @property
    def note(self) -> str:
        """What it may be, and what it changes."""
        size, in_u = f" by {self.change_n:.3g} +- {self.half_n:.2g} N", "contains"
        if self.of_unknown_size:
            size, in_u = "", "does not contain"
        return (
            f"drift: F_T - F_applied changes{size} over the campaign in both directions alike, as "
            "by a drifting zero of the load cell or of a pressure. Friction is that at the "
            f"campaign's mean time, and U {in_u} the change from there; half the difference of "
            "both directions is free of it. Subtract the zeros at rest, or let the sensors warm up"
        )

    @property
    def check(self) -> QualityCheck:
        """Its grade."""
        value = None if self.of_unknown_size else self.percent
        return QualityCheck("force_drift", "with care", value, "%", _SMALL_PERCENT, None)


def zero_drift(
    curves: Sequence[Curve], runs: Iterable[ScreenedRun], clock: RunClock, drift: Drift | None
) -> ZeroDrift | None:
    """Return the drift of steady runs; None if it is small, not significant or can't be known.

    ``drift`` is that of friction, which states whether its size over the campaign is known.
    """
    trials = trials_of(curves, {run.run.plan.run: run.run.plan.trial for run in runs}, clock)
    if len(np.unique(trials.direction)) < 2:
        return None
    size, sets = sizes_and_sets(trials.setup, trials.point)
    tau = within(trials.t, trials.point)
    force_n = within(trials.direction * trials.friction_n, trials.point)
    of_setups = [
        np.sqrt(size) * means_of_setups(values, trials.setup)
        for values in (tau, trials.direction * tau, force_n)
    ]
    matrix, y = np.stack(of_setups[:2], axis=1), of_setups[2]
    dof = len(size) - sets - 2
    one_percent_n = 0.01 * float(np.median(np.abs(trials.friction_n)))
    if dof < _LEAST_DOF or not matrix[:, 0].any() or one_percent_n == 0.0:
        return None
    found, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    residual = y - matrix @ found
    covariance = np.linalg.pinv(matrix.T @ matrix) * float(residual @ residual) / dof
    rate, se, span = float(found[0]), float(np.sqrt(covariance[0, 0])), clock.span(curves)
    change_n, half_n = rate * span, student_factor(dof) * se * span
    surely_n = abs(change_n) - half_n
    if p_value(rate, se, dof) >= _SIGNIFICANT or surely_n <= _SMALL_PERCENT * one_percent_n:
        return None
    return ZeroDrift(
        change_n,
        half_n,
        se * span,
        abs(change_n) / one_percent_n,
        of_unknown_size=drift is None or drift.of_unknown_size,
    )
