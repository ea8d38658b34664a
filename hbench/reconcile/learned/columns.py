"""Columns of learned laws: means of their modes over the windows of the logs."""

from collections.abc import Sequence

import numpy as np

from hbench.config.effects import Target
from hbench.model.effects.applied import SUPPLY_DROOP
from hbench.model.effects.catalogue import EFFECTS
from hbench.model.parameters import CylinderParameters
from hbench.reconcile.column_names import mode_name
from hbench.reconcile.learned.table import Table
from hbench.reconcile.measured.balances import (
    BALANCES,
    BalanceModel,
    driving_signals,
    laws_along,
    true_values,
)
from hbench.reconcile.measured.session import Session

_ENDS = 0.5, 99.5  # percentiles of the samples: first and last knot
_SLOW_M_S = 1e-3  # the direction of dry friction changes over this speed
_DROOP_LAG = list(EFFECTS["supply_droop"].coefficients).index("lag")


def quantity_samples(
    quantity: str, adds_to: Target, session: Session, model: BalanceModel
) -> np.ndarray:
    """Return a quantity (n,) of a target along the logs of a session."""
    if adds_to == "position_sensor":
        return true_values(session, "x_m", model, "x")
    signals = driving_signals(session, model)
    if quantity == "drawn_flow":
        none = np.zeros_like(signals[0])  # of friction: it does not change a flow
        return laws_along(session, signals, model, (none, none)).drawn
    x, v, p_tp, p_tr, p_lp, p_lr = signals[:6]
    is_load = adds_to in ("flow_lp", "flow_lr", "force_load", "friction_load")
    p_p, p_r = (p_lp, p_lr) if is_load else (p_tp, p_tr)
    if quantity == "opening":
        valve = {"flow_lr": 8, "flow_lp": 9}.get(adds_to, 7)
        limit = model.par.valve.limit_v
        return np.clip(signals[valve], -limit, limit)
    cylinder: CylinderParameters = model.par.load if is_load else model.par.test
    return {
        "velocity": v,
        "position": x,
        "piston_pressure": p_p,
        "rod_pressure": p_r,
        "pressure_drop": p_p - p_r,
        "hydraulic_force": p_p * cylinder.area_piston_m2 - p_r * cylinder.area_rod_m2,
    }[quantity]


def knots_of(samples: np.ndarray, count: int) -> tuple[float, ...]:
    """Return equidistant knots over the range of samples (n,)."""
    low, high = np.percentile(samples, _ENDS)
    return tuple(np.linspace(low, high, count).tolist())


def hats(samples: np.ndarray, knots: Sequence[float]) -> np.ndarray:
    """Return the piecewise linear basis functions (n, knots) of samples (n,)."""
    return np.stack([np.interp(samples, knots, unit) for unit in np.eye(len(knots))], axis=-1)


def size_in_balances(target: Target, sessions: Sequence[Session], model: BalanceModel) -> float:
    """Return the root mean square over windows and balances that a law of the value 1 has."""
    means = [session.mean(_effect_of_one(target, session, model)) for session in sessions]
    return float(np.sqrt(np.mean(np.concatenate(means, axis=-1) ** 2)))


def table_columns(
    table: Table, number: int, sessions: Sequence[Session], model: BalanceModel
) -> dict[str, np.ndarray]:
    """Return the columns (w, c) of a table's modes: changes of the residuals, times -1."""
    parts = [_window_means(table, session, model) for session in sessions]
    modes = np.concatenate(parts, axis=-1)
    at = [BALANCES.index(name) for name in table.balances]
    columns = {}
    for j, mode in enumerate(modes):
        column = np.zeros((mode.shape[-1], len(BALANCES)))
        column[:, at] = mode.T
        columns[mode_name(number, j)] = column
    return columns


def _window_means(table: Table, session: Session, model: BalanceModel) -> np.ndarray:
    """Return the means (modes, balances, w) of each mode over the windows."""
    samples = [quantity_samples(name, table.adds_to, session, model) for name in table.knots]
    each = [hats(s, knots) for s, knots in zip(samples, table.knots.values(), strict=True)]
    both = each[0]
    if len(each) == 2:
        both = (each[0][:, :, None] * each[1][:, None, :]).reshape(len(samples[0]), -1)
    modes = (both @ table.basis).T
    if table.adds_to == "supply":
        modes = _lagging(modes, session, model)
    effects = _effect_of_one(table.adds_to, session, model)
    return np.stack([session.mean(modes * effect) for effect in effects], axis=1)


def _effect_of_one(target: Target, session: Session, model: BalanceModel) -> np.ndarray:
    """Return what a law of the value 1 adds to its balances (balances, n) along the logs."""
    v = session.velocity_m_s
    if target.startswith("friction"):
        return np.clip(v / _SLOW_M_S, -1.0, 1.0)[None]
    if target != "position_sensor":
        return np.ones((1, len(v)))
    test, load = model.par.test, model.par.load
    areas = -test.area_piston_m2, test.area_rod_m2, load.area_piston_m2, -load.area_rod_m2
    return np.outer(areas, v)


def _lagging(modes: np.ndarray, session: Session, model: BalanceModel) -> np.ndarray:
    """Return the means of modes (m, n) over each record behind the lag of the supply pressure.

    Each log begins without a deviation, as the supply along it does.
    """
    from scipy.signal import lfilter  # slow import

    assert model.par.effects is not None  # a balance model has them all
    lag = model.par.effects[SUPPLY_DROOP][_DROOP_LAG]
    rest = np.exp(-session.window.dt_s / lag)
    out = np.empty_like(modes)
    for start, stop in zip(session.edges[:-1], session.edges[1:], strict=True):
        own = modes[:, start:stop]
        ends = lfilter([1.0 - rest], [1.0, -rest], own)
        before = np.concatenate([np.zeros((len(own), 1)), ends[:, :-1]], axis=1)
        share = (1.0 - rest) * lag / session.window.dt_s  # of a deviation, on average
        out[:, start:stop] = own + share * (before - own)
    return out
