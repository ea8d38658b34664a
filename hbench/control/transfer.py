"""Transfer functions of plants, controller and valve (4.25, 4.26, 4.29 to 4.36, 2.16)."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from hbench.control.linearisation import LinearCoefficients


@dataclass(frozen=True)
class TransferFunction:
    """A ratio of polynomials in s, highest power first."""

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]

    def __call__(self, s: np.ndarray | complex) -> Any:
        """Return the value at ``s`` [rad/s]."""
        return np.polyval(self.numerator, s) / np.polyval(self.denominator, s)

    def __mul__(self, other: "TransferFunction") -> "TransferFunction":
        """Return both in series."""
        return TransferFunction(
            tuple(np.polymul(self.numerator, other.numerator)),
            tuple(np.polymul(self.denominator, other.denominator)),
        )

    @property
    def closed(self) -> "TransferFunction":
        """G / (1 + G): the loop closed by unit feedback."""
        return TransferFunction(self.numerator, tuple(np.polyadd(self.denominator, self.numerator)))

    @property
    def poles(self) -> np.ndarray:
        """Roots of the denominator [rad/s]."""
        return np.roots(self.denominator)

    @property
    def zeros(self) -> np.ndarray:
        """Roots of the numerator [rad/s]."""
        return np.roots(self.numerator)


def rod_pressure_plant(c: LinearCoefficients) -> TransferFunction:
    """G_Lrol = (K_uLr beta/V_Lr) / (s - beta K_PLr/V_Lr), Pa/V, equation 4.25."""
    stiffness = c.beta / c.v_lr
    return TransferFunction((c.ku_lr * stiffness,), (1.0, -c.kp_lr * stiffness))


def piston_pressure_plant(c: LinearCoefficients) -> TransferFunction:
    """G_Lpol = (K_uLp beta/V_Lp) / (s - beta K_PLp/V_Lp), Pa/V, equation 4.26."""
    stiffness = c.beta / c.v_lp
    return TransferFunction((c.ku_lp * stiffness,), (1.0, -c.kp_lp * stiffness))


def velocity_plant(c: LinearCoefficients) -> TransferFunction:
    """G_Tol, m/s/V, equations 4.29 to 4.35: the load cylinder's force does not change."""
    m, b, beta = c.mass, c.viscous, c.beta
    mvv = m * c.v_tp * c.v_tr
    n_tc = beta / mvv
    n_t0 = beta * (c.ku_tp * c.kp_tr * c.a_tp - c.ku_tr * c.kp_tp * c.a_tr)
    n_t1 = c.ku_tr * c.a_tr * c.v_tp + c.ku_tp * c.a_tp * c.v_tr
    d_t0 = beta**2 * (c.a_tp**2 * c.kp_tr - c.kp_tr * c.kp_tp * b - c.a_tr**2 * c.kp_tp) / mvv
    d_t1 = (
        c.a_tp**2 * c.v_tr
        - c.kp_tp * b * c.v_tr
        - beta * c.kp_tp * m * c.kp_tr
        + c.a_tr**2 * c.v_tp
        + c.v_tp * b * c.kp_tr
    ) * (beta / mvv)
    d_t2 = (c.v_tp * m * beta * c.kp_tr - beta * c.kp_tp * c.v_tr * m + b * c.v_tp * c.v_tr) / mvv
    return TransferFunction((n_tc * n_t1, n_tc * n_t0), (1.0, d_t2, d_t1, d_t0))


def pi(gain: float, time_constant_s: float) -> TransferFunction:
    """C_PI = K_c (tau_c s + 1) / s, equation 4.36."""
    return TransferFunction((gain * time_constant_s, gain), (1.0, 0.0))


def valve(natural_frequency_rad_s: float, damping: float) -> TransferFunction:
    """Return spool over command, second order, equation 2.16."""
    square = natural_frequency_rad_s**2
    return TransferFunction((square,), (1.0, 2 * damping * natural_frequency_rad_s, square))
