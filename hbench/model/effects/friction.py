"""Effects of friction and ends of the stroke; see ``catalogue.py`` for how a law is called.

Most change the magnitude of the cylinder's own dry friction, whatever its law, so that the law's
memory carries the change too. Each is neutral, to the bit, where its coefficient is 0.
"""

from math import copysign, exp, log10

import numpy as np

from hbench.model.compiled import inlined
from hbench.model.cylinders import pressure_force
from hbench.model.effects.couplings import Coefficients, FrictionTerms
from hbench.model.effects.flows import PRESSURE_PA
from hbench.model.effects.shapes import power_law
from hbench.model.friction.laws import steady_parts
from hbench.model.parameters import FrictionParameters, PlantParameters
from hbench.model.states import P_LP, P_LR, P_TP, P_TR, V, X

_AT_REST_M_S = 1e-4
_FORCE_N = 2500.0  # where a law with another exponent stays the same
_SPEED_M_S = 0.05  # where one that follows the Stribeck curve stays the same


@inlined
def add_dry(f: FrictionTerms, test: float, load: float) -> FrictionTerms:
    """Add to the dry magnitudes [N]."""
    return FrictionTerms(f.dry_t, f.dry_l, f.more_t + test, f.more_l + load, f.force_t, f.force_l)


@inlined
def stribeck_factor(
    share: float, v: float, p_p: float, p_r: float, par: FrictionParameters
) -> float:
    """Factor on added dry friction, a ``share`` of which follows the law's own over the speed."""
    if share == 0.0:
        return 1.0
    usual, _ = steady_parts(_SPEED_M_S, p_p, p_r, 1.0, par)
    own, _ = steady_parts(v, p_p, p_r, 1.0, par)
    return 1.0 if usual == 0.0 else 1.0 + share * (abs(own) / usual - 1.0)


@inlined
def add_force(f: FrictionTerms, test: float, load: float) -> FrictionTerms:
    """Add forces [N], positive against extension."""
    return FrictionTerms(f.dry_t, f.dry_l, f.more_t, f.more_l, f.force_t + test, f.force_l + load)


