"""Words that anybody may have written, made harmless for a terminal and for a spreadsheet."""

import re

CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029]")  # tab and newline are none
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def printable(text: str) -> str:
    """Put a question mark for each character that a terminal would obey."""
    return CONTROL.sub("?", text)


def as_cell(text: str) -> str:
    """Put an apostrophe before what a spreadsheet would run as a formula; it is then text."""
    return f"'{text}" if text.startswith(_FORMULA) else text


def from_cell(cell: str) -> str:
    """Take away the apostrophe that ``as_cell`` put there."""
    return cell[1:] if cell.startswith("'") and cell[1:].startswith(_FORMULA) else cell
