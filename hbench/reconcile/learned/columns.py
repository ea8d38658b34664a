"""Columns of learned laws: means of their modes over the windows of the logs."""

from collections.abc import Sequence

import numpy as np

from hbench.config.effects import Target
from hbench.model.parameters import CylinderParameters
from hbench.reconcile.learned.table import Table, mode_name
from hbench.reconcile.measured.balances import BALANCES, BalanceModel, driving_signals
from hbench.reconcile.measured.session import Session

_ENDS = 0.5, 99.5  # percentiles of the samples: first and last knot
_SLOW_M_S = 1e-3  # the direction of dry friction changes over this speed


def quantity_samples(
    quantity: str, adds_to: Target, session: Session, model: BalanceModel
) -> np.ndarray:
    """Return a quantity (n,) of a target along the logs of a session."""
    signals = driving_signals(session, model)
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


def table_columns(
    table: Table, number: int, sessions: Sequence[Session], model: BalanceModel
) -> dict[str, np.ndarray]:
    """Return the columns (w, c) of a table's modes: changes of the residuals, times -1."""
    parts = [_window_means(table, session, model) for session in sessions]
    modes = np.concatenate(parts, axis=-1)
    columns = {}
    for j, mode in enumerate(modes):
        column = np.zeros((len(mode), len(BALANCES)))
        column[:, BALANCES.index(table.balance)] = mode
        columns[mode_name(number, j)] = column
    return columns


def _window_means(table: Table, session: Session, model: BalanceModel) -> np.ndarray:
    """Return the means (modes, w) of each mode over the windows."""
    samples = [quantity_samples(name, table.adds_to, session, model) for name in table.knots]
    each = [hats(s, knots) for s, knots in zip(samples, table.knots.values(), strict=True)]
    both = each[0]
    if len(each) == 2:
        both = (each[0][:, :, None] * each[1][:, None, :]).reshape(len(samples[0]), -1)
    if table.adds_to.startswith("friction"):
        direction = np.clip(session.velocity_m_s / _SLOW_M_S, -1.0, 1.0)
        both = both * direction[:, None]
    return session.mean((both @ table.basis).T)
