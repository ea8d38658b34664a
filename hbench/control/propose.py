"""Gains for a bench: the fastest of a family of designs that keeps its margins everywhere.

A design of the family is an order of the three loops, from fast to slow, and the bandwidth w of
the fastest. Neighbouring bandwidths are apart by the ratio r: w, w/r, w/r^2. A loop of bandwidth w
is designed at the nominal point, with an ideal valve and G of 4.25, 4.26 and 4.29:

    velocity    tau_c = d_T1/d_T0 - n_T1/n_T0, the plant's own lag, which the zero cancels
                K_c = w / G_T(0), so that K_v = w: on a ramp of slope a, velocity lags by a / w
    pressures   tau_c = 10 / w: the zero costs 6 degrees at w
                K_c tau_c = w V / (beta K_u): the open loop of a chamber at rest (K_P = 0), an
                integrator beta K_u / (V s), crosses 1 near w

Neither law becomes unstable in a slower design: the oil's resonance, sqrt(beta A^2 / (V m)), limits
w from above alone. A pressure gain that gives the closed loop a bandwidth at the nominal point
would not fall with w where w is below the chamber's pole, beta K_P / V.

w is the largest for which every loop, opened at its valve with the other two closed, keeps its
margins at every point of a grid: positions, loads, speeds and both directions, with valve,
filters and sampling. Of the six orders, the proposal is that with the fastest slowest loop: the
source's order (velocity, rod, piston) suits a soft bench, a stiff one needs fast pressure loops.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from hbench.config.bench import Bench
from hbench.control.grid import (
    GAIN_MARGIN_DB,
    PHASE_MARGIN_DEG,
    Grid,
    GridPoint,
    margin_checks,
)
from hbench.control.linearisation import LinearCoefficients, OperatingPoint, linear_coefficients
from hbench.control.loops import loop_plants
from hbench.control.sampled import Pi, T
from hbench.errors import ConvergenceError
from hbench.model.build import plant_parameters
from hbench.records import Check

ZERO_RATIO = 10.0  # of a pressure loop's bandwidth to its zero
_SLOWEST, _FASTEST = 1.0, 3000.0  # rad/s: least bandwidth of the slowest loop, largest w
_FINE = 0.02  # relative tolerance of w


@dataclass(frozen=True)
class Proposed:
    """Proposed gains and the margins that they keep."""

    loops: tuple[Pi, Pi, Pi]
    order: tuple[int, ...]  # of the loops, from fast to slow
    bandwidths_rad_s: tuple[float, ...]  # in that order
    feedforward: tuple[float, float]
    checks: tuple[Check, ...]
    points: int
    left_out: tuple[str, ...]  # of the grid, with the reason


def propose(bench: Bench, ratio: float, point: OperatingPoint, grid: Grid) -> Proposed:
    """Return gains for ``bench``, designed at ``point`` and checked over its ``grid``.

    ``ratio`` is that of neighbouring bandwidths. Raises ``ConvergenceError`` where even the
    slowest designs of the family do not keep the margins.
    """
    c = linear_coefficients(plant_parameters(bench), point)
    best: tuple[int, ...] = ()
    slowest, chosen = 0.0, None
    for order in permutations(range(3)):
        w = _fastest(grid.points, c, ratio, order, beyond=max(slowest, _SLOWEST) * ratio**2)
        if w > 0.0:
            best, slowest, chosen = order, w / ratio**2, family(c, w, ratio, order)
    if chosen is None:
        raise ConvergenceError(
            f"{bench.name}: no gains with bandwidths of at least {_SLOWEST:g} rad/s "
            f"keep {PHASE_MARGIN_DEG:g} degrees and {GAIN_MARGIN_DB:g} dB",
            "Is the bench file right? A resonance without damping (viscous friction 0) or a slow "
            "valve or filter leaves no margin.",
        )
    return Proposed(
        chosen,
        best,
        (slowest * ratio**2, slowest * ratio, slowest),
        (c.feedforward_rod, c.feedforward_piston),
        margin_checks(grid.points, chosen),
        len(grid.points),
        grid.left_out,
    )


def _fastest(
    points: Sequence[GridPoint],
    c: LinearCoefficients,
    ratio: float,
    order: Sequence[int],
    beyond: float,
) -> float:
    """Return the largest w [rad/s] that keeps all margins; 0 if it does not exceed ``beyond``."""

    def good(log_w: float) -> bool:
        loops = family(c, float(np.exp(log_w)), ratio, order)
        return all(check.holds for point in points for check in margin_checks([point], loops))

    low, high = np.log(beyond) + _FINE, np.log(_FASTEST)
    if not points or not good(low):
        return 0.0
    while high - low > _FINE:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if good(middle) else (low, middle)
    return float(np.exp(low))


def family(
    c: LinearCoefficients, w: float, ratio: float, order: Sequence[int]
) -> tuple[Pi, Pi, Pi]:
    """Return K_c and tau_c of the three loops; see above. ``w`` is the fastest's [rad/s]."""
    loops: dict[int, Pi] = {}
    for rank, loop in enumerate(order):
        plant, width = loop_plants(c)[loop], w / ratio**rank
        if loop == T:
            (n_1, n_0), (d_1, d_0) = plant.numerator, plant.denominator[-2:]
            loops[loop] = (width * d_0 / n_0, d_1 / d_0 - n_1 / n_0)
        else:
            tau = ZERO_RATIO / width
            loops[loop] = (width / (tau * plant.numerator[0]), tau)
    return loops[0], loops[1], loops[2]
