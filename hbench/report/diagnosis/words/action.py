"""What to do next in words: what to measure, and what to inspect."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from hbench.records import (
    KINDS,
    AddedEffect,
    Candidate,
    Diagnosis,
    EffectInPractice,
    Gap,
    Lookalike,
)
from hbench.report.diagnosis.names import (
    AXES,
    BORES,
    CHAMBERS,
    COMMON_PARTS,
    PRESSURE_SYMBOLS,
    all_in_sentence,
    in_sentence,
    in_words,
    parts_of,
)
from hbench.report.diagnosis.words.change import alternatives, readings_words
from hbench.report.diagnosis.words.coefficient import (
    alike_words,
    gap_words,
    leak_alike,
    parts_present,
)
from hbench.report.diagnosis.words.deviation import beyond_balances, too_small_words
from hbench.report.diagnosis.words.edge import (
    EdgePattern,
    edge_pattern,
    pattern_words,
    suspect_edge,
)
from hbench.report.diagnosis.words.place import edge_gaps, rms_words, worst_places
from hbench.report.diagnosis.words.refit import refit_increases, unexplained
from hbench.report.render.numbers import significant
from hbench.sentences import capital, listed

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
    chosen = alternatives(diagnosis)
    shown = [effect for effect in chosen if readings_words(effect)] or chosen
    inspect = [effect.inspect for effect in shown if effect.inspect]
    return [
        "Next step: a zero check with the supply off.",
        f"Read {listed(inspect)}.",
        "Zero the sensor that is off, or enter its offset in the bench file, and measure again.",
        _ZEROS,
    ]


def zero_readings(diagnosis: Diagnosis) -> str:
    """Return what each sensor shows in the zero check.

    Empty where none separates the set, and where no readings are known, as of strokes.
    """
    if not zero_check(diagnosis):
        return ""
    chosen = alternatives(diagnosis)
    errors = {effect.name: readings_words(effect) for effect in chosen}
    if not any(errors.values()):
        return ""
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
    names = [candidate.name for candidate in diagnosis.alternatives]
    for effect in alternatives(diagnosis):
        for other in effect.lookalikes:
            if other.name in names[names.index(effect.name) :]:
                yield effect, other


def _inspections(
    diagnosis: Diagnosis, effects: Sequence[AddedEffect] | Sequence[Candidate]
) -> list[str]:
    """Return what to inspect for each of some effects, as far as it is known."""
    practice = diagnosis.in_practice
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
    own = [each for each in diagnosis.effects if each.name == effect.name]
    alike = " ".join(filter(None, map(alike_words, own)))
    inspect = f"{'Then inspect' if alike else 'Inspect'} {words}." if words else ""
    parts = (alike, inspect, *map(gap_words, own), effect.repair)
    return " ".join(filter(None, parts))


def _inspect(diagnosis: Diagnosis, effects: Sequence[AddedEffect]) -> str:
    """Return the sentence on what to inspect next; empty where nothing is known."""
    practice = diagnosis.in_practice
    matters = [
        each
        for each in effects
        if each.name not in practice or not too_small_words(diagnosis, practice[each.name])
    ]
    if effects and not matters:
        return _TOO_SMALL
    if parts := _first_parts(_inspections(diagnosis, matters)):
        first = ", then ".join(parts)
        if any(map(leak_alike, matters)):
            return f"First check the valves, whose leakage may look the same; then inspect {first}."
        return f"{'Inspect first' if parts[1:] else 'Next, inspect'} {first}."
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
    """Return how to confirm effects that do not reduce the gap of runs outside the fit."""
    measure = "make the runs of next.yaml" if diagnosis.next_schedule else "repeat the runs"
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
            return "Next step: make the runs of next.yaml, with the command below."
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
        part, _ = _starting_point(diagnosis)
        return f"First inspect {part}." if part else ""
    return ""


def _starting_point(diagnosis: Diagnosis) -> tuple[str, str]:
    """Return the part to inspect first where no effect explains the gaps, and why that one.

    What several valves have in common comes first. Empty where the parts of the first balance are
    not known.
    """
    if pattern := _pattern(diagnosis):
        return pattern_words(diagnosis, pattern)
    return _start(diagnosis, unexplained(diagnosis)[0])


def starting_reason(diagnosis: Diagnosis) -> str:
    """Return why ``next_step`` has one part inspected first; empty where nothing points to it."""
    part, reason = _starting_point(diagnosis)
    return reason if part else ""


def _pattern(diagnosis: Diagnosis) -> EdgePattern | None:
    return None if beyond_balances(diagnosis) else edge_pattern(diagnosis)


def _first_part(diagnosis: Diagnosis, gap: Gap) -> str:
    return next(iter(parts_of(diagnosis, gap.name)), "")


def _start(diagnosis: Diagnosis, gap: Gap) -> tuple[str, str]:
    """Return the part of the bench to inspect first for a gap, and a sentence on why that one."""
    deviating = {each.name for each in diagnosis.rest}
    for common, signs in COMMON_PARTS.items():
        if gap.name in signs and deviating.issuperset(signs) and _deviate_so(diagnosis, signs):
            return common, f"{capital(all_in_sentence(list(signs)))} depend on it."
    part = _first_part(diagnosis, gap)
    alike = [each.name for each in unexplained(diagnosis) if _first_part(diagnosis, each) == part]
    if part and alike[1:] and not refit_increases(diagnosis).keys() & alike:
        return part, f"{capital(all_in_sentence(alike))} deviate, and {part} is common to them."
    places, quantity = worst_places(diagnosis, gap.name), in_sentence(gap.name)
    if beyond_balances(diagnosis) or not places:
        return part, ""
    largest = places[0]
    size = rms_words(diagnosis, gap.name, largest.gap)
    most = f"{capital(quantity)} deviates most {largest.words} (about {size})"
    if gap.name in BORES and largest.axis == AXES["position_m"].title:
        return BORES[gap.name], f"{most}, and a valve does not depend on the position."
    if edges := suspect_edge(diagnosis, gap.name):
        worst, other = edges
        sizes = edge_gaps(diagnosis, gap.name)
        high, low = (rms_words(diagnosis, gap.name, sizes[edge]) for edge in edges)
        return f"{part}, at its edge to {worst}", (
            f"{capital(quantity)} deviates by about {high} while the edge of {part} to {worst} "
            f"meters it, and by {low} while the edge to {other} does."
        )
    return part, f"{most}."


def _deviate_so(diagnosis: Diagnosis, signs: Mapping[str, int]) -> bool:
    """Return whether the residuals of no two balances contradict the signs of one cause."""
    residuals = diagnosis.residuals_after
    every = dict(zip(residuals.names, residuals.value.T, strict=True))
    turned = [sign * every[name] for name, sign in signs.items() if name in every]
    return all(np.nansum(one * other) >= 0 for one, other in combinations(turned, 2))


def further_inspections(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield what else to inspect for the first two balances that no effect explains."""
    if pattern := _pattern(diagnosis):
        parts = [listed(parts_of(diagnosis, name)[1:]) for name in pattern.valves]
        then = "; then ".join(parts[:_MOST_BALANCES])
        yield f"If nothing is found at the valves and their common line, inspect {then}."
        return
    first, *others = unexplained(diagnosis)[:_MOST_BALANCES]
    start, _ = _start(diagnosis, first)
    parts = [part for part in parts_of(diagnosis, first.name) if not start.startswith(part)]
    if start and parts:
        yield f"If nothing is found at {start.partition(',')[0]}, inspect {listed(parts)}."
    for gap in others:
        every = parts_of(diagnosis, gap.name)
        named = [part for part in every if part in parts or start.startswith(part)]
        if remaining := [part for part in every if part not in named]:
            yield f"For {in_sentence(gap.name)}, inspect {listed(remaining)}."
