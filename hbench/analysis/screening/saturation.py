"""Identification of the saturated sensors and valves in records that are marked as saturated."""

from collections.abc import Iterator, Sequence

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.channels import CHANNELS
from hbench.records import Run

_SENSORS = ("x_m", "p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa", "f_applied_n")
_VALVES = ("u_t_v", "u_l1_v", "u_l2_v")
_SAME = 1e-9  # of a channel's range: equal within rounding
_NEARLY_ALL, _MOST = 0.95, 0.5  # of the marked records


def saturated_sensors(run: Run, window: slice) -> str:
    """Return the symbols of the saturated channels in the marked records, with their values.

    A saturated converter has a constant value, which no other record exceeds. So these are the
    channels whose highest or lowest value occurs in nearly all marked records of the window, and
    not in unmarked ones. If there are none, they are the channels that are constant in the whole
    run, or else those at their highest or lowest value in most marked records, since a record can
    average saturated and unsaturated samples. A frozen channel is constant in the marked records.
    """
    return _at_limits(run, run.sensor_saturated, window, _SENSORS)


def saturated_valves(run: Run, window: slice) -> str:
    """Return the symbols of the valve commands at their limit, as ``saturated_sensors`` does.

    The valves have one voltage limit, so a command below the largest of the run is not at it.
    """
    names = [name for name in _VALVES if getattr(run, name) is not None]
    peaks = {name: np.abs(getattr(run, name)).max(initial=0.0) for name in names}
    limit = max(peaks.values(), default=0.0)
    names = [name for name in names if peaks[name] >= (1 - _SAME) * limit]
    return _at_limits(run, run.valve_saturated, window, names)


def saturation_reasons(
    code: str, flags: np.ndarray | None, window: slice, what: str, of: str = "window"
) -> Iterator[str]:
    """Yield the reason to reject a run with saturated records (n,) in a window; none without.

    ``what`` are the channels at their limits, empty where the log does not show which they are.
    """
    if flags is None or not (count := int(np.sum(flags[window]))):
        return
    every = len(flags[window])
    number = f"all {every}" if count == every else f"{count} of the {every}"
    channels = f"{what}, " if what else ""
    yield f"{code}: {channels}in {number} records of the {of} (none allowed)"


def _at_limits(run: Run, flags: np.ndarray | None, window: slice, names: Sequence[str]) -> str:
    if flags is None:
        return ""
    marked = np.flatnonzero(flags[window]) + (window.start or 0)
    if not len(marked):
        return ""
    unmarked = np.flatnonzero(~flags)
    shares, throughout, held = {}, [], []
    for name in names:
        symbol, values = CHANNELS[name].symbol, getattr(run, name)
        if values is None:
            continue
        if is_constant(values):
            throughout.append(f"{symbol} is constant at {_value(name, values[0])}")
            continue
        if len(marked) > 1 and is_constant(values[marked]):
            held.append(f"{symbol} is frozen at {_value(name, values[marked[0]])}")
        for limit, side in ((values.max(), "maximum"), (values.min(), "minimum")):
            at_limit = np.abs(values - limit) <= _SAME * np.ptp(values)
            share = at_limit[marked].mean()
            if len(unmarked):
                share -= at_limit[unmarked].mean()
            shares[f"{symbol} is at its {side}, {_value(name, limit)}"] = share
    nearly_all = [text for text, share in shares.items() if share > _NEARLY_ALL]
    most = [text for text, share in shares.items() if share > _MOST]
    if held and len(unmarked):  # a constant of a map is constant in unmarked records as well
        throughout = []
    return ", ".join(nearly_all or throughout or most or held)


def _value(name: str, value: float) -> str:
    if name.endswith("_pa"):
        return f"{value / 1e5:.1f} bar"
    if name.endswith("_v"):
        return f"{value:.1f} V"
    return f"{1e3 * value:.1f} mm" if name == "x_m" else f"{value:.0f} N"
