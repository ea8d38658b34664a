"""Deviations of balances and signals in words, with the limits below which they do not matter."""

from collections.abc import Mapping, Sequence
from math import isfinite, sqrt

from hbench.records import BeforeAfter, Diagnosis, EffectInPractice, Gap
from hbench.records.reconcile.diagnosis import SIGNIFICANT_P, UNEXPLAINED_GAP
from hbench.report.diagnosis.names import (
    BALANCE_NAMES,
    added_words,
    balance,
    deviation_and_limit,
    gap_number,
    in_sentence,
    in_unit,
    models_of,
    shown,
    signal,
)
from hbench.report.render.numbers import NONE, number, p_equation, significant
from hbench.sentences import listed, plural

CLEARLY_WORSE = 1.1  # gap against another one
_MUCH_LARGER = 2.0  # gap of a simulated signal against the largest one of a balance
MOST_SIGNALS = 3  # gaps of a sentence
_MOST_GAPS = 4  # with their sizes in a sentence
_FEW = 2  # balances, or unexplained gaps, in a sentence


def deviations(gaps: Sequence[Gap], *, probable: bool = False) -> str:
    """Return gaps in their units, with the limits below which they do not matter.

    If ``probable``, each with the probability of such a deviation with a correct model.
    """
    limits = [deviation_and_limit(gap)[1] for gap in gaps[:_MOST_GAPS]]
    one_limit = len(set(limits)) == 1 < len(limits) and not probable
    parts: list[str] = []
    for gap, limit in zip(gaps, limits, strict=False):
        size = f"{number(gap.gap, 1)} times the repeatability"
        if isfinite(gap.material) and one_limit:
            each = f" (each matters above {limit})" if len(parts) == len(limits) - 1 else ""
            size = f"{deviation_and_limit(gap)[0]} RMS{each}"
        elif isfinite(gap.material):
            p = f", {p_equation(gap.p_value)}" if probable else ""
            size = f"{deviation_and_limit(gap)[0]} RMS (matters above {limit}{p})"
        elif isfinite(gap.deviation):
            size = f"{in_unit(gap, gap.deviation)} RMS{_repeats(gap)}"
        elif isfinite(gap.scatter):
            size = f"{in_unit(gap, gap.gap * gap.scatter)}{_repeats(gap)}"
        parts.append(f"{in_sentence(gap.name)}{'' if parts else ' deviates'} by {size}")
    others = [in_sentence(gap.name) for gap in gaps[_MOST_GAPS:]]
    return f"{listed(parts)}{f'; also {listed(others)}' if others else ''}"


def sensors_words(diagnosis: Diagnosis, gaps: Sequence[Gap]) -> str:
    """Return whether errors of the sensors within their tolerances may cause unexplained gaps.

    Empty where the gaps are not those of a whole bench, whose sensors have tolerances.
    """
    known = [gap for gap in gaps if gap.name in BALANCE_NAMES and isfinite(gap.allowed)]
    within = [gap for gap in known if gap.allowed >= gap.deviation]
    if not known:
        return ""
    if not within:
        return "Sensor errors within the tolerances cannot cause as much."
    if diagnosis.refit_refused:
        names = listed([in_sentence(gap.name) for gap in within])
        return (
            f"Sensor errors within the tolerances may cause as much in {names}: check these first."
        )
    return (
        "Sensor errors within the tolerances do not explain this, since the refit includes "
        "them; a sensor beyond its tolerance may."
    )


def _repeats(gap: Gap) -> str:
    return f" (repeated trials scatter by {in_unit(gap, gap.scatter)})"


def as_expected(diagnosis: Diagnosis) -> list[Gap]:
    """Return the unexplained gaps that a correct model has too; none of an unnamed law.

    Its values are as uncertain and trials differ as much, so it deviates as well.
    """
    laws = {name for law in diagnosis.unnamed for name in law.balances}
    every = (gap for gap in diagnosis.rest if gap.name not in laws)
    return [gap for gap in every if _is_expected(diagnosis, gap)]


