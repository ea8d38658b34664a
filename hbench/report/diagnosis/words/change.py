"""Changes that an effect makes, in words."""

from collections.abc import Sequence

from hbench.records import Change, Diagnosis, EffectInPractice, FitParameter
from hbench.records.reconcile.diagnosis import MOTION_BALANCE
from hbench.report.diagnosis.names import (
    BALANCE_NAMES,
    CHAMBERS,
    PRESSURE_SYMBOLS,
    in_sentence,
    in_words,
    of_strokes,
    quantity,
)
from hbench.report.diagnosis.words.coefficient import parameter_text
from hbench.report.render.numbers import significant
from hbench.sentences import capital, listed

FLOWS = ("flow_tp", "flow_tr", "flow_lp", "flow_lr")
READINGS = ("p_tp", "p_tr", "p_lp", "p_lr", "p_s", "f_applied")
_GROUPS: tuple[tuple[str, ...], ...] = (
    READINGS,
    FLOWS,
    ("speed",),
    ("force_test", "force_load", MOTION_BALANCE),
    ("pressure",),
    ("supply",),
    ("kinematics",),
    ("force_band", "force_middle"),
)
_OBJECTS = {
    "speed": "the speed",
    "pressure": "the pressure",
    "force_band": "friction in both directions",
    "force_middle": "the force against extension, the same in both directions,",
}
TEST_FRICTION = "force_test"  # balance of the friction of the test cylinder
_LEAST = 0.01  # of the largest change along the logs: smaller ones at the point are none
CYLINDERS = {
    "force_test": "friction of the test cylinder",
    "force_load": "friction of the load cylinder",
    MOTION_BALANCE: "force against the motion",
}
INERTIA = "added_mass"  # the effect whose force is no friction


def alternatives(diagnosis: Diagnosis) -> list[EffectInPractice]:
    """Return what each effect of the ambiguous set changes, as far as it is known."""
    known = diagnosis.in_practice
    return [known[each.name] for each in diagnosis.alternatives if each.name in known]


def changes_of(effect: EffectInPractice) -> list[Change]:
    """Return what an effect changes.

    The supply pressure of an instrument's error is that of its reading, which is in the list.
    """
    wrong = wrong_readings(effect)
    return [change for change in effect.changes if not (wrong and change.quantity == "supply")]


def friction_words(diagnosis: Diagnosis, *, brief: bool = False) -> str:
    """Return what each effect of the ambiguous set would mean for friction of the test cylinder.

    An error of a sensor changes the friction that is computed, an effect of the bench the friction
    itself: its measured value is right then. In brief, by how much the values differ.
    """
    chosen = alternatives(diagnosis)
    if len(chosen) < 2 or diagnosis.alternative_sets[1:]:  # with two sets two are missing
        return ""
    if of_strokes(diagnosis):
        return _friction_of_strokes(chosen)
    parts, errors = [], []
    frictions = [
        next((c for c in effect.changes if c.quantity == TEST_FRICTION), None) for effect in chosen
    ]
    if not (brief or any(frictions)):
        return ""
    for effect, change in zip(chosen, frictions, strict=True):
        if change is None:
            words = "is measured correctly, and none of it is due to this effect"
        elif wrong_readings(effect):
            words = f"is computed {_size(change)} too {'high' if change.at_point > 0 else 'low'}"
        else:
            words = (
                f"is measured correctly, and the effect changes it by {interval(change)} "
                f"({significant(change.along, 2)} {change.unit} RMS over all motion)"
            )
        errors.append(change.at_point if change and wrong_readings(effect) else 0.0)
        parts.append(f"with {in_words(effect.name)} it {words}")
    differ = max(errors) - min(errors)
    if brief and differ:
        size = significant(differ, 2)
        return f"The friction of the test cylinder differs by {size} N from case to case."
    if brief:
        return "The measured friction of the test cylinder is right in each case."
    return f"Friction of the test cylinder at the working point: {'; '.join(parts)}."


