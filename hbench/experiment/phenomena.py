"""The table of phenomena: each name with what simulates it."""

from collections.abc import Callable
from typing import Any

from hbench.experiment.instability_page import instability
from hbench.experiment.supply_sag import supply_sag
from hbench.model.phenomena.breakaway import breakaway_force
from hbench.model.phenomena.lag import lag
from hbench.model.phenomena.presliding import presliding
from hbench.model.phenomena.stick_slip import stick_slip
from hbench.model.phenomena.stribeck import stribeck
from hbench.records import Phenomenon

BenchData = dict[str, Any]  # content of a bench file

PHENOMENA: dict[str, Callable[[BenchData], Phenomenon]] = {
    "stribeck": lambda bench: stribeck(),
    "lag": lambda bench: lag(),
    "presliding": lambda bench: presliding(),
    "stick-slip": lambda bench: stick_slip(),
    "breakaway": lambda bench: breakaway_force(),
    "supply": supply_sag,
    "instability": instability,
}
