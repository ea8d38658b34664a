"""The source's controllers in its nonlinear model (section 4.5, figure 4.11).

D.18 at 10 kHz on the plant's own velocity and pressures: no filter, no sensor, as in the source.
What the board does with its filters and sensors is checked with the firmware itself.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hbench.control.sampled import Pi
from hbench.model.compiled import compiled
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters, PlantParameters
from hbench.model.plant import P_LP, P_LR, TICK_S, V, forces, initial_state, new_work, step

_SETTLE_S = 1.0  # at rest under load, before the motion


def coulomb_viscous(
    par: PlantParameters, coulomb_n: float, viscous_n_s_m: float
) -> PlantParameters:
    """Return the plant with the friction of chapter 4 in each cylinder: Coulomb and viscous."""
    law = LAWS["tustin"]
    friction = FrictionParameters(
        law=law.code, coulomb=coulomb_n, stiction=coulomb_n, viscous=viscous_n_s_m
    )
    return par._replace(
        test=par.test._replace(friction=friction),
        load=par.load._replace(friction=friction),
        substeps=law.substeps,
    )


class RampErrors(NamedTuple):
    """Velocity error [m/s] at the end of a ramp up and of a ramp down, along the ramp."""

    extend: float
    retract: float


def ramp_errors(
    par: PlantParameters,
    loops: Sequence[Pi],
    f_load_n: float,
    p_lr_pa: float,
    *,
    x_m: float,
    v_m_s: float,
    slope_m_s2: float,
) -> RampErrors:
    """Ramp the reference between -v and +v and return the errors at its ends (section 4.5.3).

    ``loops``: K_c and tau_c of u_T, u_L1, u_L2. The load's references are constant.
    """
    load = par.load
    p_lp_pa = (load.area_rod_m2 * p_lr_pa + f_load_n) / load.area_piston_m2
    rest, up = round(_SETTLE_S / TICK_S), round(v_m_s / slope_m_s2 / TICK_S)
    ramp = np.linspace(-v_m_s, v_m_s, 2 * up)
    v_ref = np.concatenate([np.zeros(rest), -ramp[up:], ramp, ramp[::-1]])
    references = np.full((len(v_ref), 3), (0.0, p_lr_pa, p_lp_pa))
    references[:, 0] = v_ref
    state = initial_state(par, x_m, p_lr_pa, p_lp_pa)
    outputs = run_loops(par, references, np.array(loops), state, np.zeros(3))
    error = v_ref - outputs[:, 0]
    return RampErrors(float(error[rest + 3 * up - 1]), float(-error[-1]))


def run_loops(
    par: PlantParameters,
    references: np.ndarray,
    loops: np.ndarray,
    state: np.ndarray,
    sums: np.ndarray,
) -> np.ndarray:
    """Run D.18 against the plant; return velocity, P_Lr and P_Lp at each tick (n, 3).

    ``sums`` are the integrals of the errors at the start; they and ``state`` are advanced.
    The commands end at the valves' limit; the integrators don't (the source has no anti-windup).
    """
    outputs = np.empty_like(references)
    _run(par, references, loops, state, sums, np.zeros(3), np.ones(2), new_work(par), outputs)
    return outputs


@compiled
def _run(
    par: PlantParameters,
    references: np.ndarray,
    loops: np.ndarray,
    state: np.ndarray,
    sums: np.ndarray,
    u: np.ndarray,
    levels: np.ndarray,
    work: np.ndarray,
    outputs: np.ndarray,
) -> None:
    for k in range(len(references)):
        outputs[k, 0], outputs[k, 1], outputs[k, 2] = state[V], state[P_LR], state[P_LP]
        for i in range(3):
            error = references[k, i] - outputs[k, i]
            sums[i] += TICK_S * error
            u[i] = loops[i, 0] * (loops[i, 1] * error + sums[i])
        on_masses = forces(state, levels, par, work[0])
        step(state, u, on_masses, levels, par, TICK_S, work)
