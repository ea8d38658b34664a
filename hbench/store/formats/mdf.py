"""MDF files of measurement and calibration systems (ASAM MDF, versions 2 to 4)."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, BinaryIO

import numpy as np

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.formats.arrays import Arrays, Signal, by_name
from hbench.store.formats.packages import optional_package

_MAGIC = (b"MDF ", b"UnFinMF ")
_PIECE = 16_000_000  # bytes of records in memory at once
_SECONDS = ("s", "")


def open_mdf(file: BinaryIO, source: str, layout: Format) -> Arrays:
    """Return the channels of a file, read one by one; their times are those of their group.

    Raises ``DataError``, ``ConfigError``.
    """
    asammdf = optional_package("asammdf", "MDF", "mdf")
    is_mdf = file.read(8).startswith(_MAGIC)
    file.seek(0)
    if not is_mdf:
        raise DataError(f"{source}: is not an MDF file")
    try:
        named = by_name(_signals(asammdf.MDF(file)))
    except Exception as error:  # of many kinds
        raise DataError(f"{source}: can't be read as an MDF file: {error}") from None
    return Arrays(named, source)


def _signals(mdf: Any) -> Iterator[tuple[str, str, Signal]]:
    for number, group in enumerate(mdf.groups):
        about, master = group.channel_group, mdf.masters_db.get(number)
        name = getattr(about, "acq_name", "") or f"group {number + 1}"
        records = max(1, _PIECE // max(1, about.samples_byte_nr))
        pieces = [
            {"record_offset": start, "record_count": records}
            for start in range(0, about.cycles_nr, records)
        ]
        # A master may also be an angle or a distance.
        timed = master is not None and mdf.get_channel_unit(group=number, index=master) in _SECONDS
        times = partial(_times, mdf, number, pieces) if timed else None
        for index, channel in enumerate(group.channels):
            if index != master:
                unit = mdf.get_channel_unit(group=number, index=index) or None
                read = partial(_samples, mdf, number, index, pieces)
                yield name, channel.name, Signal(about.cycles_nr, read, times, unit)


def _samples(mdf: Any, group: int, index: int, pieces: Sequence[Mapping[str, int]]) -> np.ndarray:
    """Return a channel (n,); invalid samples are NaN."""
    parts = []
    for piece in pieces:
        samples, invalid = mdf.get(
            group=group, index=index, samples_only=True, ignore_invalidation_bits=True, **piece
        )
        parts.append(samples if invalid is None else np.where(invalid, np.nan, samples))
    return np.concatenate(parts) if parts else np.zeros(0)


def _times(mdf: Any, group: int, pieces: Sequence[Mapping[str, int]]) -> np.ndarray:
    """Return the times (n,) [s] of a group, from the start of the measurement."""
    parts = [mdf.get_master(group, **piece) for piece in pieces]
    return np.concatenate(parts).astype(float) if parts else np.zeros(0)
