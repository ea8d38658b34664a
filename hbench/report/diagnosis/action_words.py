"""What to do next in words: what to measure, and what to inspect."""

import re
from collections.abc import Iterator, Sequence

from hbench.records import (
    KINDS,
    AddedEffect,
    Candidate,
    Diagnosis,
    EffectInPractice,
    Lookalike,
)
from hbench.report.diagnosis.change_words import readings_words
from hbench.report.diagnosis.coefficient_words import parts_present
from hbench.report.diagnosis.deviation_words import beyond_balances, too_small_words
from hbench.report.diagnosis.names import (
    CHAMBERS,
    PRESSURE_SYMBOLS,
    in_sentence,
    in_words,
    parts_of,
)
from hbench.report.diagnosis.place_words import CLEARLY_LARGER, edge_gaps, worst_region
from hbench.report.render.numbers import number, significant
from hbench.report.render.symbols import capital, listed

# Words of the catalogue for the parts that an effect acts on, and these parts by coefficient.
_PARTS = {
    "each leaking cylinder": {"test": "the test cylinder", "load": "the load cylinder"},
    "that chamber": CHAMBERS,
}
_EVERY = {"each leaking cylinder": "each cylinder", "that chamber": "all chambers"}
_MOST_BALANCES = 2  # whose parts are to be inspected
_TOO_SMALL = (
    "Nothing needs to be inspected or repaired for an effect of this size; model.yaml contains it."
)
_ZEROS = (
    "There is no next.yaml, since a zero check is no run. To have hbench take the zeros in each "
    "campaign, list an experiment of the kind check first and last in the schedule, with a "
    "free load cell (configs/README.md, Zero checks)."
)


