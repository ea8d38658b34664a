"""TDMS files of LabVIEW and DIAdem."""

from typing import Any, BinaryIO

import numpy as np

from hbench.config.import_layout import Format
from hbench.store.formats.arrays import Arrays, Signal, by_name
from hbench.store.formats.date_times import utc


def open_tdms(file: BinaryIO, source: str, layout: Format) -> Arrays:
    """Return the channels of a file; those with waveform properties have times of their own.

    Raises ``DataError``.
    """
    import nptdms

    content = nptdms.TdmsFile.open(file)
    channels = [channel for group in content.groups() for channel in group.channels()]
    starts = [c.properties["wf_start_time"] for c in channels if "wf_start_time" in c.properties]
    origin = min(starts, default=None)
    named = by_name((c.group_name, c.name, _signal(c, origin)) for c in channels)
    return Arrays(named, source, started=None if origin is None else utc(origin))


def _signal(channel: Any, origin: np.datetime64 | None) -> Signal:
    about, size = channel.properties, len(channel)
    step = about.get("wf_increment", 0.0)
    start = about.get("wf_start_offset", 0.0)
    is_known = origin is None or "wf_start_time" in about  # not beside channels that state a start
    if origin is not None and is_known:
        start += (about["wf_start_time"] - origin) / np.timedelta64(1, "s")
    return Signal(
        size,
        lambda: channel[:],
        (lambda: start + step * np.arange(size)) if step and is_known else None,
        about.get("unit_string") or None,
    )
