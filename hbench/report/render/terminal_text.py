"""Text for a terminal: lines of limited width, and signs that every terminal shows."""

from textwrap import wrap
from unicodedata import name

from hbench.report.render.numbers import without_powers

WIDE = 100  # characters of a line of prose
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


def plain(text: str) -> str:
    """Replace signs that some terminals do not have, and powers of ten: ``1.25e-5``."""
    return without_powers(text).translate(str.maketrans(_PLAIN))


def wrapped(text: str) -> list[str]:
    """Return the lines of a paragraph; those after the first are indented."""
    return wrap(text, WIDE, subsequent_indent="  ")
