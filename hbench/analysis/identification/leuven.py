"""The modified Leuven law's elements theta_i, online and in one batch (3.14 to 3.24).

Both drive N elements with given Delta_max along the logged motion by 3.15. The batch fit compares
the law's friction with the measured one, as for LuGre. The recursive estimate takes the measured
hysteresis force F_h = F - B v (sigma_1 neglected) in 3.15, where it tells how far the elements go:
in presliding. While the piston slides, F_h is the steady curve whatever the elements are; there
they move as their estimate says, and nothing is learnt.

There a log tells F_h at the deflections that it reaches (``hysteresis_at``), a sum in which all
elements that don't slip yet move together. The elements one by one are for the batch fit, which
uses sliding too.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from hbench.analysis.identification.lugre import UNKNOWNS, fit_along, unknown
from hbench.analysis.identification.recursive import Estimate, update
from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.model.friction.dynamic_laws import slip_deflection
from hbench.model.friction.laws import LAWS
from hbench.model.friction.static_laws import dry_friction
from hbench.model.parameters import FrictionParameters
from hbench.records import Fit

_PRESLIDING = 0.9  # of the steady curve's dry part; above, sliding has begun
_SHAPES = {
    "delta_max_m": unknown("delta_max_m", 1e-5, 0.05, 1e-3),
    "n": unknown("n", 0.2, 5.0, 1.0),
}
STEADY = ("f_coulomb_n", "f_stiction_n", "v_stribeck_m_s", "b_viscous_n_s_m")
_SIZE_N = 100.0  # of an element
_P0 = 1e4
# Tried for a start: multiples of the elements, multiples of Delta_max, and n.
_FACTORS, _SPANS, _EXPONENTS = (0.6, 1.0, 1.6), (0.5, 0.7, 1.0, 1.4, 2.0), (0.7, 1.0, 1.6)


def fit_leuven(
    motions: Sequence[LoggedMotion],
    known: FrictionParameters,
    names: Sequence[str] = STEADY,
    spans: Sequence[float] = _SPANS,
) -> Fit:
    """Fit all elements (non-negative) and what ``names`` tells; the rest stays as in ``known``.

    ``names`` are of LuGre's ``UNKNOWNS`` (without sigma_0), or ``delta_max_m`` and ``n``.
    ``known.elements`` gives their number, and where the search starts. Delta_max and n are the
    user's, unless they are among ``names``; intervals hold on condition of those that are given.
    They have several minima, so the search is made from several of them, Delta_max at ``spans``
    times the known. To choose between given ones, compare the friction of runs that were held out.
    Intervals are over whole runs, as for LuGre.
    """
    law = known._replace(law=LAWS["leuven"].code)
    n = len(law.elements)
    others = {name: {**UNKNOWNS, **_SHAPES}[name] for name in names}
    element = unknown("theta_i_n", 0.0, 1e5, _SIZE_N)
    elements = {f"theta_{i + 1}_n": element for i in range(n)}

    def put(x: np.ndarray) -> FrictionParameters:
        new = zip(others.values(), x[n:].tolist(), strict=True)
        values: dict[str, Any] = {u.field: value for u, value in new}
        return law._replace(elements=tuple(x[:n].tolist()), **values)

    spans = spans if "delta_max_m" in others else (1.0,)
    shapes = _EXPONENTS if "n" in others else (law.shape,)
    starts = []
    for span, shape in product(spans, shapes):
        scaled = law._replace(presliding=span * law.presliding, shape=shape)
        fixed = [getattr(scaled, u.field) for u in others.values()]
        starts.append([np.array([*(f * e for e in law.elements), *fixed]) for f in _FACTORS])
    return fit_along("leuven", motions, put, elements | others, starts)


def identify_online(
    motions: Sequence[LoggedMotion], known: FrictionParameters, forgetting: float = 1.0
) -> Estimate:
    """Estimate the elements by recursive least squares, sample by sample, from nothing on.

    All begin at zero, with P = 1e4 I: as if they were known to 100 times the noise of F_h, so the
    start weighs nothing. ``known`` gives the steady curve, Delta_max, n, and by its elements their
    number. With ``forgetting`` lambda the last 1/(1 - lambda) samples count; a log has some 80
    a run in presliding.

    ``P`` times the mean square of the errors is no covariance of the elements: the samples of a run
    go together, and the way of the deflections while the piston slides depends on the estimate.
    On the virtual rig with another plant (three elements, 8 campaigns of 8 runs) such standard
    errors are 2 to 5 N, and single elements are off by 10 to 230 N. ``hysteresis_at`` is low by 2 %
    before the first slips and by 1 % at half of Delta_max; from campaign to campaign it scatters by
    0.3 % and 0.1 %.
    """
    limits = np.array([slip_deflection(i, known) for i in range(len(known.elements))])
    estimate = Estimate(np.zeros(len(limits)), _P0 * np.eye(len(limits)))
    for motion in motions:
        measured = motion.friction_n - known.viscous * motion.v_m_s
        steady = steady_curve(motion, known)
        deflection = np.zeros(len(limits))
        for k in range(1, len(measured)):
            v = 0.5 * (motion.v_m_s[k - 1] + motion.v_m_s[k])
            f_h, dry = 0.5 * (measured[k - 1] + measured[k]), 0.5 * (steady[k - 1] + steady[k])
            sliding = abs(f_h) > _PRESLIDING * dry
            if sliding:
                f_h = estimate.theta @ (deflection / limits)
            ratio = np.sign(v) * f_h / dry
            rate = v * (1.0 - np.sign(ratio) * abs(ratio) ** known.shape)
            deflection = np.clip(deflection + motion.dt_s * rate, -limits, limits)
            if motion.compared[k] and not sliding:
                estimate = update(estimate, deflection / limits, float(measured[k]), forgetting)
    return estimate


def hysteresis_at(deflection_m: float, theta_n: np.ndarray, known: FrictionParameters) -> float:
    """Return F_h [N] at a deflection from rest, sum of theta_i min(z / Delta_i, 1) (3.17 to 3.20).

    ``theta_n`` is (N,); ``known`` gives Delta_max.
    """
    limits = np.array([slip_deflection(i, known) for i in range(len(theta_n))])
    return float(theta_n @ np.minimum(deflection_m / limits, 1.0))


def steady_curve(motion: LoggedMotion, par: FrictionParameters) -> np.ndarray:
    """Return the magnitude of S [N] (3.16) at each sample of a motion (n,)."""
    samples = zip(motion.v_m_s, motion.p_p_pa, motion.p_r_pa, strict=True)
    return np.array([dry_friction(v, p_p, p_r, 1.0, par) for v, p_p, p_r in samples])
