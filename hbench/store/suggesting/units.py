"""Units in the names of columns, in rows of units and in the names of files."""

import re

from hbench.units import unit_in

_BRACKETS = re.compile(r"\s*[\[({<]\s*([^\[\](){}<>]*(?:\([^()]*\))?)\s*[\])}>]\s*$")
# Of an unknown unit: what is in square brackets, or a quotient in round ones.
_UNKNOWN = re.compile(r"\[\s*([^\[\]]{1,20}?)\s*\]\s*$|\(\s*([^()/]{1,9}/[^()/]{1,9}?)\s*\)\s*$")
_SLASH = re.compile(r"\s+/\s*(\S+)\s*$|\s*,\s*(\S+)\s*$|\s+in\s+(\S+)\s*$")
# A symbol over its unit, such as F/kN and p_A/MPa; behind a word a slash divides a path.
_SYMBOL = re.compile(r"\s*([^\W\d_](?:[A-Z0-9_]\w{0,4})?)/(\S+)\s*")
# Of signals before they are converted.
_ELECTRICAL = re.compile(
    r"[\s_.(\[](mA|counts|cts|digits?|increments|lsb)[)\]]?\s*$", re.IGNORECASE
)
_ENDING = re.compile(r"[\s_.\-]+([^\s_.\-]+|mm?[_/]s)$")


def split_unit(name: str) -> tuple[str, str | None]:
    """Return a column's name without its unit in brackets or behind a slash, and the unit."""
    for pattern in (_BRACKETS, _SLASH):
        if match := pattern.search(name):
            unit = unit_in(next(filter(None, match.groups()), ""))
            if unit is not None or pattern is _BRACKETS:
                return name[: match.start()], unit
    if (match := _SYMBOL.fullmatch(name)) and (unit := unit_in(match[2])):
        return match[1], unit
    return name, None


def unknown_unit(name: str, stated: str = "") -> str:
    """Return the unit in brackets behind a name, or ``stated``, if hbench does not know it.

    Round brackets contain other words too: a unit in them has a slash, or is that of a signal, such
    as mA, which may also end a name. Otherwise the result is empty.
    """
    match = _UNKNOWN.search(name)
    text = stated.strip() or (match[1] or match[2] if match else "")
    if not text and (electrical := _ELECTRICAL.search(name)):
        text = electrical[1]
    return text if re.search(r"[^\W\d]|%", text) and unit_in(text) is None else ""


def split_ending(name: str) -> tuple[str, str | None]:
    """Return a name such as ``Weg_mm`` without its last word, and that word if it is a unit."""
    match = _ENDING.search(name)
    unit = unit_in(match[1]) if match else None
    return (name[: match.start()], unit) if match and unit else (name, None)
