"""Points for fits: magnitudes of friction over speed and pressures, with their trials."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from hbench.analysis.fitting.trial_weights import PooledSigma, pooled_sigma
from hbench.analysis.rounding import distinct, is_constant
from hbench.analysis.statistics.trial_levels import TrialLevels, trial_levels
from hbench.records import Curve


@dataclass(frozen=True)
class FitPoints:
    """Points of one or more curves. Friction in the direction of motion is negative."""

    inputs: np.ndarray  # (3, n) speed [m/s], P_p and P_r [Pa]; nan where not measured
    friction_n: np.ndarray  # (n,) means of the trials
    sigma: np.ndarray  # (n,) relative standard deviations of the means; mean square 1
    trials_n: tuple[np.ndarray, ...]  # of each point
    trial_numbers: tuple[tuple[int, ...], ...]  # of each point's trials
    weighted: bool  # whether ``sigma`` comes from the trials
    # (n,) changes of ln sigma^2 by the standard error of its slope over speed; 0 if not weighted
    slope_errors: np.ndarray

    @property
    def speeds(self) -> int:
        """The number of different speeds."""
        return len(distinct(self.inputs[0]))

    def subset(self, chosen: np.ndarray) -> "FitPoints":
        """Return the points with True in ``chosen`` (n,)."""
        numbers = np.flatnonzero(chosen).tolist()
        return FitPoints(
            self.inputs[:, chosen],
            self.friction_n[chosen],
            self.sigma[chosen],
            tuple(self.trials_n[i] for i in numbers),
            tuple(self.trial_numbers[i] for i in numbers),
            self.weighted,
            self.slope_errors[chosen],
        )

    def trial_levels(self) -> TrialLevels | None:
        """Estimate the levels that each trial has at all points; of the points of one curve."""
        counts = [len(values) for values in self.trials_n]
        if min(counts, default=0) < 1 or max(counts) < 2:
            return None
        return trial_levels(
            np.concatenate(self.trials_n),
            np.repeat(np.arange(len(counts)), counts),
            np.array(list(chain.from_iterable(self.trial_numbers))),
            self.sigma * np.sqrt(counts),
        )


def fit_points(curves: Sequence[Curve], weights: str = "equal") -> FitPoints:
    """Return the points of ``curves``; ``weights`` are "equal", or from the "trials".

    Weights from trials need scatter and three points with two trials or more; otherwise all weights
    are equal.
    """
    signed = [(curve.against_motion, point) for curve in curves for point in curve.points]
    rows = [
        (
            abs(point.v_m_s),
            np.nan if point.p_tp_pa is None else point.p_tp_pa,
            np.nan if point.p_tr_pa is None else point.p_tr_pa,
            direction * point.friction_n,
        )
        for direction, point in signed
    ]
    columns = np.array(rows, dtype=float).reshape(-1, 4).T
    trials = tuple(direction * np.array(point.trials_n) for direction, point in signed)
    counts = np.array([len(values) for values in trials], dtype=float)
    pooled = _pooled(columns[0], trials, counts) if weights == "trials" else None
    sigma, slope_errors = np.ones(len(rows)), np.zeros(len(rows))
    if pooled is not None:
        of_means = pooled.sigma / np.sqrt(counts)
        sigma, slope_errors = of_means / np.sqrt(np.mean(of_means**2)), pooled.slope_errors
    return FitPoints(
        inputs=columns[:3],
        friction_n=columns[3],
        sigma=sigma,
        trials_n=trials,
        trial_numbers=tuple(point.trials for _, point in signed),
        weighted=pooled is not None,
        slope_errors=slope_errors,
    )


def _pooled(
    speed: np.ndarray, trials: Sequence[np.ndarray], counts: np.ndarray
) -> PooledSigma | None:
    variance = np.array([0.0 if is_constant(values) else values.var(ddof=1) for values in trials])
    return pooled_sigma(speed, variance, counts - 1)
