"""Coefficients and fitted values in words, with their intervals."""

import re

from hbench.records import AddedEffect, FitParameter
from hbench.report.diagnosis.names import CHAMBERS, PRESSURE_SYMBOLS, in_words
from hbench.report.render.numbers import significant, with_ends

_OF_POWER = re.compile(r"_0 = (\d+ [^,]+)")  # where a law of any exponent has the same value
_NOT_OF_POWER = ("exponent", "lag")
_COEFFICIENTS = {
    "test": "test cylinder",
    "load": "load cylinder",
    **{f"{part}_{side}": f"{side} side of {part} cylinder"
       for part in ("test", "load") for side in ("piston", "rod")},
    **{chamber: f"chamber {chamber.capitalize()}" for chamber in CHAMBERS},
}  # fmt: skip
_FINE = 1e-5  # a narrower interval is not written with fixed decimals


def coefficient_words(name: str) -> str:
    """Return the name of an effect's coefficient in words."""
    return _COEFFICIENTS.get(name) or PRESSURE_SYMBOLS.get(name) or in_words(name)


def effect_words(effect: AddedEffect) -> str:
    """Return an effect's name with its coefficients and their intervals.

    Those at a bound are left out where others are not.
    """
    return f"{effect.name} ({coefficients_words(effect)})"


def coefficients_words(effect: AddedEffect) -> str:
    """Return an effect's coefficients with their intervals; see ``effect_words``."""
    free = {name: p for name, p in effect.parameters.items() if not p.at_bound}
    chosen = free or effect.parameters
    return ", ".join(
        f"{coefficient_words(name)} {coefficient_text(effect, name)}" for name in chosen
    )


def parameter_text(parameter: FitParameter) -> str:
    """Write a value with its 95 % interval and its unit, or why there is no interval."""
    texts = [_with_interval(parameter)]
    if parameter.unit != "1":
        texts.append(parameter.unit)
    if parameter.at_bound:
        texts.append(f"(at its {parameter.at_bound} bound)")
    elif parameter.ci95 is None:
        texts.append("(not determined)")
    return " ".join(texts)


def coefficient_text(effect: AddedEffect, name: str) -> str:
    """Write a coefficient, and where it holds if the law has another exponent than the textbook's.

    With the exponent its unit no longer fits the law: the law has a reference value for that.
    """
    text, reference = parameter_text(effect.parameters[name]), _OF_POWER.search(effect.law)
    if reference is None or name in _NOT_OF_POWER or "exponent" not in effect.parameters:
        return text
    return f"{text} at {reference[1]}"


def _with_interval(parameter: FitParameter) -> str:
    value = significant(parameter.value, 3)
    if parameter.ci95 is None:
        return value
    low, high = parameter.ci95
    if parameter.value == 0 and parameter.at_bound:
        return f"0 (95 %: {significant(low, 2)} to {significant(high, 2)})"
    if high - low > _FINE:
        return with_ends(parameter.value, low, high)
    return f"{value} ({significant(low, 3)} to {significant(high, 3)})"