def separation(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield how the effects of an ambiguous set are separated, and what to inspect."""
    pairs = list(_separable_pairs(diagnosis))
    if diagnosis.next_experiment:
        yield diagnosis.next_experiment
    elif not pairs and not diagnosis.missing:
        yield "The catalogue contains no run that separates them."
    else:
        for effect, other in pairs:
            pair = f"{in_words(effect.name)} and {in_words(other.name)}"
            yield f"{capital(_runs(other))} separate {pair} ({other.why})."
    if not diagnosis.next_experiment and diagnosis.missing:
        yield f"Measure also {diagnosis.missing[0]}."
    experiment = diagnosis.next_experiment or ""
    every = _inspections(diagnosis, diagnosis.alternatives)
    inspect = [each for each in every if each not in experiment]
    if inspect:
        yield f"At the bench, inspect {_either(inspect)}."


def zero_check(diagnosis: Diagnosis) -> list[str]:
    """Return how a zero check separates the ambiguous set, and what to do then.

    Empty where another run separates the set, or where next.yaml is proposed.
    """
    kinds = {other.kind for _, other in _separable_pairs(diagnosis)}
    if diagnosis.next_schedule or not kinds or not all(map(_is_zero_check, kinds)):
        return []
    practice = {effect.name: effect for effect in diagnosis.practice}
    chosen = [practice[c.name] for c in diagnosis.alternatives if c.name in practice]
    inspect = [effect.inspect for effect in chosen if readings_words(effect) and effect.inspect]
    return [
        "Next step: a zero check with the supply off.",
        f"Read {listed(inspect)}.",
        "Zero the sensor that is off, or enter its offset in the bench file, and measure again.",
        _ZEROS,
    ]


def zero_readings(diagnosis: Diagnosis) -> str:
    """Return what each sensor shows in the zero check; empty where none separates the set."""
    if not zero_check(diagnosis):
        return ""
    practice = {effect.name: effect for effect in diagnosis.practice}
    chosen = [practice[c.name] for c in diagnosis.alternatives if c.name in practice]
    errors = {effect.name: readings_words(effect) for effect in chosen}
    shown = [
        f"with {in_words(name)}, {words or 'every sensor'} {'' if words else 'shows zero'}".strip()
        for name, words in errors.items()
    ]
    return (
        f"{'; '.join(shown)}. The other sensors show zero within their "
        f"tolerances{_tolerances(diagnosis)}."
    )


def _tolerances(diagnosis: Diagnosis) -> str:
    """Return the largest offsets within the tolerances of the sensors; empty without any."""
    known = diagnosis.zero_tolerances
    pressures = [known[name] for name in PRESSURE_SYMBOLS if name in known]
    parts = [f"±{significant(max(pressures), 2)} bar for pressures"] if pressures else []
    if "f_applied" in known:
        parts.append(f"±{significant(known['f_applied'], 2)} N for the load cell")
    return f" ({' and '.join(parts)})" if parts else ""


def _is_zero_check(kind: str) -> bool:
    return kind in KINDS and KINDS[kind].needs_supply_off


def _separable_pairs(diagnosis: Diagnosis) -> Iterator[tuple[EffectInPractice, Lookalike]]:
    """Yield the effects of an ambiguous set that runs of a known kind separate."""
    practice = {effect.name: effect for effect in diagnosis.practice}
    names = [candidate.name for candidate in diagnosis.alternatives]
    for effect in (practice[name] for name in names if name in practice):
        for other in effect.lookalikes:
            if other.name in names[names.index(effect.name) :]:
                yield effect, other


def _inspections(
    diagnosis: Diagnosis, effects: Sequence[AddedEffect] | Sequence[Candidate]
) -> list[str]:
    """Return what to inspect for each of some effects, as far as it is known."""
    practice = {effect.name: effect for effect in diagnosis.practice}
    known = (inspection(diagnosis, practice[e.name]) for e in effects if e.name in practice)
    return list(filter(None, known))


def inspection(diagnosis: Diagnosis, effect: EffectInPractice) -> str:
    """Return what to inspect for an effect, at the parts that it acts on by its coefficients."""
    fitted = [each for each in diagnosis.effects if each.name == effect.name]
    words = effect.inspect
    for general, parts in _PARTS.items():
        found = [parts[name] for each in fitted for name in parts_present(each) if name in parts]
        if len(found) == len(parts):
            words = words.replace(general, _EVERY[general])
        words = words.replace(general, listed(found) or general)
    return words


def advice(diagnosis: Diagnosis, effect: EffectInPractice) -> str:
    """Return what to inspect and what to do then; that neither is needed for a small effect."""
    words = inspection(diagnosis, effect)
    if too_small_words(diagnosis, effect):
        return _TOO_SMALL
    return " ".join(filter(None, (f"Inspect {words}." if words else "", effect.repair)))


def _inspect(diagnosis: Diagnosis, effects: Sequence[AddedEffect]) -> str:
    """Return the sentence on what to inspect next; empty where nothing is known."""
    practice = {effect.name: effect for effect in diagnosis.practice}
    matters = [
        each
        for each in effects
        if each.name not in practice or not too_small_words(diagnosis, practice[each.name])
    ]
    if effects and not matters:
        return _TOO_SMALL
    if parts := _first_parts(_inspections(diagnosis, matters)):
        return f"{'Inspect first' if parts[1:] else 'Next, inspect'} {', then '.join(parts)}."
    return " ".join(practice[each.name].repair for each in matters if each.name in practice)


def _first_parts(inspections: Sequence[str]) -> list[str]:
    """Return what to inspect first for each effect; the rest, and how, is in the answers."""
    return [re.split(r"[:,]", words)[0] for words in inspections]


def first_step(diagnosis: Diagnosis) -> str:
    """Return what to inspect for the confirmed effects, and how to confirm the others."""
    confirmed = [effect for effect in diagnosis.effects if effect.confirmed]
    others = [effect for effect in diagnosis.effects if not effect.confirmed]
    confirm = confirmation(diagnosis, others) if others else ""
    return " ".join(filter(None, (_inspect(diagnosis, confirmed), confirm)))


def confirmation(diagnosis: Diagnosis, effects: Sequence[AddedEffect]) -> str:
    """Return how to confirm effects that do not reduce the gap of held-out runs."""
    measure = "measure next.yaml" if diagnosis.next_schedule else "repeat the runs"
    return (
        f"To confirm {listed([in_words(effect.name) for effect in effects])}, {measure} and "
        "reconcile again; replace or adjust nothing before that."
    )


def _runs(other: Lookalike) -> str:
    """Return the runs that separate two effects, in words."""
    return f"{KINDS[other.kind].display_name} runs" if other.kind in KINDS else f"{other.kind} runs"


def _either(parts: Sequence[str]) -> str:
    """Return alternatives, as ``_joined`` does."""
    return _joined(parts, "or")


def _joined(parts: Sequence[str], word: str) -> str:
    """Join parts by a word, and by a semicolon too where some contain a comma or a colon."""
    long = any(sign in part for part in parts for sign in ",:;")
    return (f"; {word} " if long else f" {word} ").join(parts)


def next_step(diagnosis: Diagnosis) -> str:
    """Return the sentence of the verdict on what to do next; empty where nothing is missing."""
    if diagnosis.alternatives:
        if diagnosis.next_schedule:
            return "Next step: measure next.yaml; the command is below."
        if check := zero_check(diagnosis):
            return check[0]
        kinds = dict.fromkeys(_runs(other) for _, other in _separable_pairs(diagnosis))
        inspect = _either(_first_parts(_inspections(diagnosis, diagnosis.alternatives)))
        step = f"inspect {inspect}" if inspect else ""
        if kinds:  # what to inspect is in the answers
            step = f"measure {listed(list(kinds))}, which separate them"
        first = first_step(diagnosis)
        begin = f"{first} To separate the possible causes" if first else "Next"
        return f"{begin}, {step}." if step else first
    if diagnosis.effects:
        return first_step(diagnosis)
    if diagnosis.verdict == "unknown" and diagnosis.where:
        return _where_to_look(diagnosis)
    return ""


def _where_to_look(diagnosis: Diagnosis) -> str:
    """Return what to inspect, and under which conditions, where no effect explains the gaps."""
    name = (diagnosis.rest or diagnosis.where)[0].name
    inspect = parts_of(diagnosis, name)
    if not inspect:
        return ""
    words = (
        "" if beyond_balances(diagnosis) else worst_region(diagnosis, name),
        f"Next, inspect {inspect}.",
    )
    return " ".join(filter(None, words))


def other_inspections(diagnosis: Diagnosis) -> str:
    """Return what to inspect for a second balance that no effect explains; empty without any."""
    first, *others = (gap.name for gap in diagnosis.rest or diagnosis.where[:1])
    return " ".join(
        f"For {in_sentence(other)}, inspect {parts}."
        for other in others[: _MOST_BALANCES - 1]
        if (parts := parts_of(diagnosis, other)) and parts != parts_of(diagnosis, first)
    )


def first_edge(diagnosis: Diagnosis, name: str) -> str:
    """Return which metering edge of a chamber's valve is suspect; empty where neither is."""
    gaps = edge_gaps(diagnosis, name)
    if len(gaps) < 2 or not max(gaps.values()) > CLEARLY_LARGER * min(gaps.values()):
        return ""
    worst, other = sorted(gaps, key=lambda edge: -gaps[edge])
    return (
        f"Begin with the valve's edge to {worst}: over all runs the gap is "
        f"{number(gaps[worst], 1)} there and {number(gaps[other], 1)} at that to {other}."
    )
