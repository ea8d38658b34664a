"""Laws of the plant along a log: flows, friction and supply under the measured signals.

Position, velocity, pressures and commands are those of the log; only what no sensor shows is
integrated: spools, bristles, and the states of the effects. So a law is evaluated where the bench
was, whoever controlled it. A record is divided into steps of at most 1 ms, in which all signals
are parabolas with the record's mean, so that means of products such as u sqrt(dP) are correct.
"""

from collections.abc import Sequence
from functools import cache
from math import ceil
from typing import NamedTuple

import numpy as np

from hbench.model.cylinders import extending_volumes, retracting_volumes
from hbench.model.effects.catalogue import EFFECTS, Effect
from hbench.model.parameters import PlantParameters, ValveParameters
from hbench.model.plant import n_states
from hbench.model.states import X, bristles_end
from hbench.parallel.process_pool import usable_cores
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.measured.integration import (
    COMPRESSION,
    DRAWN,
    MEANS,
    PER_VOLUME,
    Logs,
    Parts,
    Starts,
    Step,
    integrate_logs,
    new_work,
)

STEP_S = 1e-3  # at most
ALL_PARTS = Parts()


class AlongLog(NamedTuple):
    """Means over each record of a log of n records, for the chambers Tp, Tr, Lp, Lr."""

    per_volume: np.ndarray  # (4, n) Q / V [1/s]
    log_volume: np.ndarray  # (4, n) ln(V / 1 m^3) at the mean position
    compression: np.ndarray  # (4, n) integral of dP / beta since the start [1]
    drawn: np.ndarray  # (n,) flow from the supply line [m^3/s]
    supply_pa: np.ndarray  # (n,) supply pressure of a source without pump
    friction_test: np.ndarray  # (n,) N
    friction_load: np.ndarray  # (n,) N


def acts(row: Effect, coefficients: Sequence[float]) -> bool:
    """Return whether an effect's coefficients switch it on."""
    own = zip(row.coefficients.values(), coefficients, strict=True)
    return any(value != key.to_si(key.default) for key, value in own if key.typical)


def states_move(par: PlantParameters) -> bool:
    """Return whether states of effects may change: one with states acts, or the supply sags."""
    coefficients = dict(zip(EFFECTS, par.effects or (), strict=False))
    return len(par.learned) > 0 or any(
        acts(EFFECTS[name], own)
        for name, own in coefficients.items()
        if EFFECTS[name].states or name == "supply_droop"
    )


def single_start(records: int, par: PlantParameters) -> Starts:
    """Return the start of a single log without friction, with the effects' states at 0."""
    states = n_states(par) - bristles_end(par)
    none = np.zeros(states)
    return Starts(np.array([0, records]), np.zeros((1, 2)), none[None], none.astype(bool))


def along(
    signals: np.ndarray,
    dt_s: float,
    par: PlantParameters,
    starts: Starts,
    levels: np.ndarray,
    step_s: float = STEP_S,
    parts: Parts = ALL_PARTS,
) -> AlongLog:
    """Return the means along logs of n records in all, on all cores.

    ``signals`` (10, n) are x, v, four chamber pressures, supply pressure and three commands in SI;
    ``levels`` (2, n), or (2, 1), are those of dry friction; ``parts`` are the laws that are wanted,
    which is for callers that know that no effect connects them. Spools start at rest at their first
    command, bristles with the measured friction less what the effects add to it.
    """
    steps = max(1, ceil(dt_s / step_s - 1e-9))
    h = dt_s / steps
    out = np.zeros((MEANS, signals.shape[1]))
    logs = Logs(signals, np.ascontiguousarray(np.broadcast_to(levels, (2, signals.shape[1]))))
    step = Step(h, steps, _spool_step(par.valve, h), states_move(par), parts)

    def integrate(part: Starts) -> None:
        integrate_logs(logs, step, par, part, new_work(par), out)

    map_on_threads(integrate, starts.divided(usable_cores()))
    volumes = (*extending_volumes(signals[X], par.test), *retracting_volumes(signals[X], par.load))
    return AlongLog(
        out[PER_VOLUME:COMPRESSION], np.log(volumes), out[COMPRESSION:DRAWN], *out[DRAWN:]
    )


@cache
def _spool_step(valve: ValveParameters, h: float) -> np.ndarray:
    """Return the transition matrix (2, 2) of the spool over ``h`` [s] at a constant command.

    Its states are the position less the command, and the rate.
    """
    from scipy.linalg import expm

    omega = valve.natural_frequency_rad_s
    return expm(h * np.array([[0.0, 1.0], [-(omega**2), -2 * valve.damping * omega]]))
