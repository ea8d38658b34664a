"""How numbers are written for people: rounding by the interval, minus signs, units."""

import math

NONE = "–"  # what stands for a number that does not exist


def _minus(text: str) -> str:
    return text.replace("-", "−")


def number(value: float | None, decimals: int = 1) -> str:
    """Write with fixed decimals; a number that does not exist is a dash."""
    if value is None or not math.isfinite(value):
        return NONE
    return _minus(f"{value:.{decimals}f}")


def significant(value: float | None, digits: int = 4) -> str:
    """Write with significant digits and no exponent between 1e-4 and 1e7."""
    if value is None or not math.isfinite(value):
        return NONE
    if value == 0:
        return "0"
    magnitude = math.floor(math.log10(abs(value)))
    if not -4 <= magnitude < 7:
        return _minus(f"{value:.{digits - 1}e}")
    return number(value, max(0, digits - 1 - magnitude))


def with_interval(value: float | None, half_width: float | None) -> str:
    """Write ``value ± half_width``, both to the second significant digit of the half-width."""
    known = half_width is not None and math.isfinite(half_width) and half_width > 0
    if value is None or not math.isfinite(value) or not known:
        return significant(value)
    decimals = min(max(0, 1 - math.floor(math.log10(half_width))), 6)
    return f"{number(value, decimals)} ± {number(half_width, decimals)}"


def force(value_n: float | None) -> str:
    """Write a load such as ``−500 N``."""
    if value_n is None:
        return "not set"
    return f"{number(value_n, 0 if abs(value_n) >= 100 else 1).removesuffix('.0')} N"


def span(values: list[float], unit: str, decimals: int = 0) -> str:
    """Write the range of some numbers: ``5 to 200 mm/s``."""
    low, high = number(min(values), decimals), number(max(values), decimals)
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"
