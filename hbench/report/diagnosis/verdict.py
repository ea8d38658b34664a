"""Verdict of a diagnosis for the first paragraph of its page, and the next step.

It answers what is missing, how large it is, how sure that is and what to do; the coefficients are
in the tables.
"""

from collections.abc import Iterator

from hbench.records import AddedEffect, Diagnosis
from hbench.report.diagnosis.names import gap_number, in_words, of_strokes
from hbench.report.diagnosis.sentences import doubtful_values, values_at_bounds
from hbench.report.diagnosis.tables.separability_tables import undetectable
from hbench.report.diagnosis.words.action import first_step, next_step
from hbench.report.diagnosis.words.agreement import (
    agreement_words,
    largest_deviation_words,
    small_words,
    total_words,
)
from hbench.report.diagnosis.words.change import (
    alternatives,
    friction_words,
    largest_words,
    main_changes,
    may_be_none,
    second_deviation,
    wrong_readings,
)
from hbench.report.diagnosis.words.coefficient import (
    coefficient_words,
    coefficients_words,
    description_words,
    of_valves,
    only_coefficient,
    parts_present,
    parts_words,
)
from hbench.report.diagnosis.words.delay import delay_words
from hbench.report.diagnosis.words.deviation import (
    CLEARLY_WORSE,
    beyond_balances,
    deviations,
    not_expected,
    too_small_words,
)
from hbench.report.diagnosis.words.error import change_of_errors, load_errors, use_words
from hbench.report.diagnosis.words.odds import favoured, least_odds, odds_clause
from hbench.report.diagnosis.words.place import change_clauses, each_size, extent_words, size_words
from hbench.report.diagnosis.words.refit import unexplained
from hbench.report.diagnosis.words.unexplained import (
    limits_words,
    narrowing_words,
    unexplained_words,
)
from hbench.sentences import capital, listed, plural, uncapital


def verdict_words(diagnosis: Diagnosis) -> str:
    """Return the first paragraph of the page."""
    of_effects = _of_strokes if of_strokes(diagnosis) else _named
    words = {"named": of_effects, "ambiguous": _ambiguous, "none": _none, "unknown": _unknown}
    return " ".join(filter(None, [*words[diagnosis.verdict](diagnosis), delay_words(diagnosis)]))


def _named(diagnosis: Diagnosis) -> Iterator[str]:
    several = len(diagnosis.confirmed) > 1
    if several:
        yield from _several(diagnosis)
    for effect in diagnosis.effects:
        if not (several and effect.confirmed):
            yield _effect(diagnosis, effect)
    if diagnosis.errors:
        yield change_of_errors(diagnosis)
        yield use_words(diagnosis)
    elif several:
        yield _together(diagnosis)
    if diagnosis.alternatives:
        yield second_deviation(diagnosis)
    if gaps := not_expected(diagnosis):
        yield f"Not explained: {deviations(gaps)}."
    yield next_step(diagnosis)


