"""MDF files of measurement and calibration systems (ASAM MDF, versions 2 to 4)."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from functools import partial
from typing import Any, BinaryIO

import numpy as np

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.formats.arrays import Arrays, Signal, by_name

_MAGIC = (b"MDF ", b"UnFinMF ")
_PIECE = 16_000_000  # bytes of records in memory at once
_SECONDS = ("s", "")
# A formula is evaluated as a program, so it is refused if it is more than arithmetic.
_FORMULA = re.compile(
    r"(?:[-+*/^(),\s]|\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+|X1?"
    r"|sin|cos|tan|sinh|cosh|tanh|exp|log|log10|sqrt|abs)+"
)


def open_mdf(file: BinaryIO, source: str, layout: Format) -> Arrays:
    """Return the channels of a file, read one by one; their times are those of their group.

    Raises ``DataError``.
    """
    import asammdf

    is_mdf = file.read(8).startswith(_MAGIC)
    file.seek(0)
    if not is_mdf:
        raise DataError(f"{source}: is not an MDF file")
    mdf = asammdf.MDF(file, process_bus_logging=False)
    return Arrays(by_name(_signals(mdf)), source, started=_start(mdf.header))


def _start(header: Any) -> datetime | None:
    """Return the start of the measurement: UTC in version 4, local time without zone before it.

    The header's own ``start_time`` is the present time where its date is invalid.
    """
    with suppress(ValueError, OverflowError, OSError):
        if not hasattr(header, "date"):
            return datetime.fromtimestamp(header.abs_time / 1e9, UTC) if header.abs_time else None
        text = f"{header.date.decode('latin-1')} {header.time.decode('latin-1')}"
        return datetime.strptime(text.rstrip("\0 "), "%d:%m:%Y %H:%M:%S").replace(tzinfo=UTC)
    return None


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
    """Return a channel (n,); invalid samples are NaN. Raises ``ValueError`` for its formula."""
    formula = _formula(mdf.groups[group].channels[index].conversion)
    parts = []
    for piece in pieces:
        samples, invalid = mdf.get(
            group=group,
            index=index,
            samples_only=True,
            raw=bool(formula),
            ignore_invalidation_bits=True,
            **piece,
        )
        parts.append(samples if invalid is None else np.where(invalid, np.nan, samples))
    values = np.concatenate(parts) if parts else np.zeros(0)
    return _evaluated(formula, values) if formula else values


def _times(mdf: Any, group: int, pieces: Sequence[Mapping[str, int]]) -> np.ndarray:
    """Return the times (n,) [s] of a group, from the start of the measurement."""
    if _formula(mdf.groups[group].channels[mdf.masters_db[group]].conversion):
        raise ValueError("the time is a formula")
    parts = [mdf.get_master(group, **piece) for piece in pieces]
    return np.concatenate(parts).astype(float) if parts else np.zeros(0)


def _formula(conversion: Any) -> str:
    """Return the formula of a conversion; empty if it has none. Raises ``ValueError``."""
    formula = getattr(conversion, "formula", None) or ""
    formula = (formula.decode() if isinstance(formula, bytes) else formula).strip("\0 ")
    if formula and not _FORMULA.fullmatch(formula):
        raise ValueError(f"formula {formula[:60]!r} is more than arithmetic")
    for inner in (getattr(conversion, "referenced_blocks", None) or {}).values():
        if inner is not conversion and _formula(inner):
            raise ValueError("a table contains a formula")
    return formula


def _evaluated(formula: str, values: np.ndarray) -> np.ndarray:
    """Return a formula of X. asammdf itself returns ``values`` for a formula that it can't read."""
    import numexpr  # which asammdf needs too

    x = values.astype(float)
    return numexpr.evaluate(formula.replace("^", "**"), {"X": x, "X1": x}, {})
