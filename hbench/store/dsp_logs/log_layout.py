"""Layout of the raw logs, from the campaign's header: channels, rate and flags."""

from collections.abc import Mapping
from typing import Any

from hbench.errors import DataError
from hbench.records import LogChannel
from hbench.units import parse_unit


def read_layout(log: Any, source: str) -> tuple[tuple[LogChannel, ...], float, tuple[str, ...]]:
    """Return the channels, the rate [Hz] and the names of the flags.

    Raises ``DataError`` naming ``source`` if the section is missing or invalid.
    """
    if not isinstance(log, Mapping):
        raise DataError(f"{source}: is missing or not a section")
    try:
        channels = tuple(_channel(**channel) for channel in log["channels"])
        names = [channel.name for channel in channels]
        if twice := [name for name in names if names.count(name) > 1]:
            raise ValueError(f"channel {twice[0]!r} occurs twice")
        rate_hz = _number("rate_hz", log["rate_hz"], 1e-3, 1e6)
        flags = log["flags"]
        if not isinstance(flags, list) or not all(isinstance(flag, str) for flag in flags):
            raise ValueError("flags is not a list of names")
        if len(set(flags)) < len(flags) or len(flags) > 16:
            raise ValueError("flags: a name occurs twice, or there are more than 16")
    except (KeyError, TypeError, ValueError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else error
        raise DataError(f"{source}: {what}") from None
    return channels, rate_hz, tuple(flags)


def _channel(name: Any, signed: Any, scale: Any, unit: Any) -> LogChannel:
    if not isinstance(name, str) or not isinstance(unit, str) or not isinstance(signed, bool):
        raise ValueError(f"channel {str(name)[:40]!r}: name, signed or unit has the wrong type")
    if unit != "count":
        parse_unit(unit)
    return LogChannel(name, signed, _number(f"scale of {name}", scale, 1e-12, 1e12), unit)


def _number(what: str, value: Any, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{what} is {str(value)[:40]!r}, not a number")
    if not low <= value <= high:  # nor is NaN
        raise ValueError(f"{what} is {str(value)[:40]}; expected {low:g} to {high:g}")
    return float(value)
