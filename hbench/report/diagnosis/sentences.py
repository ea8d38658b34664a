"""Sentences of a diagnosis: where, how large, how sure, and what to do."""

from math import inf, log

from hbench.records import AddedEffect, Diagnosis, FitParameter
from hbench.records.reconcile.diagnosis import TOLERATED
from hbench.report.diagnosis.names import (
    CHAMBERS,
    added_words,
    compared_model,
    gap_number,
    in_sentence,
    in_words,
    keys_in_words,
    of_strokes,
    share,
    value_words,
)
from hbench.report.diagnosis.words.coefficient import keys_as_words, parameter_text
from hbench.report.diagnosis.words.deviation import CLEARLY_WORSE, MOST_SIGNALS
from hbench.report.diagnosis.words.error import load_errors
from hbench.report.diagnosis.words.refit import refit_increases
from hbench.report.render.numbers import number
from hbench.sentences import listed

_AS_GOOD = 3.0  # nats below the named effects: odds of 20 to 1
_DEAD_VOLUMES = {
    "flow_tp": "test_cylinder.dead_volume_piston",
    "flow_tr": "test_cylinder.dead_volume_rod",
    "flow_lp": "load_cylinder.dead_volume_piston",
    "flow_lr": "load_cylinder.dead_volume_rod",
}  # values of the model file, by the balance of their chamber
_MASSES = "moving_mass."  # values of the model file that weighing gives
_CATALOGUED = ("valve.", "oil.", "supply.")  # values that data sheets state
_FRICTION = "friction."  # first guesses
_DOUBTFUL = 1.5  # assumed standard deviations
_MOST_FACTORS = 3  # refitted values in a sentence


def gap_change(effect: AddedEffect) -> str:
    """Return how an effect changes the gap of held-out runs, also where it does not reduce it."""
    before, after = gap_number(effect.gap_before), gap_number(effect.gap_after)
    where = "in the quantities that it changes"
    if effect.confirmed:
        return (
            f"It reduces the gap of runs outside the fit {where} from {before} to {after}, where 1 "
            "is the repeatability of the bench."
        )
    return (
        f"It does not reduce the gap of runs outside the fit {where}: {before} without it and "
        f"{after} with it, where 1 is the repeatability of the bench. So model.yaml does not "
        "contain it."
    )


def ruled_out_words(diagnosis: Diagnosis) -> str:
    """Return which candidates explain enough and are ruled out; empty for none.

    By other data, or beside effects as their errors of the instruments are within tolerances.
    """
    also = " too" if diagnosis.effects else ""
    scores = {each.name: each.score for each in diagnosis.ranking}
    named = min(
        (scores[each.name] for each in diagnosis.effects if each.name in scores), default=inf
    )
    sentences = []
    for each in diagnosis.ranking:
        if each.score <= each.threshold:
            continue
        would = (
            f"{title(each.name)} would explain {share(each.explained)} of the gap{also}, but is "
        )
        if each.name in diagnosis.ruled_out:
            reason = keys_as_words(diagnosis.ruled_out[each.name])
            sentences.append(f"{would}ruled out: {reason}.")
        elif each.size == 0 and each.score > named - _AS_GOOD:
            sentences.append(f"{would}not named: {TOLERATED}.")
    return " ".join(sentences)


def reason_words(diagnosis: Diagnosis) -> str:
    """Return the reason for the verdict, without the candidate that ``best_candidate`` explains."""
    return keys_in_words(diagnosis.why.partition(" The best candidate, ")[0])


def refused_words(diagnosis: Diagnosis) -> str:
    """Return why the refit without effects was refused; empty where it was not."""
    return diagnosis.refit_refused.replace("held-out runs", "runs outside the fit")


def worse_words(diagnosis: Diagnosis) -> str:
    """Return which gaps of held-out runs the model of model.yaml increases beyond repeatability.

    It is compared with the model that it was made from: an effect's with the refitted one, and the
    refitted one with the given one.
    """
    revised = added_words(diagnosis)
    if not revised and diagnosis.refit_refused:
        return ""
    if not revised:
        return _worse(diagnosis, "refitted", "before")
    base = compared_model(diagnosis)
    words = _worse(diagnosis, "after", "refitted", model="revised model", base=base)
    return " ".join(filter(None, (refit_worse_words(diagnosis), words)))


