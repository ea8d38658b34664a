"""Deviations of balances and signals in words, with the limits below which they do not matter."""

from collections.abc import Sequence
from math import isfinite

from hbench.records import Diagnosis, EffectInPractice, Gap
from hbench.records.diagnosis import UNEXPLAINED_GAP
from hbench.records.summary import SIGNIFICANCE
from hbench.report.diagnosis.names import (
    balance,
    deviation_and_limit,
    gap_number,
    in_sentence,
    in_unit,
    p_equation,
    p_words,
    shown,
    steps_of,
)
from hbench.report.render.numbers import number
from hbench.report.render.symbols import listed

CLEARLY_WORSE = 1.1  # gap against another one
MOST_SIGNALS = 3  # gaps of a sentence
_FEW = 2  # balances, or unexplained gaps, in a sentence
CLEARLY_WORSE = 1.1  # gap of the revised model against that without effects
MOST_SIGNALS = 3  # gaps of a sentence that become larger


def deviations(gaps: Sequence[Gap]) -> str:
    """Return gaps in their units, with the limits below which they do not matter."""
    parts = []
    for gap in gaps[:_FEW]:
        size = f"{number(gap.gap, 1)} trial scatters"
        if isfinite(gap.material):
            size = "{} RMS (matters above {})".format(*deviation_and_limit(gap))
        elif isfinite(gap.deviation):
            size += f" ({in_unit(gap, gap.deviation)} RMS)"
        elif isfinite(gap.scatter):
            size += f" ({in_unit(gap, gap.gap * gap.scatter)})"
        parts.append(f"{in_sentence(gap.name)} deviates by {size}")
    more = f"; and {len(gaps) - _FEW} more" if len(gaps) > _FEW else ""
    return f"{'; '.join(parts)}{more}"


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


def poorly_simulated(diagnosis: Diagnosis) -> str:
    """Return which signals the simulation of the final model reproduces worst; empty for none."""
    *_, step = (step for step in steps_of(diagnosis, of_balances=False))
    gaps = {name: getattr(gap, step) for name, gap in diagnosis.gap_heldout.signals.items()}
    poor = sorted((n for n in gaps if gaps[n] > UNEXPLAINED_GAP), key=lambda n: -gaps[n])
    if not poor:
        return ""
    parts = [f"{in_sentence(name)} by {gap_number(gaps[name])}" for name in poor[:MOST_SIGNALS]]
    more = f" (the worst {MOST_SIGNALS} of {len(poor)} signals above {UNEXPLAINED_GAP:g})"
    return (
        "Simulated in closed loop with the model of model.yaml, held-out runs deviate in "
        f"{listed(parts)} trial scatters{more if len(poor) > MOST_SIGNALS else ''}. The verdict "
        "rests on the balances, which need no simulation; do not expect the simulation to "
        "reproduce these signals, or an oscillation in them, within the repeatability of the bench."
    )


def agrees(diagnosis: Diagnosis) -> bool:
    """Return whether the compared model is as close as a correct one may be.

    Its gap of held-out runs is that expected of a correct model, and no significant deviation is
    large enough to matter.
    """
    total = diagnosis.gap_heldout.total
    small = not total.refitted > CLEARLY_WORSE * total.floor
    return small and not any(gap.p_value < SIGNIFICANCE for gap in exceeding(diagnosis.where))


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
        if gap.p_value < SIGNIFICANCE and gap.deviation <= gap.material
        for deviation, limit in [deviation_and_limit(gap)]
    ]
    if len(parts) > _FEW:
        parts = [*parts[:_FEW], f"{len(parts) - _FEW} more, which the table shows"]
    return f"Significant, but too small to matter: {listed(parts)}." if parts else ""


def significance(gaps: Sequence[Gap]) -> str:
    """Return how probable such deviations are with a correct model."""
    parts = [f"{p_words(gap.p_value)} ({balance(gap.name).title})" for gap in gaps[:_FEW]]
    return f"Probability of such a deviation with a correct model, after Holm: {listed(parts)}."


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
    return (
        "In 95 % of the motion that is too small to matter "
        f"({in_sentence(nearest.quantity)}: above {limit})."
    )