def not_expected(diagnosis: Diagnosis) -> list[Gap]:
    """Return the unexplained gaps that are larger than those of a correct model."""
    expected = as_expected(diagnosis)
    return [gap for gap in diagnosis.rest if gap not in expected]


def unreliable(diagnosis: Diagnosis) -> list[Gap]:
    """Return the unexplained gaps that model.yaml has in held-out runs, with its unnamed laws."""
    return [gap for gap in diagnosis.rest if not _is_expected(diagnosis, gap)]


def _is_expected(diagnosis: Diagnosis, gap: Gap) -> bool:
    """Return whether a deviation is mostly that of a correct model, and the rest does not matter.

    The gaps compared are those of held-out runs.
    """
    held_out = diagnosis.gap_heldout.balances.get(gap.name)
    if held_out is None or not _beyond_expected(diagnosis, gap) <= gap.material:
        return False
    return held_out.after**2 - held_out.floor**2 <= held_out.floor**2 - 1


def _beyond_expected(diagnosis: Diagnosis, gap: Gap) -> float:
    """Return the deviation [SI] of a balance in held-out runs beyond that of a correct model."""
    held_out = diagnosis.gap_heldout.balances[gap.name]
    return sqrt(max(held_out.after**2 - held_out.floor**2, 0.0)) * gap.scatter


def expected_words(diagnosis: Diagnosis) -> str:
    """Return the unexplained gaps that a correct model has too; empty without any."""
    gaps = as_expected(diagnosis)
    if not gaps:
        return ""
    beyond = listed([in_unit(gap, _beyond_expected(diagnosis, gap)) for gap in gaps[:_FEW]])
    return (
        "The remaining deviation is mostly that of a correct model, whose values would be as "
        f"uncertain and whose trials would differ as much: {deviations(gaps)}. In runs outside the "
        f"fit {beyond} of it {plural(len(gaps), 'is', 'are')} beyond that, which is too small "
        "to matter."
    )


def expected_gaps(diagnosis: Diagnosis) -> str:
    """Return the numbers behind ``expected_words``, and what reduces such deviations."""
    gaps = [(gap, diagnosis.gap_heldout.balances[gap.name]) for gap in as_expected(diagnosis)]
    if not gaps:
        return ""
    parts = [
        f"{in_sentence(gap.name)} has a gap of {gap_number(held_out.after)}, where a correct model "
        f"with equally uncertain values would have {gap_number(held_out.floor)}"
        for gap, held_out in gaps
    ]
    return (
        f"In runs outside the fit {'; '.join(parts)}. That is no evidence of a further cause: the "
        "trials differ and the values of model.yaml are uncertain to this extent. More runs of the "
        "same kinds reduce it."
    )


def remainder(diagnosis: Diagnosis) -> str:
    """Return the gap with the effects where it is larger than that of a correct model.

    Empty where it is not, or where the gaps that are not explained are listed.
    """
    total = diagnosis.gap_heldout.total
    listed_elsewhere = diagnosis.rest or diagnosis.alternatives or not diagnosis.confirmed
    if listed_elsewhere or not total.after > CLEARLY_WORSE * total.floor:
        return ""
    none = (
        "No single quantity has a deviation that is significant, large enough to matter and more "
        f"than {UNEXPLAINED_GAP:g} times the repeatability over all runs."
    )
    if diagnosis.errors:  # of the only balance
        none = (
            f"A gap of up to {UNEXPLAINED_GAP:g} over all runs, or one that is not significant, is "
            "not reported as a further effect."
        )
    return (
        f"With the {added_words(diagnosis)}, a gap of {gap_number(total.after)} remains in runs "
        f"outside the fit, where a correct model would have {gap_number(total.floor)} on average. "
        f"{none}"
    )


