"""Verdict of a diagnosis for the first paragraph of its page, and the next step.

It answers what is missing, how large it is, how sure that is and what to do; the coefficients are
in the tables.
"""

from collections.abc import Iterator, Sequence

from hbench.records import AddedEffect, Diagnosis, Gap
from hbench.records.diagnosis import UNEXPLAINED_GAP
from hbench.records.summary import SIGNIFICANCE
from hbench.report.diagnosis.action_words import next_step
from hbench.report.diagnosis.change_words import (
    friction_words,
    largest_words,
    sizes_words,
    wrong_readings,
)
from hbench.report.diagnosis.names import (
    deviation_and_limit,
    in_sentence,
    in_words,
    keys_in_words,
    of_strokes,
    p_equation,
)
from hbench.report.diagnosis.sentences import (
    coefficients_words,
    deviations,
    gap_change,
    increased,
    largest_deviation,
    odds_words,
    with_laws,
)
from hbench.report.diagnosis.separability_tables import undetectable
from hbench.report.diagnosis.text import verdict_sentence
from hbench.report.render.numbers import number
from hbench.report.render.symbols import capital


def verdict_words(diagnosis: Diagnosis) -> str:
    """Return the first paragraph of the page."""
    words = {"named": _named, "ambiguous": _ambiguous, "none": _none, "unknown": _unknown}
    return " ".join(filter(None, words[diagnosis.verdict](diagnosis)))


def _named(diagnosis: Diagnosis) -> Iterator[str]:
    for effect in diagnosis.effects:
        yield _effect(diagnosis, effect)
    if diagnosis.alternatives:
        yield (
            "A second deviation has several possible causes, which these runs cannot distinguish; "
            f"at the working point: {sizes_words(diagnosis)}."
        )
    if diagnosis.rest:
        runs = " even with the values fitted to all loads" if of_strokes(diagnosis) else ""
        yield f"Not explained: {deviations(diagnosis.rest)}{runs}."
        yield increased(diagnosis)
    yield next_step(diagnosis)


def _effect(diagnosis: Diagnosis, effect: AddedEffect) -> str:
    """State an effect, its largest changes, and what it does to held-out runs."""
    name = in_words(effect.name)
    sure = effect.confirmed
    missing = f"The model does not contain {name}"
    if effect.of_sensor:
        missing = f"The instruments {'have' if sure else 'may have'} an error, {name}"
    elif not sure:
        missing = f"{capital(name)} may be missing in the model"
    finding = f"{missing}: {effect.description} ({coefficients_words(effect)}; 95 % intervals)."
    practice = {each.name: each for each in diagnosis.practice}.get(effect.name)
    changes = largest_words(practice) if practice else ""
    verb = "changes" if sure else "would change"
    size = f"It {verb} {changes}." if changes else ""
    evidence = _improvement(diagnosis, effect) if sure else _no_improvement(diagnosis, effect)
    return " ".join(filter(None, (finding, size, evidence)))


def _improvement(diagnosis: Diagnosis, effect: AddedEffect) -> str:
    """State what an effect does to the deviation of the model, without the page's own terms."""
    runs, gaps = "in runs that were not used for the fit", diagnosis.gap_heldout.balances.values()
    if of_strokes(diagnosis):
        runs = "when each load is predicted from the other loads"
        given = [gap.before for gap in gaps if gap.refitted == effect.gap_before]
        if given and given[0] < effect.gap_before:
            runs += f" (model as given: {number(given[0], 1)})"
    return (
        "With it, the model's deviation in the quantities that it touches falls from "
        f"{number(effect.gap_before, 1)} to {number(effect.gap_after, 1)} times the repeatability "
        f"of the bench{with_laws(diagnosis)}, {runs}."
    )


def _no_improvement(diagnosis: Diagnosis, effect: AddedEffect) -> str:
    """State the odds of an effect in the runs of the fit, and that held-out runs differ."""
    return f"The evidence is contradictory. {odds_words(effect)} {gap_change(diagnosis, effect)}"


def _ambiguous(diagnosis: Diagnosis) -> Iterator[str]:
    _, _, finding = verdict_sentence(diagnosis).partition(": ")
    sensors = {each.name for each in diagnosis.practice if wrong_readings(each)}
    wrong = all(candidate.name in sensors for candidate in diagnosis.alternatives)
    what = "errors of the instruments is present" if wrong else "effects is missing in the model"
    yield f"One of these {what}: {keys_in_words(finding)}"
    yield friction_words(diagnosis, brief=True)
    yield next_step(diagnosis)


def _none(diagnosis: Diagnosis) -> Iterator[str]:
    _, _, finding = verdict_sentence(diagnosis).partition(": ")
    yield f"No missing effect is found: {keys_in_words(finding)}"
    yield _largest(diagnosis.where)
    yield undetectable(diagnosis)
    yield "Those of next.yaml would show more." if diagnosis.next_schedule else ""


def _largest(gaps: Sequence[Gap]) -> str:
    """State the deviation that exceeds its limit most, and why it is no missing effect."""
    largest = largest_deviation(gaps)
    if largest is None:
        return ""
    why = f"is not distinguishable from the trials' scatter ({p_equation(largest.p_value)})"
    if largest.deviation <= largest.material:
        why = "does not matter"
    elif largest.p_value < SIGNIFICANCE:
        why = (
            f"is {number(largest.gap, 2)} trial scatters, and only more than "
            f"{number(UNEXPLAINED_GAP, 0)} point to a missing effect"
        )
    deviation, limit = deviation_and_limit(largest)
    return (
        f"The largest deviation that remains, {in_sentence(largest.name)} by {deviation} RMS "
        f"(matters above {limit}), {why}."
    )


def _unknown(diagnosis: Diagnosis) -> Iterator[str]:
    if not diagnosis.where:
        yield "These runs do not suffice to find a missing effect."
        yield f"Missing: {diagnosis.missing[0]}." if diagnosis.missing else ""
        return
    gaps = diagnosis.rest or diagnosis.where[:1]
    yield (
        f"No known effect explains how the measurement deviates from the model: {deviations(gaps)}."
    )
    yield next_step(diagnosis)
