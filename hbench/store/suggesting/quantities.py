"""The quantity that a column's name means, in English and German."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from hbench.store.suggesting.units import split_ending, split_unit
from hbench.units import ANGLES, parse_unit

Quantity = Literal["time", "position", "velocity", "pressure", "force", "valve", "temperature", ""]
Side = Literal["piston", "rod", "supply", "load piston", "load rod", "tank", "port", "seal", ""]

# A unit of each quantity, for linear and for rotary actuators.
_UNITS: dict[Quantity, tuple[str, ...]] = {
    "time": ("s",),
    "position": ("m",),  # or one of ANGLES
    "velocity": ("m/s", "rad/s"),
    "pressure": ("Pa",),
    "force": ("N", "N m"),
    "valve": ("V",),
    "temperature": ("K",),
}
CHANNEL_OF = {  # of a quantity with its side
    ("time", ""): "t_s",
    ("position", ""): "x_m",
    ("velocity", ""): "v_m_s",
    ("pressure", "piston"): "p_tp_pa",
    ("pressure", "rod"): "p_tr_pa",
    ("pressure", "supply"): "p_s_pa",
    ("pressure", "load piston"): "p_lp_pa",
    ("pressure", "load rod"): "p_lr_pa",
    ("force", ""): "f_applied_n",
    ("valve", ""): "u_t_v",
    ("temperature", "tank"): "temp_tank_k",
    ("temperature", "port"): "temp_port_k",
    ("temperature", "seal"): "temp_seal_k",
}

_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "å": "aa", "ø": "oe"})
# Parts of German compounds such as Kolbenstangenseite.
_PARTS = (
    *("kolben", "stange", "ring", "boden", "zylinder", "druck", "weg", "kraft", "position", "hub"),
    *("geschwindigkeit", "zeit", "stempel", "seite", "seitig", "sensor", "signal", "aufnehmer"),
    *("dose", "zelle", "mess", "last", "axial", "zug", "soll", "ist", "wert", "ventil", "pumpe"),
    *("system", "versorgung", "ueber", "raum", "kammer", "spannung", "ansteuerung", "stell"),
    *("groesse", "laser", "laenge", "speise", "motor", "antrieb", "spindel", "oel", "tank"),
    *("temperatur", "dichtung", "anschluss"),
)
_COMPOUND = re.compile(rf"(?:(?:{'|'.join(_PARTS)})(?:n|s|en|er)?)+")
_PART = re.compile("|".join(_PARTS))

_REFERENCE = re.compile(
    r"\b(ref|reference|soll|set|setpoint|sp|target|desired|demand|command|cmd|w)\b"
)
# Words of a signal that is no measurement of the cylinder's state.
_OTHER = re.compile(
    r"\b(flow|error|err|fehler|abweichung|pid|ff|feedforward|temp|temperature|temperatur|oil|oel"
    r"|volumenstrom|joystick|tank|status|state|index|sample|count|counter|nr|no|number|flag"
    r"|u ?l ?[12]|datum|date|current|strom|acc|acceleration"
    r"|beschleunigung)\b"
)
_WEAKER = re.compile(r"\b(raw|roh|dcv|valve|hose|out|signal|comp|compensated|adj|filtered|filt)\b")
_NEUTRAL = re.compile(
    r"\b(cyl|cylinder|zyl|zylinder|actual|act|ist|mess|meas|measured|sensor|signal|wert|value|data"
    r"|test|channel|kanal|ch|raum|kammer|chamber|side|seite|end|aufnehmer|dose|zelle|cell|ueber"
    r"|piston|kolben|rod|stange|abs|rel|dot|raw|dcv|and|the|of|der|des|im|am)\b"
)
# Words of the oil's temperature, and of its place: of the oil itself it is that in the tank.
_TEMPERATURE = re.compile(r"\b(t|temp|temperature|temperatur)\b")
_PLACES: tuple[tuple[Side, re.Pattern[str]], ...] = (
    ("seal", re.compile(r"\b(seal|dichtung)\b")),
    ("port", re.compile(r"\b(port|inlet|anschluss|zulauf)\b")),
    ("tank", re.compile(r"\b(oil|oel|fluid|tank|reservoir|sump)\b")),
)
# Words of a force that a drive without hydraulics exerts.
_DRIVE = re.compile(r"\b(motor|drive|antrieb|spindle|spindel|actuator|aktor)\b")
# By quantity: names that leave no doubt, and words that suggest it.
_NAMES: dict[Quantity, tuple[re.Pattern[str], re.Pattern[str]]] = {
    "valve": (
        re.compile(r"\b(u|u ?[tv]|valve|ventil|servo|spool|stell|ansteuerung|control)\b"),
        re.compile(r"\b(y|out|cmd|command)\b"),
    ),
    "velocity": (
        re.compile(
            r"\b(v|vel|velo|velocity|speed|geschw|geschwindigkeit|x ?dot|dx|dxdt|xp"
            r"|v ?(ist|cyl|zyl))\b"
        ),
        re.compile(r"\b(rate)\b"),
    ),
    "force": (
        re.compile(
            r"\b(f|frc|force|kraft|fuerza|forza|torque|moment|drehmoment|kmd|load ?cell"
            r"|f ?(applied|ext|last|mess|cyl|axial|load))\b"
        ),
        re.compile(r"\b(load|last|lc|dms)\b"),
    ),
    "pressure": (
        re.compile(
            r"\b(p|prs|pressure|press|presion|druck|p ?(tp|tr|lp|lr|ls|sys|[abcsp]|[0-9])|dp)\b"
        ),
        re.compile(r"\b(dr|pr|pt)\b"),
    ),
    "time": (
        re.compile(
            r"\b(t|time|zeit|time ?stamp|zeit ?stempel|elapsed|x ?value|uhrzeit|datetime|tid)\b"
        ),
        re.compile(r"\b(sec|seconds|sekunden|clock)\b"),
    ),
    "position": (
        re.compile(
            r"\b(x|pos|position|stroke|hub|weg|displacement|disp|travel|lvdt|extension|ausfahr"
            r"|angle|winkel|phi)\b"
        ),
        re.compile(r"\b(s|y|z|lage|laser|distance|dist|abstand|length|laenge|l)\b"),
    ),
}
_SIDES: tuple[tuple[Side, re.Pattern[str]], ...] = (
    ("load piston", re.compile(r"\b(p ?lp|lp)\b")),
    ("load rod", re.compile(r"\b(p ?lr|lr)\b")),
    (
        "supply",
        re.compile(
            r"\bp ?(s|p|0|sys|v)\b|\b(supply|pump|pumpe|system|sys|versorgung|s"
            r"|speise|source|feed)\b"
        ),
    ),  # fmt: skip
    # Words come before letters and numbers, which may be those of the logger's channels.
    ("rod", re.compile(r"\b(rod|stange|ring|annulus)\b")),
    ("piston", re.compile(r"\b(cap|bore|kolben|boden|piston|blind|bottom)\b")),
    ("rod", re.compile(r"\bp ?(b|2|tr|r)\b|\b(b|2|tr)\b")),
    ("piston", re.compile(r"\bp ?(a|1|tp|k)\b|\b(a|1|tp)\b")),
)


_PREFIX = re.compile(r"\bf\b")  # of a number's name in a PLC, as in fPosition
_SEVERAL = 4  # names with a word in common
_OF_LOAD: dict[Side, Side] = {"piston": "load piston", "rod": "load rod"}


@dataclass(frozen=True)
class Meaning:
    """What a column's name says about it."""

    quantity: Quantity  # empty if it is not known
    side: Side = ""  # of a pressure
    is_reference: bool = False
    is_sure: bool = False  # the name leaves no doubt
    by_unit: bool = False  # the name says nothing about the quantity
    is_weaker: bool = False  # another signal of the same quantity is closer to the cylinder
    unit: str | None = None  # in the name
    group: frozenset[str] = frozenset()  # other words, such as a machine's or an axis's name
    is_drive: bool = False  # a force is that of the drive

    @property
    def channel(self) -> str:
        """Name of the channel in an import map; empty if there is none."""
        if self.is_reference:
            return "v_ref_m_s" if self.quantity == "velocity" else ""
        if self.is_drive:
            return "f_drive_n"
        return CHANNEL_OF.get((self.quantity, self.side), "")


