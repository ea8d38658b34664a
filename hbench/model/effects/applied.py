"""The effects' laws put together: what the plant calls at each place where effects act."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from hbench.model.compiled import compiled, inlined
from hbench.model.effects.catalogue import EFFECTS
from hbench.model.effects.couplings import Flows, Oil, Openings, Rubbing
from hbench.model.effects.rows import MOVING, Effect
from hbench.model.friction.laws import steady_parts
from hbench.model.parameters import PlantParameters
from hbench.model.states import P_LP, P_LR, P_TP, P_TR, SPOOL_L1, SPOOL_L2, SPOOL_T, V, bristles_end

LEAST_DRY = 0.1  # of the dry friction, that effects leave of it: friction stays passive

_STATES = sum(row.states for row in EFFECTS.values())


def together(place: str, effects: Mapping[str, Effect]) -> Callable:
    """Return ``apply(what, first, state, rates, par)``: all laws of a place, compiled into one.

    ``first`` is the place of the effects' first state.
    """

    @inlined
    def apply(what, first, state, rates, par):
        return what

    at = 0
    for number, row in enumerate(effects.values()):
        if place in row.laws:
            apply = _then(apply, row.laws[place], number, at)
        at += row.states
    return apply


def _then(before: Callable, law: Callable, number: int, at: int) -> Callable:
    @inlined
    def both(what, first, state, rates, par):
        what = before(what, first, state, rates, par)
        return law(what, par.effects[number], state, first + at, rates, par)

    return both


_openings, _oil, _flows, _friction = (together(place, EFFECTS) for place in MOVING)


@compiled
def effect_states(effects: tuple[tuple[float, ...], ...] | None) -> int:
    """Return the number of states that the effects have."""
    if effects is None:
        return 0
    return _STATES


# ``effects`` is ``par.effects``: where this argument is None, what follows is not compiled.


@compiled
def openings(state: np.ndarray, par: PlantParameters, effects: Any, rates: np.ndarray) -> Openings:
    """Openings of the valves: their spools, as the effects change them."""
    spools = Openings(state[SPOOL_T], state[SPOOL_L1], state[SPOOL_L2])
    if effects is None:
        return spools
    return _openings(spools, bristles_end(par), state, rates, par)


@compiled
def oil(state: np.ndarray, par: PlantParameters, effects: Any, rates: np.ndarray) -> Oil:
    """Tank pressure and bulk moduli."""
    beta = par.bulk_modulus_pa
    constant = Oil(par.supply.tank_pa, beta, beta, beta, beta)
    if effects is None:
        return constant
    return _oil(constant, bristles_end(par), state, rates, par)


@compiled
def flow_effects(
    q: Flows, state: np.ndarray, par: PlantParameters, effects: Any, rates: np.ndarray
) -> Flows:
    """Flows into the chambers, those of the valves given."""
    if effects is None:
        return q
    return _flows(q, bristles_end(par), state, rates, par)


@compiled
def friction_effects(
    level_t: float,
    level_l: float,
    state: np.ndarray,
    par: PlantParameters,
    effects: Any,
    rates: np.ndarray,
) -> tuple[float, float, float, float]:
    """Levels of the dry friction of the test and the load cylinder, and forces [N] to add."""
    if effects is None:
        return level_t, level_l, 0.0, 0.0
    v = state[V]
    dry_t, _ = steady_parts(v, state[P_TP], state[P_TR], level_t, par.test.friction)
    dry_l, _ = steady_parts(v, state[P_LP], state[P_LR], level_l, par.load.friction)
    own = Rubbing(abs(dry_t), abs(dry_l), 0.0, 0.0, 0.0, 0.0)
    f = _friction(own, bristles_end(par), state, rates, par)
    level_t = _raised(level_t, f.more_t, f.dry_t)
    level_l = _raised(level_l, f.more_l, f.dry_l)
    return level_t, level_l, f.force_t, f.force_l


@compiled
def _raised(level: float, more: float, dry: float) -> float:
    """Level at which the dry part is ``dry + more``, but not below a tenth of ``dry``."""
    if more == 0.0 or dry == 0.0:
        return level
    return level * max(LEAST_DRY, 1.0 + more / dry)
