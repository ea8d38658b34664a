"""Samples far from all others, such as dropouts of a sensor or numbers that stand for no value."""

from typing import NamedTuple

import numpy as np

from hbench.analysis.screening.friction_channels import test_force
from hbench.analysis.screening.log_steps import friction_step
from hbench.motion.noise import robust_sigma
from hbench.records import Run

_FAR = 10.0  # robust standard deviations of a window; farther samples are faults of the log ...
_FEW = 0.05  # ... if they are few: a motion that sticks and slips has more ...
_MOST = 0.4  # ... or dropouts, beside which every sample is within ...
_NEAR = 5.0  # ... robust standard deviations: after a slip friction rises gradually
_STEPS = 3.0  # of a resolution; smaller changes of a coarse signal are its rounding
_LEAST = 0.01  # of friction; a smaller change of the mean is neglected


class Outliers(NamedTuple):
    """Samples far from all others, such as dropouts of a sensor."""

    samples: int
    shift: float  # of the mean of all samples by them


def far_samples(run: Run, window: slice, friction_n: float) -> Outliers:
    """Return the samples of a window that are far from all others and change ``friction_n`` [N].

    None where the change is too small to matter.
    """
    friction = test_force(run, window) - run.channel("f_applied_n")[window]
    far = outliers(friction, friction_step(run))
    return far if abs(far.shift) > _LEAST * abs(friction_n) else Outliers(0, 0.0)


def outliers(y: np.ndarray, step: float) -> Outliers:
    """Return the samples of ``y`` (n,), n > 0, that are far from the median.

    If they are many, none counts, unless all are dropouts: ``y`` leaves the median and returns to
    it from one sample to the next. ``step`` is the resolution of ``y``, which is no dropout.
    """
    deviation = np.abs(y - np.median(y))
    sigma = robust_sigma(deviation)
    far = deviation > _FAR * sigma
    if far.mean() > _FEW:
        far = deviation > max(_FAR * sigma, _STEPS * step)
        beside = np.convolve(far, np.ones(3), "same").astype(bool) & ~far
        if far.mean() > _MOST or not np.all(deviation[beside] <= _NEAR * sigma):
            return Outliers(0, 0.0)
    if not far.any():
        return Outliers(0, 0.0)
    return Outliers(int(far.sum()), float(np.mean(y) - np.mean(y[~far])))
