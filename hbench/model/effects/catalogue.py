"""Catalogue of the physical effects that a plant can have.

An effect is a row of ``EFFECTS``, in three files by the kind of effect. A row also states which
signals move, what looks alike and what to inspect (``rows.Effect``), from which README.md
(``guide.py``) and the page of a diagnosis are made. Its law is a pure function for the place where
it acts:

    law(terms, c, state, at, rates, par) -> terms

``terms`` is the place's tuple (``couplings.py``) after the effects above it in the table; ``c`` are
the effect's coefficients in SI, in the row's order. Its own states begin at ``state[at]``; it
always writes their rates to the same indices of ``rates``. With all coefficients at their defaults
it must return ``terms`` unchanged to the bit. Places: ``openings`` of the valves, ``oil``,
``ports`` of the valves, ``flows`` into the chambers, ``friction``. Laws of these places are
compiled; functions that they call need the decorator ``inlined`` (``hbench.model.compiled``). An
effect with two laws has the same states in both. Two more places take parameters and return others,
``law(parameters, c)``: ``sensors`` and ``board`` (its controllers). Linearisation and
``reconcile/measured/balances.py`` use the plant without effects.

To add an effect without changing hbench, write one function and one row in a file and name that
file in the environment variable ``HBENCH_EFFECTS`` (``rows.py``). Simulation and reconcile then
use it.

    from hbench.model.effects.catalogue import Coefficient, Effect
    from hbench.model.effects.couplings import OilProperties

    def cavity(oil, c, state, at, rates, par):
        '''A soft hose at the test cylinder's rod side: 1 / beta grows by c.'''
        soft = 1.0 / (1.0 / oil.beta_tr + c[0])
        return OilProperties(oil.tank_pa, oil.beta_tp, soft, oil.beta_lp, oil.beta_lr)

    EFFECTS = {
        "soft_hose": Effect("1 / beta of Tr grows", {"soft": Coefficient("1/bar", 1e-4, 0, 0.1)},
                            ("flow_tr",), {"oil": cavity}),
    }

Without any of the effects that act in the equations of motion ``par.effects`` is None, and their
code is not compiled at all. With one of them all are, so that coefficients vary without compiling.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from hbench.config.effects import Coefficient as Coefficient  # for a user's file of effects
from hbench.config.effects import Effects as Section
from hbench.config.effects import LearnedLaw, parse_effects
from hbench.errors import ConfigError
from hbench.model.effects import flow_rows, friction_rows, instrument_rows
from hbench.model.effects.learned import learned_table
from hbench.model.effects.rows import (
    MOVING,
    Effect,
    Separation,
    call_own,
    check_neutral,
    own_effects,
)
from hbench.model.parameters import PlantParameters

Values = Mapping[str, Mapping[str, float]]  # effect: coefficient: number in SI


# Effects at the same place act in this order.
_CATALOGUE: dict[str, Effect] = {**flow_rows.ROWS, **friction_rows.ROWS, **instrument_rows.ROWS}
_OWN = own_effects(_CATALOGUE)
EFFECTS: dict[str, Effect] = {**_CATALOGUE, **_OWN}
_unchecked = dict(_OWN)


def lookalikes(name: str, effects: Mapping[str, Effect] = EFFECTS) -> dict[str, Separation]:
    """Return the effects that are confused with one, each with the run that separates the two."""
    pairs = dict(effects[name].confused_with)
    for other, row in effects.items():
        if name in row.confused_with:
            pairs[other] = row.confused_with[name]
    return pairs


def read_effects(section: Section) -> dict[str, dict[str, float]]:
    """Return the coefficients [SI] of a file's section ``effects``. Raises ``ConfigError``."""
    return parse_effects(section, {name: row.coefficients for name, row in EFFECTS.items()})


def changed_by(place: str, parameters: Any, values: Values) -> Any:
    """Return the parameters of ``sensors`` or ``board``, changed by the effects of that place."""
    for name, coefficients in values.items():
        law = EFFECTS[name].laws.get(place)
        if law is not None:
            c = _in_order(name, coefficients)
            is_own = name in _OWN
            parameters = call_own(name, law, parameters, c) if is_own else law(parameters, c)
    return parameters


def with_effects(
    par: PlantParameters, values: Values, learned: Sequence[LearnedLaw] = ()
) -> PlantParameters:
    """Add effects and learned laws to a plant that has none. Raises ``ConfigError``."""
    if "supply_droop" in values and par.supply.has_pump:
        raise ConfigError(
            "effects.supply_droop: the supply has a pump, which has a droop of its own",
            "Change supply.pump.band, or remove supply.pump.",
        )
    if par.supply.has_pump and any(law.adds_to == "supply" for law in learned):
        raise ConfigError(
            "learned: a law that adds to supply is of a source without pump",
            "Remove that law, or supply.pump.",
        )
    if not learned and all(set(MOVING).isdisjoint(EFFECTS[name].laws) for name in values):
        return par
    return with_all_effects(par, values, learned)


def with_all_effects(
    par: PlantParameters, values: Values, learned: Sequence[LearnedLaw]
) -> PlantParameters:
    """Add all effects, those without ``values`` with their defaults: one type for the compiler."""
    rows = tuple(_in_order(name, values.get(name, {})) for name in EFFECTS)
    par = par._replace(effects=rows, learned=learned_table(learned))
    if _unchecked:
        check_neutral(_unchecked, par)
        _unchecked.clear()
    return par


def _in_order(name: str, values: Mapping[str, float]) -> tuple[float, ...]:
    """Return the coefficients in the row's order, with defaults for those not given."""
    row = EFFECTS[name].coefficients
    return tuple(float(values.get(key, c.to_si(c.default))) for key, c in row.items())
