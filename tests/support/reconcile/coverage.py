"""How often the intervals of named effects contain what was hidden.

The hidden laws have other forms than the catalogue's, so their coefficients can't be compared. What
both say at one working point can: a leak's flow at a pressure, a friction force under a load. Those
of ``oil_warming`` and ``position_friction`` share no such point and are left out.
"""

from collections.abc import Callable, Mapping
from math import sqrt

import numpy as np

from hbench.analysis.statistics.student import student_factor
from hbench.model.effects.catalogue import EFFECTS
from hbench.model.effects.flows import with_air
from hbench.model.effects.openings import overlapped
from hbench.reconcile.estimates import ParameterEstimates, whole_dof
from hbench.reconcile.hypothesis import Hypothesis, effect_coefficients
from hbench.reconcile.linearised import hypothesis_at
from tests.support.hidden.laws.flows import compliance, soft_lap

Coefficients = Mapping[str, float]  # SI
Pair = tuple[Callable[[Coefficients], float], Callable[[Coefficients], float]]

_OPENING_V, _STIFF_PA, _AIR_PA = 1.0, 1e12, 20e5
_FLOW_M3_S = 10e-3 / 60
_LOAD_N, _SPEED_M_S = 2500.0, 0.1
_DRAWS = 400


def _same(catalogue: str, hidden: str = "") -> Pair:
    return (lambda c: c[catalogue]), (lambda h: h[hidden or catalogue])


def _leak(side: str, hidden_pa: float) -> Pair:
    """Flow at the pressure for which the hidden law states it; the catalogue's is for 50 bar."""
    return (
        lambda c: c[side] * 50e5 * (hidden_pa / 50e5) ** c["exponent"],
        lambda h: h[side],
    )


def _lost(side: str) -> Pair:
    return (
        lambda c: _OPENING_V - overlapped(_OPENING_V, c[side], c["softness"]),
        lambda h: _OPENING_V - soft_lap(_OPENING_V, h[side]),
    )


def _uneven(side: str) -> Pair:
    return (
        lambda c: c[side] * _OPENING_V / (_OPENING_V + c["knee"]),
        lambda h: h[side] * _OPENING_V / sqrt(_OPENING_V**2 + h["knee"] ** 2),
    )


def _under_load(side: str) -> Pair:
    return (
        lambda c: c[side] * _LOAD_N,
        lambda h: h[side] * _LOAD_N / (1 + _LOAD_N / h["limit"]),
    )


def _direction(side: str) -> Pair:
    return (lambda c: c[side]), (lambda h: h[side] * (1 + _SPEED_M_S / h["speed"]))


_SIDES = ("test", "load")
# By effect and quantity: from the catalogue's coefficients, and from the hidden ones.
QUANTITIES: dict[str, dict[str, Pair]] = {
    "valve_lag": {"delay": _same("time")},
    "valve_deadband": {side: _lost(side) for side in _SIDES},
    "valve_asymmetry": {side: _uneven(side) for side in _SIDES},
    "entrained_air": {
        "compliance at 20 bar": (
            lambda c: 1 / with_air(_STIFF_PA, _AIR_PA, c["fraction"]),
            lambda h: 1 / compliance(_STIFF_PA, _AIR_PA, h["fraction"], h["dissolved"]),
        )
    },
    "tank_back_pressure": {
        "pressure at 10 l/min": (
            lambda c: c["resistance"] * _FLOW_M3_S**2,
            lambda h: h["resistance"] * _FLOW_M3_S,
        )
    },
    "supply_droop": {
        "droop at 10 l/min": (
            lambda c: c["slope"] * _FLOW_M3_S,
            lambda h: h["slope"] * _FLOW_M3_S**2,
        )
    },
    "internal_leakage": {side: _leak(side, 30e5) for side in _SIDES},
    "external_leakage": {side: _leak(side, 50e5) for side in ("tp", "tr", "lp", "lr")},
    "seal_pressure_friction": {
        side: ((lambda c, side=side: c[f"{side}_piston"] * 50e5), (lambda h, side=side: h[side]))
        for side in _SIDES
    },
    "load_friction": {side: _under_load(side) for side in _SIDES},
    "direction_asymmetry": {side: _direction(side) for side in _SIDES},
    "friction_lag": {"time": _same("time")},
    "presliding": {"force": _same("force")},
    "added_mass": {side: _same(side) for side in _SIDES},
    "load_cell_gain": {"error": _same("error")},
    "load_cell_offset": {"force": _same("force")},
    "pressure_offset": {f"p_{name}": _same(f"p_{name}") for name in ("tp", "tr", "lp", "lr", "s")},
    "velocity_filter_lag": {"time": _same("time")},
    "valve_hysteresis": {side: _same(side) for side in _SIDES},
}


def estimated(name: str, fit: ParameterEstimates) -> dict[str, tuple[float, float]]:
    """Return value and half width of the 95 % interval of an effect's quantities.

    The coefficients' covariance is carried over by draws.
    """
    dof = min(
        fit.degrees_of_freedom(which)
        for which in effect_coefficients(name)
        if ".".join(which) in fit.model.data.names
    )
    factor = float(student_factor(whole_dof(dof)))
    best = _coefficients(name, fit.hypothesis)
    betas = np.random.default_rng(1).multivariate_normal(
        fit.beta, fit.covariance, _DRAWS, method="svd"
    )
    within = np.clip(betas, fit.low, fit.high)
    drawn = [
        _coefficients(name, hypothesis_at(fit.model, fit.plant, fit.chosen, beta))
        for beta in within
    ]
    return {
        quantity: (of(best), factor * float(np.std([of(each) for each in drawn])))
        for quantity, (of, _) in QUANTITIES.get(name, {}).items()
    }


def _coefficients(name: str, hypothesis: Hypothesis) -> dict[str, float]:
    return {key: hypothesis.coefficient((name, key)) for key in EFFECTS[name].coefficients}


def hidden(name: str, coefficients: Coefficients) -> dict[str, float]:
    """Return an effect's quantities from what was hidden [SI]."""
    return {key: of(coefficients) for key, (_, of) in QUANTITIES.get(name, {}).items()}
