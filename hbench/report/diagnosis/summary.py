"""Summary of a diagnosis for the engineer at the bench: one paragraph for each verdict.

What is missing, how large it is at the working point, what it does to force, speed and pressure,
how sure that is, and what to inspect or to repair. All numbers are those of the diagnosis.
"""

from collections.abc import Iterator, Sequence
from math import exp, isfinite

from hbench.records import (
    AddedEffect,
    Candidate,
    Change,
    Diagnosis,
    EffectInPractice,
    Gap,
    WorkingPoint,
)
from hbench.report.diagnosis.change_words import along_words, listed, main_changes, phrase
from hbench.report.diagnosis.names import AXES, balance, in_unit, share, shown
from hbench.report.render.numbers import number, short, significant

_MOST_ODDS = 1000.0  # larger ones are not stated: the model of the residuals is not that exact
_CLEARLY_LARGER = 1.5  # gap of a region against that of the best region of its axis
_FEW = 2  # balances, or unexplained gaps, in a sentence
_WAYS = {"extend": "extending", "retract": "retracting"}


def summary(diagnosis: Diagnosis) -> str:
    """Return the paragraph of the page."""
    return _paragraph(diagnosis, _sentences(diagnosis))


def short_summary(diagnosis: Diagnosis) -> str:
    """Return the paragraph of the terminal, which follows the verdict's sentence."""
    return _paragraph(diagnosis, _short_sentences(diagnosis))


def _paragraph(diagnosis: Diagnosis, sentences: Iterator[str]) -> str:
    """Join sentences; the working point is described once."""
    text, where = " ".join(filter(None, sentences)), _where(diagnosis.working_point)
    before, found, after = text.partition(where)
    return before + found + after.replace(where, "There")


def _sentences(diagnosis: Diagnosis) -> Iterator[str]:
    if diagnosis.effects:
        yield from _named(diagnosis)
    if diagnosis.alternatives:
        yield from _ambiguous(diagnosis)
    if diagnosis.effects or diagnosis.alternatives:
        if diagnosis.rest:
            yield f"Not explained: {_deviations(diagnosis.rest)}."
    elif diagnosis.verdict == "unknown":
        yield from _unknown(diagnosis) if diagnosis.where else _insufficient(diagnosis)
    else:
        yield from _none(diagnosis)


def _short_sentences(diagnosis: Diagnosis) -> Iterator[str]:
    practice = {effect.name: effect for effect in diagnosis.practice}
    for effect in diagnosis.effects:
        if effect.name in practice:
            yield _at_point(diagnosis.working_point, practice[effect.name], brief=True)
        yield _odds(effect)
        if effect.name in practice:
            yield _advice(practice[effect.name])
    if diagnosis.alternatives:
        yield from _ambiguous_sizes(diagnosis, brief=True)
        yield from _separation(diagnosis)
    elif not diagnosis.effects:
        if diagnosis.verdict == "unknown" and not diagnosis.where:
            yield from _insufficient(diagnosis)
        elif diagnosis.verdict == "unknown":
            yield f"Not explained: {_deviations(diagnosis.rest or diagnosis.where[:1])}."
            yield _best_candidate(diagnosis)
        else:
            yield _agreement(diagnosis)
            yield _best_candidate(diagnosis)


# ---- verdicts


def _named(diagnosis: Diagnosis) -> Iterator[str]:
    practice = {effect.name: effect for effect in diagnosis.practice}
    for effect in diagnosis.effects:
        of = (
            "an error of the measurement that"
            if effect.of_sensor
            else "an effect of the bench that"
        )
        yield f"{_title(effect.name)} is {of} the model does not contain: {effect.description}."
        if effect.name in practice:
            yield _at_point(diagnosis.working_point, practice[effect.name])
            along = along_words(practice[effect.name])
            yield f"Computed along the measured logs with and without it, it changes {along}."
        yield (
            f"With it the gap of held-out runs falls from {number(effect.gap_before, 1)} to "
            f"{number(effect.gap_after, 1)}, where 1 is the repeatability of the bench."
        )
        yield _odds(effect)
        if effect.name in practice:
            yield _advice(practice[effect.name])


def _ambiguous(diagnosis: Diagnosis) -> Iterator[str]:
    names = " or ".join(_words(candidate.name) for candidate in diagnosis.alternatives)
    also = "also " if diagnosis.effects else ""
    yield f"The model {also}does not contain {names}; these runs cannot show which it is."
    yield from _ambiguous_sizes(diagnosis)
    yield _odds_within(diagnosis.alternatives)
    yield from _separation(diagnosis)


