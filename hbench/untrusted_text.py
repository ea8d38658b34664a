"""Text from foreign files, made harmless for terminals and spreadsheets."""

import re

# Without tab and newline. The surrogates replace the bytes of a file's name that is not UTF-8.
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def printable(text: str) -> str:
    """Replace each control character and invalid byte by a question mark."""
    return CONTROL.sub("?", text)


def as_cell(text: str) -> str:
    """Put an apostrophe before text that a spreadsheet would read as a formula."""
    return f"'{text}" if text.startswith(_FORMULA) else text


def from_cell(cell: str) -> str:
    """Remove the apostrophe of ``as_cell``."""
    return cell[1:] if cell.startswith("'") and cell[1:].startswith(_FORMULA) else cell
