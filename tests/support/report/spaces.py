"""Text of pages where lines may be broken anywhere."""

import re

_WHOLE = re.compile(r'<span class="whole">(.*?)</span>')


def ordinary_spaces(page: str) -> str:
    """Return a page without the no-break spaces between numbers and their units."""
    return page.replace("\N{NO-BREAK SPACE}", " ")


def breakable(page: str) -> str:
    """Return a page without the marks of names, dates and options that are kept on one line."""
    return _WHOLE.sub(r"\1", page)