def beyond_balances(diagnosis: Diagnosis) -> str:
    """Return the signal that the simulation reproduces clearly worse than the balances show.

    Empty without any.
    """
    gaps = _final_gaps(diagnosis, diagnosis.gap_heldout.signals)
    balances = _final_gaps(diagnosis, diagnosis.gap_heldout.balances).values()
    if not gaps or not balances:
        return ""
    name, largest = max(gaps, key=lambda each: gaps[each]), max(*balances, UNEXPLAINED_GAP)
    if not gaps[name] > _MUCH_LARGER * largest:
        return ""
    return (
        f"The closed-loop simulation shows more: {in_sentence(name)} deviates by "
        f"{_in_a_run(diagnosis, name) or f'{gap_number(gaps[name])} times its repeatability'}: "
        "look there for fast motion, such as chatter."
    )


def _in_a_run(diagnosis: Diagnosis, name: str) -> str:
    """Return the deviation of a simulated signal in the run that the page shows; empty for none."""
    shown_runs = [each for each in diagnosis.overlays if each.signal == name]
    if not shown_runs:
        return ""
    error = shown_runs[0].after - shown_runs[0].measured
    display = signal(name)
    size = significant(shown(sqrt(float((error**2).mean())), display), 2)
    return f"{size} {display.unit} RMS in run {shown_runs[0].run}"


def increased(diagnosis: Diagnosis) -> str:
    """Return which of the deviations that the effects do not explain the fit with them increased.

    Empty without any.
    """
    before = {gap.name: gap for gap in diagnosis.where}
    larger = [
        f"{in_sentence(gap.name)} by {in_unit(gap, before[gap.name].deviation)}"
        for gap in diagnosis.rest[:_FEW]
        if gap.name in before and gap.deviation > CLEARLY_WORSE * before[gap.name].deviation
    ]
    if not larger:
        return ""
    alone = len(diagnosis.rest) == 1
    less = f"it is {larger[0].rpartition(' by ')[2]}" if alone else f"it is less ({listed(larger)})"
    return f"Without the effects {less}: the values that are fitted together with them increase it."


def largest_gap(diagnosis: Diagnosis) -> str:
    """State the largest gap of a quantity in held-out runs beside that of a correct model."""
    gaps = diagnosis.gap_heldout.balances
    name = max(gaps, key=lambda each: gaps[each].refitted, default="")
    if len(gaps) < 2 or not gaps[name].refitted > 1:
        return ""
    largest, expected = (gap_number(gap) for gap in (gaps[name].refitted, gaps[name].floor))
    every = [gap_number(gap.gap) for gap in diagnosis.where if gap.name == name]
    rule = f" Over all runs, which decide, its gap is {every[0]}." if every else ""
    return (
        f"The largest gap of a quantity in runs outside the fit is {largest} in "
        f"{in_sentence(name)} ({expected} expected of a correct model).{rule}"
    )


def _final_gaps(diagnosis: Diagnosis, gaps: Mapping[str, BeforeAfter]) -> dict[str, float]:
    """Return the gaps of the last model that is compared."""
    *_, final = models_of(diagnosis)
    return {name: getattr(gap, final) for name, gap in gaps.items()}


def poorly_simulated(diagnosis: Diagnosis) -> str:
    """Return which signals the simulation of the final model reproduces worst; empty for none."""
    gaps = _final_gaps(diagnosis, diagnosis.gap_heldout.signals)
    poor = sorted((n for n in gaps if gaps[n] > UNEXPLAINED_GAP), key=lambda n: -gaps[n])
    if not poor:
        return ""
    parts = [f"{in_sentence(name)} by {gap_number(gaps[name])}" for name in poor[:MOST_SIGNALS]]
    more = f" (the worst {MOST_SIGNALS} of {len(poor)} signals above {UNEXPLAINED_GAP:g})"
    reading = (
        "The verdict rests on the flows and forces, which need no simulation; do not expect the "
        "simulation to reproduce these signals, or an oscillation in them, within the "
        "repeatability of the bench."
    )
    if beyond_balances(diagnosis):
        reading = (
            "That is far more than the flows and forces show, which are means over 0.16 s: either "
            "the bench moves in a way that the model does not contain, such as chatter, or the "
            "control loop of the simulation is damped differently."
        )
    return (
        "Simulated in closed loop with the model of model.yaml, runs outside the fit deviate in "
        f"{listed(parts)} times the repeatability{more if len(poor) > MOST_SIGNALS else ''}. "
        f"{reading}"
    )


