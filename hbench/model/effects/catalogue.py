"""Catalogue of the physical effects that a plant can have.

An effect is a row of ``EFFECTS`` and a law, a pure function for the place where it acts:

    law(terms, c, state, at, rates, par) -> terms

``terms`` is the place's tuple (``couplings.py``) after the effects above it in the table; ``c`` are
the effect's coefficients in SI, in the row's order. Its own states begin at ``state[at]``; it
always writes their rates to the same indices of ``rates``. With all coefficients at their defaults
it must return ``terms`` unchanged to the bit. Places: ``openings`` of the valves, ``oil``,
``flows`` into the chambers, ``friction``. Laws of these places are compiled; functions that they
call need the decorator ``inlined`` (``hbench.model.compiled``). An effect with two laws has the
same states in both. Two more places take parameters and return others, ``law(parameters, c)``:
``sensors`` and ``board`` (its controllers). Linearisation and ``reconcile/measured/balances.py``
use the plant without effects.

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

from hbench.config.effects import Coefficient, LearnedLaw, parse_effects
from hbench.config.effects import Effects as Section
from hbench.errors import ConfigError
from hbench.model.effects import flows, friction, instruments
from hbench.model.effects.learned import learned_table
from hbench.model.effects.rows import MOVING, Effect, call_own, check_neutral, own_effects
from hbench.model.parameters import PlantParameters

Values = Mapping[str, Mapping[str, float]]  # effect: coefficient: number in SI


def _c(unit: str, typical: float, low: float, high: float, default: float = 0.0) -> Coefficient:
    return Coefficient(unit, typical, low, high, default)


_FLOWS = ("flow_tp", "flow_tr", "flow_lp", "flow_lr")
_FORCES = ("force_test", "force_load")
_VALVES = ("test", "load_1", "load_2")
_LINEAR = _c("1", 0, 0.3, 3, 1)  # exponent
_LEAK = _c("l/min/bar", 3e-3, 0, 1)
_BOTH_SHARE = {"test": _c("%", 5, -50, 50), "load": _c("%", 5, -50, 50)}
_BAR = _c("bar", 0.5, -20, 20)

# Effects at the same place act in this order.
_CATALOGUE: dict[str, Effect] = {
    "valve_trim": Effect(
        "each valve has a gain and a null of its own",
        {
            **{f"gain_{valve}": _c("%", 5, -50, 50) for valve in _VALVES},
            **{f"null_{valve}": _c("V", 0.05, -2, 2) for valve in _VALVES},
            "curvature": _c("1/V", 0.005, -0.1, 0.1),
            "exponent": _c("1", 0.02, -0.2, 0.5),
        },
        _FLOWS, {"openings": flows.valve_trim, "flows": flows.port_exponent},
    ),
    "valve_lag": Effect(
        "each valve's opening follows its spool with a first-order lag",
        {"time": _c("ms", 3, 0.1, 100)},
        _FLOWS, {"openings": flows.valve_lag}, states=3,
    ),
    "valve_deadband": Effect(
        "a valve opens only beyond a voltage",
        {"test": _c("V", 0.05, 0, 5), "load": _c("V", 0.05, 0, 5), "softness": _c("1", 0, 0, 5)},
        _FLOWS, {"openings": flows.valve_deadband},
    ),
    "valve_asymmetry": Effect(
        "a valve opens further in one direction than in the other",
        {**_BOTH_SHARE, "knee": _c("V", 0, 0, 10)},
        _FLOWS, {"openings": flows.valve_asymmetry},
    ),
    "entrained_air": Effect(
        "free air makes the oil softer at low pressure",
        {"fraction": _c("%", 2, 0, 20)},
        _FLOWS, {"oil": flows.entrained_air},
    ),
    "tank_back_pressure": Effect(
        "the pressure at the valves' return ports rises with the return flow's square",
        {
            "resistance": _c("bar min^2/l^2", 0.005, 0, 10),
            "lag": _c("ms", 0, 1, 1e4, 5),
            "exponent": _c("1", 0, 0.3, 3, 2),
        },
        _FLOWS, {"oil": flows.tank_back_pressure, "flows": flows.return_line}, states=1,
    ),
    "supply_droop": Effect(
        "the supply pressure falls with the flow drawn",
        {
            "slope": _c("bar min/l", 0.1, 0, 50),
            "lag": _c("ms", 0, 1, 1e4, 20),
            "exponent": _LINEAR,
        },
        ("supply",), {"flows": flows.supply_droop},
    ),
    "oil_warming": Effect(
        "the oil warms with the pump and the power drawn: less viscous friction, more leakage",
        {
            "rise": _c("K/kW", 10, 0, 1e3),
            "pump": _c("K", 10, 0, 200),
            "time": _c("s", 0, 0.1, 1e5, 300),
            "viscosity": _c("1/K", 0, 0, 0.1, 0.03),
        },
        (*_FORCES, *_FLOWS), {"flows": flows.warmth, "friction": friction.thinner_film}, states=1,
        builds_up=True,
    ),
    "internal_leakage": Effect(
        "oil leaks across the piston with the pressure drop",
        {"test": _LEAK, "load": _LEAK, "exponent": _LINEAR},
        _FLOWS, {"flows": flows.internal_leakage},
    ),
    "external_leakage": Effect(
        "oil leaks out of a chamber with its pressure",
        {"tp": _LEAK, "tr": _LEAK, "lp": _LEAK, "lr": _LEAK, "exponent": _LINEAR},
        _FLOWS, {"flows": flows.external_leakage},
    ),
    "seal_pressure_friction": Effect(
        "dry friction grows with the pressures on piston and rod side",
        {
            **{f"{side}_{chamber}": _c("N/bar", 0.5, 0, 1e3)
               for side in ("test", "load") for chamber in ("piston", "rod")},
            "exponent": _LINEAR,
        },
        _FORCES, {"friction": friction.seal_pressure_friction},
    ),
    "load_friction": Effect(
        "dry friction grows with the cylinder's force",
        {"test": _c("%", 2, 0, 100), "load": _c("%", 2, 0, 100), "exponent": _LINEAR},
        _FORCES, {"friction": friction.load_friction},
    ),
    "direction_asymmetry": Effect(
        "dry friction is larger in one direction",
        {"test": _c("%", 10, -90, 90), "load": _c("%", 10, -90, 90)},
        _FORCES, {"friction": friction.direction_asymmetry},
    ),
    "friction_lag": Effect(
        "dry friction follows the speed with a lag",
        {"time": _c("ms", 60, 0.1, 1e3)},
        _FORCES, {"friction": friction.friction_lag}, states=1,
    ),
    "rest_time": Effect(
        "dry friction of the test cylinder grows with the time at rest",
        {"growth": _c("N", 20, 0, 1e4), "length": _c("mm", 0, 0.01, 100, 10)},
        (), {"friction": friction.rest_time}, states=1,
    ),
    "presliding": Effect(
        "a part of the test cylinder's dry friction builds up over a displacement",
        {"force": _c("N", 100, 0, 1e5), "length": _c("mm", 0, 0.05, 100, 2)},
        ("force_test",), {"friction": friction.presliding}, states=1,
    ),
    "position_friction": Effect(
        "dry friction of the test cylinder depends on the position",
        {"slope": _c("N", 40, -1e5, 1e5), "bow": _c("N", 40, -1e5, 1e5)},
        ("force_test",), {"friction": friction.position_friction},
    ),
    "end_cushion": Effect(
        "trapped oil brakes the test piston near the ends of its stroke",
        {"length": _c("mm", 0, 1, 1e3, 100), "damping": _c("N s/m", 10000, 0, 1e6)},
        ("force_test",), {"friction": friction.end_cushion},
    ),
    "added_mass": Effect(
        "the moving masses are larger",
        {"test": _c("kg", 20, 0, 500), "load": _c("kg", 20, 0, 500), "lag": _c("ms", 0, 1, 100, 3)},
        _FORCES, {"friction": friction.added_mass}, states=1,
    ),
    "load_cell_gain": Effect(
        "the load cell shows a share too much",
        {"error": _c("%", 2, -50, 50)},
        _FORCES, {"sensors": instruments.load_cell_gain},
    ),
    "load_cell_offset": Effect(
        "the load cell shows a force too much",
        {"force": _c("N", 30, -1e5, 1e5)},
        _FORCES, {"sensors": instruments.load_cell_offset},
    ),
    "pressure_offset": Effect(
        "a transducer shows a pressure too much",
        {"p_tp": _BAR, "p_tr": _BAR, "p_lp": _BAR, "p_lr": _BAR, "p_s": _BAR},
        (*_FLOWS, *_FORCES, "supply"), {"sensors": instruments.pressure_offset},
    ),
    "pressure_gain": Effect(
        "a transducer shows a share too much",
        {name: _c("%", 1, -20, 20) for name in ("p_tp", "p_tr", "p_lp", "p_lr", "p_s")},
        (*_FLOWS, *_FORCES, "supply"), {"sensors": instruments.pressure_gain},
    ),
    "velocity_filter_lag": Effect(
        "the board's velocity filter is slower than the bench file says",
        {"time": _c("ms", 2, 0, 50)},
        ("kinematics",), {"board": instruments.slower_filter},
    ),
}  # fmt: skip

_OWN = own_effects(_CATALOGUE)
EFFECTS: dict[str, Effect] = {**_CATALOGUE, **_OWN}
_unchecked = dict(_OWN)


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
    if not learned and all(set(MOVING).isdisjoint(EFFECTS[name].laws) for name in values):
        return par
    return with_all_effects(par, values, learned)


def with_all_effects(
    par: PlantParameters, values: Values, learned: Sequence[LearnedLaw] = ()
) -> PlantParameters:
    """Add all effects, those without ``values`` with their defaults: one type for the compiler."""
    rows = (_in_order(name, values.get(name, {})) for name in EFFECTS)
    par = par._replace(effects=(*rows, learned_table(learned)))
    if _unchecked:
        check_neutral(_unchecked, par)
        _unchecked.clear()
    return par


def _in_order(name: str, values: Mapping[str, float]) -> tuple[float, ...]:
    """Return the coefficients in the row's order, with defaults for those not given."""
    row = EFFECTS[name].coefficients
    return tuple(float(values.get(key, c.to_si(c.default))) for key, c in row.items())
