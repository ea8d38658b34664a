"""Friction of a law driven by a logged motion.

Within a sample's interval, in steps of at most 1 ms, velocity and pressures are parabolas
(``model/friction/parabola.py``), so that the bristles travel as far as the piston. (Linear
interpolation between samples errs by a dt^2/8 at acceleration a: some um after a reversal at
100 Hz, which reduced a sigma_1 of 100 N s/m by 30 N s/m at a sigma_0 of 2.6e5 N/m.) LuGre's and
Leuven's states follow the exact solution over a step; the other laws use the explicit midpoint
rule. All start relaxed.
"""

import numpy as np

from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.model.compiled import compiled
from hbench.model.friction.laws import exact_step
from hbench.model.friction.parabola import within
from hbench.model.parameters import FrictionParameters

_LONGEST_STEP_S = 1e-3
_ROUNDING = 1e-6  # of a number of steps
_NOMINAL = 1.0  # level of friction


def driven_friction(motion: LoggedMotion, par: FrictionParameters) -> np.ndarray:
    """Return the law's friction [N] at each sample (n,) of a motion, from relaxed bristles on."""
    out = np.zeros(len(motion.v_m_s))
    steps = int(np.ceil(motion.dt_s / _LONGEST_STEP_S - _ROUNDING))
    state, work = np.zeros(2 * len(par.elements)), np.zeros((2, 2 * len(par.elements)))
    # Of a table's columns, too, arrays of one kind: for another one all is compiled again.
    signals = map(np.ascontiguousarray, (motion.v_m_s, motion.p_p_pa, motion.p_r_pa))
    _along(steps, motion.dt_s, *signals, par, state, work, out)
    return out


@compiled
def _along(
    steps: int,
    dt: float,
    v: np.ndarray,
    p_p: np.ndarray,
    p_r: np.ndarray,
    par: FrictionParameters,
    state: np.ndarray,
    work: np.ndarray,
    out: np.ndarray,
) -> None:
    h, last = dt / steps, len(v) - 1
    for k in range(len(v)):
        before, after = max(k - 1, 0), min(k + 1, last)
        for i in range(steps):
            s = (i + 0.5) / steps
            v_now = within(v[before], v[k], v[after], s)
            p_now = within(p_p[before], p_p[k], p_p[after], s)
            r_now = within(p_r[before], p_r[k], p_r[after], s)
            force = exact_step(v_now, state, p_now, r_now, _NOMINAL, h, par, work)
            out[k] += force / steps
