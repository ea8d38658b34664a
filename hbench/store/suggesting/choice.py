"""The column chosen for a channel, with the reason."""

from dataclasses import dataclass

from hbench.store.suggesting.samples import SampleColumn

SURE, LIKELY, GUESS = "sure", "likely", "guess"


@dataclass(frozen=True)
class Choice:
    """The column chosen for a channel."""

    column: SampleColumn
    unit: str
    in_file: bool  # the file states the unit, so that the map need not
    certainty: str
    reason: str
    scale: float | None = 1.0  # None: to be given by the user
    time: SampleColumn | None = None  # of its times, if they are not those of t_s
