"""Flow of a pump at a log's supply pressure."""

import numpy as np

from hbench.model.parameters import SupplyParameters


def pump_flow(p_supply_pa: np.ndarray, dt_s: float, source: SupplyParameters) -> np.ndarray:
    """Return the flow [m^3/s] (n,) of a pump with compensator and swash at these pressures.

    Both lags have their exact solution for an input that is constant over each record, and start
    at steady state.
    """
    demanded = source.flow_m3_s * (source.cut_off_pa - p_supply_pa) / source.band_pa
    flow = np.clip(demanded, 0.0, source.flow_m3_s)
    for lag in (source.compensator_lag_s, source.swash_lag_s):
        flow = _lagged(flow, dt_s, lag)
    return flow


def _lagged(y: np.ndarray, dt_s: float, lag_s: float) -> np.ndarray:
    """Return the records' means of y after a first-order lag; y is constant over each record.

    The lag starts at steady state.
    """
    out, state, decay = np.empty_like(y), y[0], np.exp(-dt_s / lag_s)
    for k, value in enumerate(y):
        out[k] = value + (state - value) * (1 - decay) * lag_s / dt_s
        state = value + (state - value) * decay
    return out
