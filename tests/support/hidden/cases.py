"""The benchmark's cases, and what is hidden in each."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from tests.support.hidden.draws import Drawn, drawn
from tests.support.hidden.sizes import KNOWN, OUTSIDE

SEVERITIES = {"mild": 0.5, "clear": 1.0, "strong": 2.0}

_LATER = ("pressure_gain",)

# Of other balances first, then of the same.
_PAIRS = (
    ("supply_droop", "load_friction"),
    ("internal_leakage", "load_cell_gain"),
    ("velocity_filter_lag", "external_leakage"),
    ("tank_back_pressure", "position_friction"),
    ("valve_deadband", "seal_pressure_friction"),
    ("entrained_air", "direction_asymmetry"),
    ("supply_droop", "velocity_filter_lag"),
    ("valve_asymmetry", "load_cell_offset"),
    ("pressure_offset", "supply_droop"),
    ("valve_lag", "presliding"),
    ("internal_leakage", "tank_back_pressure"),
    ("external_leakage", "valve_deadband"),
    ("load_cell_gain", "load_friction"),
    ("position_friction", "direction_asymmetry"),
    ("seal_pressure_friction", "end_cushion"),
)


@dataclass(frozen=True)
class Case:
    """One campaign: what is hidden in it, by the catalogue's names where it has them."""

    name: str
    effects: dict[str, float]  # severities: 1 is the catalogue's typical size
    seed: int
    group: Literal["single", "pair", "outside", "none", "own"]
    own: Mapping[str, Mapping[str, str]] = field(default_factory=dict)  # see ``Drawn``


def truth(case: Case) -> Drawn:
    """Return what was put in, in numbers."""
    return replace(drawn(case.effects, case.seed), own=case.own)


def cases() -> tuple[Case, ...]:
    """Return all: 276 with one effect, 60 with none, 30 pairs, 27 outside the catalogue.

    What was added later is at the end: the seeds of the others stay.
    """
    single, later = (
        [
            ("single", {name: severity})
            for name in names
            for severity in SEVERITIES.values()
            for _ in range(4)
        ]
        for names in ([name for name in KNOWN if name not in _LATER], _LATER)
    )
    pairs = [("pair", dict.fromkeys(two, size)) for two in _PAIRS for size in (1.0, 2.0)]
    outside = [("outside", {name: size}) for name in OUTSIDE for size in (1.0, 1.0, 2.0)]
    rows = single + [("none", {})] * 60 + pairs + outside + later
    return tuple(_case(group, effects, 1000 + i) for i, (group, effects) in enumerate(rows))


def small_sample() -> tuple[Case, ...]:
    """Return a few fixed cases of every group, all with the same law of friction to compile."""
    return (
        _case("single", {"internal_leakage": 1.0}, 1),
        _case("single", {"supply_droop": 1.0}, 2),
        _case("single", {"seal_pressure_friction": 2.0}, 9),
        _case("single", {"load_cell_gain": 1.0}, 4),
        _case("none", {}, 5),
        _case("none", {}, 6),
        _case("pair", {"velocity_filter_lag": 1.0, "external_leakage": 1.0}, 7),
        _case("outside", {"flow_force": 2.0}, 10),
    )


def stored() -> tuple[Case, ...]:
    """Return those whose campaigns lie in ``data_samples/blind``, of its own short schedule."""
    return (
        _case("single", {"internal_leakage": 1.0}, 1),
        _case("none", {}, 5),
        _case("outside", {"flow_force": 1.0}, 10),
    )


def _case(group: str, effects: dict[str, float], seed: int) -> Case:
    words = {size: word for word, size in SEVERITIES.items()}
    said = "+".join(effects) or "none"
    size = f"-{words[max(effects.values())]}" if effects else ""
    return Case(f"{said}{size}-{seed}", effects, seed, group)
