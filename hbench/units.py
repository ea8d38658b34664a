"""Quantities with units: "150 bar" to 1.5e7 Pa, and back for messages.

A unit is a factor to SI and the exponents of (m, kg, s, V, K). Expressions combine unit
names with ``*`` or a space, ``/``, ``^`` and parentheses: ``N s/m``, ``V/(Pa s)``, ``m^2/V`` or
``m²/V``. A temperature in degC or degF has a zero of its own, so that it is no part of an
expression.
"""

import math
import re
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple
from unicodedata import normalize

Dimension = tuple[int, ...]  # exponents of (m, kg, s, V, K)


class Unit(NamedTuple):
    """A unit: SI = number * factor + zero, and the exponents of (m, kg, s, V, K)."""

    factor: float
    dimension: Dimension
    zero: float = 0.0  # of degC and degF, which are therefore no factors of other units

    def to_si(self, number: Any) -> Any:
        """Convert a number or an array."""
        return number * self.factor + self.zero if self.zero else number * self.factor

    def from_si(self, si: Any) -> Any:
        """Convert a number or an array in SI."""
        return (si - self.zero) / self.factor


def _unit(factor: float, m: int = 0, kg: int = 0, s: int = 0, v: int = 0, k: int = 0) -> Unit:
    return Unit(factor, (m, kg, s, v, k))


_PASCAL = {"m": -1, "kg": 1, "s": -2}
_NEWTON = {"m": 1, "kg": 1, "s": -2}

UNITS: dict[str, Unit] = {
    "1": _unit(1.0),
    "%": _unit(1e-2),
    "m": _unit(1.0, m=1),
    "cm": _unit(1e-2, m=1),
    "mm": _unit(1e-3, m=1),
    "um": _unit(1e-6, m=1),
    "in": _unit(0.0254, m=1),
    "l": _unit(1e-3, m=3),
    "ml": _unit(1e-6, m=3),
    "kg": _unit(1.0, kg=1),
    "g": _unit(1e-3, kg=1),
    "s": _unit(1.0, s=1),
    "ms": _unit(1e-3, s=1),
    "us": _unit(1e-6, s=1),
    "ns": _unit(1e-9, s=1),
    "min": _unit(60.0, s=1),
    "h": _unit(3600.0, s=1),
    "d": _unit(86400.0, s=1),
    "Hz": _unit(1.0, s=-1),
    "kHz": _unit(1e3, s=-1),
    "rad": _unit(1.0),
    "deg": _unit(math.pi / 180),
    "rpm": _unit(math.pi / 30, s=-1),
    "N": _unit(1.0, **_NEWTON),
    "daN": _unit(10.0, **_NEWTON),
    "kN": _unit(1e3, **_NEWTON),
    "kgf": _unit(9.80665, **_NEWTON),
    "tf": _unit(9806.65, **_NEWTON),  # tonne-force, metric
    "lbf": _unit(4.4482216152605, **_NEWTON),
    "kip": _unit(4448.2216152605, **_NEWTON),
    "Pa": _unit(1.0, **_PASCAL),
    "kPa": _unit(1e3, **_PASCAL),
    "MPa": _unit(1e6, **_PASCAL),
    "GPa": _unit(1e9, **_PASCAL),
    "bar": _unit(1e5, **_PASCAL),
    "mbar": _unit(1e2, **_PASCAL),
    "psi": _unit(6894.757293168361, **_PASCAL),
    "W": _unit(1.0, m=2, kg=1, s=-3),
    "kW": _unit(1e3, m=2, kg=1, s=-3),
    "V": _unit(1.0, v=1),
    "mV": _unit(1e-3, v=1),
    "K": _unit(1.0, k=1),
    "degC": Unit(1.0, (0, 0, 0, 0, 1), 273.15),
    "degF": Unit(5 / 9, (0, 0, 0, 0, 1), 459.67 * 5 / 9),
    "cSt": _unit(1e-6, m=2, s=-1),
}

