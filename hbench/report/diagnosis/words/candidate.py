"""Candidates of the search in words: how much they explain, and why they are not named."""

from collections.abc import Sequence

from hbench.records import Candidate, Diagnosis
from hbench.records.reconcile.diagnosis import LEAST_EXPLAINED, LEAST_SIZE, TOLERATED
from hbench.report.diagnosis.names import in_words, share
from hbench.report.render.numbers import number, significant
from hbench.sentences import capital, listed, plural


def too_small(candidate: Candidate) -> list[str]:
    """Return which of the three numbers of a candidate are too small for it to be named."""
    enough = {
        "score": candidate.score > candidate.threshold,
        "share": candidate.explained >= LEAST_EXPLAINED,
        "size": candidate.size >= LEAST_SIZE,
    }
    return [name for name, fulfilled in enough.items() if not fulfilled]


def closeness(candidates: Sequence[Candidate]) -> str:
    """Return how close the scores of an ambiguous set are."""
    explained = [f"{in_words(each.name)} {share(each.explained)}" for each in candidates]
    scores = [f"{in_words(each.name)} {number(each.score, 0)}" for each in candidates]
    return (
        "Share of the gap beyond the repeatability that each explains in cross-validation: "
        f"{', '.join(explained)}. Their scores ({', '.join(scores)} nats) are too close to decide."
    )


def best_candidate(diagnosis: Diagnosis) -> str:
    """Return how much the best candidate explains, with its score and size."""
    if not diagnosis.ranking:
        return ""
    best = diagnosis.ranking[0]
    reasons = _not_named(best)
    if not reasons and best.name in diagnosis.ruled_out:
        reasons = [f"refined with the model's values, {diagnosis.ruled_out[best.name]}"]
    why = f" It is not named: {listed(reasons)}." if reasons else ""
    needs = f" It would need {coefficients}." if (coefficients := _coefficients(best)) else ""
    enough = (
        f"; that share is large enough ({share(LEAST_EXPLAINED)} needed)"
        if best.score <= best.threshold and best.explained >= LEAST_EXPLAINED
        else ""
    )
    hint = (
        " Take it as a hint: errors of the model's laws can look like a small effect."
        if best.explained >= LEAST_EXPLAINED and diagnosis.verdict == "unknown"
        else ""
    )
    return (
        f"{capital(in_words(best.name))} is the closest of the {len(diagnosis.ranking)} effects "
        f"that were tried and would explain {share(best.explained)} of the gap in the quantities "
        f"that it changes{enough}.{needs}{why}{hint}{_too_small_ones(diagnosis)}"
    )


def absorbed_words(diagnosis: Diagnosis) -> str:
    """Return the candidates with a sufficient score that the refitted values make superfluous."""
    names = [
        f"{in_words(each.name)} (score {number(each.score, 1)} nats, {number(each.threshold, 1)} "
        f"needed; explains {share(each.explained)})"
        for each in diagnosis.ranking
        if each.score > each.threshold and each.explained < LEAST_EXPLAINED
    ]
    if not names or diagnosis.verdict != "none":
        return ""
    without = plural(len(names), "it", "them")
    return (
        f"Not excluded: {listed(names)}. The refitted model without {without}, with errors of the "
        "sensors within their tolerances, comes about as close."
    )


def _coefficients(candidate: Candidate) -> str:
    """Write which offsets of the pressures a candidate consists of; empty for other candidates."""
    sizes = [abs(value) for value in candidate.parameters.values()]
    if candidate.name != "pressure_offset" or not sizes:
        return ""
    low, high = (significant(size / 1e5, 2) for size in (min(sizes), max(sizes)))
    return (
        f"offsets of {low} to {high} bar, up to {number(candidate.size, 1)} times typical ones, "
        "which a gauge would show"
    )


def _too_small_ones(diagnosis: Diagnosis) -> str:
    """State which other candidates fail by their size alone; empty without any."""
    failing = [each for each in diagnosis.ranking[1:] if too_small(each) == ["size"]]
    return "".join(
        f" {capital(in_words(each.name))} exceeds its score ({number(each.score, 1)} nats, "
        f"{number(each.threshold, 1)} needed) and its share ({share(each.explained)}), but "
        f"{_size_words(each)}."
        for each in failing
    )


def _size_words(candidate: Candidate) -> str:
    """Return why the size of a candidate is too small."""
    if candidate.size == 0.0:
        return TOLERATED
    return (
        f"its size of {number(candidate.size, 2)} times a typical one is too small "
        f"({number(LEAST_SIZE, 2)} needed)"
    )


def _not_named(best: Candidate) -> list[str]:
    """Return the criteria of a named effect that a candidate does not meet."""
    reasons = []
    if best.score <= best.threshold:
        reasons.append(
            "it does not predict other operating points so much better that chance is ruled out "
            f"(score {number(best.score + 0.0, 1)} nats, {number(best.threshold, 1)} needed)"
        )
    if best.explained < LEAST_EXPLAINED:
        reasons.append(f"it explains too little ({share(LEAST_EXPLAINED)} needed)")
    if best.size < LEAST_SIZE:
        reasons.append(_size_words(best))
    return reasons


def is_hint(diagnosis: Diagnosis) -> bool:
    """Return whether the best candidate explains a part of the deviation, by more than chance."""
    if not diagnosis.ranking:
        return False
    best = diagnosis.ranking[0]
    return best.size > 0.0 and set(too_small(best)) <= {"size"}


def too_small_hint(diagnosis: Diagnosis) -> str:
    """State that the best candidate explains a part and is too small to be named; else empty."""
    if not (is_hint(diagnosis) and too_small(diagnosis.ranking[0])):
        return ""
    best = diagnosis.ranking[0]
    return (
        f"Too small to be named, {in_words(best.name)} would explain {share(best.explained)} of "
        "the deviation of the quantities that it changes."
    )
