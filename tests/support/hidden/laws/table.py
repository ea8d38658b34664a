"""The rows of the hidden plants' laws, for ``HBENCH_EFFECTS``."""

from hbench.model.effects.catalogue import Coefficient, Effect
from tests.support.hidden.laws import flows, friction

_FLOWS = ("flow_tp", "flow_tr", "flow_lp", "flow_lr")
_FORCES = ("force_test", "force_load")


def _row(balances, coefficients, states=0, **laws):
    """Return a row; ``coefficients`` are names and units."""
    wide = {key: Coefficient(unit, 0.0, -1e15, 1e15) for key, unit in coefficients.items()}
    return Effect("see its law", wide, balances, laws, states)


_SIDES = {"test": "N", "load": "N"}
_SHARES = {"test": "1", "load": "1"}
_LEAKS = {"test": "m^3/s", "load": "m^3/s"}
_WAVE = {"force": "N", "period": "m", "phase": "1"}

EFFECTS = {
    f"hidden_{name}": row
    for name, row in {
        "valve_lag": _row(
            _FLOWS, {"time": "s", "damping": "1"}, 6, openings=flows.valve_lag
        ),
        "valve_spread": _row(
            _FLOWS,
            {"test": "1", "load_1": "1", "load_2": "1"}
            | {"null_test": "V", "null_load_1": "V", "null_load_2": "V"},
            openings=flows.valve_spread,
        ),
        "valve_deadband": _row(
            _FLOWS, {"test": "V", "load": "V"}, openings=flows.valve_deadband
        ),
        "valve_asymmetry": _row(_FLOWS, _SHARES | {"knee": "V"}, openings=flows.valve_asymmetry),
        "gain_curvature": _row(_FLOWS, {"share": "1"}, openings=flows.gain_curvature),
        "valve_hysteresis": _row(
            _FLOWS, {"test": "V", "load": "V"}, 3, openings=flows.valve_hysteresis
        ),
        "flow_force": _row(_FLOWS, {"share": "1"}, openings=flows.flow_force),
        "laminar_ports": _row(
            _FLOWS, {"transition": "Pa"}, flows=flows.laminar_ports
        ),  # before the leaks, which are not of the valves
        "spool_leak": _row(
            _FLOWS, {"conductance": "m^3/(s Pa)", "overlap": "V"}, flows=flows.spool_leak
        ),
        "entrained_air": _row(
            _FLOWS, {"fraction": "1", "dissolved": "Pa"}, oil=flows.entrained_air
        ),
        "tank_back_pressure": _row(
            _FLOWS, {"resistance": "Pa s/m^3", "lag": "s"}, 1,
            oil=flows.raised_tank, flows=flows.laminar_return,
        ),
        "supply_droop": _row(
            ("supply",), {"slope": "Pa s^2/m^6", "lag": "s"}, flows=flows.supply_droop
        ),
        "internal_leakage": _row(
            _FLOWS, _LEAKS | {"exponent": "1"}, flows=flows.internal_leakage
        ),
        "external_leakage": _row(
            _FLOWS, dict.fromkeys(("tp", "tr", "lp", "lr"), "m^3/s") | {"exponent": "1"},
            flows=flows.external_leakage,
        ),
        "worn_bore": _row(
            _FLOWS, {"leak": "m^3/s", "middle": "m", "width": "m"}, flows=flows.worn_bore
        ),
        "position_error": _row(
            _FLOWS, {"bow": "1", "wave": "1", "period": "m"}, flows=flows.position_error
        ),
        "hose_volume": _row(
            _FLOWS, {"tr": "m^3", "lr": "m^3", "time": "s"}, 2, flows=flows.hose_volume
        ),
        "seal_pressure_friction": _row(
            _FORCES, _SIDES | {"exponent": "1"}, friction=friction.seal_pressure_friction
        ),
        "load_friction": _row(
            _FORCES, _SHARES | {"limit": "N"}, friction=friction.load_friction
        ),
        "direction_asymmetry": _row(
            _FORCES, _SHARES | {"speed": "m/s"}, friction=friction.direction_asymmetry
        ),
        "friction_lag": _row(
            _FORCES, {"time": "s", "speed": "m/s"}, 1, friction=friction.friction_lag
        ),
        "presliding": _row(
            _FORCES, {"force": "N", "short": "m", "long": "m"}, 2, friction=friction.presliding
        ),
        "position_friction": _row(
            _FORCES,
            {"bump": "N", "wave": "N", "middle": "m", "width": "m", "period": "m", "phase": "1"},
            friction=friction.position_friction,
        ),
        "oil_warming": _row(
            _FORCES, {"rise": "K", "time": "s", "viscosity": "1/K"}, 1,
            friction=friction.oil_warming,
        ),
        "end_cushion": _row(
            _FORCES, {"damping": "N s^2/m^2", "length": "m"}, friction=friction.end_cushion
        ),
        "added_mass": _row(
            _FORCES, {"test": "kg", "load": "kg", "time": "s"}, 1, friction=friction.added_mass
        ),
        "bore_ripple": _row(
            _FORCES, {"share": "1", "period": "m", "phase": "1"}, friction=friction.bore_ripple
        ),
        "friction_level": _row(_FORCES, _SHARES, friction=friction.friction_level),
        "bore_chatter": _row(_FORCES, _WAVE, friction=friction.bore_chatter),
        "guide_misalignment": _row(
            _FORCES, {"share": "1"}, friction=friction.guide_misalignment
        ),
        "rest_film": _row(
            _FORCES, {"share": "1", "length": "m", "time": "s"}, 1, friction=friction.rest_film
        ),
    }.items()
}  # fmt: skip
