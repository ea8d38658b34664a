"""Text for a terminal: lines of limited width, and signs that every terminal shows."""

import re
from textwrap import wrap
from unicodedata import name

from hbench.report.render.numbers import unit_kept, without_powers

WIDE = 80  # characters of a line, of prose and of tables
_PLAIN: dict[str, str | int | None] = {
    "−": "-",
    "–": "-",
    "\N{NON-BREAKING HYPHEN}": "-",
    "±": "+-",
    "×": "x",
    "²": "^2",
    "³": "^3",
    "°": "deg",
    "…": "...",
    "∞": "inf",
    "√": "sqrt",
    **{letter: name(letter).split()[-1].lower() for letter in "αβγδεηθλμνρστφχω"},
    "Δ": "Delta",
    "\N{NO-BREAK SPACE}": " ",
}
_RANGE = re.compile(r"(?<=\d)–(?=\d)")


def plain(text: str) -> str:
    """Replace signs that some terminals do not have, powers of ten and ranges: ``5 to 20``."""
    return _RANGE.sub(" to ", without_powers(text)).translate(str.maketrans(_PLAIN))


def wrapped(text: str) -> list[str]:
    """Return the lines of a paragraph in ``plain`` signs; those after the first are indented."""
    return broken(plain(text), WIDE, "  ")


def broken(text: str, width: int, indent: str = "") -> list[str]:
    """Return lines of a text that is broken at spaces, those after the first with an ``indent``.

    It is not broken between a number and its unit, nor within a path or an option.
    """
    lines = wrap(
        unit_kept(text),
        width,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]
