"""Working point of a campaign, and the balances of a model there in steady motion."""

from collections.abc import Sequence

import numpy as np

from hbench.reconcile.evidence.window_sums import MOTIONS, window_motions
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.measured.along import along, single_start
from hbench.reconcile.measured.balances import CHANNELS_OF, FLOWS, BalanceModel
from hbench.reconcile.measured.session import COMMANDS, PRESSURES, Session
from hbench.records import WorkingPoint
from hbench.records.reconcile.diagnosis import REST_M_S

READINGS = {  # sensors of a working point: field of ``Run`` by channel
    **dict(zip(("p_tp", "p_tr", "p_lp", "p_lr", "p_s"), PRESSURES, strict=True)),
    "f_applied": "f_applied_n",
}
_PLACE = ("f_applied_n", "p_tp_pa", "p_tr_pa")  # with the speed, where the bench works
_RECORD_S = 1e6  # longer than any lag of an effect: its states are at equilibrium
_RECORDS = 3  # states with nonlinear rates take more than one step


def window_means(logs: Sequence[Session], field: str) -> np.ndarray:
    """Return the means (w,) of a channel over all windows; nan where a run does not have it."""
    parts = []
    for log in logs:
        has = np.array([getattr(run, field) is not None for run in log.runs])
        parts.append(np.where(has[log.run_of_window], log.mean(log.channels[field]), np.nan))
    return np.concatenate(parts)


def working_point(logs: Sequence[Session], windows: GapMap) -> WorkingPoint | None:
    """Return the operating point nearest to the medians of the steady windows in one direction.

    The direction is that with the most steady windows; where none is steady, all windows in motion
    count. Medians of all runs are of different runs and need not be at balance, so the measured
    operating point that is nearest to them is taken, in units of their quartiles, and its own
    medians. None where the piston never moves.
    """
    v = windows.v_m_s
    steady = window_motions(windows) == MOTIONS.index("steady")
    moving = np.abs(v) > REST_M_S
    chosen = steady & moving if (steady & moving).any() else moving
    if not chosen.any():
        return None
    extends = np.sum(chosen & (v > 0)) >= np.sum(chosen & (v < 0))
    chosen &= (v > 0) == extends
    fields = (*READINGS.values(), *COMMANDS)
    means = {field: window_means(logs, field) for field in fields}
    nearest = _nearest_point(windows.point, [v, *(means[f] for f in _PLACE)], chosen)
    own = chosen & (windows.point == nearest)
    return WorkingPoint(
        direction="extend" if extends else "retract",
        windows=int(own.sum()),
        v_m_s=_median(v[own]),
        x_m=_median(windows.x_m[own]),
        residuals={
            name: _median(residual[own])
            for name, residual in zip(windows.names, windows.difference.T, strict=True)
        },
        **{field: _median(values[own]) for field, values in means.items()},
    )


def _nearest_point(point: np.ndarray, signals: Sequence[np.ndarray], chosen: np.ndarray) -> int:
    """Return the operating point whose medians are nearest to those of all chosen windows."""
    points = np.unique(point[chosen])
    distance = np.zeros(len(points))
    for signal in signals:
        if not np.isfinite(signal[chosen]).any():
            continue  # not measured
        low, middle, high = np.nanquantile(signal[chosen], (0.25, 0.5, 0.75))
        if high > low:
            own = [_median(signal[chosen & (point == each)]) for each in points]
            distance += np.nan_to_num((np.array(own) - middle) / (high - low)) ** 2
    return int(points[np.argmin(distance)])


def _median(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")


def true_value(reading: np.ndarray | float, channel: str, model: BalanceModel) -> np.ndarray:
    """Return a reading without the errors of the model's sensor."""
    a, b = model.sensors[channel]
    return (np.asarray(reading) - b) / a


def steady_balances(point: WorkingPoint, model: BalanceModel) -> np.ndarray:
    """Return the residuals (8,) of the balances at a working point, all states at equilibrium.

    As in ``measured/balances.py`` without derivatives: the signals are constant, and the laws have
    the states that they reach then. nan where a signal was not measured.
    """
    par = model.par
    p_tp, p_tr, p_lp, p_lr, p_s, applied = (
        float(true_value(getattr(point, field), channel, model))
        for channel, field in READINGS.items()
    )
    commands = [getattr(point, field) for field in COMMANDS]
    signals = np.array([point.x_m, point.v_m_s, p_tp, p_tr, p_lp, p_lr, p_s, *commands])
    log = np.repeat(np.nan_to_num(signals)[:, None], _RECORDS, axis=1)
    levels = np.array(model.levels)[:, None]
    means = along(log, _RECORD_S, par, single_start(_RECORDS, par), levels, step_s=_RECORD_S)
    flows = means.per_volume[:, -1] * np.exp(means.log_volume[:, -1])
    f_test = p_tp * par.test.area_piston_m2 - p_tr * par.test.area_rod_m2
    f_load = p_lp * par.load.area_piston_m2 - p_lr * par.load.area_rod_m2
    test = f_test - applied - means.friction_test[-1]
    load = applied - f_load - means.friction_load[-1]
    supply = p_s - means.supply_pa[-1]
    if par.supply.has_pump:
        supply = means.drawn[-1] * par.supply.band_pa / par.supply.flow_m3_s
    measured = {name for name in (*PRESSURES, *COMMANDS) if np.isfinite(getattr(point, name))}
    flows = np.where([measured.issuperset(CHANNELS_OF[each]) for each in FLOWS], -flows, np.nan)
    return np.array([*flows, test, load, 0.0, supply])
