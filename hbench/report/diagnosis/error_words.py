"""Errors of held-out runs of a driven mass in words: of force and of open-loop position."""

from collections.abc import Sequence
from itertools import pairwise

from hbench.records import Diagnosis, HeldOutError
from hbench.report.diagnosis.names import steps_of
from hbench.report.render.numbers import significant
from hbench.report.render.symbols import listed

_EQUAL = 0.02  # of an error: a smaller change is none
_TEXTS = {"force": "force error", "position": "open-loop position error"}
_REFIT, _EFFECTS, _BOTH = ("before", "refitted"), ("refitted", "after"), ("before", "after")
_SUBJECTS = {
    _REFIT: "The refit improves",
    _EFFECTS: "The effects improve",
    _BOTH: "Compared with the model as given, the revised model improves",
}
_MEANING = {
    "force": "the simulated motion is no better, so use the model for forces, not for positions",
    "position": "errors of the force may cancel in the simulated motion",
}


def errors_in_words(diagnosis: Diagnosis) -> str:
    """Return both errors of each model; empty where no motion was compared."""
    steps = steps_of(diagnosis, of_balances=False)
    parts = [
        f"the {_TEXTS[error.quantity]} is "
        + listed([f"{significant(getattr(error, s), 3)} {error.unit} {steps[s]}" for s in steps])
        for error in diagnosis.errors
    ]
    return f"In held-out runs {'; '.join(parts)}." if parts else ""


def one_sided_words(diagnosis: Diagnosis) -> str:
    """Return each step from model to model that improves one error without the other."""
    stages = list(steps_of(diagnosis, of_balances=False))
    steps = [*pairwise(stages), *([_BOTH] if len(stages) > 2 else [])]
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
