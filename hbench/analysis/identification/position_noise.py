"""Noise of the position beside the deflection of the bristles, which it must resolve.

Noise smears the reversals of the motion: the bristles seem softer and the static friction larger.
This error is common to all runs, so that the intervals, which are those of the scatter of runs, do
not contain it. Of eight simulated campaigns whose friction is not the fit's law, with a noise of
the stated share of the deflection, the intervals contained the value without noise in

    share    sigma_0  F_s
    1.5 %    8        8
    5 %      7        6
    8 %      4        2
    12 %     1        0

(``pytest -m slow -s tests/analysis/test_noisy_position.py``).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.records import Fit

LARGEST_SHARE = 0.05  # of the deflection before sliding


def with_position_noise(fit: Fit, motions: Sequence[LoggedMotion], deflection_m: float) -> Fit:
    """Return ``fit`` with a message where the noise of the position is too large for it.

    ``deflection_m`` is that of the bristles before they slide, F_s / sigma_0. The noise is the
    median over the ``motions``.
    """
    noise_m = float(np.median([motion.noise_m for motion in motions]))
    if not deflection_m > 0.0:
        return fit  # no bristles deflect
    share = noise_m / deflection_m
    if share <= LARGEST_SHARE:
        return fit
    message = (
        f"the noise of the position, {1e3 * noise_m:.2g} mm, is {100 * share:.2g} % of the "
        f"deflection of the bristles before sliding, {1e3 * deflection_m:.2g} mm. Above "
        f"{100 * LARGEST_SHARE:g} %, the bristle stiffness is fitted too small and the static "
        "friction too large, by about as much as their intervals or more. Use a position sensor "
        "with less noise"
    )
    return replace(fit, message="; ".join(filter(None, (fit.message, message))))
