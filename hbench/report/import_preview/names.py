"""Channels of an import map in words, and their display units."""

from hbench.channels import CHANNELS

_DISPLAY = {
    "s": ("s", 1.0),
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "Pa": ("bar", 1e-5),
}


def display(unit: str) -> tuple[str, float]:
    """Return the display unit of a channel in SI, and the factor from SI to it."""
    return _DISPLAY.get(unit, (unit, 1.0))


def symbol(channel: str) -> str:
    """Return the symbol of a channel."""
    return CHANNELS[channel].symbol if channel in CHANNELS else channel


def words(channel: str) -> str:
    """Return what a channel is."""
    return CHANNELS[channel].words if channel in CHANNELS else channel
