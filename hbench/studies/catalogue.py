"""Table of phenomena: each name with its simulation."""

from collections.abc import Callable
from typing import Any

from hbench.records import Phenomenon
from hbench.studies.instability_page import instability
from hbench.studies.phenomena.breakaway import breakaway_force
from hbench.studies.phenomena.lag import lag
from hbench.studies.phenomena.presliding import presliding_loops
from hbench.studies.phenomena.stick_slip import stick_slip
from hbench.studies.phenomena.stribeck import steady_curve
from hbench.studies.supply_sag import supply_sag

BenchData = dict[str, Any]  # content of a bench file

PHENOMENA: dict[str, Callable[[BenchData], Phenomenon]] = {
    "stribeck": lambda bench: steady_curve(),
    "lag": lambda bench: lag(),
    "presliding": lambda bench: presliding_loops(),
    "stick-slip": lambda bench: stick_slip(),
    "breakaway": lambda bench: breakaway_force(),
    "supply": supply_sag,
    "instability": instability,
}
