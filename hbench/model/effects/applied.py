"""Laws of all effects composed into one function for each place of the plant's equations."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from hbench.model.compiled import inlined
from hbench.model.effects.catalogue import EFFECTS
from hbench.model.effects.couplings import (
    ChamberFlows,
    FrictionTerms,
    OilProperties,
    Openings,
    PortFlows,
)
from hbench.model.effects.learned import (
    learned_flows,
    learned_friction,
    learned_supply,
    reading_of,
)
from hbench.model.effects.rows import MOVING, Effect
from hbench.model.friction.laws import steady_parts
from hbench.model.parameters import PlantParameters
from hbench.model.states import (
    P_LP,
    P_LR,
    P_TP,
    P_TR,
    SPOOL_L1,
    SPOOL_L2,
    SPOOL_T,
    V,
    X,
    bristles_end,
)

LEAST_DRY = 0.1  # of the law's dry friction, a lower limit of effects: friction stays passive

_STATES = sum(row.states for row in EFFECTS.values())
# Place of the oil's warming among the effects' states.
_WARMTH = sum(row.states for row in list(EFFECTS.values())[: list(EFFECTS).index("oil_warming")])


def compose(place: str, effects: Mapping[str, Effect]) -> Callable:
    """Return ``apply(terms, first, state, rates, par)``: all laws of a place, compiled into one.

    ``first`` is the index of the effects' first state.
    """

    @inlined
    def apply(terms, first, state, rates, par):
        return terms

    at = 0
    for number, row in enumerate(effects.values()):
        if place in row.laws:
            apply = _composed(apply, inlined(row.laws[place]), number, at)
        at += row.states
    return apply


def _composed(before: Callable, law: Callable, number: int, at: int) -> Callable:
    @inlined
    def both(terms, first, state, rates, par):
        terms = before(terms, first, state, rates, par)
        return law(terms, par.effects[number], state, first + at, rates, par)

    return both


SUPPLY_DROOP = list(EFFECTS).index("supply_droop")

_openings, _oil, _ports, _flows, _friction = (compose(place, EFFECTS) for place in MOVING)


@inlined
def effect_states(effects: tuple[tuple[float, ...], ...] | None) -> int:
    """Return the number of states that the effects have."""
    if effects is None:
        return 0
    return _STATES


# ``effects`` is ``par.effects``: where this argument is None, the code below is not compiled.


@inlined
def openings(state: np.ndarray, par: PlantParameters, effects: Any, rates: np.ndarray) -> Openings:
    """Return the openings of the valves: their spools, changed by the effects."""
    spools = Openings(state[SPOOL_T], state[SPOOL_L1], state[SPOOL_L2])
    if effects is None:
        return spools
    return _openings(spools, bristles_end(par), state, rates, par)


@inlined
def oil(state: np.ndarray, par: PlantParameters, effects: Any, rates: np.ndarray) -> OilProperties:
    """Return tank pressure and bulk moduli, changed by the effects."""
    beta = par.bulk_modulus_pa
    constant = OilProperties(par.supply.tank_pa, beta, beta, beta, beta)
    if effects is None:
        return constant
    return _oil(constant, bristles_end(par), state, rates, par)


@inlined
def oil_temperature(state: np.ndarray, par: PlantParameters, effects: Any) -> float:
    """Return the oil's temperature in the tank [K]: that at the start and the warming since."""
    if effects is None:
        return par.oil_k
    return par.oil_k + state[bristles_end(par) + _WARMTH]


@inlined
def position_reading(state: np.ndarray, par: PlantParameters, effects: Any) -> float:
    """Return the position [m] that the sensor shows."""
    if effects is None:
        return state[X]
    return reading_of(state[X], par.learned)


@inlined
def port_effects(
    flows: PortFlows, state: np.ndarray, par: PlantParameters, effects: Any, rates: np.ndarray
) -> ChamberFlows:
    """Return the flows of the valves' ports, changed by the effects."""
    if effects is None:
        return flows.q
    return _ports(flows, bristles_end(par), state, rates, par).q


@inlined
def flow_effects(
    q: ChamberFlows, state: np.ndarray, par: PlantParameters, effects: Any, rates: np.ndarray
) -> ChamberFlows:
    """Return the flows into the chambers: ``q`` of the valves, changed by the effects.

    The effects' rates go into ``rates``, with that of a supply pressure that they change.
    """
    if effects is None:
        return q
    q = _flows(q, bristles_end(par), state, rates, par)
    learned_supply(q.drawn, par.learned, effects[SUPPLY_DROOP], state, rates, par)
    return learned_flows(q, par.learned, state, par)


@inlined
def friction_effects(
    level_t: float,
    level_l: float,
    state: np.ndarray,
    par: PlantParameters,
    effects: Any,
    rates: np.ndarray,
) -> tuple[float, float, float, float]:
    """Return the levels of dry friction of test and load cylinder, and forces [N] to add."""
    if effects is None:
        return level_t, level_l, 0.0, 0.0
    v = state[V]
    dry_t, _ = steady_parts(v, state[P_TP], state[P_TR], level_t, par.test.friction)
    dry_l, _ = steady_parts(v, state[P_LP], state[P_LR], level_l, par.load.friction)
    terms = FrictionTerms(abs(dry_t), abs(dry_l), 0.0, 0.0, 0.0, 0.0)
    f = _friction(terms, bristles_end(par), state, rates, par)
    f = learned_friction(f, par.learned, state, par)
    level_t = _raised(level_t, f.more_t, f.dry_t)
    level_l = _raised(level_l, f.more_l, f.dry_l)
    return level_t, level_l, f.force_t, f.force_l


@inlined
def _raised(level: float, more: float, dry: float) -> float:
    """Return the level at which the dry part is ``dry + more``, at least a tenth of ``dry``."""
    if more == 0.0 or dry == 0.0:
        return level
    return level * max(LEAST_DRY, 1.0 + more / dry)
