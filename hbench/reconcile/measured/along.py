"""Laws of the plant along a log: flows, friction and supply under the measured signals.

Position, velocity, pressures and commands are those of the log; only what no sensor shows is
integrated: spools, bristles, and the states of the effects. So a law is evaluated where the bench
was, whoever controlled it. A record is divided into steps of at most 1 ms, in which all signals
are parabolas with the record's mean, so that means of products such as u sqrt(dP) are correct.
"""

from collections.abc import Sequence
from functools import cache, lru_cache
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


@lru_cache(maxsize=64)
def acting(effects: tuple[tuple[float, ...], ...]) -> tuple[str, ...]:
    """Return the effects that act, from the coefficients of all in the catalogue's order."""
    rows = zip(EFFECTS.items(), effects, strict=False)
    return tuple(name for (name, row), coefficients in rows if _acts(row, coefficients))


def _acts(row: Effect, coefficients: Sequence[float]) -> bool:
    """Return whether an effect's coefficients switch it on."""
    own = zip(row.coefficients.values(), coefficients, strict=True)
    return any(value != key.to_si(key.default) for key, value in own if key.typical)


def connected(par: PlantParameters) -> bool:
    """Return whether a state of an effect that acts, such as warm oil, is in flows and friction."""
    return any("friction" in laws and laws - {"friction"} for laws in _laws_with_states(par))


def states_act(par: PlantParameters, parts: Parts) -> bool:
    """Return whether states of effects that act change these parts."""
    laws = set().union(*_laws_with_states(par))
    return bool((parts.friction and "friction" in laws) or (parts.flows and laws - {"friction"}))


def supply_sags(par: PlantParameters, parts: Parts) -> bool:
    """Return whether the flow drawn changes the supply pressure of a source without pump."""
    rows = [EFFECTS[name] for name in acting(par.effects or ())]
    of_supply = any("supply" in row.balances and "flows" in row.laws for row in rows)
    return parts.flows and (of_supply or len(par.learned) > 0)


def _laws_with_states(par: PlantParameters) -> list[set[str]]:
    """Return the places where each effect that acts and has states changes the plant."""
    names = acting(par.effects or ())
    return [set(EFFECTS[name].laws) for name in names if EFFECTS[name].states]


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
    ``levels`` (2, n), or (2, 1), are those of dry friction. Spools start at rest at their first
    command, bristles with the measured friction less what the effects add to it. Laws that are not
    among the ``parts`` have the mean 0.
    """
    steps = max(1, ceil(dt_s / step_s - 1e-9))
    h = dt_s / steps
    out = np.zeros((MEANS, signals.shape[1]))
    # A copy, as a view may be read-only: for that kind of array all is compiled again.
    logs = Logs(signals, np.array(np.broadcast_to(levels, (2, signals.shape[1])), order="C"))
    spool = _spool_step(par.valve, h)
    step = Step(h, steps, spool, states_act(par, parts), supply_sags(par, parts), parts)

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
