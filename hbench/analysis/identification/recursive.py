"""Recursive least squares for F = Theta' Phi (3.21 to 3.24, with the gain's erratum).

    L(k)     = P(k-1) Phi(k) / (lambda + Phi(k)' P(k-1) Phi(k))
    Theta(k) = Theta(k-1) + L(k) (F(k) - Theta(k-1)' Phi(k))
    P(k)     = (P(k-1) - L(k) Phi(k)' P(k-1)) / lambda

With lambda = 1 this is the batch solution (P_0^-1 + sum Phi Phi')^-1 (P_0^-1 Theta_0 + sum Phi F).
"""

from typing import NamedTuple

import numpy as np


class Estimate(NamedTuple):
    """What is known after k samples."""

    theta: np.ndarray  # (N,)
    p: np.ndarray  # (N, N); times the noise's variance it is the covariance of theta
    squares: float = 0.0  # sum of the squared errors before each update
    samples: int = 0

    @property
    def error(self) -> float:
        """E of equation 3.24: mean square of the errors, each before its own update."""
        return self.squares / self.samples if self.samples else float("nan")


def update(before: Estimate, phi: np.ndarray, force: float, forgetting: float = 1.0) -> Estimate:
    """Take in one sample: ``phi`` (N,) and ``force``. ``forgetting`` is lambda, in (0, 1]."""
    seen = before.p @ phi
    gain = seen / (forgetting + phi @ seen)
    error = float(force - before.theta @ phi)
    p = (before.p - np.outer(gain, seen)) / forgetting
    return Estimate(before.theta + gain * error, p, before.squares + error**2, before.samples + 1)
