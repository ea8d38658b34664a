"""Symbols with an index, such as F_C, which is set below the line."""

import re
from collections.abc import Iterator

_SYMBOL = re.compile(
    r"\b(?:([AFPQp]|dP)_([^\W²]+)|([kabc])_(\d)\b|(v)_(SW|stribeck|s)\b|(u)_([TL]\d?)\b|(C)_(ff\w+)"
    r"|(m)_(T)\b|(t)_(point|mean)\b|([xz])_(i(?:−1)?)(?!\w)|([Kτ])_(c)\b|(U)_(95)(?!\d)|(s)_([rRw])\b|([σθ])_(\d|i|between|own)(?![^\W²])"
    r"|(Δ)_(max|i)\b|(k)_(piston|rod)\b)"
)


def pieces(text: str) -> Iterator[tuple[str, bool]]:
    """Yield a text in pieces, each with whether it is an index, which is set below the line."""
    end = 0
    for match in _SYMBOL.finditer(text):
        symbol, index = filter(None, match.groups())
        yield text[end : match.start()] + symbol, False
        yield index, True
        end = match.end()
    yield text[end:], False
