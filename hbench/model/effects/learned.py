"""Learned laws: tables that a plant file adds to the equations beside the effects.

A law adds g(q) or g(q_1, q_2) to one term: the inflow of a chamber, the force against extension of
a cylinder, the magnitude of its dry friction, or the pressure of a source without pump. g is linear
(bilinear) between its knots and constant beyond them. The laws are the rows of one array, so that
laws of any number and size use the same compiled code.

The supply pressure follows its law with the lag of ``supply_droop``, whose default holds without
that effect:

    lag dP_s/dt = P_0 - droop + g - P_s

Where a position sensor shows r, the piston goes 1 + g(r) times as far as its reading:

    x = r + integral of g from the first knot to r
"""

from collections.abc import Sequence

import numpy as np

from hbench.config.effects import MOST_KNOTS, MOST_OF_TWO, QUANTITIES, TARGETS, LearnedLaw
from hbench.model.compiled import compiled, inlined
from hbench.model.cylinders import pressure_force
from hbench.model.effects.couplings import ChamberFlows, Coefficients, FrictionTerms
from hbench.model.effects.friction import add_dry, add_force
from hbench.model.parameters import PlantParameters
from hbench.model.states import P_LP, P_LR, P_S, P_TP, P_TR, SPOOL_L1, SPOOL_L2, SPOOL_T, V, X

# Columns of a row: target, quantities, numbers of knots, knots of either quantity, values.
_SECOND, _COUNTS = 2, 3
_KNOTS = 5
_OTHER_KNOTS = _KNOTS + MOST_KNOTS
_VALUES = _OTHER_KNOTS + MOST_OF_TWO
_WIDTH = _VALUES + max(MOST_KNOTS, MOST_OF_TWO**2)
_NAMES = tuple(QUANTITIES)
_SUPPLY, _POSITION = float(TARGETS.index("supply")), float(TARGETS.index("position_sensor"))
_ROUNDS = 6  # of the reading at a position: each multiplies its error by g


def learned_table(laws: Sequence[LearnedLaw]) -> np.ndarray:
    """Return the rows (laws, numbers) of learned laws for compiled code."""
    rows = np.zeros((len(laws), _WIDTH))
    for row, law in zip(rows, laws, strict=True):
        row[:3] = TARGETS.index(law.adds_to), _NAMES.index(next(iter(law.over))), -1
        row[_COUNTS : _COUNTS + 2] = 1
        for i, (name, knots) in enumerate(law.over.items()):
            row[1 + i], row[_COUNTS + i] = _NAMES.index(name), len(knots)
            first = (_KNOTS, _OTHER_KNOTS)[i]
            row[first : first + len(knots)] = knots
        values = np.array(law.values).ravel()
        row[_VALUES : _VALUES + len(values)] = values
    return rows


@inlined
def learned_flows(
    q: ChamberFlows, c: np.ndarray, state: np.ndarray, par: PlantParameters
) -> ChamberFlows:
    """Add the laws of the chambers' flows."""
    tp, tr, lp, lr = q.tp, q.tr, q.lp, q.lr
    for i in range(c.shape[0]):
        target = c[i, 0]
        if target < 4.0:
            more = _law(c[i], state, q.drawn, par)
            tp += more if target == 0.0 else 0.0
            tr += more if target == 1.0 else 0.0
            lp += more if target == 2.0 else 0.0
            lr += more if target == 3.0 else 0.0
    return ChamberFlows(tp, tr, lp, lr, q.drawn, q.returned, q.fluidity)


@inlined
def learned_supply(
    drawn: float,
    c: np.ndarray,
    droop: Coefficients,
    state: np.ndarray,
    rates: np.ndarray,
    par: PlantParameters,
) -> None:
    """Add the laws of the supply pressure to its rate, which has that of ``droop`` (see there)."""
    slope, lag, _ = droop
    has_rate = slope != 0.0
    for i in range(c.shape[0]):
        if c[i, 0] == _SUPPLY:
            if not has_rate:
                rates[P_S] = (par.supply.pressure_pa - state[P_S]) / lag
                has_rate = True
            rates[P_S] += _law(c[i], state, drawn, par) / lag


@inlined
def reading_of(x: float, c: np.ndarray) -> float:
    """Return what the position sensor shows [m] at the position ``x``."""
    shown = x
    for _ in range(_ROUNDS):
        error, _ = _position_error(shown, c)
        shown = x - error
    return shown


