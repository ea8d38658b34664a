"""Points for fits: magnitudes of friction over speed and pressures, with their trials."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hbench.analysis.fitting.trial_weights import pooled_sigma
from hbench.analysis.rounding import distinct, is_constant
from hbench.records import Curve


@dataclass(frozen=True)
class FitPoints:
    """Points of one or more curves. Friction in the direction of motion is negative."""

    inputs: np.ndarray  # (3, n) speed [m/s], P_p and P_r [Pa]; nan where not measured
    friction_n: np.ndarray  # (n,) means of the trials
    sigma: np.ndarray  # (n,) relative standard deviations of the means; mean square 1
    trials_n: tuple[np.ndarray, ...]  # of each point
    weighted: bool  # whether ``sigma`` comes from the trials

    @property
    def speeds(self) -> int:
        """The number of different speeds."""
        return len(distinct(self.inputs[0]))

    def subset(self, chosen: np.ndarray) -> "FitPoints":
        """Return the points with True in ``chosen`` (n,)."""
        trials = tuple(t for t, used in zip(self.trials_n, chosen, strict=True) if used)
        return FitPoints(
            self.inputs[:, chosen],
            self.friction_n[chosen],
            self.sigma[chosen],
            trials,
            self.weighted,
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
    sigma = _sigma(columns[0], trials) if weights == "trials" else None
    return FitPoints(
        inputs=columns[:3],
        friction_n=columns[3],
        sigma=np.ones(len(rows)) if sigma is None else sigma,
        trials_n=trials,
        weighted=sigma is not None,
    )


def _sigma(speed: np.ndarray, trials: Sequence[np.ndarray]) -> np.ndarray | None:
    counts = np.array([len(values) for values in trials], dtype=float)
    variance = np.array([0.0 if is_constant(values) else values.var(ddof=1) for values in trials])
    pooled = pooled_sigma(speed, variance, counts - 1)
    if pooled is None:
        return None
    of_means = pooled / np.sqrt(counts)
    return of_means / np.sqrt(np.mean(of_means**2))
