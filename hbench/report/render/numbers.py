"""Numbers as text for readers: rounding by the interval, minus signs, units."""

import math
import re
from collections.abc import Collection
from operator import itemgetter

_WITH_UNIT = re.compile(
    r"[\d⁰¹²³⁴⁵⁶⁷⁸⁹] (?:%|k?N(?: s/m|/mm?|/bar)?|m?m(?:/s²?|²)?|m?V(?: s/m|/m|/\(Pa s\))?|[kM]?Pa"
    r"|bar|m?s|min|h|k?Hz|rad/s|dB|deg|J|kg|m?l/min(?:/bar| per bar)?|°C|K|nats)(?![\w/])"
    r"|\((?:N s/m|Pa s|ml/min per bar|% points)\)|± U\b"
)
_OF_SYMBOL = re.compile(r"\b(P_[TLS][pr]?) (?=−?\d)")  # a pressure before its value
_RELATION = re.compile(r"(\bp )?([=<>≥≤]) (?=[−\d])")  # before a number, such as p = 0.01
_NEGATIVE = re.compile(r"(?<![\w.)-])-(?=\d)")
_EXPONENT = re.compile(r"(?<=\d)[eE]([+-]?\d+)(?!\w)")
_TEN = re.compile(r"·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_SYMMETRIC = 0.05  # of the half-width
_LEAST_P = 1e-4  # a smaller p-value is written as being below it
NONE = "–"  # in place of a number that does not exist


def _minus(text: str) -> str:
    """Write a minus sign, and none before a zero."""
    return text.lstrip("-") if not text.strip("-0.") else text.replace("-", "−")


def with_minus(text: str) -> str:
    """Return a text with minus signs before its negative numbers in place of hyphens."""
    return _NEGATIVE.sub("−", text)


def with_powers(text: str) -> str:
    """Return a text with powers of ten: ``1.25·10⁻⁵`` for ``1.25e-5``."""
    return _EXPONENT.sub(lambda found: f"·10{str(int(found[1])).translate(_RAISED)}", text)


def without_powers(text: str) -> str:
    """Return the text of ``with_powers`` as a terminal shows it: ``1.25e-5``."""
    return _TEN.sub(lambda found: f"e{found[1].translate(_LOWERED)}", text)


def number(value: float | None, decimals: int = 1) -> str:
    """Write with fixed decimals; a number that does not exist is a dash."""
    if value is None or not math.isfinite(value):
        return NONE
    return _minus(f"{value:.{decimals}f}")


def significant(value: float | None, digits: int) -> str:
    """Write with significant digits and no exponent between 1e-4 and 1e7."""
    if value is None or not math.isfinite(value):
        return NONE
    if value == 0:
        return "0"
    rounded = float(f"{value:.{digits - 1}e}")  # 0.0996 has two digits in 0.10
    magnitude = math.floor(math.log10(abs(rounded)))
    if not -4 <= magnitude < 7:
        return _minus(f"{value:.{digits - 1}e}")
    return number(value, max(0, digits - 1 - magnitude))


def p_words(p: float) -> str:
    """Write a p-value with two significant digits."""
    return f"< {_LEAST_P:g}" if p < _LEAST_P else significant(p, 2)


def p_equation(p: float) -> str:
    """Write a p-value with its sign of equality, such as ``p = 0.016``."""
    return f"p {p_words(p)}" if p < _LEAST_P else f"p = {p_words(p)}"


def with_interval(value: float | None, half_width: float | None) -> str:
    """Write ``value ± half_width``, both to the second significant digit of the half-width.

    This is GUM 7.2.6: 1300.4 and 145.2 are written as ``1300 ± 150``.
    """
    if half_width is None or not math.isfinite(half_width) or not half_width > 0:
        return significant(value, 3)
    if value is None or not math.isfinite(value):
        return significant(value, 3)
    return f"{_to_half(value, half_width)} ± {_to_half(half_width, half_width)}"


def with_ends(value: float | None, low: float, high: float, more: int = 0) -> str:
    """Write ``value (low to high)``, to the second significant digit of half of their distance.

    If the value lies in the middle of them, it is written with this half. ``more`` digits are added
    where they differ.
    """
    half = (high - low) / 2
    if value is None or not half > 0 or abs(low + high - 2 * value) < _SYMMETRIC * half:
        return with_interval(value, half)
    shown, *ends = (_to_half(each, half, more) for each in (value, low, high))
    return f"{shown} ({' to '.join(ends)})"


def _to_half(value: float, half_width: float, more: int = 0) -> str:
    """Write to the second significant digit of ``half_width``, to no more than six decimals.

    ``more`` decimals are added.
    """
    decimals = _decimals(half_width, more)
    return number(round(value, decimals), max(0, decimals))


def _decimals(half_width: float, more: int = 0) -> int:
    rounded = float(f"{half_width:.1e}")  # 99.6 has its second digit at the tens: 100
    return min(1 + more - math.floor(math.log10(rounded)), 6)


def finer(value: float, half_width: float) -> str:
    """Write with one decimal more than ``with_interval``, so that differences agree with it."""
    return _to_half(value, half_width, 1)


def half_width(value: float) -> str:
    """Write the half-width of an interval with two significant digits: 9.4, 110."""
    return _to_half(value, value) if math.isfinite(value) and value > 0 else significant(value, 2)


def short(value: float | None) -> str:
    """Write with three significant digits and no zeros at the end: 5, 1.2, 49.1, 5000."""
    return _without_end_zeros(significant(value, 3))


def in_mm_s(v_m_s: float | None) -> str:
    """Write a speed in mm/s with one decimal, a slow one with two digits: 0.38, 3.8, 200.0."""
    if v_m_s is not None and 0 < abs(v_m_s) < 1e-3:
        return significant(1e3 * v_m_s, 2)
    return number(None if v_m_s is None else 1e3 * v_m_s)


def whole_mm_s(v_m_s: float) -> str:
    """Write a speed in whole mm/s, or with two digits: 82, 3.8, 0.38."""
    v_mm_s = 1e3 * v_m_s
    if abs(v_mm_s) < 10:
        return _without_end_zeros(significant(v_mm_s, 2))
    return number(v_mm_s, 0)


def unbroken(text: str) -> str:
    """Return a text that is not broken over lines, such as a number with its uncertainty."""
    return text.replace(" ", "\N{NO-BREAK SPACE}")


def unit_kept(text: str) -> str:
    """Return a text that is not broken over lines between a symbol, its number and the unit."""
    text = _OF_SYMBOL.sub("\\1\N{NO-BREAK SPACE}", text)
    text = _RELATION.sub(lambda match: unbroken(match[0]), text)
    return _WITH_UNIT.sub(lambda match: match[0].replace(" ", "\N{NO-BREAK SPACE}"), text)


def force(value_n: float | None) -> str:
    """Write a load such as ``−500 N``."""
    return "not set" if value_n is None else f"{short(value_n)} N"


def span(values: Collection[float]) -> str:
    """Write the range of some numbers: ``5–200``, ``0.95–38``.

    The smaller end has no more decimals than three digits of the larger one; below 1 it has two
    digits.
    """
    low, high = min(values), max(values)
    decimals = len(significant(high, 3).partition(".")[2])
    if abs(low) < 1:
        decimals = max(decimals, len(significant(low, 2).partition(".")[2]))
    return _range(_without_end_zeros(number(low, decimals)), short(high))


def alike(values: Collection[float]) -> str:
    """Write the range of measured numbers with the larger one's decimals: ``67.7–93.0``."""
    low, high = min(values), max(values)
    decimals = len(significant(max(abs(low), abs(high)), 3).partition(".")[2])
    return _range(number(low, decimals), number(high, decimals))


def span_with_intervals(
    values: Collection[tuple[float, float | None]], widest: float | None = None
) -> str:
    """Write the range of values with half-widths, both ends rounded as the less certain one.

    Ranges of parts of the values are rounded alike with the ``widest`` half-width of all. An end
    that would keep a single digit is rounded by its own half-width: ``1.7–16.1``. If both would,
    the smaller half-width rounds both, so that the smaller value stays in front: ``3300–3400``.
    """
    ends = (min(values, key=itemgetter(0)), max(values, key=itemgetter(0)))
    if widest is None:
        widest = max((half for _, half in ends if half is not None), default=None)
    coarse = [widest is not None and abs(end) < 10.0 ** (1 - _decimals(widest)) for end, _ in ends]
    own = [half for (_, half), too_coarse in zip(ends, coarse, strict=True) if too_coarse and half]
    finest = min(own, default=None)
    halves = [finest if too_coarse else widest for too_coarse in coarse]
    return _range(
        *(
            with_interval(end, half).partition(" ± ")[0]
            for (end, _), half in zip(ends, halves, strict=True)
        )
    )


def percent_span(shares: Collection[float]) -> str:
    """Write the range of shares in per cent, each with two significant digits: ``1.8–2.5 %``."""
    return f"{_range(*(significant(end, 2) for end in (min(shares), max(shares))))} %"


def _range(low: str, high: str) -> str:
    """Write a range; with a negative end a dash would look like another minus sign."""
    return (" to " if "−" in low + high else "–").join(dict.fromkeys((low, high)))


def _without_end_zeros(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text
