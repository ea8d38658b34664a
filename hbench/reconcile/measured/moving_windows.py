"""Windows of motion far from a reversal, in which logs and model are checked."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hbench.reconcile.measured.balances import BalanceModel, driving_signals, measured_laws
from hbench.reconcile.measured.session import COMMANDS, Session
from hbench.records.reconcile.diagnosis import REST_M_S

FEWEST = 20  # windows that show something
SIGMAS = 4.0  # of its standard error, at least: what a fit shows
_FAR = 0.5  # relative change of the velocity over a window: the motion does not reverse near it


@dataclass(frozen=True)
class Moving:
    """Windows (w,) of motion: their means, and their runs."""

    v_m_s: np.ndarray
    a_m_s2: np.ndarray
    pressures_pa: np.ndarray  # (4, w) Tp, Tr, Lp, Lr
    force_n: np.ndarray  # applied
    commands_v: dict[str, np.ndarray]  # nan where not measured
    needed_m3_s: np.ndarray  # (4, w) flows into the chambers by the motion ...
    by_law_m3_s: np.ndarray  # (4, w) ... and by commands and pressures
    run: np.ndarray


def moving_windows(logs: Sequence[Session], model: BalanceModel) -> Moving:
    """Return the windows of all logs in which the piston moves, and does not soon reverse."""
    parts, first = [], 0
    test, load = model.par.test, model.par.load
    areas = test.area_piston_m2, -test.area_rod_m2, -load.area_piston_m2, load.area_rod_m2
    for log in logs:
        signals = driving_signals(log, model)
        v = log.rate(signals[0])
        a = log.second(signals[0])
        change = np.abs(a) * log.window.dt_s * len(log.window.value)
        at = (np.abs(v) > REST_M_S) & (change < _FAR * np.abs(v))
        laws = measured_laws(log, model)
        by_law = np.exp(log.mean(laws.log_volume)) * log.mean(laws.per_volume)
        has = {name: log.measured[name][log.run_of_window] for name in COMMANDS}
        parts.append(
            Moving(
                v[at],
                a[at],
                log.mean(signals[2:6])[:, at],
                log.mean(log.channels["f_applied_n"])[at],
                {
                    name: np.where(own, log.mean(log.channels[name]), np.nan)[at]
                    for name, own in has.items()
                },
                np.outer(areas, v[at]),
                by_law[:, at],
                log.run_of_window[at] + first,
            )
        )
        first += len(log.runs)
    return Moving(
        np.concatenate([part.v_m_s for part in parts]),
        np.concatenate([part.a_m_s2 for part in parts]),
        np.concatenate([part.pressures_pa for part in parts], axis=1),
        np.concatenate([part.force_n for part in parts]),
        {name: np.concatenate([part.commands_v[name] for part in parts]) for name in COMMANDS},
        np.concatenate([part.needed_m3_s for part in parts], axis=1),
        np.concatenate([part.by_law_m3_s for part in parts], axis=1),
        np.concatenate([part.run for part in parts]),
    )
