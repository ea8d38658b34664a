"""Identification of the saturated sensors in records marked as ``sensor_saturated``."""

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.channels import CHANNELS
from hbench.records import Run

_SENSORS = ("x_m", "p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa", "f_applied_n")
_SAME = 1e-9  # of a channel's range: equal within rounding
_NEARLY_ALL, _MOST = 0.95, 0.5  # of the marked records


def saturated_sensors(run: Run, window: slice) -> str:
    """Return the symbols of the saturated channels in the marked records, with their values.

    A saturated converter has a constant value, which no other record exceeds. So these are the
    channels whose highest or lowest value occurs in nearly all marked records of the window, and
    not in unmarked ones. If there are none, they are the channels that are constant in the whole
    run, or else those at their highest or lowest value in most marked records, since a record can
    average saturated and unsaturated samples.
    """
    if run.sensor_saturated is None:
        return ""
    marked = np.flatnonzero(run.sensor_saturated[window]) + (window.start or 0)
    if not len(marked):
        return ""
    unmarked = np.flatnonzero(~run.sensor_saturated)
    shares, throughout = {}, []
    for name in _SENSORS:
        symbol, values = CHANNELS[name].symbol, getattr(run, name)
        if values is None:
            continue
        if is_constant(values):
            throughout.append(f"{symbol} is constant at {_value(name, values[0])}")
            continue
        for limit, side in ((values.max(), "maximum"), (values.min(), "minimum")):
            at_limit = np.abs(values - limit) <= _SAME * np.ptp(values)
            share = at_limit[marked].mean()
            if len(unmarked):
                share -= at_limit[unmarked].mean()
            shares[f"{symbol} is at its {side}, {_value(name, limit)}"] = share
    nearly_all = [text for text, share in shares.items() if share > _NEARLY_ALL]
    most = [text for text, share in shares.items() if share > _MOST]
    return ", ".join(nearly_all or throughout or most)


def _value(name: str, value: float) -> str:
    if name.endswith("_pa"):
        return f"{value / 1e5:.1f} bar"
    return f"{1e3 * value:.1f} mm" if name == "x_m" else f"{value:.0f} N"
