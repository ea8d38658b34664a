"""Summary of a diagnosis for the engineer at the bench: one paragraph for each verdict.

What is missing, how large it is at the working point, what it does to force, speed and pressure,
how sure that is, and what to inspect or to repair. All numbers are those of the diagnosis.
"""

from collections.abc import Iterator

from hbench.records import (
    Diagnosis,
)
from hbench.report.diagnosis.change_words import along_words, listed, main_changes
from hbench.report.diagnosis.law_words import law_summary
from hbench.report.diagnosis.sentences import (
    advice,
    agreement,
    at_point_words,
    best_candidate,
    clause,
    closeness,
    deviations,
    odds_words,
    residual_words,
    title,
    where_words,
    words,
    worst_region,
)
from hbench.report.render.numbers import number


def summary(diagnosis: Diagnosis) -> str:
    """Return the paragraph of the page."""
    return _paragraph(diagnosis, _sentences(diagnosis))


def short_summary(diagnosis: Diagnosis) -> str:
    """Return the paragraph of the terminal, which follows the verdict's sentence."""
    return _paragraph(diagnosis, _short_sentences(diagnosis))


def _paragraph(diagnosis: Diagnosis, sentences: Iterator[str]) -> str:
    """Join sentences; the working point is described once."""
    text, where = " ".join(filter(None, sentences)), where_words(diagnosis.working_point)
    before, found, after = text.partition(where)
    return before + found + after.replace(where, "There")


def _sentences(diagnosis: Diagnosis) -> Iterator[str]:
    if diagnosis.effects:
        yield from _named(diagnosis)
    if diagnosis.alternatives:
        yield from _ambiguous(diagnosis)
    if diagnosis.effects and diagnosis.rest:
        yield f"Not explained: {deviations(diagnosis.rest)}."
        yield law_summary(diagnosis.unnamed)
    if diagnosis.effects or diagnosis.alternatives:
        return
    if diagnosis.verdict == "unknown":
        yield from _unknown(diagnosis) if diagnosis.where else _insufficient(diagnosis)
    else:
        yield from _none(diagnosis)


def _short_sentences(diagnosis: Diagnosis) -> Iterator[str]:
    practice = {effect.name: effect for effect in diagnosis.practice}
    for effect in diagnosis.effects:
        if effect.name in practice:
            yield at_point_words(diagnosis.working_point, practice[effect.name], brief=True)
        yield odds_words(effect)
        if effect.name in practice:
            yield advice(practice[effect.name])
    if diagnosis.alternatives:
        yield from _ambiguous_sizes(diagnosis, brief=True)
        yield from _separation(diagnosis)
    elif not diagnosis.effects:
        if diagnosis.verdict == "unknown" and not diagnosis.where:
            yield from _insufficient(diagnosis)
        elif diagnosis.verdict == "unknown":
            yield f"Not explained: {deviations(diagnosis.rest or diagnosis.where[:1])}."
            yield law_summary(diagnosis.unnamed)
            yield best_candidate(diagnosis)
        else:
            yield agreement(diagnosis)
            yield best_candidate(diagnosis)


# ---- verdicts


def _named(diagnosis: Diagnosis) -> Iterator[str]:
    practice = {effect.name: effect for effect in diagnosis.practice}
    for effect in diagnosis.effects:
        kind = "error of the measurement" if effect.of_sensor else "effect of the bench"
        yield (
            f"{title(effect.name)} is an {kind} that the model does not contain: "
            f"{effect.description}."
        )
        if effect.name in practice:
            yield at_point_words(diagnosis.working_point, practice[effect.name])
            if along := along_words(practice[effect.name]):
                yield f"Computed along the measured logs with and without it, it changes {along}."
        yield (
            "With it the gap of held-out runs in the balances that it touches falls from "
            f"{number(effect.gap_before, 1)} to {number(effect.gap_after, 1)}, "
            "where 1 is the repeatability of the bench."
        )
        yield odds_words(effect)
        if effect.name in practice:
            yield advice(practice[effect.name])


def _ambiguous(diagnosis: Diagnosis) -> Iterator[str]:
    names = " or ".join(words(candidate.name) for candidate in diagnosis.alternatives)
    also = "also " if diagnosis.effects else ""
    yield f"The model {also}does not contain {names}; these runs cannot show which it is."
    yield from _ambiguous_sizes(diagnosis)
    yield closeness(diagnosis.alternatives)
    yield from _separation(diagnosis)


def _ambiguous_sizes(diagnosis: Diagnosis, *, brief: bool = False) -> Iterator[str]:
    practice = {effect.name: effect for effect in diagnosis.practice}
    chosen = [practice[c.name] for c in diagnosis.alternatives if c.name in practice]
    parts = [
        f"{words(effect.name)} would mean that {listed([clause(c, diagnosis) for c in changes])}"
        for effect in chosen
        if (changes := main_changes(effect)[: 1 if brief else None])
    ]
    if parts:
        yield f"{where_words(diagnosis.working_point)} {'; '.join(parts)}."


def _separation(diagnosis: Diagnosis) -> Iterator[str]:
    practice = {effect.name: effect for effect in diagnosis.practice}
    names = [candidate.name for candidate in diagnosis.alternatives]
    if diagnosis.next_experiment:
        yield diagnosis.next_experiment
    else:
        for effect in (practice[name] for name in names if name in practice):
            for other in effect.lookalikes:
                if other.name in names[names.index(effect.name) :]:
                    pair = f"{words(effect.name)} and {words(other.name)}"
                    yield f"Runs of the kind {other.kind} separate {pair} ({other.why})."
    experiment = diagnosis.next_experiment or ""
    inspect = [practice[name].inspect for name in names if name in practice]
    inspect = [each for each in inspect if each and each not in experiment]
    if inspect:
        yield f"At the bench, inspect {'; or '.join(inspect)}."


def _unknown(diagnosis: Diagnosis) -> Iterator[str]:
    gaps = diagnosis.rest or diagnosis.where[:1]
    yield (
        "The measurement deviates from the model, and no effect of the catalogue explains how: "
        f"{deviations(gaps)}."
    )
    yield law_summary(diagnosis.unnamed)
    yield residual_words(diagnosis, [gap.name for gap in gaps])
    yield worst_region(diagnosis, gaps[0].name)
    yield agreement(diagnosis)
    yield best_candidate(diagnosis)
    yield (
        "No part can be named for inspection. The shape of the residuals below shows under which "
        "conditions to look."
    )
    yield diagnosis.next_experiment or ""


def _none(diagnosis: Diagnosis) -> Iterator[str]:
    yield "Nothing is missing in the model within what these runs can show."
    yield agreement(diagnosis)
    yield residual_words(diagnosis, [gap.name for gap in diagnosis.where])
    yield best_candidate(diagnosis)
    yield "There is nothing to inspect or to repair."
    if diagnosis.refitted:
        yield "Use model.yaml, which has the refitted values."


def _insufficient(diagnosis: Diagnosis) -> Iterator[str]:
    yield "These runs do not suffice to find a missing effect, so its size is not known."
    if diagnosis.missing:
        yield f"Missing: {diagnosis.missing[0]}."
    yield "There is nothing to inspect or to repair before these are measured."
    yield diagnosis.next_experiment or ""
