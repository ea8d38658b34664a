"""Text of pages with ordinary spaces."""


def ordinary_spaces(page: str) -> str:
    """Return a page without the no-break spaces between numbers and their units."""
    return page.replace("\N{NO-BREAK SPACE}", " ")