def _several(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield which confirmed effects are present, and what each changes most."""
    of_bench = [_with_parts(effect) for effect in diagnosis.confirmed if not effect.of_sensor]
    errors = [in_words(effect.name) for effect in diagnosis.confirmed if effect.of_sensor]
    number_of = plural(len(errors), "an error", "errors")
    parts = [
        *([f"the model does not contain {listed(of_bench)}"] if of_bench else []),
        *([f"the instruments have {number_of}, {listed(errors)}"] if errors else []),
    ]
    yield f"{capital('; '.join(parts))}."
    practice = diagnosis.in_practice
    known = [practice[each.name] for each in diagnosis.confirmed if each.name in practice]
    yield each_size(diagnosis, known)
    for effect in known:
        if words := too_small_words(diagnosis, effect):
            yield f"{capital(in_words(effect.name))}: {uncapital(words)}"


def _with_parts(effect: AddedEffect) -> str:
    """Return an effect's name with the parts of the bench where it is present."""
    parts = _parts(effect)
    return f"{in_words(effect.name)} ({parts})" if parts else in_words(effect.name)


def _parts(effect: AddedEffect) -> str:
    parts = parts_present(effect)
    if set(parts) == {"test", "load"}:
        return "all valves" if of_valves(effect.name) else "both cylinders"
    whole = [side for side in ("test", "load") if {f"{side}_piston", f"{side}_rod"} <= set(parts)]
    if len(whole) == 2:
        return "both cylinders"
    others = [name for name in parts if name.partition("_")[0] not in whole]
    return listed(
        [f"both sides of {side} cylinder" for side in whole]
        + [coefficient_words(name, effect.name) for name in others]
    )


def _of_strokes(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield the sentences of a named effect of steady strokes; sizes and tests are below."""
    for effect in diagnosis.effects:
        yield _finding(effect)
        yield _size(diagnosis, effect)
        yield "" if effect.confirmed else _no_improvement(diagnosis, effect)
    if diagnosis.confirmed and diagnosis.held_out_loads:
        yield _force_errors(diagnosis)
    if diagnosis.alternatives:
        yield second_deviation(diagnosis)
    yield first_step(diagnosis)


def _force_errors(diagnosis: Diagnosis) -> str:
    """State what the effects of steady strokes do to the force error, over all held-out loads.

    The model without them is the better one of the given and the refitted model.
    """
    given, refitted, after, *_ = load_errors(diagnosis).values()
    worse = sum(load.before**2 - load.refitted**2 for load in diagnosis.held_out_loads) < 0
    before = given if worse else refitted
    return (
        f"With it in the model, the force error at loads outside the fit is {after} RMS, "
        f"without it {before}."
    )


def _effect(diagnosis: Diagnosis, effect: AddedEffect) -> str:
    """State an effect, its largest changes, and what it does to held-out runs."""
    evidence = _no_improvement(diagnosis, effect)
    practice = diagnosis.in_practice.get(effect.name)
    if effect.confirmed:
        small = practice is not None and too_small_words(diagnosis, practice)
        evidence = "" if diagnosis.errors or small else _improvement(diagnosis, effect)
        if len(diagnosis.effects) == 1:
            evidence = f"{evidence} {odds_clause(effect)}".strip()
    return " ".join(filter(None, (_finding(effect), _size(diagnosis, effect), evidence)))


def _size(diagnosis: Diagnosis, effect: AddedEffect) -> str:
    """State what an effect changes at the working point, or that it is too small to matter."""
    practice = diagnosis.in_practice.get(effect.name)
    if practice is None or not largest_words(practice):
        return ""
    small = too_small_words(diagnosis, practice)
    if effect.confirmed and not small:
        return size_words(diagnosis, practice)
    verb = "changes" if effect.confirmed else "would change"
    extent = f"It {verb} {largest_words(practice)}{extent_words(diagnosis)}."
    return " ".join(filter(None, (extent, small)))


def _finding(effect: AddedEffect) -> str:
    """State that an effect is missing, with its law in words and its coefficients."""
    name, sure = in_words(effect.name), effect.confirmed
    missing = f"{capital(name)} is found, which the model does not contain"
    if effect.of_sensor:
        missing = f"The instruments {'have' if sure else 'may have'} an error, {name}"
    elif not sure:
        missing = f"{capital(name)} may be missing in the model"
    value = only_coefficient(effect)
    words = f"{value}; 95 % interval" if value else parts_words(effect) or _parts(effect)
    return f"{missing}: {description_words(effect)}{f' ({words})' if words else ''}."


def _improvement(diagnosis: Diagnosis, effect: AddedEffect) -> str:
    """State what an effect does to the deviation of the model, without the page's own terms."""
    total, alone = diagnosis.gap_heldout.total, len(diagnosis.effects) == 1
    alone = alone and not (diagnosis.unnamed or diagnosis.alternatives)
    typical = total.after <= CLEARLY_WORSE * effect.gap_after  # no other quantity dominates
    if alone and typical and total.after < total.refitted:  # the pair that the gaps' section has
        return (
            f"With it in the model, the deviation in runs outside the fit falls from "
            f"{gap_number(total.refitted)} to {gap_number(total.after)} times the repeatability."
        )
    before, after = gap_number(effect.gap_before), gap_number(effect.gap_after)
    laws = " (without the unnamed law)" if diagnosis.unnamed else ""
    return (
        "With it in the model, the deviation of the quantities that it changes falls from "
        f"{before} to {after} times the repeatability in runs outside the fit{laws}."
    )


def _together(diagnosis: Diagnosis) -> str:
    """State what several effects do to the deviation of the model in held-out runs.

    Where unnamed laws contribute, state the odds of the effects instead.
    """
    if diagnosis.unnamed:
        return least_odds(diagnosis.confirmed)
    total = diagnosis.gap_heldout.total
    effects = "both" if len(diagnosis.confirmed) == 2 else "these effects"
    falls = "falls" if total.after < total.refitted else "goes"
    return (
        f"With {effects}, the deviation in runs outside the fit {falls} from "
        f"{gap_number(total.refitted)} to {gap_number(total.after)} times the repeatability."
    )


def _no_improvement(diagnosis: Diagnosis, effect: AddedEffect) -> str:
    """State that held-out runs do not confirm an effect, and its odds in the runs of the fit.

    The odds of an effect that is too small to matter are below.
    """
    before, after = gap_number(effect.gap_before), gap_number(effect.gap_after)
    gaps = (
        f"confirm it (deviation {before} times the repeatability without it, {after} with it). So "
        "model.yaml does not contain"
    )
    practice = diagnosis.in_practice.get(effect.name)
    if practice and too_small_words(diagnosis, practice):
        return f"Runs outside the fit do not {gaps} it."
    return (
        f"The evidence is contradictory: in the runs of the fit, {favoured(effect)}, but other "
        f"runs do not {gaps} it."
    )


def _ambiguous(diagnosis: Diagnosis) -> Iterator[str]:
    sensors = {each.name for each in diagnosis.practice if wrong_readings(each)}
    sets = diagnosis.alternative_sets
    present = list[str]()
    for candidates in sets:
        wrong = all(each.name in sensors for each in candidates)
        doubtful = wrong and all(may_be_none(diagnosis.in_practice[e.name]) for e in candidates)
        verb = "may be" if doubtful else "is"
        what = (
            f"errors of the instruments {verb} present"
            if wrong
            else "effects is missing in the model"
        )
        names = listed([in_words(each.name) for each in candidates], "or")
        zero = " (each may be 0 within its 95 % intervals)" if doubtful else ""
        present.append(f"{'also, ' if present else ''}one of these {what}: {names}{zero}")
    also = [f"{in_words(each.name)} ({coefficients_words(each)})" for each in diagnosis.effects]
    apart = "the effects of a set" if sets[1:] else "them"
    yield f"{capital('. '.join(map(capital, present)))}; these data cannot distinguish {apart}."
    yield f"Added before: {'; '.join(also)}." if also else ""
    yield _cases(diagnosis)
    yield friction_words(diagnosis, brief=True)
    yield next_step(diagnosis)


def _cases(diagnosis: Diagnosis) -> str:
    """State the first change at the working point that each effect of an ambiguous set means."""
    chosen = alternatives(diagnosis)
    point = diagnosis.working_point
    if point is None or of_strokes(diagnosis):
        return ""
    parts = [
        f"{in_words(effect.name)} would mean that {clause}"
        for effect in chosen
        for clause in change_clauses(effect, main_changes(effect)[:1], point, brief=True)
    ]
    return f"At the working point, {'; '.join(parts)}." if parts else ""


def _none(diagnosis: Diagnosis) -> Iterator[str]:
    if diagnosis.errors:
        yield "No missing effect is found."
        yield change_of_errors(diagnosis)
    elif diagnosis.small_effects:
        yield "No missing effect is found that is large enough to be named."
        yield small_words(diagnosis)
    else:
        yield f"No missing effect is found: {agreement_words(diagnosis)}."
    yield beyond_balances(diagnosis)
    doubtful = doubtful_values(diagnosis)
    yield doubtful or "These runs give no reason to inspect or to repair anything."
    yield undetectable(diagnosis)
    yield "The runs of next.yaml would show more." if diagnosis.next_schedule else ""
    yield "" if diagnosis.errors else total_words(diagnosis)
    yield "" if diagnosis.small_effects else largest_deviation_words(diagnosis)


def _unknown(diagnosis: Diagnosis) -> Iterator[str]:
    if not diagnosis.where:
        yield "These runs do not suffice to find a missing effect."
        if diagnosis.left_out:
            count = len(diagnosis.left_out)
            runs = plural(count, "A run is", f"{count} runs are")
            yield f"{runs} left out: {diagnosis.left_out[0]}."
        yield f"Missing: {diagnosis.missing[0]}." if diagnosis.missing else ""
        return
    finding, *place = unexplained_words(diagnosis)
    yield finding
    yield limits_words(diagnosis)
    yield beyond_balances(diagnosis) or " ".join(filter(None, place))
    yield _model_first(diagnosis, next_step(diagnosis))
    yield (
        ""
        if diagnosis.next_experiment
        else narrowing_words(diagnosis, unexplained(diagnosis)[0].name)
    )


def _model_first(diagnosis: Diagnosis, step: str) -> str:
    """Return the next step, after a look at values of the model file that no refit reaches."""
    if not (values := values_at_bounds(diagnosis)):
        return step
    check = f"First check in the model file: {listed(values)}."
    return f"{check} Then {uncapital(step.removeprefix('First '))}" if step else check