def seal_pressure_friction(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Seals pressed by the oil: dry friction grows by k_p P_p + k_r P_r.

    Of a piston's two lips one faces each chamber; the rod's faces the rod chamber. With the drop
    across one piston seal instead, as in 3.7, a falling pressure behind it could add friction.
    c: k_p, k_r [N/Pa] of the test and of the load cylinder, an exponent of the pressures other than
    1: the same at 50 bar, and the share that follows the Stribeck curve: the same at 50 mm/s.
    """
    test_p, test_r, load_p, load_r, n, share = c
    v, tp, tr, lp, lr = state[V], state[P_TP], state[P_TR], state[P_LP], state[P_LR]
    p_tp, p_tr = power_law(tp, PRESSURE_PA, n), power_law(tr, PRESSURE_PA, n)
    p_lp, p_lr = power_law(lp, PRESSURE_PA, n), power_law(lr, PRESSURE_PA, n)
    of_test = stribeck_factor(share, v, tp, tr, par.test.friction)
    of_load = stribeck_factor(share, v, lp, lr, par.load.friction)
    return add_dry(
        f, of_test * (test_p * p_tp + test_r * p_tr), of_load * (load_p * p_lp + load_r * p_lr)
    )


def load_friction(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Guides pressed by the load: dry friction grows by k |F|, F the cylinder's pressure force.

    c: k [1] of the test and load cylinder, an exponent of the force other than 1: the same at
    2500 N, and the share that follows the Stribeck curve: the same at 50 mm/s.
    """
    test, load, n, share = c
    v, tp, tr, lp, lr = state[V], state[P_TP], state[P_TR], state[P_LP], state[P_LR]
    f_test = power_law(abs(pressure_force(tp, tr, par.test)), _FORCE_N, n)
    f_load = power_law(abs(pressure_force(lp, lr, par.load)), _FORCE_N, n)
    of_test = stribeck_factor(share, v, tp, tr, par.test.friction)
    of_load = stribeck_factor(share, v, lp, lr, par.load.friction)
    return add_dry(f, test * of_test * f_test, load * of_load * f_load)


def direction_asymmetry(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Lips that rub unequally: dry friction is F (1 + k sign v). c: k [1], test and load.

    F includes the terms of pressure and load, as if they were in the friction law.
    """
    test, load = c
    way = copysign(1.0, state[V])
    return add_dry(f, way * test * (f.dry_t + f.more_t), way * load * (f.dry_l + f.more_l))


def friction_lag(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Frictional memory: the dry part follows a speed that lags, tau ds/dt = |v| - s.

    c: tau [s]. Both cylinders (Hess and Soom, J. Tribology 112, 1990, as a first-order lag).
    Pressures act at once. The change is that of the nominal level.
    """
    (tau,) = c
    if tau == 0.0:
        rates[at] = 0.0
        return f
    speed, lagged = abs(state[V]), state[at]
    rates[at] = (speed - lagged) / tau
    now_t, now_l = _dry(state, speed, par)
    then_t, then_l = _dry(state, lagged, par)
    return add_dry(f, then_t - now_t, then_l - now_l)


@inlined
def _dry(state: np.ndarray, speed: float, par: PlantParameters) -> tuple[float, float]:
    """Dry parts [N] at another speed in the present direction, at nominal level."""
    v = copysign(speed, state[V])
    dry_t, _ = steady_parts(v, state[P_TP], state[P_TR], 1.0, par.test.friction)
    dry_l, _ = steady_parts(v, state[P_LP], state[P_LR], 1.0, par.load.friction)
    return abs(dry_t), abs(dry_l)


def rest_time(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Seals that stick while at rest: dry friction grows by g log10(1 + theta / 1 s).

    The contacts' age grows at rest and is lost over a distance L of sliding:
    dtheta/dt = 1 / (1 + (v / v_0)^2) - |v| theta / L with v_0 = 0.1 mm/s. It is the ageing law of
    rate-and-state friction (Dieterich, J. Geophys. Res. 84, 1979), but does not age in motion, so
    that friction in steady motion does not change. c: g [N] for each decade of the time, L [m].
    """
    growth, length = c
    if growth == 0.0:
        rates[at] = 0.0
        return f
    age = max(state[at], 0.0)
    v = state[V]
    rates[at] = 1.0 / (1.0 + (v / _AT_REST_M_S) ** 2) - abs(v) * age / length
    return add_dry(f, growth * log10(1.0 + age), 0.0)


def presliding(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """A part F of the test cylinder's dry friction builds up over a displacement L.

    dz/dt = (v - |v| z) / L, force F z instead of F sign(v): a seal that shears before it slides
    (Dahl 1968). Friction in steady motion does not change. c: F [N], L [m].
    """
    part, length = c
    if part == 0.0:
        rates[at] = 0.0
        return f
    v, z = state[V], state[at]
    rates[at] = (v - abs(v) * z) / length
    return add_force(add_dry(f, -part, 0.0), part * z, 0.0)


def position_friction(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Bore of varying diameter: a s + b s^2 is added to the test cylinder's dry friction.

    s = -1 and 1 at its ends, 0 in the middle. c: a, b [N].
    """
    slope, bow = c
    s = 2.0 * (state[X] + par.test.offset_m) / par.test.stroke_m - 1.0
    return add_dry(f, s * (slope + bow * s), 0.0)


def thinner_film(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Viscous friction falls with the warm oil's viscosity: B v (exp(-k theta) - 1) is added.

    See ``flows.warmth``. A law without a viscous part B does not change.
    """
    rise, pump, _, k = c
    if rise == 0.0 and pump == 0.0:
        return f
    change = (exp(-k * state[at]) - 1.0) * state[V]
    return add_force(f, change * par.test.friction.viscous, change * par.load.friction.viscous)


def end_cushion(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Trapped oil brakes the test piston near its ends: D (1 - d / L) v while it nears one.

    d is the distance to that end, L the cushion's length; the oil leaves through a laminar gap.
    Away from the end a check valve opens. c: L [m], D [N s/m].
    """
    length, damping = c
    if damping == 0.0:
        return f
    v, position = state[V], state[X] + par.test.offset_m
    distance = par.test.stroke_m - position if v > 0.0 else position
    depth = min(max(1.0 - distance / length, 0.0), 1.0)
    return add_force(f, damping * depth * v, 0.0)


def added_mass(
    f: FrictionTerms, c: Coefficients, state: np.ndarray, at: int, rates: np.ndarray,
    par: PlantParameters,
) -> FrictionTerms:  # fmt: skip
    """Masses m on damped mounts, on either side of the load cell: m dw/dt, tau dw/dt = v - w.

    A rigid mass would take phase from the loops at frequencies that no joint is rigid at.
    c: m [kg] of the test and load side, tau [s].
    """
    test, load, tau = c
    if test == 0.0 and load == 0.0:
        rates[at] = 0.0
        return f
    rates[at] = (state[V] - state[at]) / tau
    return add_force(f, test * rates[at], load * rates[at])