def second_deviation(diagnosis: Diagnosis) -> str:
    """Return the possible causes of deviations beside named effects, with their main changes."""
    practice, before = diagnosis.in_practice, ""
    sets = []
    for candidates in diagnosis.alternative_sets:
        parts = []
        for candidate in candidates:
            effect, size = practice.get(candidate.name), ""
            for change in main_changes(effect)[-1:] if effect else ():
                changed = "" if change.quantity == before else f"{quantity(change.quantity)} "
                size, before = f" ({changed}{rounded(change, change.at_point)})", change.quantity
            parts.append(f"{in_words(candidate.name)}{size}")
        sets.append(" or ".join(parts))
    return f"A second deviation may be due to {', a third one to '.join(sets)}."


def readings_words(effect: EffectInPractice) -> str:
    """Return what each sensor of an instrument's error reads too much; empty without any."""
    return listed(
        [
            f"{PRESSURE_SYMBOLS.get(change.quantity, 'the load cell')} {interval(change)}"
            for change in effect.changes
            if change.quantity in READINGS
        ]
    )


def common_error(effect: EffectInPractice) -> str:
    """Return how to read the errors of several sensors that are one effect; empty for one sensor.

    They may have one cause where they have one sign and their intervals a value in common.
    """
    errors = [change for change in effect.changes if change.quantity in READINGS]
    ends = [change.ci95 for change in errors]
    if len(ends) < 2:
        return ""
    words = (
        f"{in_words(effect.name)} is one effect with a value for each of the {len(ends)} sensors; "
        "the values are fitted together"
    )
    known = [end for end in ends if end is not None]
    one_sign = len({change.at_point > 0 for change in errors}) == 1
    alike = known and max(low for low, _ in known) <= min(high for _, high in known)
    if one_sign and alike and len(known) == len(ends):
        words += (
            ". They are equal within their intervals, so a common cause, such as the supply or the "
            "amplifier of the sensors, is as possible as single faults"
        )
    return f"{capital(words)}."


def _friction_of_strokes(effects: Sequence[EffectInPractice]) -> str:
    """Return by how much friction differs between effects that change the mean of both directions.

    A pair of strokes shows friction as half the difference of both directions.
    """
    bands = [
        next((c.at_point for c in effect.changes if c.quantity == "force_band"), 0.0)
        for effect in effects
    ]
    differ = significant(max(bands) - min(bands), 2)
    return f"Friction differs by no more than {differ} N from case to case at the working point."


def wrong_readings(effect: EffectInPractice) -> int:
    """Count the readings that an error of the instruments changes; 0 for an effect of the bench."""
    return sum(change.quantity in READINGS for change in effect.changes)


def may_be_none(effect: EffectInPractice) -> bool:
    """Return whether the error of an instrument may be 0 (95 %) in each of its readings."""
    ends = [change.ci95 for change in effect.changes if change.quantity in READINGS]
    return bool(ends) and all(end is not None and end[0] <= 0.0 <= end[1] for end in ends)


def main_changes(effect: EffectInPractice) -> list[Change]:
    """Return the changes at the working point: the largest of each group."""
    chosen = []
    for names in _GROUPS:
        group = [change for change in changes_of(effect) if change.quantity in names]
        group = list(filter(_at_the_point, group))
        if group:
            chosen.append(max(group, key=lambda change: _rounded(change.at_point)))
    return chosen


def phrase(change: Change, direction: str, readings: int, *, brief: bool) -> str:
    """Return a change at the working point as a clause; of ``readings`` that are wrong, if any.

    In brief, without its interval.
    """
    more, name = change.at_point > 0, change.quantity
    size = rounded(change, abs(change.at_point)) if brief else _size(change)
    way = "higher" if more else "lower"
    if name in READINGS:
        symbol = PRESSURE_SYMBOLS.get(name)
        sensor = f"the transducer of {symbol}" if symbol else "the load cell"
        words = f"{sensor} shows {size} too {'much' if more else 'little'}"
        return f"{words} (the largest of {readings} errors)" if readings > 1 else words
    if readings and (name in FLOWS or name in CYLINDERS):
        return f"the computed {_thing(name)} is {size} too {'high' if more else 'low'}"
    if name in FLOWS:
        return f"{size} {'more' if more else 'less'} oil enters {CHAMBERS[name[-2:]]}"
    if name in CYLINDERS:
        return f"the {_thing(name)} is {size} {way}"
    fed = "P_Tp" if direction == "extend" else "P_Tr"
    phrases = {
        "speed": f"the piston is {size} {'faster' if more else 'slower'} at the same commands",
        "pressure": f"{fed} is {size} {way} at the same speed and load",
        "supply": f"the supply pressure is {size} {way}",
        "force_band": f"friction is {size} {way} in both directions",
        "force_middle": f"the force against extension is {size} {way} in both directions",
        "kinematics": f"the logged velocity is {size} {way}",
    }
    return phrases.get(name, f"{name} is {size} {way}")


