"""Drift of sensors over a campaign: linear from its first run to its last, a nuisance.

A drift is the change of a reading from the middle of the campaign to its last run. It belongs to
the measurement, not to the model, so a plant file does not contain it. Columns of drifts have names
of their own, with the channel of the sensor.
"""


def drift_name(channel: str) -> str:
    """Return the name of the column of a channel's drift."""
    return f"~{channel}"


def is_drift(name: str) -> bool:
    """Return whether a column is that of a drift."""
    return name.startswith("~")


def channel_of(name: str) -> str:
    """Return the channel of a drift's column."""
    return name[1:]
