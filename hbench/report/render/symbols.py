"""Symbols with an index, such as F_C, which is set below the line, and what a line keeps whole."""

import re
from collections.abc import Iterator

from markupsafe import Markup, escape

from hbench.report.render.numbers import unit_kept

_SYMBOL = re.compile(
    r"\b(?:([AFPQp]|dP)_([^\W²]+)|([kabc])_(\d)\b|(v)_(SW|stribeck|s)\b|(u)_([TL]\d?)\b|(C)_(ff\w+)"
    r"|(m)_(T)\b|(t)_(point|mean)\b|([xz])_(i(?:−1)?)(?!\w)|([Kτ])_(c)\b|(U)_(95)(?!\d)|(s)_([rRw])\b|([σθ])_(\d|i|between|own)(?![^\W²])"
    r"|(Δ)_(max|i)\b|(k)_(piston|rod)\b)"
)
_INTERVAL = re.compile(r"(?<=\d) ± (?=\d)")
_NUMBERED = re.compile(r"\b(Table) (\d)")
_RANGE = re.compile(r"\(([−+]?[\d.]+) to ([−+]?[\d.]+)\)")
_OPTION = r"(?<![\w-])--[a-z][a-z-]*"  # of a command
# a name such as HC-0011, unless it is long
_NAME = r"(?<![\w&#-])(?=[\w-]*[A-Za-z])(?=[\w-]*\d)(?![\w-]{25})\w+(?:-\w+)+(?![\w-])"
_DATE = r"(?<![\w&#-])\d{4}-\d\d-\d\d(?![\w-])"
_ON_ONE_LINE = re.compile(f"{_OPTION}|{_NAME}|{_DATE}")


def pieces(text: str) -> Iterator[tuple[str, bool]]:
    """Yield a text in pieces, each with whether it is an index, which is set below the line."""
    end = 0
    for match in _SYMBOL.finditer(text):
        symbol, index = filter(None, match.groups())
        yield text[end : match.start()] + symbol, False
        yield index, True
        end = match.end()
    yield text[end:], False


def numbers_kept(text: str) -> str:
    """Return a text that is not broken within a number, its interval and its unit."""
    text = _NUMBERED.sub("\\g<1>\N{NO-BREAK SPACE}\\g<2>", text)
    text = _RANGE.sub("(\\g<1>\N{NO-BREAK SPACE}to\N{NO-BREAK SPACE}\\g<2>)", text)
    return _INTERVAL.sub("\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}", unit_kept(text))


def subscripts(text: str) -> Markup:
    """Write the index of a symbol such as F_C below the line; all else is escaped.

    A number is kept on one line with its unit and interval, and so are options, names and dates.
    """
    parts = pieces(numbers_kept(text))
    words = (f"<sub>{escape(each)}</sub>" if low else escape(each) for each, low in parts)
    return Markup(_ON_ONE_LINE.sub(r'<span class="whole">\g<0></span>', "".join(words)))
