"""Display names and units of balances, signals and axes."""

import re
from collections.abc import Sequence
from math import isfinite
from typing import Any, NamedTuple

from hbench.channels import CHANNELS
from hbench.records import Diagnosis, Gap
from hbench.records.reconcile.diagnosis import MOTION_BALANCE
from hbench.report.render.numbers import NONE, number, significant
from hbench.sentences import listed
from hbench.units import from_si


class DisplayName(NamedTuple):
    """Display name of a quantity, and the unit its numbers are shown in."""

    title: str
    unit: str


BALANCE_NAMES = {
    "flow_tp": DisplayName("flow to test piston side", "l/min"),
    "flow_tr": DisplayName("flow to test rod side", "l/min"),
    "flow_lp": DisplayName("flow to load piston side", "l/min"),
    "flow_lr": DisplayName("flow to load rod side", "l/min"),
    "force_test": DisplayName("force of test cylinder", "N"),
    "force_load": DisplayName("force of load cylinder", "N"),
    "kinematics": DisplayName("position against velocity", "mm/s"),
    "supply": DisplayName("supply pressure", "bar"),
}
# Balances of a pair of steady strokes, one in each direction.
STROKE_NAMES = {
    "force_band": DisplayName("friction (half difference)", "N"),
    "force_middle": DisplayName("mean force of both directions", "N"),
}
_KNOWN = (
    BALANCE_NAMES | STROKE_NAMES | {MOTION_BALANCE: DisplayName("force balance of the mass", "N")}
)
PRESSURE_SYMBOLS = {
    name: CHANNELS[f"{name}_pa"].symbol for name in ("p_tp", "p_tr", "p_lp", "p_lr", "p_s")
}
SIGNAL_NAMES = {
    "x": DisplayName("position", "mm"),
    "v": DisplayName("velocity", "mm/s"),
    **{name: DisplayName(symbol, "bar") for name, symbol in PRESSURE_SYMBOLS.items()},
    "p_s": DisplayName("supply pressure", "bar"),
    "f_applied": DisplayName("load cell's force", "N"),
    "u_t": DisplayName("command of valve T", "V"),
    "u_l1": DisplayName("command of valve L1", "V"),
    "u_l2": DisplayName("command of valve L2", "V"),
    "friction": DisplayName("friction", "N"),
}
# Quantities that an effect changes, besides balances and readings, by the records' names.
SOLVED_NAMES = {
    "speed": DisplayName("speed at the same commands", "mm/s"),
    "pressure": DisplayName("pressure at the same speed and load", "bar"),
}
# Axes of regions and maps, by the records' names.
AXES = {
    "direction": DisplayName("direction", ""),
    "speed_m_s": DisplayName("speed", "mm/s"),
    "v_m_s": DisplayName("velocity", "mm/s"),
    "load_n": DisplayName("load", "kN"),
    "position_m": DisplayName("position", "mm"),
    "x_m": DisplayName("position", "mm"),
    "time_s": DisplayName("time in the run", "s"),
    "t_s": DisplayName("time in the run", "s"),
}
# Fields of BeforeAfter.
STEPS = {
    "before": "as given",
    "refitted": "refitted",
    "after": "with the effects",
    "floor": "expected of a correct model",
}
CHAMBERS = {
    "tp": "the piston side of the test cylinder (Tp)",
    "tr": "the rod side of the test cylinder (Tr)",
    "lp": "the piston side of the load cylinder (Lp)",
    "lr": "the rod side of the load cylinder (Lr)",
}
# Parts of the bench that a balance depends on, the one to inspect first at its beginning.
PARTS = {
    "flow_tp": ("the test valve", "the piston side of the test cylinder", "the transducer of P_Tp"),
    "flow_tr": ("the test valve", "the rod side of the test cylinder", "the transducer of P_Tr"),
    "flow_lp": ("load valve L2", "the piston side of the load cylinder", "the transducer of P_Lp"),
    "flow_lr": ("load valve L1", "the rod side of the load cylinder", "the transducer of P_Lr"),
    "force_test": (
        "the seals and guides of the test cylinder",
        "the load cell",
        "the transducers of P_Tp and P_Tr",
    ),
    "force_load": (
        "the seals and guides of the load cylinder",
        "the load cell",
        "the transducers of P_Lp and P_Lr",
    ),
    "kinematics": ("the position transducer", "the velocity filter"),
    "supply": ("the pump", "the accumulator", "the transducer of P_S"),
}
_PARTS_OF_MASS = (
    "the guide and its seals",
    "the drive",
    "the factor of its force",
    "the moving mass",
)
# Part that a chamber's flow depends on by the position, which a valve does not.
BORES = {
    "flow_tp": "the bore and the piston seal of the test cylinder",
    "flow_tr": "the bore and the piston seal of the test cylinder",
    "flow_lp": "the bore and the piston seal of the load cylinder",
    "flow_lr": "the bore and the piston seal of the load cylinder",
}
# Parts that several balances have in common: the one to inspect first where all of them deviate.
# An error of the part changes each balance with a sign of its own.
COMMON_PARTS = {
    "the position transducer": {"flow_tp": 1, "flow_tr": -1, "flow_lp": -1, "flow_lr": 1},
    BORES["flow_lp"]: {"flow_lp": 1, "flow_lr": -1},
    "the load cell": {"force_test": 1, "force_load": -1},
}
# Metering edge of each chamber while the piston extends, and while it retracts.
EDGES = {
    "flow_tp": ("supply", "tank"),
    "flow_tr": ("tank", "supply"),
    "flow_lp": ("tank", "supply"),
    "flow_lr": ("supply", "tank"),
}