def interval(change: Change) -> str:
    """Return a change at the working point with its interval; 0 has none."""
    if change.at_point == 0 and change.ci95 in (None, (0, 0)):
        return f"0 {change.unit}"
    text = parameter_text(FitParameter(change.at_point, None, change.ci95, None, change.unit))
    return text.removesuffix(" (not determined)")


def rounded(change: Change, value: float) -> str:
    """Write a value of a change with two digits and its unit."""
    return f"{significant(value, 2)} {change.unit}"


def _size(change: Change) -> str:
    """Return a change at the working point with its interval, without its sign."""
    value, ends = abs(change.at_point), change.ci95
    if ends is not None and change.at_point < 0:
        ends = -ends[1], -ends[0]
    text = parameter_text(FitParameter(value, None, ends, None, change.unit))
    return text.removesuffix(" (not determined)")


def _thing(name: str) -> str:
    """Return a force or a flow by its cylinder or chamber."""
    if name in CYLINDERS:
        return CYLINDERS[name]
    return f"flow to {CHAMBERS[name[-2:]]}"


def _object(change: Change, *, computed: bool, inertia: bool) -> str:
    """Return a quantity as the object of a sentence."""
    name = change.quantity
    if inertia and name in CYLINDERS:
        return f"the {_thing(name).replace('friction', 'inertial force')}"
    if name in CYLINDERS or name in FLOWS:
        return f"the {'computed ' if computed else ''}{_thing(name)}"
    if name in BALANCE_NAMES:
        return in_sentence(name)
    if name in READINGS:
        symbol = PRESSURE_SYMBOLS.get(name)
        return f"the reading of {symbol or 'the load cell'}"
    return _OBJECTS.get(name, f"the {quantity(name)}")


def largest_words(effect: EffectInPractice) -> str:
    """Return the largest changes over all measured motion, as objects of a sentence."""
    things: dict[str, list[str]] = {}  # by their common size
    for thing, change in _consequences(effect):
        things.setdefault(rounded(change, change.largest), []).append(thing)
    return listed([f"{listed(each)} by up to {size}" for size, each in things.items()])


def _at_the_point(change: Change) -> bool:
    """Return whether a quantity changes at the working point, not only elsewhere."""
    return abs(change.at_point) > _LEAST * max(change.largest, change.along)


def _along(effect: EffectInPractice) -> list[tuple[str, Change]]:
    """Return the quantity in each group that an effect changes most along the logs."""
    known, computed = [c for c in changes_of(effect) if c.largest > 0], bool(wrong_readings(effect))
    groups = (
        [c for c in known if c.quantity in names] for names in _GROUPS if "pressure" not in names
    )
    chosen = (max(group, key=lambda change: _rounded(change.along)) for group in groups if group)
    inertia = effect.name == INERTIA
    return [(_object(change, computed=computed, inertia=inertia), change) for change in chosen]


def _consequences(effect: EffectInPractice) -> list[tuple[str, Change]]:
    """Return the changes along the logs, of an instrument's error only those in computed values.

    The error itself is one of the effect's coefficients.
    """
    changes = _along(effect)
    return [each for each in changes if each[1].quantity not in READINGS] or changes


def _rounded(value: float) -> float:
    """Return a magnitude for comparison: what one chamber loses to another is equal in both."""
    return float(f"{abs(value):.2g}")
