"""Coefficients and fitted values in words, with their intervals."""

import re

from hbench.records import DIRECTION_WORDS, AddedEffect, FitParameter
from hbench.report.diagnosis.names import CHAMBERS, PRESSURE_SYMBOLS, in_words
from hbench.report.render.numbers import significant, with_ends
from hbench.sentences import listed

_OF_POWER = re.compile(r"_0 = (\d+) ([^,]+)")  # where a law of any exponent has the same value
# Size there of a coefficient in another unit: its unit, and the power of the reference value in it.
_AT_REFERENCE = {
    "l/min/bar": ("l/min", 1),
    "bar min/l": ("bar", 1),
    "bar min^2/l^2": ("bar", 2),
}
_NOT_OF_POWER = ("exponent", "lag", "stribeck")
_COEFFICIENTS = {
    "test": "test cylinder",
    "load": "load cylinder",
    **{f"{part}_{side}": f"{side} side of {part} cylinder"
       for part in ("test", "load") for side in ("piston", "rod")},
    **{chamber: f"chamber {chamber.capitalize()}" for chamber in CHAMBERS},
}  # fmt: skip
_OF_VALVES = {
    "test": "test valve",
    "load": "load valves",
    "load_apart": "load valves, L1 above and L2 below their mean",
}
_QUOTED = re.compile(r"coefficient '(\w+)'")
_ASYMMETRY = "direction_asymmetry"  # positive: larger while extending
# Exponents of the flow through a gap over its pressure drop, and what causes such a gap by effect.
_GAPS = {0.5: "an orifice", 1.0: "a laminar gap"}
_CAUSES = {
    "internal_leakage": ("a damaged seal or a score in the bore", "a worn seal"),
    "external_leakage": ("a damaged seal, a score or a loose fitting", "a worn seal"),
}
_ZERO = "not distinguishable from 0"
_FINE = 1e-5  # a narrower interval is not written with fixed decimals


def coefficient_words(name: str, effect: str = "") -> str:
    """Return the name of a coefficient in words; that of an ``effect`` where this is known."""
    if of_valves(effect) and name in _OF_VALVES:
        return _OF_VALVES[name]
    return _COEFFICIENTS.get(name) or PRESSURE_SYMBOLS.get(name) or in_words(name)


def of_valves(effect: str) -> bool:
    """Return whether an effect is one of the valves, so that its coefficients name valves."""
    return effect.startswith("valve_")


def keys_as_words(text: str) -> str:
    """Return a text with the coefficients that it quotes by their keys in words."""
    return _QUOTED.sub(lambda key: f"coefficient ({coefficient_words(key[1])})", text)


def effect_words(effect: AddedEffect) -> str:
    """Return an effect's name with its coefficients and their intervals.

    Those at a bound are left out where others are not.
    """
    return f"{effect.name} ({coefficients_words(effect)})"


def coefficients_words(effect: AddedEffect) -> str:
    """Return an effect's coefficients with their intervals; see ``effect_words``."""
    free = {name: p for name, p in effect.parameters.items() if not p.at_bound}
    chosen = free or effect.parameters
    zero = [name for name, p in chosen.items() if _contains_zero(p)]
    texts = {
        name: f"{coefficient_words(name, effect.name)} {_size_text(effect, name)}"
        for name in chosen
    }
    known = [text for name, text in texts.items() if name not in zero]
    words = ("; " if any(", " in text for text in known) else ", ").join(known)
    unknown = f"{_ZERO}: {', '.join(texts[name] for name in zero)}" if zero else ""
    return "; ".join(filter(None, (words, unknown)))


def gap_exponent(effect: AddedEffect) -> float | None:
    """Return the exponent, 0.5 or 1, of the kind of gap that a leak flows through.

    None where the interval of the fitted exponent contains neither or both, or where the exponent
    is not fitted.
    """
    fitted = effect.parameters.get("exponent")
    if effect.name not in _CAUSES or fitted is None or fitted.ci95 is None or fitted.at_bound:
        return None
    low, high = fitted.ci95
    kinds = [exponent for exponent in _GAPS if low <= exponent <= high]
    return kinds[0] if len(kinds) == 1 else None


def gap_words(effect: AddedEffect) -> str:
    """Return which kind of gap the exponent of a leak suggests; empty where it does not decide."""
    kind = gap_exponent(effect)
    if kind is None:
        return ""
    (other,) = (exponent for exponent in _GAPS if exponent != kind)
    causes = dict(zip(_GAPS, _CAUSES[effect.name], strict=True))
    return (
        f"The exponent, {parameter_text(effect.parameters['exponent'])}, is that of {_GAPS[kind]} "
        f"({kind:g}), such as {causes[kind]}, and not that of {_GAPS[other]} ({other:g}), such as "
        f"{causes[other]}."
    )


def description_words(effect: AddedEffect) -> str:
    """Return an effect's law in words, with the kind of gap that a leak flows through.

    Of an asymmetry of friction its direction is added.
    """
    if (kind := gap_exponent(effect)) is not None:
        return f"{effect.description}, as through {_GAPS[kind]}"
    known = [p for p in effect.parameters.values() if not (p.at_bound or _contains_zero(p))]
    ways = {p.value > 0 for p in known}
    if effect.name != _ASYMMETRY or len(ways) != 1:
        return effect.description
    way = DIRECTION_WORDS["extend" if ways.pop() else "retract"]
    mean = "than the mean of both directions"
    return effect.description.replace("in one direction", f"while {way} {mean}")