@compiled
def corrected_motion(shown: np.ndarray, slope: np.ndarray, c: np.ndarray) -> None:
    """Replace the reading (n,) of the position and its derivative by position and velocity."""
    for k in range(len(shown)):
        error, more = _position_error(shown[k], c)
        shown[k] += error
        slope[k] *= 1.0 + more


@inlined
def _position_error(shown: float, c: np.ndarray) -> tuple[float, float]:
    """Return the position less its reading [m], and the derivative of this by the reading."""
    error, slope = 0.0, 0.0
    for i in range(c.shape[0]):
        if c[i, 0] != _POSITION:
            continue
        last = int(c[i, _COUNTS]) - 1
        value = c[i, _VALUES]
        error += value * min(shown - c[i, _KNOTS], 0.0)
        for j in range(last):
            low, high = c[i, _KNOTS + j], c[i, _KNOTS + j + 1]
            if shown > low:
                share = min((shown - low) / (high - low), 1.0)
                first = c[i, _VALUES + j]
                value = first + share * (c[i, _VALUES + j + 1] - first)
                error += 0.5 * (first + value) * share * (high - low)
        error += c[i, _VALUES + last] * max(shown - c[i, _KNOTS + last], 0.0)
        slope += value
    return error, slope


@inlined
def learned_friction(
    f: FrictionTerms, c: np.ndarray, state: np.ndarray, par: PlantParameters
) -> FrictionTerms:
    """Add the laws of forces and of dry friction."""
    for i in range(c.shape[0]):
        target = c[i, 0]
        if 4.0 <= target < _SUPPLY:
            more = _law(c[i], state, 0.0, par)
            f = add_force(f, more if target == 4.0 else 0.0, more if target == 5.0 else 0.0)
            f = add_dry(f, more if target == 6.0 else 0.0, more if target == 7.0 else 0.0)
    return f


@inlined
def _law(c: np.ndarray, state: np.ndarray, drawn: float, par: PlantParameters) -> float:
    """Return g of one row at a state; ``drawn`` is the flow from the supply, for its laws."""
    spool = SPOOL_L2 if c[0] == 2.0 else SPOOL_L1 if c[0] == 3.0 else SPOOL_T
    is_load = c[0] == 2.0 or c[0] == 3.0 or c[0] == 5.0 or c[0] == 7.0
    n, m = int(c[_COUNTS]), int(c[_COUNTS + 1])
    at = _place(_quantity(c[1], is_load, state, spool, drawn, par), c, _KNOTS, n)
    i = min(int(at), max(n - 2, 0))
    share = at - i
    if m == 1:
        first = _VALUES + i
        return c[first] + share * (c[first + 1] - c[first])
    second = _quantity(c[_SECOND], is_load, state, spool, drawn, par)
    across = _place(second, c, _OTHER_KNOTS, m)
    j = min(int(across), m - 2)
    part = across - j
    first = _VALUES + i * m + j
    low = c[first] + part * (c[first + 1] - c[first])
    high = c[first + m] + part * (c[first + m + 1] - c[first + m])
    return low + share * (high - low)


@inlined
def _place(q: float, c: np.ndarray, first: int, n: int) -> float:
    """Return the place of q among n knots, 0 to n - 1."""
    if q <= c[first]:
        return 0.0
    for i in range(n - 1):
        low, high = c[first + i], c[first + i + 1]
        if q < high:
            return i + (q - low) / (high - low)
    return n - 1.0


@inlined
def _quantity(
    code: float, is_load: bool, state: np.ndarray, spool: int, drawn: float, par: PlantParameters
) -> float:
    """Return the quantity with this place in ``QUANTITIES``."""
    if code == 0.0:
        return state[V]
    if code == 1.0:
        return state[X]
    if code == 6.0:
        return state[spool]
    if code == 7.0:
        return drawn
    p_p, p_r = (state[P_LP], state[P_LR]) if is_load else (state[P_TP], state[P_TR])
    if code == 2.0:
        return p_p
    if code == 3.0:
        return p_r
    if code == 4.0:
        return p_p - p_r
    if is_load:
        return pressure_force(p_p, p_r, par.load)
    return pressure_force(p_p, p_r, par.test)
