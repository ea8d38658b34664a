"""Errors of held-out data in their units: of a driven mass, and of strokes at each load."""

from collections.abc import Sequence
from itertools import pairwise
from math import sqrt

from hbench.records import Diagnosis, HeldOutError
from hbench.report.diagnosis.names import added_words, also_words, in_sentence, models_of
from hbench.report.render.numbers import number, significant
from hbench.sentences import listed

_EQUAL = 0.02  # of an error: a smaller change is none
_TEXTS = {"force": "force error", "position": "open-loop position error"}
_REFIT, _EFFECTS, _BOTH = ("before", "refitted"), ("refitted", "after"), ("before", "after")
_SUBJECTS = {
    _REFIT: "The refit improves",
    _EFFECTS: "The effects improve",
    _BOTH: "Compared with the model as given, the revised model improves",
}
_MEANING = {
    "force": "the simulated motion is no better",
    "position": "errors of the force may cancel in the simulated motion",
}


def errors_in_words(diagnosis: Diagnosis) -> str:
    """Return both errors of each model; empty where no motion was compared."""
    models = models_of(diagnosis)
    parts = [
        f"the {_TEXTS[error.quantity]} is "
        + listed([f"{significant(getattr(error, s), 3)} {error.unit} {models[s]}" for s in models])
        for error in diagnosis.errors
    ]
    return f"In runs outside the fit {'; '.join(parts)}." if parts else ""


def change_of_errors(diagnosis: Diagnosis) -> str:
    """Return how the last step from model to model changes both errors; empty without any.

    The errors of every model are in a table.
    """
    models = list(models_of(diagnosis))
    if len(models) < 2:
        return errors_in_words(diagnosis)
    parts, verbs = [], set()
    for error in diagnosis.errors:
        before, after = (getattr(error, model) for model in models[-2:])
        start, end = significant(before, 3), significant(after, 3)
        verb = "rises" if after > before else "falls"
        change = f"stays at {end}" if start == end else f"{verb} from {start} to {end}"
        parts.append(f"the {_TEXTS[error.quantity]} {change} {error.unit}")
        verbs.add(change.split()[0])
    added = added_words(diagnosis)
    model = f"the {added}" if added else "refitted values"
    if added and len(diagnosis.confirmed) == 1 and not diagnosis.unnamed:
        model = "it"
    join = ", but " if len(verbs) > 1 else " and "
    return f"With {model}, {join.join(parts)} in runs outside the fit." if parts else ""


def use_words(diagnosis: Diagnosis) -> str:
    """Return that the final model improves the force alone, compared with the given one."""
    *_, last = models_of(diagnosis)
    improved = _better(diagnosis.errors, "before", last)
    only_force = improved == (["force"], "position")
    return "Use the model for forces, not for positions." if only_force else ""


def load_errors(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the force error of strokes over all held-out loads by the words of each model.

    Those with one more effect of an ambiguous set come last. Empty without held-out loads.
    """
    loads = diagnosis.held_out_loads
    models = models_of(diagnosis)
    errors = {title: [getattr(load, model) for load in loads] for model, title in models.items()}
    for name in loads[0].also if loads else ():
        errors[also_words(diagnosis, name)] = [load.also[name] for load in loads]
    return {
        title: f"{significant(sqrt(sum(error**2 for error in each) / len(each)), 2)} N"
        for title, each in errors.items()
        if each
    }


def scatter_words(diagnosis: Diagnosis) -> str:
    """Return at which held-out load a balance of strokes repeats best; empty without any."""
    loads = diagnosis.held_out_loads
    known = [(size, name, load) for load in loads for name, size in load.scatters.items()]
    if not known:
        return ""
    least, name, load = min(known, key=lambda each: each[0])
    return (
        f"At {number(load.load_n, 0)} N {in_sentence(name)} repeats within {significant(least, 2)} "
        "N, so that a deviation of a few newtons is a large gap there."
    )


def one_sided_words(diagnosis: Diagnosis) -> str:
    """Return each step from model to model that improves one error without the other."""
    models = list(models_of(diagnosis))
    steps = [*pairwise(models), *([_BOTH] if len(models) > 2 else [])]
    found = {step: _better(diagnosis.errors, *step) for step in steps}
    alike = found.get(_BOTH) == found.get(_REFIT)
    return " ".join(
        f"{_SUBJECTS[step]} the {better[0]} without the {other}"
        f"{', also together with the effects' if alike and step == _REFIT else ''}: "
        f"{_MEANING[better[0]]}."
        for step, (better, other) in found.items()
        if other and not (alike and step == _BOTH)
    )


def _better(errors: Sequence[HeldOutError], start: str, end: str) -> tuple[list[str], str]:
    """Return the errors that a step reduces, and the other one where it reduces one alone."""
    better: list[str] = [
        error.quantity
        for error in errors
        if getattr(error, end) < (1 - _EQUAL) * getattr(error, start)
    ]
    others: list[str] = [error.quantity for error in errors if error.quantity not in better]
    return better, others[0] if len(better) == 1 else ""


def drift_words(diagnosis: Diagnosis) -> str:
    """Return how the open-loop position error is to be read, with the travel of a run beside it."""
    if not diagnosis.errors:
        return ""
    shown = diagnosis.overlays[0]
    travel_mm = 1e3 * float(shown.measured.max() - shown.measured.min())
    return (
        "The open-loop motion starts with the first sample of a run and follows the measured drive "
        "force; nothing corrects it, so a small error of the force accumulates. For comparison, "
        f"the mass moves over {significant(travel_mm, 3)} mm in run {shown.run}."
    )