def predictions_words(diagnosis: Diagnosis) -> str:
    """Return that an unexplained model whose refit increases a gap predicts nothing; or nothing."""
    moved = refit_increases(diagnosis)
    worse = [f"{in_sentence(name)} ({gaps})" for name, gaps in moved.items()]
    if not worse:
        return ""
    return f"Do not predict with model.yaml: its refit increases the error of {listed(worse)}."


def refit_worse_words(diagnosis: Diagnosis) -> str:
    """Return which gaps of held-out strokes the refit without effects increases; empty for none.

    It is kept, since the given level of friction is a first guess that may have no influence, or
    was taken from these same strokes. In other campaigns such a refit is refused.
    """
    words = _worse(diagnosis, "refitted", "before") if of_strokes(diagnosis) else ""
    if words and diagnosis.held_out_loads:
        given, refitted, *_ = load_errors(diagnosis).values()
        words = (
            f"At loads outside the fit the force error is {given} as given, {refitted} refitted."
        )
    reason = (
        "The refit is kept, since the level of friction in the model file may have been taken from "
        "these same strokes."
    )
    return f"{words} {reason}" if words else ""


def _worse(
    diagnosis: Diagnosis,
    end: str,
    start: str,
    *,
    model: str = "refitted model",
    base: str = "model as given",
) -> str:
    """Return which gaps of held-out runs increase between two steps beyond repeatability."""
    table = diagnosis.gap_heldout
    groups = (
        ("", table.balances),
        (" in closed loop", table.signals),
        (" in open loop", table.open_loop),
    )
    parts = [
        f"{in_sentence(name)}{where} ({gap_number(before)} to {gap_number(after)})"
        for where, gaps in groups
        for name, gap in gaps.items()
        for before, after in [(getattr(gap, start), getattr(gap, end))]
        if after > max(1.0, CLEARLY_WORSE * before)
    ]
    if not parts:
        return ""
    more = len(parts) - MOST_SIGNALS
    if more > 1:
        parts = [*parts[:MOST_SIGNALS], f"{more} more, which the figures of the gaps show"]
    return f"The {model} is worse than the {base} in the gaps of {listed(parts)}."


def refit_words(diagnosis: Diagnosis) -> str:
    """Return the values of the model that the refit changes most; empty without any.

    Those count whose 95 % interval does not contain 1, in relation to their assumed accuracy.
    """
    changed = _changed_values(diagnosis)
    largest = sorted(changed, key=lambda path: -_priors_off(diagnosis, path))[:_MOST_FACTORS]
    parts = [f"{value_words(path)} {parameter_text(changed[path])}" for path in largest]
    if not parts or diagnosis.refit_refused:
        return ""
    then = "If one is implausible, correct the model file and reconcile again."
    if diagnosis.verdict == "unknown":
        then = "An implausible one may be a trace of the missing effect."
    return (
        "Values of the model that the refit changes most for their assumed accuracy, with the "
        f"factor: {'; '.join(parts)}. {then}"
    )


def doubtful_values(diagnosis: Diagnosis) -> str:
    """Return the values of the model that the refit moves far beyond their assumed accuracy.

    Empty without any. Volumes and masses are known from drawings and by weighing; of valves, oil,
    supply and friction a value counts that is at its bound. Where the commands are late, the
    valves' bandwidth does not count: both delay the flow. If such a value is right in the model
    file, the refit has changed it in place of an effect that the model does not contain.
    Where flows to chambers are unexplained, the dead volumes there are a hint from one assumed
    standard deviation; where a force is, so is a value of its friction law that is at its bound.
    """
    if diagnosis.refit_refused:
        return ""
    if diagnosis.verdict == "unknown":
        friction = _friction_at_bound(diagnosis, _with_force_gaps(diagnosis))
        hints = _bounds_hint(diagnosis), _volume_hint(diagnosis), friction
        return " ".join(filter(None, hints))
    parts = [
        f"{value_words(path)} {parameter_text(factor)}"
        for path, factor in _changed_values(diagnosis).items()
        if _is_doubtful(diagnosis, path)
    ]
    friction = _friction_at_bound(diagnosis, _FRICTION)
    if not parts:
        return friction
    checks = (
        "Check these values of the model file by drawings, data sheets or weighing. The refit "
        f"multiplies them by a factor: {'; '.join(parts)}. If the file is right, an effect is "
        "missing in the model."
    )
    return " ".join(filter(None, (checks, friction)))