def only_coefficient(effect: AddedEffect) -> str:
    """Return the only coefficient that is not 0, with its interval; empty where there are more.

    Only a part of the bench is named with it.
    """
    free = [name for name, p in effect.parameters.items() if not p.at_bound]
    known = [name for name in free if not _contains_zero(effect.parameters[name])] or free
    if len(known) != 1:
        return ""
    part = _COEFFICIENTS.get(known[0], "")
    return f"{part} {_size_text(effect, known[0])}".strip()


def parts_present(effect: AddedEffect) -> list[str]:
    """Return the coefficients of parts of the bench that are not 0 within their intervals.

    These parts are a cylinder or a chamber, by the coefficient's name.
    """
    return [
        name
        for name, p in effect.parameters.items()
        if name in _COEFFICIENTS and not p.at_bound and p.value and not _contains_zero(p)
    ]


def parameter_text(parameter: FitParameter, at: str = "") -> str:
    """Write a value with its 95 % interval and its unit, or why there is no interval.

    ``at`` is the condition that it applies to, such as ``at 50 bar``.
    """
    texts = [_with_interval(parameter)]
    if parameter.unit != "1":
        texts.append(unit_text(parameter.unit))
    texts += [at] if at else []
    if parameter.at_bound:
        texts.append(f"(at its {parameter.at_bound} bound)")
    elif parameter.ci95 is None:
        texts.append("(not determined)")
    return " ".join(texts)


def coefficient_text(effect: AddedEffect, name: str) -> str:
    """Write a coefficient with its interval, and whether that contains 0.

    Where the exponent is the textbook's, the coefficient of model.yaml is added: with a fitted
    exponent it is no constant that another pressure or flow may be multiplied by.
    """
    parameter = effect.parameters[name]
    own = ""
    if parameter.value and "exponent" not in effect.parameters and _at_reference(effect, name):
        own = f", i.e. {significant(parameter.value, 3)} {unit_text(parameter.unit)}"
    note = f" ({_ZERO})" if _contains_zero(parameter) else ""
    return f"{_size_text(effect, name)}{own}{note}"


def _at_reference(effect: AddedEffect, name: str) -> re.Match[str] | None:
    """Return the reference value of a coefficient that is written as its law's size there."""
    known = effect.parameters[name].unit in _AT_REFERENCE and name not in _NOT_OF_POWER
    return _OF_POWER.search(effect.law) if known else None


def _size_text(effect: AddedEffect, name: str) -> str:
    """Write a coefficient with its interval, and the reference value of its law.

    A leak or the resistance of a line is written as the flow or the pressure at the reference value
    of its law. Other coefficients have the reference value where the exponent is fitted too: with
    another exponent than the textbook's their unit applies only there.
    """
    parameter, reference = effect.parameters[name], _OF_POWER.search(effect.law)
    if reference is None or name in _NOT_OF_POWER:
        return parameter_text(parameter)
    at = f"at {reference[1]} {reference[2]}"
    if parameter.unit not in _AT_REFERENCE:
        return parameter_text(parameter, at if "exponent" in effect.parameters else "")
    unit, power = _AT_REFERENCE[parameter.unit]
    return parameter_text(_scaled(parameter, float(reference[1]) ** power, unit), at)


def parts_words(effect: AddedEffect) -> str:
    """Return the two parts of the bench where an effect is present, with its coefficients there.

    Empty where these are more or fewer.
    """
    parts = parts_present(effect)
    if len(parts) != 2:
        return ""
    sizes = [_size_text(effect, name) for name in parts]
    first, at, reference = sizes[0].partition(" at ")
    if at and sizes[1].endswith(f"{at}{reference}"):
        sizes[0] = first  # the condition is that of both
    names = [coefficient_words(name, effect.name) for name in parts]
    return listed([f"{name} {size}" for name, size in zip(names, sizes, strict=True)])


def leak_alike(effect: AddedEffect) -> bool:
    """Return whether both cylinders leak alike, as leaking valves would make them."""
    both = [effect.parameters[name] for name in ("test", "load") if name in parts_present(effect)]
    if effect.name != "internal_leakage" or len(both) < 2:
        return False
    (low, high), (other_low, other_high) = ((p.ci95 or (p.value, p.value)) for p in both)
    return max(low, other_low) <= min(high, other_high)


def alike_words(effect: AddedEffect) -> str:
    """State that both cylinders leak alike, which a common cause explains better; or nothing."""
    if not leak_alike(effect):
        return ""
    return (
        "First check the valves for leakage: both cylinders leak alike, and leaking valves may "
        "look the same in these runs."
    )


def unit_text(unit: str) -> str:
    """Write a unit with raised exponents."""
    return unit.replace("^2", "²")


def _contains_zero(parameter: FitParameter) -> bool:
    """Return whether a value within bounds may be 0 by its interval."""
    ends = parameter.ci95
    return ends is not None and not parameter.at_bound and ends[0] < 0 < ends[1]


def _scaled(parameter: FitParameter, factor: float, unit: str) -> FitParameter:
    se, ends = parameter.se, parameter.ci95
    return FitParameter(
        factor * parameter.value,
        None if se is None else factor * se,
        None if ends is None else (factor * ends[0], factor * ends[1]),
        parameter.at_bound,
        unit,
    )


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