def agrees(diagnosis: Diagnosis) -> bool:
    """Return whether the compared model is as close as a correct one may be.

    Its gap of held-out runs is that expected of a correct model, and no significant deviation is
    large enough to matter.
    """
    total = diagnosis.gap_heldout.total
    small = not total.refitted > CLEARLY_WORSE * total.floor
    return small and not any(gap.p_value < SIGNIFICANT_P for gap in exceeding(diagnosis.where))


def exceeding(gaps: Sequence[Gap]) -> list[Gap]:
    """Return the gaps whose deviations are large enough to matter, the worst first."""
    large = [gap for gap in gaps if gap.deviation > gap.material > 0]
    return sorted(large, key=lambda gap: -gap.deviation / gap.material)


def largest_deviation(gaps: Sequence[Gap]) -> Gap | None:
    """Return the gap whose deviation exceeds its limit most; None where no limit is known."""
    known = [gap for gap in gaps if gap.deviation >= 0 and gap.material > 0]
    return max(known, key=lambda gap: gap.deviation / gap.material, default=None)


def significant_gaps(gaps: Sequence[Gap]) -> str:
    """Return the gaps that are significant but do not matter; empty without any."""
    parts = [
        f"{in_sentence(gap.name)} by {deviation} RMS ({p_equation(gap.p_value)}, matters above "
        f"{limit})"
        for gap in gaps
        if gap.p_value < SIGNIFICANT_P and gap.deviation <= gap.material
        for deviation, limit in [deviation_and_limit(gap)]
    ]
    if len(parts) > _FEW:
        parts = [*parts[:_FEW], f"{len(parts) - _FEW} more, which the table shows"]
    return f"Significant, but too small to matter: {listed(parts)}." if parts else ""


def too_small_words(diagnosis: Diagnosis, effect: EffectInPractice) -> str:
    """State that no change by an effect is large enough to matter; empty where one may be."""
    limits = {gap.name: gap for gap in diagnosis.where if gap.material > 0}
    known = [
        (change.largest / shown(limits[change.quantity].material, balance(change.quantity)), change)
        for change in effect.changes
        if change.quantity in limits
    ]
    share_of_limit, nearest = max(known, key=lambda each: each[0], default=(1.0, None))
    if nearest is None or not share_of_limit < 1:
        return ""
    limit = in_unit(limits[nearest.quantity], limits[nearest.quantity].material)
    return f"That is too small to matter (limit for {in_sentence(nearest.quantity)}: {limit})."


def undecided_words(diagnosis: Diagnosis) -> str:
    """Return how far a balance deviates from the model while its cause is undecided."""
    name = undecided_balance(diagnosis)
    if name is None:
        return ""
    none = "neither" if len(diagnosis.alternatives) == 2 else "none"
    gap = gap_number(diagnosis.gap_heldout.balances[name].after)
    sizes = [in_unit(each, each.deviation) for each in diagnosis.where if each.name == name]
    known = [size for size in sizes if size != NONE]
    size = f"in runs outside the fit by {gap} times the repeatability of the bench"
    if known:
        size = f"by {known[0]} RMS over all runs with the refitted model"
    return (
        f"Until this is decided, model.yaml contains {none} of them, and {in_sentence(name)} "
        f"deviates {size}."
    )


def undecided_balance(diagnosis: Diagnosis) -> str | None:
    """Return the balance that most of the gap is in while its causes are undecided."""
    if not (diagnosis.confirmed and diagnosis.alternatives):
        return None
    balances = diagnosis.gap_heldout.balances
    worst = max(balances, key=lambda name: balances[name].after)
    return worst if balances[worst].after >= diagnosis.gap_heldout.total.after else None
