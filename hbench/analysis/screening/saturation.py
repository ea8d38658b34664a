"""Which sensor is at the end of its converter's range, where a record is marked so."""

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.records import Run

_SENSORS = ("x_m", "p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa", "f_applied_n")
_SAME = 1e-9  # of a channel's range: equal but for rounding
_NEARLY_ALL, _MOST = 0.95, 0.5  # of the marked records


def sensors_at_their_end(run: Run, window: slice) -> str:
    """Return the channels that are at an end of their range in marked records, with the value.

    A converter at its end shows the same value each time, which no other record exceeds: so the
    channels whose highest or lowest value is in nearly all marked records of the window. Where
    there is none, it is those that show one value in the whole run; else, as some records may be
    means of samples inside the range too, those at an end in most of the marked records.
    """
    if run.sensor_saturated is None:
        return ""
    marked = np.flatnonzero(run.sensor_saturated[window]) + (window.start or 0)
    if not len(marked):
        return ""
    shares, throughout = {}, []
    for name in _SENSORS:
        values = getattr(run, name)
        if values is None:
            continue
        if is_constant(values):
            throughout.append(f"{name} shows {_words(name, values[0])} throughout")
            continue
        for end, word in ((values.max(), "most"), (values.min(), "least")):
            there = np.abs(values[marked] - end) <= _SAME * np.ptp(values)
            shares[f"{name} shows {_words(name, end)} at {word}"] = there.mean()
    surely = [words for words, share in shares.items() if share > _NEARLY_ALL]
    mostly = [words for words, share in shares.items() if share > _MOST]
    return ", ".join(surely or throughout or mostly)


def _words(name: str, value: float) -> str:
    if name.endswith("_pa"):
        return f"{value / 1e5:.1f} bar"
    return f"{1e3 * value:.1f} mm" if name == "x_m" else f"{value:.0f} N"