def meaning(name: str, unit: str | None = None, ignored: frozenset[str] = frozenset()) -> Meaning:
    """Return the meaning of a column's name.

    ``unit`` is the unit in the file, if it states one; ``ignored`` are words without a meaning.
    """
    path, in_name = split_unit(name.replace("(:,", " ").replace("(1)", " "))
    if unit is None and in_name is None:
        shorter, ending = split_ending(path)
        words = _without(words_of(shorter), ignored)
        by_name = _by_words(words, None).quantity
        is_long = len(ending or "") > 1 or (path.endswith("V") and len(shorter) > 1)  # not p_v
        is_signal = ending is not None and is_long and _fits("valve", ending)  # such as mV
        if ending and (_fits(by_name, ending) or is_signal if by_name else len(ending) > 1):
            return _by_words(words, ending)
    return _by_words(_without(words_of(path), ignored), unit or in_name)


def common_words(names: Sequence[str]) -> frozenset[str]:
    """Return the words in all of several names: those of a machine or a program."""
    if len(names) < _SEVERAL:
        return frozenset()
    return frozenset.intersection(*(frozenset(words_of(name).split()) for name in names))


def is_numbered(name: str) -> bool:
    """Return whether only a number in the name of a pressure states its side, as in P2."""
    words = words_of(split_unit(name)[0])
    return re.search(r"\d", words) is not None and not _side(re.sub(r"\d+", " ", words))


