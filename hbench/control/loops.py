"""The three loops at an operating point: with an ideal valve, with the valve, and on the board."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from hbench.control import sampled
from hbench.control.jacobian import disagreement
from hbench.control.linearisation import (
    LinearCoefficients,
    OperatingPoint,
    as_numbers,
    linear_coefficients,
    state_space,
)
from hbench.control.merits import bandwidth, margins, ramp_error, step_merits, step_response
from hbench.control.sampled import Pi, SampledPlant
from hbench.control.transfer import (
    TransferFunction,
    pi,
    piston_pressure_plant,
    rod_pressure_plant,
    valve,
    velocity_plant,
)
from hbench.model.parameters import PlantParameters
from hbench.model.plant import TICK_S
from hbench.records import ControlLoop, Design, LoopMerits, Reproduced, RootLocus

LOOPS = (  # name, symbol of the source, unit of K_c; by valve
    ("velocity", "T", "V/m"),
    ("rod pressure", "Lr", "V/(Pa s)"),
    ("piston pressure", "Lp", "V/(Pa s)"),
)
RAMP_M_S2 = 0.1  # of the ramp error, section 4.5.3
_OMEGA = np.geomspace(0.1, 0.9 * np.pi / TICK_S, 2000)
_TIMES_S = np.arange(0.0, 2.0, TICK_S)
_FACTORS = np.unique(np.append(np.geomspace(0.02, 50.0, 1000), 1.0))


def design_at(
    name: str,
    par: PlantParameters,
    point: OperatingPoint,
    gains: Sequence[Pi],
    filters_s: tuple[float, float],
    reproduced: tuple[Reproduced, ...] = (),
) -> Design:
    """Return the loops of a bench ``name`` at ``point`` with their figures of merit.

    ``gains``: K_c and tau_c of the velocity, rod and piston pressure loop; ``filters_s``: lags of
    the velocity (D.11) and the pressures (D.29).
    """
    c = linear_coefficients(par, point)
    plant = sampled.sample_plant(*state_space(c, par), *filters_s)
    load = par.load
    return Design(
        bench=name,
        point=as_numbers(point),
        f_load_n=load.area_piston_m2 * point.p_lp_pa - load.area_rod_m2 * point.p_lr_pa,
        coefficients=as_numbers(c),
        jacobian_difference=disagreement(par, point, c),
        loops=_control_loops(c, par, plant, gains),
        feedforward=(c.feedforward_rod, c.feedforward_piston),
        ramp_error_m_s=ramp_error(loop_plants(c)[0] * pi(*gains[0]), RAMP_M_S2),
        coupled_modulus=sampled.modulus(plant, gains),
        tick_s=TICK_S,
        reproduced=reproduced,
    )


def loop_plants(
    c: LinearCoefficients,
) -> tuple[TransferFunction, TransferFunction, TransferFunction]:
    """Return G_Tol, G_Lrol and G_Lpol (4.29, 4.25, 4.26)."""
    return velocity_plant(c), rod_pressure_plant(c), piston_pressure_plant(c)


def _control_loops(
    c: LinearCoefficients, par: PlantParameters, plant: SampledPlant, gains: Sequence[Pi]
) -> tuple[ControlLoop, ...]:
    spool = valve(par.valve.natural_frequency_rad_s, par.valve.damping)
    response = sampled.measurement_response(plant, _OMEGA)
    poles = np.linalg.eigvals(sampled.closed_loop_matrices(plant, gains)[0])
    loops = []
    for i, (name, symbol, unit) in enumerate(LOOPS):
        ideal = loop_plants(c)[i] * pi(*gains[i])
        with_valve = ideal * spool
        on_board = sampled.broken_loop(response, _OMEGA, gains, i)
        step = sampled.sampled_step(plant, gains, i, _TIMES_S[-1] + TICK_S)
        loops.append(
            ControlLoop(
                name=name,
                symbol=symbol,
                gain=gains[i][0],
                gain_unit=unit,
                time_constant_s=gains[i][1],
                merits=(
                    _continuous("ideal valve", ideal),
                    _continuous("valve", with_valve),
                    _with_merits("board", on_board, step[1], poles),
                ),
                locus=(root_locus(ideal), root_locus(with_valve)),
            )
        )
    return tuple(loops)


def _continuous(chain: str, open_loop: TransferFunction) -> LoopMerits:
    closed = open_loop.closed
    return _with_merits(
        chain,
        open_loop(1j * _OMEGA),
        step_response(closed, _TIMES_S),
        backward_euler(closed.poles),
        closed.poles,
        closed.zeros,
    )


def _with_merits(
    chain: str,
    open_loop: np.ndarray,
    step: np.ndarray,
    digital_poles: np.ndarray,
    poles: np.ndarray | None = None,
    zeros: np.ndarray | None = None,
) -> LoopMerits:
    margin, merit = margins(_OMEGA, open_loop), step_merits(_TIMES_S, step)
    return LoopMerits(
        chain=chain,
        bandwidth_rad_s=bandwidth(_OMEGA, open_loop / (1 + open_loop)),
        phase_margin_deg=margin.phase_deg,
        gain_margin=margin.gain,
        phase_margin_rad_s=margin.phase_rad_s,
        gain_margin_rad_s=margin.gain_rad_s,
        overshoot=merit.overshoot,
        settling_s=merit.settling_s,
        digital_modulus=float(np.abs(digital_poles).max()),
        omega_rad_s=_OMEGA,
        open_loop=open_loop,
        t_s=_TIMES_S,
        step=step,
        digital_poles=digital_poles,
        poles_rad_s=poles,
        zeros_rad_s=zeros,
    )


def backward_euler(s: np.ndarray) -> np.ndarray:
    """Map roots from the s to the z plane by s = (z - 1) / (T z), as appendix D does."""
    return 1 / (1 - TICK_S * s)


def root_locus(open_loop: TransferFunction) -> RootLocus:
    """Return the closed loop's poles as the gain grows from 1/50 to 50 times its value."""
    numerator, denominator = np.array(open_loop.numerator), np.array(open_loop.denominator)
    branches: list[np.ndarray] = []
    for factor in _FACTORS:
        roots = np.roots(np.polyadd(denominator, factor * numerator))
        if branches:  # in the order of the gain before
            distance = np.abs(branches[-1][:, None] - roots[None, :])
            roots = roots[linear_sum_assignment(distance)[1]]
        branches.append(roots)
    return RootLocus(_FACTORS, np.array(branches), open_loop.poles, open_loop.zeros)
