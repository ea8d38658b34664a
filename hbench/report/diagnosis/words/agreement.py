"""Agreement of a model with the measurement, and the largest deviation that is left, in words."""

from collections.abc import Sequence
from math import isfinite

from hbench.records import Diagnosis, FitParameter, Gap
from hbench.records.reconcile.diagnosis import LEAST_SIZE, SIGNIFICANT_P, UNEXPLAINED_GAP
from hbench.report.diagnosis.names import (
    BALANCE_NAMES,
    deviation_and_limit,
    gap_number,
    in_sentence,
    in_words,
)
from hbench.report.diagnosis.words.coefficient import coefficients_words
from hbench.report.diagnosis.words.deviation import agrees, deviations, exceeding, largest_deviation
from hbench.report.diagnosis.words.place import worst_places
from hbench.report.render.numbers import number, p_equation
from hbench.sentences import capital, listed, plural


def agreement_words(diagnosis: Diagnosis) -> str:
    """State whether the model agrees with the measurement, in which quantities."""
    refitted = "with refitted values " if diagnosis.refitted and not diagnosis.refit_refused else ""
    where = ""
    if {gap.name for gap in diagnosis.where} < BALANCE_NAMES.keys():
        where = "in the quantities that these channels determine, "
    if agrees(diagnosis):
        return f"{where}{refitted}the model agrees with the measurement"
    total = diagnosis.gap_heldout.total
    if total.refitted <= total.floor:
        return (
            f"{where}{refitted}the model deviates from runs outside the fit by "
            f"{gap_number(total.refitted)} times the repeatability, no more than a correct one "
            f"({gap_number(total.floor)} on average)"
        )
    gaps = (
        f"by {gap_number(total.refitted)} times the repeatability, a correct one by "
        f"{gap_number(total.floor)} on average"
    )
    if not exceeding(diagnosis.where):
        return (
            f"{where}{refitted}the model agrees with the measurement as far as it matters (it "
            f"deviates from runs outside the fit {gaps})"
        )
    return (
        f"{where}{refitted}the model deviates from runs outside the fit {gaps}; no known effect "
        "explains the difference"
    )


def total_words(diagnosis: Diagnosis) -> str:
    """State the deviation of a model that agrees, beside that of a correct model."""
    total = diagnosis.gap_heldout.total
    if not (agrees(diagnosis) and isfinite(total.refitted)):
        return ""
    return (
        f"In runs outside the fit the model deviates by {gap_number(total.refitted)} times the "
        f"repeatability, a correct model by {gap_number(total.floor)} on average: its fitted "
        "values are uncertain, and trials differ by more at some operating points than at others."
    )


def largest_deviation_words(diagnosis: Diagnosis) -> str:
    """State the largest deviation that may matter, and why it is no missing effect.

    A significant one comes first; the table has the others.
    """
    large, nearest = exceeding(diagnosis.where), largest_deviation(diagnosis.where)
    if nearest is None:
        return ""
    if not large:
        deviation, limit = deviation_and_limit(nearest)
        return (
            "No deviation is large enough to matter; nearest to its limit is "
            f"{in_sentence(nearest.name)} with {deviation} RMS (matters above {limit})."
        )
    real = [gap for gap in large if gap.p_value < SIGNIFICANT_P]
    end = f"is not significant ({p_equation(large[0].p_value)})"
    if real:
        size = f", at {number(real[0].gap, 1)} times the repeatability,"
        end = (
            f"is significant, but{size if real[0].gap < UNEXPLAINED_GAP else ''} below the limit "
            f"for an unknown effect ({UNEXPLAINED_GAP:g} times): a small one is possible"
        )
        for place in worst_places(diagnosis, real[0].name)[:1]:
            end += f". It is largest {place.words}"
    return f"The largest deviation, {_most(real or large)}, {end}."


def small_words(diagnosis: Diagnosis) -> str:
    """State what effects that are too small to be named explain."""
    real = [gap for gap in exceeding(diagnosis.where) if gap.p_value < SIGNIFICANT_P]
    effects = [
        f"{in_words(each.name)} ({coefficients_words(each)})" for each in diagnosis.small_effects
    ]
    one = len(effects) == 1
    return (
        f"{capital(deviations(real))}. {capital(listed(effects))} "
        f"{'explains' if one else 'explain'} this; {'it is' if one else 'they are'} too "
        f"small to be named ({100 * LEAST_SIZE:.0f} % of the typical size needed), and model.yaml "
        f"does not contain {'it' if one else 'them'}."
    )


def include_words(diagnosis: Diagnosis) -> str:
    """Return the lines that add the small effects to a model file; empty without any."""
    lines = [
        f"'{effect.name}: {{{', '.join(_entry(*each) for each in effect.parameters.items())}}}'"
        for effect in diagnosis.small_effects
    ]
    if not lines:
        return ""
    effects = plural(len(lines), "that effect", "these effects")
    return f"To include {effects} too, add {listed(lines)} to its section 'effects'."


def _entry(key: str, parameter: FitParameter) -> str:
    """Write a coefficient as in a model file."""
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    return f"{key}: {parameter.value:.4g}{unit}"


def _most(gaps: Sequence[Gap]) -> str:
    """Write the first deviation with its limit as a noun."""
    deviation, limit = deviation_and_limit(gaps[0])
    return f"{deviation} RMS in {in_sentence(gaps[0].name)} (matters above {limit})"