_COLUMN = re.compile("_(?:s|m|pa|n|v|k)$")  # of an import map
# Of an effect; no file's name, and no line for a file such as "valve_lag: {time: 3 ms}".
_KEY = re.compile(r"(?<!/)\b[a-z]+(?:_[a-z]+)+\b(?![/-]|\.\w|: [{\d-])")
_CYLINDER = re.compile(r"\b(to|of) (test|load)\b")
_VALUE_OF = re.compile(r"test cylinder (?=[−\d])")
_PART = re.compile(r", test (cylinder|side)")
_FLOW = "the flow to "
_WITHOUT_ARTICLE = ("friction", "kinematics")
_MOST_DIGITS = 4  # of a deviation that is close to its limit


def balance(name: str) -> DisplayName:
    """Return the display name of a balance, by default its key."""
    return _KNOWN.get(name, DisplayName(name.replace("_", " "), ""))


def of_strokes(diagnosis: Diagnosis) -> bool:
    """Return whether pairs of steady strokes were compared, not the logs of a whole bench."""
    return any(gap.name in STROKE_NAMES for gap in diagnosis.where)


def parts_of(diagnosis: Diagnosis, name: str) -> tuple[str, ...]:
    """Return the parts of the bench that a balance depends on; empty where none are listed."""
    return _PARTS_OF_MASS if diagnosis.errors else PARTS.get(name, ())


def residual_name(name: str) -> DisplayName:
    """Return the display name of a residual: of a balance, or of a signal solved for."""
    return SOLVED_NAMES.get(name) or balance(name)


def signal(name: str) -> DisplayName:
    """Return the display name of a signal, by default its key."""
    return SIGNAL_NAMES.get(name, DisplayName(name.replace("_", " "), ""))


def in_words(name: str) -> str:
    """Return an effect's name in words."""
    return name.replace("_", " ")


def keys_in_words(line: str) -> str:
    """Return a text with effects, balances and channels in words or symbols, not in keys.

    The columns of an import map, whose names end in a unit, remain keys: they are to be written.
    """
    names = {key: name.title for key, name in (SIGNAL_NAMES | _KNOWN).items()}

    def words(key: re.Match[str]) -> str:
        return names.get(key[0]) or (key[0] if _COLUMN.search(key[0]) else in_words(key[0]))

    return _KEY.sub(words, line)


_MODEL_VALUES = {
    "supply.pressure": "supply pressure",
    "supply.tank": "tank pressure",
    "oil.bulk_modulus": "bulk modulus of oil",
    "moving_mass.test": "moving mass, test side",
    "moving_mass.load": "moving mass, load side",
}
_FRICTION_VALUES = {
    "coulomb": "Coulomb friction",
    "stiction": "static friction",
    "stribeck_velocity": "Stribeck velocity",
    "stribeck_exponent": "Stribeck exponent",
    "viscous": "viscous friction",
    "bristle_stiffness": "bristle stiffness",
    "dead_volume_piston": "dead volume, piston side",
    "dead_volume_rod": "dead volume, rod side",
}


def value_words(path: str) -> str:
    """Return a value of the model file in words: its name, then the part of the bench."""
    *sections, key = path.split(".")
    if path in _MODEL_VALUES or not sections:
        return _MODEL_VALUES.get(path, in_words(key))
    part = in_words(sections[-1])
    if sections[0] == "friction":
        part = f"{part} cylinder"
    if key in _FRICTION_VALUES:
        return f"{_FRICTION_VALUES[key]}, {part}"
    return f"{part} {in_words(key)}"


