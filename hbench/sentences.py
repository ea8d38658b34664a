"""Words of sentences: lists, first letters, and forms that agree with a count."""

import re
from collections.abc import Sequence

_END = re.compile(r"(?<=[\w)%]\.) (?=[A-Z])")
_NAMES = ("Coulomb", "Stribeck")  # of people, in quantities


def listed(parts: Sequence[str], word: str = "and") -> str:
    """Return parts of a sentence with commas, and a word before the last one."""
    if len(parts) < 2:
        return "".join(parts)
    return f"{', '.join(parts[:-1])} {word} {parts[-1]}"


def abridged(names: Sequence[str], most: int) -> str:
    """Return the first names of a list with commas; dots stand for those beyond ``most``."""
    return ", ".join(names[:most]) + (", ..." if len(names) > most else "")


def sentences(text: str) -> list[str]:
    """Return the sentences of a text."""
    return _END.split(text)


def capital(text: str) -> str:
    """Write the first letter of a sentence as a capital, unless it begins with a symbol or key."""
    return text if "_" in text.partition(" ")[0] else text[:1].upper() + text[1:]


def uncapital(text: str) -> str:
    """Write the first letter of a text in lower case, as within a sentence, unless it is a name."""
    return text if text.startswith(_NAMES) else text[:1].lower() + text[1:]


def plural(count: int | None, singular: str, several: str) -> str:
    """Return the form of a noun or verb that agrees with a count."""
    return singular if count == 1 else several


def counted(count: int, noun: str) -> str:
    """Return a count and its noun, such as ``1 run`` or ``2 runs``."""
    return f"{count} {plural(count, noun, f'{noun}s')}"
