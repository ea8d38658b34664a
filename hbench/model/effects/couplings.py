"""Terms of the plant's equations that effects change: a law takes one and returns it changed."""

from typing import NamedTuple

Coefficients = tuple[float, ...]  # of an effect in SI, in the order of its row


class Openings(NamedTuple):
    """Openings of the valves [V]: test, load 1 (rod side), load 2 (piston side)."""

    test: float
    load_1: float
    load_2: float


class OilProperties(NamedTuple):
    """Pressure [Pa] in the return line, and the oil's bulk modulus [Pa] in each chamber."""

    tank_pa: float
    beta_tp: float
    beta_tr: float
    beta_lp: float
    beta_lr: float


class ChamberFlows(NamedTuple):
    """Flows [m^3/s] into the chambers, from the supply into the valves, and back to the tank."""

    tp: float
    tr: float
    lp: float
    lr: float
    drawn: float
    returned: float
    fluidity: float  # of the oil against that of the bench file: cold viscosity over viscosity


class PortFlows(NamedTuple):
    """Flows of the valves, before leaks and lines; their openings, the tank pressure [Pa] there."""

    q: ChamberFlows
    opened: Openings
    tank_pa: float


class FrictionTerms(NamedTuple):
    """Friction of the test and the load cylinder [N]."""

    dry_t: float  # magnitude of the law's dry part at this velocity, level included
    dry_l: float
    more_t: float  # to be added to that magnitude; the law's own memory carries it too
    more_l: float
    force_t: float  # to be added to the friction, positive against extension
    force_l: float
