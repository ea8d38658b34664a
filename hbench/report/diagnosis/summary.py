"""Summary of a diagnosis for the engineer at the bench: a few short answers for each verdict.

What is missing, how large it is at the working point, what it does to force, speed and pressure,
how sure that is, and what to inspect or to repair. All numbers are those of the diagnosis.
"""

from collections.abc import Iterator

from hbench.records import (
    AddedEffect,
    Change,
    Diagnosis,
    EffectInPractice,
)
from hbench.report.diagnosis.names import in_sentence, in_words, of_strokes
from hbench.report.diagnosis.sentences import (
    doubtful_values,
    gap_change,
    predictions_words,
    refit_words,
    ruled_out_words,
    title,
    worse_words,
)
from hbench.report.diagnosis.tables.separability_tables import detectable, untried_words
from hbench.report.diagnosis.words.action import (
    advice,
    confirmation,
    further_inspections,
    inspection,
    separation,
    starting_reason,
    zero_check,
    zero_readings,
)
from hbench.report.diagnosis.words.agreement import include_words
from hbench.report.diagnosis.words.candidate import (
    absorbed_words,
    best_candidate,
    closeness,
    is_hint,
    too_small_hint,
)
from hbench.report.diagnosis.words.change import (
    READINGS,
    TEST_FRICTION,
    alternatives,
    common_error,
    friction_words,
    main_changes,
)
from hbench.report.diagnosis.words.coefficient import (
    coefficients_words,
    description_words,
    only_coefficient,
)
from hbench.report.diagnosis.words.deviation import (
    deviations,
    expected_gaps,
    expected_words,
    increased,
    largest_deviation,
    largest_gap,
    not_expected,
    poorly_simulated,
    remainder,
    sensors_words,
    significant_gaps,
    too_small_words,
    undecided_words,
    unreliable,
)
from hbench.report.diagnosis.words.error import change_of_errors, drift_words, one_sided_words
from hbench.report.diagnosis.words.law import law_summary
from hbench.report.diagnosis.words.odds import odds_clause, odds_words
from hbench.report.diagnosis.words.place import (
    AT_POINT,
    at_point_words,
    change_clauses,
    places_words,
    residual_words,
    where_words,
)
from hbench.report.diagnosis.words.unexplained import agreeing_words
from hbench.sentences import capital, listed, uncapital

Answer = tuple[str, str]  # question in a few words, and sentences

_SIZE, _SENSORS = "Size", "Several sensors"
_RESIDUALS, _FRICTION = "Residuals", "Friction"
_EVIDENCE, _ACTION, _NOT_EXPLAINED = "Evidence", "What to do", "Not explained"
_OWN_EFFECT = (
    "A cause that the catalogue does not contain can be added as an effect of your own "
    "(configs/README.md, HBENCH_EFFECTS); then reconcile again."
)
_APPROXIMATE = (
    "The laws of the catalogue are approximations: the effect with the better score may be the "
    "wrong one."
)
_MEANWHILE = (
    "Until then, model.yaml reproduces a part of this deviation by its unnamed law, within the "
    "measured range."
)
_IF_PRESENT = "The sizes that follow apply only if {name} is present."
_NO_GAIN = "So model.yaml and all gaps below are those of the model without it."
_INSPECT, _MODEL = "What to inspect", "Model"
_EXPECTED, _READINGS = "Expected deviations", "Expected readings"
_UNNAMED, _REFIT = "Unnamed law", "What the refit changes"
_CLOSEST, _SCORES, _DETECTABLE = "Closest known effect", "Scores", "What these runs can show"
_WORSE, _REMAINDER = "What gets worse", "Remaining gap"
_MOTION, _SIMULATION = "Force and motion", "Simulation"
_NEXT = "Runs that show more"
# Answers on the method, by the section of the page that they belong to.
OF_GAPS = (_WORSE, _REMAINDER, _EXPECTED, _MOTION, _SIMULATION)
OF_CANDIDATES = (_CLOSEST, _SCORES, _DETECTABLE)
OF_REFIT = (_REFIT,)
OF_DEVIATIONS = (_RESIDUALS,)
OF_NEXT = (_NEXT,)
OF_EFFECTS = (_SIZE,)  # of a single one, whose verdict has the size


def answers(diagnosis: Diagnosis) -> tuple[Answer, ...]:
    """Return the answers of the page; the working point is described once."""
    where, described, texts = where_words(diagnosis.working_point), False, dict[str, str]()
    for question, sentence in _answers(diagnosis):
        if described:
            sentence = sentence.replace(where, AT_POINT)
        described = described or where in sentence
        if sentence:
            texts[question] = " ".join(filter(None, (texts.get(question), sentence)))
    return tuple(texts.items())


