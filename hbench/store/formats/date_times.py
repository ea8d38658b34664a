"""Date-times as text: ISO 8601, and day first with points, as in ``24.12.2024 18:30:00,5``."""

import re
from datetime import datetime

_DAY_FIRST = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})[ T]\s*(.+)")


def parse_date_time(text: str) -> datetime:
    """Return the date-time of a text. Raises ``ValueError``."""
    text = text.strip()
    if match := _DAY_FIRST.fullmatch(text):
        day, month, year, time = match.groups()
        text = f"{year}-{month:0>2}-{day:0>2}T{time}"
    return datetime.fromisoformat(text)