def _ambiguous_sizes(diagnosis: Diagnosis, *, brief: bool = False) -> Iterator[str]:
    practice = {effect.name: effect for effect in diagnosis.practice}
    chosen = [practice[c.name] for c in diagnosis.alternatives if c.name in practice]
    parts = [
        f"{_words(effect.name)} would mean that {listed([_clause(c, diagnosis) for c in changes])}"
        for effect in chosen
        if (changes := main_changes(effect)[: 1 if brief else None])
    ]
    if parts:
        yield f"{_where(diagnosis.working_point)} {'; '.join(parts)}."


def _separation(diagnosis: Diagnosis) -> Iterator[str]:
    practice = {effect.name: effect for effect in diagnosis.practice}
    names = [candidate.name for candidate in diagnosis.alternatives]
    if diagnosis.next_experiment:
        yield diagnosis.next_experiment
    else:
        for effect in (practice[name] for name in names if name in practice):
            for other in effect.lookalikes:
                if other.name in names[names.index(effect.name) :]:
                    pair = f"{_words(effect.name)} and {_words(other.name)}"
                    yield f"Runs of the kind {other.kind} separate {pair}: {other.why}."
    told = diagnosis.next_experiment or ""
    inspect = [practice[name].inspect for name in names if name in practice]
    inspect = [each for each in inspect if each and each not in told]
    if inspect:
        yield f"At the bench, inspect {'; or '.join(inspect)}."


def _unknown(diagnosis: Diagnosis) -> Iterator[str]:
    gaps = diagnosis.rest or diagnosis.where[:1]
    yield (
        "The model does not contain something that no effect of the catalogue explains: "
        f"{_deviations(gaps)}."
    )
    yield _residuals(diagnosis, [gap.name for gap in gaps])
    yield _worst_region(diagnosis, gaps[0].name)
    yield _best_candidate(diagnosis)
    yield (
        "No part can be named for inspection. The shape of the residuals below shows under which "
        "conditions to look."
    )
    yield diagnosis.next_experiment or ""


def _none(diagnosis: Diagnosis) -> Iterator[str]:
    yield "Nothing is missing in the model within what these runs can show."
    yield _agreement(diagnosis)
    yield _residuals(diagnosis, [gap.name for gap in diagnosis.where])
    yield _best_candidate(diagnosis)
    yield "There is nothing to inspect or to repair."
    if diagnosis.refitted:
        yield "Use model.yaml, which has the refitted values."


def _insufficient(diagnosis: Diagnosis) -> Iterator[str]:
    yield "These runs do not suffice to find a missing effect, so its size is not known."
    if diagnosis.missing:
        yield f"Missing: {diagnosis.missing[0]}."
    yield "There is nothing to inspect or to repair before these are measured."
    yield diagnosis.next_experiment or ""


# ---- sentences


def _where(point: WorkingPoint | None) -> str:
    """Return the working point in words, as the beginning of a sentence."""
    if point is None:
        return "In these runs"
    parts = [f"{_WAYS[point.direction]} at {short(1e3 * abs(point.v_m_s))} mm/s"]
    if isfinite(point.f_applied_n):
        parts[0] += f" under {short(point.f_applied_n)} N"
    pressures = {"P_Tp": point.p_tp_pa, "P_Tr": point.p_tr_pa, "P_S": point.p_s_pa}
    parts += [f"{name} {short(p / 1e5)} bar" for name, p in pressures.items() if isfinite(p)]
    return f"At the working point of these runs ({', '.join(parts)})"


def _at_point(point: WorkingPoint | None, effect: EffectInPractice, *, brief: bool = False) -> str:
    if not effect.changes or point is None:
        return ""
    changes = main_changes(effect)
    if not changes:
        return (
            f"{_where(point)} it changes nothing: it acts only while speed or pressure changes, or "
            "at other places of the stroke."
        )
    if brief:
        changes = [change for change in changes if change.quantity not in ("pressure",)][:2]
    clauses = [phrase(change, point.direction) for change in changes]
    return f"{_where(point)} {listed(clauses)}."


def _clause(change: Change, diagnosis: Diagnosis) -> str:
    assert diagnosis.working_point is not None  # there are changes
    return phrase(change, diagnosis.working_point.direction)