def _friction_values_at_bounds(
    diagnosis: Diagnosis, sections: str | tuple[str, ...]
) -> dict[str, FitParameter]:
    """Return the factors of friction laws, in sections of the model, whose refit ends at a bound.

    They are first guesses, so that only a value counts which may be further off than its bound.
    """
    return {
        path: factor
        for path, factor in _changed_values(diagnosis).items()
        if path.startswith(sections) and factor.at_bound is not None
    }


def _with_force_gaps(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return the sections of friction of the cylinders whose forces are not explained."""
    names = {gap.name for gap in diagnosis.rest}
    return tuple(f"{_FRICTION}{each}." for each in ("test", "load") if f"force_{each}" in names)


def _friction_at_bound(diagnosis: Diagnosis, sections: str | tuple[str, ...]) -> str:
    """Return the values of friction laws, in sections of the model, whose refit ends at a bound."""
    at_bound = _friction_values_at_bounds(diagnosis, sections)
    if not at_bound:
        return ""
    parts = [f"{value_words(path)} {parameter_text(f)}" for path, f in at_bound.items()]
    soft = [path for path, factor in at_bound.items() if _is_soft(path, factor)]
    long = " Friction builds up over a longer distance than in the model." if soft else ""
    return (
        "The refit ends at the bound of the factor of these values of the model file, which may be "
        f"further off: {'; '.join(parts)}.{long} Reconcile again with the refitted model.yaml as "
        "the model."
    )


def _is_soft(path: str, factor: FitParameter) -> bool:
    return path.endswith(".bristle_stiffness") and factor.at_bound == "lower"


def _is_doubtful(diagnosis: Diagnosis, path: str) -> bool:
    if path.startswith(_MASSES) or path in _DEAD_VOLUMES.values():
        return _priors_off(diagnosis, path) > _DOUBTFUL
    return _is_beyond(diagnosis, path)


def values_at_bounds(diagnosis: Diagnosis) -> list[str]:
    """Return the values at whose bounds the refit ends, and which may explain the deviations.

    Those of valves, oil and supply, and of the friction of a cylinder whose force is not explained.
    """
    if diagnosis.refit_refused:
        return []
    friction = _friction_values_at_bounds(diagnosis, _with_force_gaps(diagnosis))
    return [*_catalogued_at_bounds(diagnosis), *map(value_words, friction)]


def _catalogued_at_bounds(diagnosis: Diagnosis) -> list[str]:
    return [value_words(path) for path in diagnosis.refitted if _is_beyond(diagnosis, path)]


def _is_beyond(diagnosis: Diagnosis, path: str) -> bool:
    """Return whether a value that data sheets state may be further off than the refit reaches."""
    if path == "valve.bandwidth" and "commands" in diagnosis.delays:
        return False
    return path.startswith(_CATALOGUED) and diagnosis.refitted[path].at_bound is not None


def _bounds_hint(diagnosis: Diagnosis) -> str:
    if not (values := _catalogued_at_bounds(diagnosis)):
        return ""
    return (
        f"The refit ends at its bound for {listed(values)}. A value of the model file that is "
        "further off causes such deviations: correct it and reconcile again."
    )


def _volume_hint(diagnosis: Diagnosis) -> str:
    paths = {gap.name: _DEAD_VOLUMES.get(gap.name, "") for gap in diagnosis.rest}
    parts = [
        f"at {CHAMBERS[balance.removeprefix('flow_')]} "
        f"{number(diagnosis.refitted[path].value, 2)} times"
        for balance, path in paths.items()
        if path in diagnosis.refitted and _priors_off(diagnosis, path) > 1
    ]
    if not parts:
        return ""
    return (
        f"A hint: the refit gives a dead volume {listed(parts)} that of the model file; compare it "
        "with the hoses, fittings and blocks there."
    )


def _changed_values(diagnosis: Diagnosis) -> dict[str, FitParameter]:
    """Return the refitted factors whose 95 % interval does not contain 1, by their paths."""
    return {
        path: factor
        for path, factor in diagnosis.refitted.items()
        if factor.ci95 is not None and not factor.ci95[0] <= 1 <= factor.ci95[1]
    }


def _priors_off(diagnosis: Diagnosis, path: str) -> float:
    """Return how many assumed standard deviations a refitted value is off the model's."""
    return abs(log(diagnosis.refitted[path].value)) / diagnosis.refit_priors[path]


def title(name: str) -> str:
    """Return an effect's name as the beginning of a sentence."""
    text = in_words(name)
    return text[:1].upper() + text[1:]
