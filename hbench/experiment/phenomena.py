"""The table of phenomena: each name with what simulates it."""

from collections.abc import Callable

from hbench.model.phenomena.breakaway import breakaway_force
from hbench.model.phenomena.lag import lag
from hbench.model.phenomena.presliding import presliding
from hbench.model.phenomena.stick_slip import stick_slip
from hbench.model.phenomena.stribeck import stribeck
from hbench.records import Phenomenon

PHENOMENA: dict[str, Callable[[], Phenomenon]] = {
    "stribeck": stribeck,
    "lag": lag,
    "presliding": presliding,
    "stick-slip": stick_slip,
    "breakaway": breakaway_force,
}