# Spellings that are no units here, in lower case, without brackets, blanks and ^.
SPELLINGS = {
    **dict.fromkeys(("sec", "sek", "secs", "seconds", "sekunden", "sekunde", "second"), "s"),
    **dict.fromkeys(("msec", "millisecond", "milliseconds", "millisekunden"), "ms"),
    **dict.fromkeys(("usec", "microseconds"), "us"),
    **dict.fromkeys(("nsec", "nanoseconds"), "ns"),
    **dict.fromkeys(("min.", "minutes", "minuten"), "min"),
    **dict.fromkeys(("meter", "metre", "meters"), "m"),
    **dict.fromkeys(("millimeter", "millimetre", "millimeters"), "mm"),
    **dict.fromkeys(("inch", "inches", "zoll"), "in"),
    **dict.fromkeys(("n", "newton"), "N"),
    **dict.fromkeys(("kn", "kilonewton"), "kN"),
    "dan": "daN",
    **dict.fromkeys(("kp", "kgf"), "kgf"),
    **dict.fromkeys(("lb", "lbs"), "lbf"),
    **dict.fromkeys(("kip", "kips"), "kip"),
    **dict.fromkeys(("pa", "pascal"), "Pa"),
    **dict.fromkeys(("hpa", "mbar"), "mbar"),
    "kpa": "kPa",
    "mpa": "MPa",
    **dict.fromkeys(("barg", "bar(g)", "bar_g", "bara", "bar(a)", "bar"), "bar"),
    **dict.fromkeys(("psig", "psia", "psi"), "psi"),
    **dict.fromkeys(("kgf/cm2", "kg/cm2", "kp/cm2"), "kgf/cm^2"),
    "n/mm2": "N/mm^2",
    **dict.fromkeys(("volt", "volts", "v"), "V"),
    **dict.fromkeys(("mps", "m_s", "m/sec", "m/sek", "m*s^-1", "m/s", "ms-1"), "m/s"),
    **dict.fromkeys(("mmps", "mm_s", "mm/sec", "mm/sek", "mms", "mm/s"), "mm/s"),
    **dict.fromkeys(("cmps", "cm_s", "cm/s"), "cm/s"),
    **dict.fromkeys(("in/s", "ips", "in_s"), "in/s"),
    **dict.fromkeys(("degc", "deg_c", "celsius", "gradcelsius"), "degC"),
    **dict.fromkeys(("degf", "deg_f", "fahrenheit"), "degF"),
    **dict.fromkeys(("deg", "degree", "degrees", "grad"), "deg"),
    **dict.fromkeys(("deg/s", "deg_s", "degs"), "deg/s"),
    **dict.fromkeys(("rad/s", "1/s", "rad_s", "rads"), "rad/s"),
    **dict.fromkeys(("nm", "n*m", "newtonmeter"), "N m"),
    "knm": "kN m",
}
ANGLES = ("deg", "rad")  # units of a position that have no dimension
_POWERS = str.maketrans({" ": "", "^": ""})
_PORT_A = ("pA", "PA")  # its pressure, not a pascal
_ABSOLUTE = ("bara", "psia")  # hbench's pressures are those above the atmosphere

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$")
_LONGEST = 200  # characters of a quantity
_RAISED = re.compile(r"⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_PRINTED = {"°": "deg", "μ": "u", "∕": "/", "⁄": "/", **dict.fromkeys("·⋅∙×", " ")}
_SIGNS = str.maketrans(_PRINTED)
_TOKEN = re.compile(r"\s*(?:([A-Za-z%]+|1)(?:\s*\^\s*(-?\d+))?|(\^(?=\s*-?\d)|[*/()]))")


def in_ascii(unit: str) -> str:
    """Return a unit in typographic notation in ASCII: mm/s² is mm/s^2, ℃ is degC, µm is um."""
    if unit.isascii():
        return unit
    powers = _RAISED.sub(lambda raised: f"^{raised[0].translate(_DIGITS)}", unit)
    return normalize("NFKC", powers).translate(_SIGNS)


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> Unit:
    """Return the unit of an expression. Raises ``ValueError`` with the invalid part."""
    if len(text) > _LONGEST:
        raise ValueError(f"unit {text[:20]!r}...: is {len(text)} characters long; limit {_LONGEST}")
    text = in_ascii(text)
    if (alone := UNITS.get(text.strip())) is not None:
        return alone
    factor = 1.0
    dimension: Dimension = (0,) * 5
    for unit, sign, exponent in _factors(text):
        signed = unit.factor**sign
        factor = factor * signed * signed ** (exponent - 1)
        powers = zip(dimension, unit.dimension, strict=True)
        dimension = tuple(before + sign * exponent * own for before, own in powers)
    return Unit(factor, dimension)


def unit_in(text: str) -> str | None:
    """Return the unit of hbench that a text such as ``[kN]`` or ``sec`` means, or None."""
    bare = text.strip().strip("[]{}<>").strip()
    bare = bare[1:-1].strip() if bare.startswith("(") and bare.endswith(")") else bare
    bare = in_ascii(bare)
    if bare in _PORT_A:
        return None
    spelled = SPELLINGS.get(bare.lower().translate(_POWERS))
    for unit in (spelled, bare):
        try:
            if not unit or not unit[0].isalpha():
                continue
            if any(parse_unit(unit).dimension) or unit in ANGLES:
                return unit
        except ValueError:
            continue
    return None


def _factors(text: str) -> Iterator[tuple[Unit, int, int]]:
    """Yield each unit of an expression with its sign, -1 if it divides, and its exponent."""
    position, end = 0, len(text.rstrip())
    signs, sign = [1], 1  # of the open parentheses, of the next unit or parenthesis
    while position < end:
        match = _TOKEN.match(text, position)
        if match is None:
            rest = text[position:]
            if position and text[position - 1].isalpha() and rest[0].isdigit():
                raise ValueError(f"unit {text!r}: a power needs ^, as in m/s^2")
            raise ValueError(f"unit {text!r}: can't read {rest!r}")
        name, exponent, mark = match.groups()
        if name is not None:
            yield _named(name, text), sign * signs[-1], _exponent(exponent or "1", text)
            sign = 1
        elif mark == "^":
            raise ValueError(f"unit {text!r}: '^' follows no unit")
        elif mark == "/":
            sign = -1
        elif mark == "(":
            signs.append(signs[-1] * sign)
            sign = 1
        elif mark == ")":
            if len(signs) == 1:
                raise ValueError(f"unit {text!r}: ')' without '('")
            signs.pop()
        position = match.end()
    if len(signs) > 1:
        raise ValueError(f"unit {text!r}: '(' is not closed")


def _named(name: str, text: str) -> Unit:
    unit = UNITS.get(name)
    if unit is None:
        raise ValueError(f"unknown unit {name!r}; {_meant(name)}")
    if unit.zero:
        raise ValueError(f"unit {text!r}: {name} is not a factor; write K for differences")
    return unit


def _meant(name: str) -> str:
    """Return what an unknown unit may be, or else the units that are known."""
    lower = name.lower()
    spelled = SPELLINGS.get(lower, "")
    if lower in _ABSOLUTE:
        return f"for an absolute pressure write {spelled!r} and offset: -1.013 bar"
    similar = [each for each in UNITS if each.lower() == lower] or [spelled] * bool(spelled)
    if similar:
        return f"did you mean {' or '.join(map(repr, similar))}?"
    return f"known are {', '.join(sorted(UNITS))}"


def _exponent(digits: str, text: str) -> int:
    if len(digits.lstrip("-")) > 1:
        raise ValueError(f"unit {text!r}: power {digits[:20]}; limit 9")
    return int(digits)


def to_si(value: object, unit: str) -> float:
    """Convert a quantity such as ``"150 bar"`` to a float in SI.

    ``unit`` is a unit of the expected dimension, for the check and in messages: degC for a
    temperature, K for a difference of temperatures. A bare number is accepted only if the expected
    dimension is 1. Raises ``ValueError``.
    """
    wanted = parse_unit(unit)
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(f"is not a quantity; write for example '1 {unit}'")
    text = str(value).replace("\u2212", "-")
    match = _NUMBER.match(text) if len(text) <= _LONGEST else None
    if match is None:
        raise ValueError(f"is not a number with a unit; write for example '1 {unit}'")
    number, given = float(match[1]), match[2]
    if re.match(r",\d", given):
        raise ValueError("has a decimal comma; write a point")
    if re.search(r"[,;]", given):
        raise ValueError(f"contains more than a number with a unit; write for example '1 {unit}'")
    if not given and any(wanted.dimension):
        raise ValueError(f"has no unit; write for example '{match[1]} {unit}'")
    parsed = parse_unit(given)
    if parsed.zero and not wanted.zero and parsed.dimension == wanted.dimension:
        raise ValueError(f"is a temperature, not a difference; write for example '1 {unit}'")
    if parsed.dimension != wanted.dimension:
        raise ValueError(f"has the wrong unit; expected a unit such as {unit}")
    si = parsed.to_si(number)
    if not math.isfinite(si):
        raise ValueError("is not a finite number")
    return si


def from_si(si: float, unit: str) -> float:
    """Convert a float in SI to ``unit``."""
    return parse_unit(unit).from_si(si)
