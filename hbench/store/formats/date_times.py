"""Date-times, mostly as text: ISO 8601, day first with points, and times of day without a date.

Examples are ``24.12.2024 18:30:00,5`` and ``18:30:00.5``; the year first with slashes,
``2024/12/24 18:30:00.5``; the month by its English name, ``24-Dec-2024 18:30:00.5``; with the
12-hour clock of the United States, the month first with slashes, ``12/24/2024 6:30:00.5 PM``. A
duration as pandas writes it, ``0 days 00:00:01.5``, is read as a time of day.
"""

import re
from contextlib import suppress
from datetime import UTC, date, datetime

import numpy as np

_DAY_FIRST = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})[ T]\s*(.+)")
_YEAR_FIRST = re.compile(r"(\d{4})/(\d{1,2})/(\d{1,2})[ T]\s*(.+)")
_NAMED_MONTH = re.compile(r"(\d{1,2})-([A-Za-z]{3})-(\d{4})[ T]\s*(.+)")
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_ONE_DIGIT_HOUR = re.compile(r"(?<=\d)[ T](\d):")
_TWELVE_HOURS = re.compile(
    r"(?:(\d{1,2})/(\d{1,2})/(\d{4}),? )?(1[0-2]|0?[1-9]):(.+?) ?([ap])\.?m\.?"
)
_NO_DATE = date(1970, 1, 1)  # of a time of day
_TIME_OF_DAY = re.compile(r"\d{1,2}:\d\d:\d\d(?:[.,]\d{1,9})?")


def utc(time: np.datetime64) -> datetime:
    """Return a time in UTC."""
    instant: datetime = time.astype("datetime64[us]").item().replace(tzinfo=UTC)
    return instant


def on_date(instant: datetime, stated: str) -> datetime:
    """Return an instant that is only a time of day on a ``stated`` date, if this is ISO 8601."""
    if instant.date() == _NO_DATE:
        with suppress(ValueError):
            return datetime.combine(date.fromisoformat(stated.strip()), instant.timetz())
    return instant


def parse_date_time(text: str) -> datetime:
    """Return the date-time of a text; a time without a date is one of 1970-01-01.

    Raises ``ValueError``.
    """
    text = text.strip().removeprefix("0 days ")
    if match := _TWELVE_HOURS.fullmatch(text.lower()):
        month, day, year, hour, rest, half = match.groups()
        text = f"{int(hour) % 12 + 12 * (half == 'p'):02}:{rest}"
        text = f"{year}-{month:0>2}-{day:0>2}T{text}" if year else text
    if _TIME_OF_DAY.fullmatch(text):
        hour, rest = text.split(":", 1)
        text = f"{_NO_DATE}T{hour:0>2}:{rest}"
    if match := _DAY_FIRST.fullmatch(text):
        day, month, year, time = match.groups()
        text = f"{year}-{month:0>2}-{day:0>2}T{time}"
    elif match := _YEAR_FIRST.fullmatch(text):
        year, month, day, time = match.groups()
        text = f"{year}-{month:0>2}-{day:0>2}T{time}"
    elif match := _NAMED_MONTH.fullmatch(text):
        day, name, year, time = match.groups()
        text = f"{year}-{_MONTHS.index(name.lower()) + 1:02}-{day:0>2}T{time}"
    text = _ONE_DIGIT_HOUR.sub(r"T0\1:", text, count=1)
    return datetime.fromisoformat(text)
