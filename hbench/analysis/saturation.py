"""Which sensor is at the end of its converter's range, where a record is marked so."""

import numpy as np

from hbench.records import Run

_SENSORS = ("x_m", "p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa", "f_applied_n")
_SAME = 1e-9  # of a channel's range: equal but for rounding


def sensors_at_their_end(run: Run, window: slice) -> str:
    """Return the channels that are at an end of their range in marked records, with the value.

    A converter at its end shows the same value each time, which no other record exceeds: so the
    channels whose highest or lowest value is in most of the marked records of the window.
    """
    if run.sensor_saturated is None:
        return ""
    marked = np.flatnonzero(run.sensor_saturated[window]) + (window.start or 0)
    found = []
    for name in _SENSORS:
        values = getattr(run, name)
        if values is None or np.ptp(values) == 0 or not len(marked):
            continue
        for end, word in ((values.max(), "most"), (values.min(), "least")):
            there = np.abs(values[marked] - end) <= _SAME * np.ptp(values)
            if there.sum() > len(marked) / 2:
                found.append(f"{name} shows {_words(name, end)} at {word}")
    return ", ".join(found)


def _words(name: str, value: float) -> str:
    if name.endswith("_pa"):
        return f"{value / 1e5:.1f} bar"
    return f"{1e3 * value:.1f} mm" if name == "x_m" else f"{value:.0f} N"