def _without(words: str, ignored: frozenset[str]) -> str:
    return " ".join(word for word in words.split() if word not in ignored)


def quantity_of(unit: str | None) -> Quantity:
    """Return the quantity with a unit of this dimension; empty for none."""
    return next((q for q in _UNITS if unit is not None and _fits(q, unit)), "")


def _fits(quantity: Quantity, unit: str) -> bool:
    if unit in ANGLES:
        return quantity == "position"
    dimension = parse_unit(unit).dimension
    return any(parse_unit(si).dimension == dimension for si in _UNITS[quantity])


def words_of(name: str) -> str:
    """Return the words of a name in lower case, between blanks."""
    text = re.sub(r"(?<=[a-zäöü])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z]{2})", " ", name)
    text = re.sub(r"(?<=[^\W\d_])(?=\d)|(?<=\d)(?=[^\W\d_])", " ", text)
    words = []
    for word in re.findall(r"[^\W\d_]+|\d+", text.lower().translate(_UMLAUTS)):
        words += _PART.findall(word) if _COMPOUND.fullmatch(word) else [word]
    return " ".join(words)


def _by_words(words: str, unit: str | None) -> Meaning:
    place: Side = next((place for place, names in _PLACES if names.search(words)), "")
    of_oil = place and _TEMPERATURE.search(words) is not None and not _REFERENCE.search(words)
    if of_oil and (unit is None or _fits("temperature", unit)):
        return Meaning("temperature", place, is_sure=True, unit=unit)
    if _OTHER.search(words):
        return Meaning("", unit=unit)
    of_unit = quantity_of(unit)
    quantity, is_sure = _quantity(words, of_unit)
    if unit is not None and quantity and of_unit not in (quantity, "valve"):
        quantity = ""  # such as a position in bar
    by_unit = not quantity and of_unit not in ("", "valve")
    if by_unit:
        quantity, is_sure = of_unit, False
    reference = quantity != "valve" and _REFERENCE.search(words) is not None
    side = _side(words) if quantity == "pressure" else ""
    is_drive = quantity == "force" and _DRIVE.search(words) is not None
    return Meaning(
        quantity=quantity,
        side=side,
        is_reference=reference,
        is_sure=is_sure,
        by_unit=by_unit,
        is_weaker=quantity != "valve" and _WEAKER.search(words) is not None,
        unit=unit,
        group=_group(_DRIVE.sub(" ", words) if is_drive else words, quantity, side),
        is_drive=is_drive,
    )


def _quantity(words: str, of_unit: Quantity) -> tuple[Quantity, bool]:
    """Return the quantity that the words mean, and whether they leave no doubt."""
    for column in (0, 1):
        found = [quantity for quantity, names in _NAMES.items() if names[column].search(words)]
        if of_unit in found:
            return of_unit, True
        if "valve" in found and of_unit and of_unit != "valve":
            found.remove("valve")  # such as the pressure at a valve
        if "pressure" in found and "valve" in found and "valve" not in words.split()[:1]:
            found.remove("valve")
        if len(found) > 1 and not _NAMES["force"][column].search(_PREFIX.sub(" ", words)):
            found = [quantity for quantity in found if quantity != "force"]
        if found:
            return found[0], column == 0
    return "", False


def _side(words: str) -> Side:
    side: Side = next((side for side, pattern in _SIDES if pattern.search(words)), "")
    if side in _OF_LOAD and re.search(r"\b(load|last)\b", words):
        return _OF_LOAD[side]
    return side


def _group(words: str, quantity: Quantity, side: Side) -> frozenset[str]:
    rest = _NEUTRAL.sub(" ", _REFERENCE.sub(" ", words))
    if quantity:
        for pattern in _NAMES.get(quantity, ()):
            rest = pattern.sub(" ", rest)
    for of_side, pattern in _SIDES:
        if of_side == side:
            rest = pattern.sub(" ", rest)
    return frozenset(word for word in rest.split() if len(word) > 1 and word.isalpha())