def _odds(effect: AddedEffect) -> str:
    rival = effect.runner_up
    if rival is None or not isfinite(rival.margin):
        return "No other effect of the catalogue explains the held-out runs."
    return (
        f"The held-out runs favour it over the next best explanation, {_words(rival.name)}, by "
        f"{_ratio(rival.margin)}."
    )


def _odds_within(candidates: Sequence[Candidate]) -> str:
    best = candidates[0]
    others = [
        f"{_words(other.name)} by {_ratio(best.score - other.score)}" for other in candidates[1:]
    ]
    if not others:
        return ""
    return (
        f"The held-out runs favour {_words(best.name)} over {listed(others)}: too little to decide."
    )


def _ratio(nats: float) -> str:
    """Return the odds that correspond to a gain of log-likelihood."""
    odds = exp(min(max(nats, 0.0), 700.0))
    if odds > _MOST_ODDS:
        return f"odds of more than {_MOST_ODDS:.0f} to 1"
    return f"odds of {significant(odds, 2)} to 1"


def _advice(effect: EffectInPractice) -> str:
    inspect = f"Inspect {effect.inspect}." if effect.inspect else ""
    return " ".join(filter(None, (inspect, effect.repair)))


def _best_candidate(diagnosis: Diagnosis) -> str:
    if not diagnosis.ranking:
        return ""
    best = diagnosis.ranking[0]
    return (
        f"The best of {len(diagnosis.ranking)} effects, {_words(best.name)}, explains "
        f"{share(best.explained)} of the gap; its score is {number(best.score + 0.0, 1)} nats "
        f"({number(best.threshold, 1)} needed), its size {significant(best.size, 2)} times a "
        "typical one."
    )


def _agreement(diagnosis: Diagnosis) -> str:
    total = diagnosis.gap_heldout.total
    if not isfinite(total.refitted):
        return ""
    return (
        f"The gap of {len(diagnosis.heldout_runs)} held-out runs is {number(total.refitted, 2)} "
        "with the refitted model, where 1 is the repeatability of the bench and "
        f"{number(total.floor, 2)} that of a correct model with parameters as uncertain."
    )


def _deviations(gaps: Sequence[Gap]) -> str:
    """Return gaps in their units, with the limits below which they do not matter."""
    parts = []
    for gap in gaps[:_FEW]:
        size = f"{number(gap.gap, 1)} trial scatters"
        if isfinite(gap.deviation):
            size = f"{in_unit(gap, gap.deviation)} ({in_unit(gap, gap.material)} would not matter)"
        parts.append(f"{balance(gap.name).title}, {size}")
    more = f"; and {len(gaps) - _FEW} more" if len(gaps) > _FEW else ""
    return f"{'; '.join(parts)}{more}"


def _residuals(diagnosis: Diagnosis, names: Sequence[str]) -> str:
    """Return the residuals at the working point."""
    point = diagnosis.working_point
    if point is None:
        return ""
    known = [name for name in names if isfinite(point.residuals.get(name, float("nan")))]
    parts = []
    for name in known[:_FEW]:
        display = balance(name)
        value = significant(shown(point.residuals[name], display), 2)
        parts.append(f"{value} {display.unit} ({display.title})")
    return f"{_where(point)} the revised model is off by {listed(parts)}." if parts else ""


def _worst_region(diagnosis: Diagnosis, name: str) -> str:
    """Return in which regions the gap of a balance is clearly larger than elsewhere."""
    places = []
    for axis in dict.fromkeys(region.axis for region in diagnosis.regions):
        own = [
            region
            for region in diagnosis.regions
            if region.axis == axis and isfinite(region.gaps.get(name, float("nan")))
        ]
        if len(own) < 2:
            continue
        worst = max(own, key=lambda region: region.gaps[name])
        if worst.gaps[name] > _CLEARLY_LARGER * min(region.gaps[name] for region in own):
            display = AXES[axis]
            ends = [short(shown(end, display)) for end in (worst.low, worst.high)]
            places.append(
                _WAYS.get(worst.label, worst.label)
                or f"{display.title} {ends[0]} to {ends[1]} {display.unit}"
            )
    return f"It is largest at: {', '.join(places)}." if places else ""


def _title(name: str) -> str:
    words = _words(name)
    return words[:1].upper() + words[1:]


def _words(name: str) -> str:
    return name.replace("_", " ")