_FRICTION = {
    "force_test": "friction of test cylinder",
    "force_load": "friction of load cylinder",
    MOTION_BALANCE: "force against the motion",
}


def of_the_mass(diagnosis: Diagnosis, words: str) -> str:
    """Return words without the cylinders where a driven mass was measured, which has none."""
    if not diagnosis.errors:
        return words
    return _VALUE_OF.sub("", _PART.sub("", words)).replace("test cylinder", "mass")


def quantity(name: str) -> str:
    """Return the title of a quantity that an effect changes."""
    if name in _FRICTION:
        return _FRICTION[name]
    if name in _KNOWN:
        return balance(name).title
    if name in SIGNAL_NAMES:
        return f"reading: {SIGNAL_NAMES[name].title}"
    return SOLVED_NAMES[name].title if name in SOLVED_NAMES else name.replace("_", " ")


def models_of(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the models that are compared: fields of ``BeforeAfter``, with their display names.

    A refused refit is no model of its own.
    """
    added = added_words(diagnosis)
    models = {"before": STEPS["before"]}
    if not diagnosis.refit_refused:
        models["refitted"] = STEPS["refitted"]
    if added:
        models["after"] = f"with the {added}"
    return models


def steps_of(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the models, and the gap of balances that is expected of a correct model."""
    return models_of(diagnosis) | {"floor": STEPS["floor"]}


def added_words(diagnosis: Diagnosis) -> str:
    """Return what the revised model has beside refitted values; empty where it has nothing."""
    parts = [
        *(["effects"] if diagnosis.confirmed else []),
        *(["unnamed laws"] if diagnosis.unnamed else []),
    ]
    return " and ".join(parts)


def also_words(diagnosis: Diagnosis, name: str) -> str:
    """Return the model with one more effect of an ambiguous set, and the best of the other sets."""
    sets = [[each.name for each in candidates] for candidates in diagnosis.alternative_sets]
    others = [in_words(names[0]) for names in sets if name not in names]
    effects = ["the effects"] if diagnosis.confirmed else []
    return f"with {listed([*effects, in_words(name), *others])}"


def compared_model(diagnosis: Diagnosis) -> str:
    """Return the model whose residuals were searched: the given one if its refit was refused."""
    return "unchanged model" if diagnosis.refit_refused else "refitted model"


def in_unit(gap: Gap, value: float) -> str:
    """Write a value of a balance's residual, such as its scatter, in the balance's unit."""
    if not isfinite(value):
        return NONE
    display = balance(gap.name)
    return f"{significant(shown(value, display), 2)} {display.unit}".strip()


def deviation_and_limit(gap: Gap) -> tuple[str, str]:
    """Write a deviation and its limit, with more digits where two would make them equal."""
    display, values = balance(gap.name), (gap.deviation, gap.material)
    if not all(map(isfinite, values)):
        return in_unit(gap, gap.deviation), in_unit(gap, gap.material)
    for digits in range(2, _MOST_DIGITS + 1):
        words = [significant(shown(value, display), digits) for value in values]
        if words[0] != words[1]:
            break
    deviation, limit = (f"{number} {display.unit}".strip() for number in words)
    return deviation, limit


def gap_number(value: float | None) -> str:
    """Write a gap with two decimals, from 10 on with one."""
    return number(value, 2 if value is None or abs(value) < 10 else 1)


def share(value: float) -> str:
    """Write a share in whole per cent, and all shares below −100 % alike."""
    if value < -1:
        return "< −100 %"
    return f"{number(round(100 * value) + 0.0, 0)} %"


def in_sentence(name: str) -> str:
    """Write a balance or a signal within a sentence: ``the force of the test cylinder``."""
    if name == "force_band":
        return "friction"
    title = (balance(name) if name in _KNOWN else signal(name)).title
    if title.startswith("P_") or name in _WITHOUT_ARTICLE:
        return title
    return "the " + _CYLINDER.sub(r"\1 the \2", title)


def all_in_sentence(names: Sequence[str]) -> str:
    """Write balances within a sentence, with flows alone as ``the flows to … and …``."""
    words = [in_sentence(name) for name in names]
    if names[1:] and all(each.startswith(_FLOW) for each in words):
        return f"the flows to {listed([each.removeprefix(_FLOW) for each in words])}"
    return listed(words)


def mathtext(symbol: str) -> str:
    """Write ``P_Tp`` for a figure, its index below the line."""
    head, index = symbol.partition("_")[::2]
    return f"${head}_{{{index}}}$" if index else symbol


def shown(si: Any, display: DisplayName) -> Any:
    """Convert a number or an array in SI to the unit it is shown in."""
    return from_si(si, display.unit) if display.unit else si