def on_method(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return the answers that are not on the finding and on what to do about it."""
    named = [effect.confirmed for effect in diagnosis.effects]
    stated = named == [True] and not diagnosis.alternatives and not of_strokes(diagnosis)
    sizes = OF_EFFECTS if stated else ()
    return (*OF_GAPS, *OF_CANDIDATES, *OF_REFIT, *OF_DEVIATIONS, *sizes)


def _answers(diagnosis: Diagnosis) -> Iterator[Answer]:
    for effect in diagnosis.effects:
        own = title(effect.name) if len(diagnosis.effects) > 1 else ""
        for question, sentence in _named(diagnosis, effect):
            yield _of(own, question), sentence
    if diagnosis.effects or diagnosis.alternatives:
        yield _WORSE, worse_words(diagnosis)
    if diagnosis.alternatives:
        own = "Second deviation" if diagnosis.effects else ""
        for question, sentence in _ambiguous(diagnosis):
            yield _of(own, question), sentence
        for candidates in diagnosis.alternative_sets:
            yield _SCORES, closeness(candidates)
        yield _SCORES, _APPROXIMATE
    if diagnosis.effects:
        yield _REMAINDER, remainder(diagnosis)
        yield from _remaining(diagnosis)
    if not (diagnosis.effects or diagnosis.alternatives):
        if diagnosis.verdict == "unknown":
            yield from _unknown(diagnosis) if diagnosis.where else _insufficient(diagnosis)
        else:
            yield from _none(diagnosis)
    yield _MOTION, one_sided_words(diagnosis)
    yield _MOTION, drift_words(diagnosis)
    yield _SIMULATION, poorly_simulated(diagnosis)


def _remaining(diagnosis: Diagnosis) -> Iterator[Answer]:
    """Yield the deviations that no effect explains, and which of them a correct model has too."""
    if gaps := not_expected(diagnosis):
        model = "With the effects" if diagnosis.confirmed else "In the model of model.yaml"
        yield _NOT_EXPLAINED, f"{model}, {deviations(gaps)} over all runs."
        yield _NOT_EXPLAINED, increased(diagnosis)
        yield _NOT_EXPLAINED, law_summary(diagnosis.unnamed)
    if gaps := unreliable(diagnosis):
        names = listed([in_sentence(gap.name) for gap in gaps])
        yield _NOT_EXPLAINED, f"Do not rely on model.yaml for {names} until this is explained."
    yield _EXPECTED, expected_words(diagnosis)
    yield _EXPECTED, expected_gaps(diagnosis)


def _of(part: str, question: str) -> str:
    """Return the question about a part of the finding; of all of it without one."""
    return f"{part}: {question.lower()}" if part else question


# ---- verdicts


def _named(diagnosis: Diagnosis, effect: AddedEffect) -> Iterator[Answer]:
    practice = diagnosis.in_practice.get(effect.name)
    several = len(diagnosis.confirmed) > 1 and effect.confirmed
    if several:
        yield _SIZE, f"{capital(description_words(effect))}."
    if practice:
        yield _SIZE, _condition(effect)
        yield _SIZE, at_point_words(diagnosis.working_point, practice)
    if several or not only_coefficient(effect):
        yield _SIZE, f"Coefficients with 95 % intervals: {coefficients_words(effect)}."
    if practice:
        yield _SENSORS, common_error(practice)
    in_lead = effect.confirmed and len(diagnosis.effects) == 1 and odds_clause(effect)
    yield _EVIDENCE, "" if in_lead else odds_words(effect)
    yield _EVIDENCE, "" if effect.confirmed else _NO_GAIN
    if several:
        yield _EVIDENCE, gap_change(effect)
    yield _EVIDENCE, ruled_out_words(diagnosis)
    if len(diagnosis.effects) > 1 or not effect.confirmed:
        yield _ACTION, _what_to_do(diagnosis, effect)
    elif practice and inspection(diagnosis, practice) and not too_small_words(diagnosis, practice):
        yield _ACTION, advice(diagnosis, practice)


def _condition(effect: AddedEffect) -> str:
    """Return under which condition an effect's sizes apply; empty where it is confirmed."""
    return "" if effect.confirmed else _IF_PRESENT.format(name=in_words(effect.name))


def _what_to_do(diagnosis: Diagnosis, effect: AddedEffect) -> str:
    """Return what to inspect and repair, or how to confirm the effect first."""
    practice = diagnosis.in_practice.get(effect.name)
    then = advice(diagnosis, practice) if practice else ""
    if effect.confirmed:
        return then
    first = confirmation(diagnosis, [effect])
    then = then.replace("model.yaml contains it", "the new model.yaml contains it")
    return f"{first} If they confirm it: {uncapital(then)}" if then else first


def _ambiguous(diagnosis: Diagnosis) -> Iterator[Answer]:
    yield _SIZE, _ambiguous_sizes(diagnosis)
    yield _SIZE, undecided_words(diagnosis)
    for effect in alternatives(diagnosis):
        yield _SENSORS, common_error(effect)
    yield _SIZE if of_strokes(diagnosis) else _FRICTION, friction_words(diagnosis)
    for sentence in zero_check(diagnosis) or separation(diagnosis):
        yield _ACTION, sentence
    yield _READINGS, capital(zero_readings(diagnosis))


def _ambiguous_sizes(diagnosis: Diagnosis) -> str:
    chosen = alternatives(diagnosis)
    point = diagnosis.working_point
    if point is None:
        return ""
    parts = [
        f"{in_words(effect.name)} would mean that {listed(change_clauses(effect, changes, point))}."
        for effect in chosen
        if (changes := _only_in_size(diagnosis, effect))
    ]
    sentences = " ".join((*parts[:1], *map(capital, parts[1:])))
    return f"{where_words(point)} {sentences}" if parts else ""


def _only_in_size(diagnosis: Diagnosis, effect: EffectInPractice) -> list[Change]:
    """Return the main changes by an effect of an ambiguous set that no other answer has."""
    elsewhere = set(READINGS) if zero_readings(diagnosis) else set[str]()
    if friction_words(diagnosis) and not of_strokes(diagnosis):
        elsewhere.add(TEST_FRICTION)
    return [change for change in main_changes(effect) if change.quantity not in elsewhere]


def _unknown(diagnosis: Diagnosis) -> Iterator[Answer]:
    gaps = diagnosis.rest or diagnosis.where[:1]
    yield _INSPECT, too_small_hint(diagnosis)
    yield _INSPECT, starting_reason(diagnosis)
    for sentence in further_inspections(diagnosis):
        yield _INSPECT, sentence
    yield _INSPECT, doubtful_values(diagnosis)
    yield "Sensors", sensors_words(diagnosis, gaps)
    yield "Next runs", diagnosis.next_experiment or ""
    yield _MODEL, predictions_words(diagnosis)
    yield _MODEL, _OWN_EFFECT
    if diagnosis.unnamed:
        yield _MODEL, _MEANWHILE
    yield _UNNAMED, law_summary(diagnosis.unnamed)
    names = [gap.name for gap in gaps]
    places = places_words(diagnosis, names)
    yield _RESIDUALS, f"{capital(deviations(gaps, probable=True))}."
    if gaps[1:]:  # the verdict has the place of a single one
        yield _RESIDUALS, places
    if not places:
        yield _RESIDUALS, residual_words(diagnosis, names)
    yield _RESIDUALS, agreeing_words(diagnosis, gaps)
    yield _RESIDUALS, change_of_errors(diagnosis)
    yield _WORSE, worse_words(diagnosis)
    yield _CLOSEST, best_candidate(diagnosis)
    yield _REFIT, refit_words(diagnosis)


def _none(diagnosis: Diagnosis) -> Iterator[Answer]:
    if diagnosis.refitted and not diagnosis.refit_refused:
        yield _ACTION, _model_to_use(diagnosis)
    yield _ACTION, include_words(diagnosis)
    yield _WORSE, worse_words(diagnosis)
    yield _CLOSEST, best_candidate(diagnosis) if is_hint(diagnosis) else ""
    yield _CLOSEST, absorbed_words(diagnosis)
    yield _REFIT, refit_words(diagnosis)
    yield _DETECTABLE, detectable(diagnosis)
    if diagnosis.next_experiment:
        yield _NEXT, diagnosis.next_experiment
        yield _NEXT, untried_words(diagnosis)
    largest = largest_deviation(diagnosis.where)
    first = [largest.name] if largest else []
    names = dict.fromkeys((*first, *(gap.name for gap in diagnosis.where)))
    yield _RESIDUALS, residual_words(diagnosis, list(names))
    yield _RESIDUALS, significant_gaps(diagnosis.where)
    yield _RESIDUALS, largest_gap(diagnosis)


def _model_to_use(diagnosis: Diagnosis) -> str:
    total = diagnosis.gap_heldout.total
    if total.before <= total.floor:
        return (
            "Keep the model as given: runs outside the fit deviate from it no more than from a "
            "correct one."
        )
    if doubtful_values(diagnosis):
        return "Use model.yaml, which has the refitted values, once those to check are plausible."
    return "Use model.yaml, which has the refitted values."


def _insufficient(diagnosis: Diagnosis) -> Iterator[Answer]:
    yield _ACTION, diagnosis.next_experiment or ""
    for item in diagnosis.missing[1:]:
        yield "Also missing", f"{capital(item)}."
    yield _ACTION, "There is nothing to inspect or to repair before these are measured."
