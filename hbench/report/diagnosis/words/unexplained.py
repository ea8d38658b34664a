"""Deviations that no known effect explains: their size, where they are, and what is ruled out."""

from collections.abc import Iterator, Sequence
from math import isfinite

import numpy as np

from hbench.records import Diagnosis, Gap
from hbench.records.reconcile.diagnosis import SIGNIFICANT_P
from hbench.report.diagnosis.names import (
    EDGES,
    all_in_sentence,
    deviation_and_limit,
    gap_number,
    in_sentence,
    in_unit,
)
from hbench.report.diagnosis.words.deviation import CLEARLY_WORSE, deviations, exceeding
from hbench.report.diagnosis.words.place import rms_words, worst_places
from hbench.report.diagnosis.words.refit import refit_increases, unexplained
from hbench.report.render.numbers import p_equation, significant
from hbench.sentences import capital, listed, plural

_FAR = 2.0  # times its limit: a deviation that is clearly above it
_REST = "while at rest"  # a place where no speed is varied
_MOST = 3  # quantities with their sizes; the table has all


def unexplained_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield how far the quantities deviate, and where a single one deviates most.

    Of several, it yields those that the refit increases, which do not show where the cause is.
    """
    gaps = unexplained(diagnosis)
    shown = gaps[: _MOST if len(gaps) <= _MOST else _MOST - 1]
    more = len(gaps) - len(shown)
    also = f", as do {more} more quantities" if more else ""
    yield f"{capital(_sizes(diagnosis, shown))}{also}; no known effect explains this."
    if not any(map(_repeats, gaps)):
        yield (
            "The deviations differ between runs of the same plan, as those of a spool that sticks, "
            "of air in the oil or of a loose contact do."
        )
    if not gaps[1:]:
        for place in worst_places(diagnosis, gaps[0].name)[:1]:
            size = rms_words(diagnosis, gaps[0].name, place.gap)
            yield f"The deviation is largest {place.words} ({size})."
        return
    yield _shared_place(diagnosis, shown)
    moved = refit_increases(diagnosis)
    named = [in_sentence(gap.name) for gap in shown if gap.name in moved]
    if named and len(named) < len(gaps):
        yield (
            f"The refit itself increases the deviation of {listed(named)}, which therefore does "
            "not show where the cause is."
        )


def _shared_place(diagnosis: Diagnosis, gaps: Sequence[Gap]) -> str:
    """Return how far several quantities deviate where all of them deviate most; or nothing."""
    worst = [places[0] for gap in gaps if (places := worst_places(diagnosis, gap.name))]
    if len(worst) < len(gaps) or len({place.words for place in worst}) > 1:
        return ""
    sizes = [
        rms_words(diagnosis, gap.name, place.gap) for gap, place in zip(gaps, worst, strict=True)
    ]
    numbers, units = zip(*(size.split(" ", 1) for size in sizes), strict=True)
    if len(set(units)) == 1:
        sizes = [*numbers[:-1], sizes[-1]]
    return f"{capital(worst[0].words)} they deviate by {listed(sizes)}."


def limits_words(diagnosis: Diagnosis) -> str:
    """Return how far a few deviations are above their limits, where none is twice its limit."""
    gaps = unexplained(diagnosis)
    if len(gaps) > _MOST or not all(
        0 < gap.material < gap.deviation < _FAR * gap.material for gap in gaps
    ):
        return ""
    excess = [100 * (gap.deviation / gap.material - 1) for gap in gaps]
    limits = "limits that matter" if gaps[1:] else "limit that matters"
    percents = [f"{float(f'{percent:.1g}'):.0f}" for percent in excess]
    if max(excess) < 1:
        size = "less than 1 %"
    elif min(excess) < 1:
        size = f"at most about {percents[int(np.argmax(excess))]} %"
    else:
        size = f"only about {listed(percents)} %"
    return f"That is {size} above the {limits}."


def agreeing_words(diagnosis: Diagnosis, gaps: Sequence[Gap]) -> str:
    """Return what is known of the other quantities where some deviate; empty without others."""
    large = [gap for gap in exceeding(diagnosis.where) if gap.name not in {g.name for g in gaps}]
    deviating = {gap.name for gap in (*gaps, *large)}
    below = [gap for gap in diagnosis.where if gap.name not in deviating]
    noise = [gap.name for gap in below if not gap.deviation > 0]
    significantly = [gap for gap in below if _below_limit(gap)]
    agreeing = [gap.name for gap in below if gap.name not in noise and gap not in significantly]
    by_chance = [gap for gap in large if not gap.p_value < SIGNIFICANT_P]
    sentences = []
    if by_chance:
        sentences.append(f"{capital(deviations(by_chance, probable=True))}; this may be chance.")
    sentences += [_below_limit_words(diagnosis, gap) for gap in significantly]
    if agreeing:
        verb = plural(len(agreeing), "agrees", "agree")
        sentences.append(
            f"{capital(all_in_sentence(agreeing))} {verb} within the limits that matter."
        )
    if noise:
        names = listed([in_sentence(name) for name in noise])
        sentences.append(f"No deviation of {names} is distinguishable from noise.")
    return " ".join(sentences)


def _below_limit(gap: Gap) -> bool:
    """Return whether a deviation is significant and does not exceed its limit."""
    return 0 < gap.deviation <= gap.material and gap.p_value < SIGNIFICANT_P


def _below_limit_words(diagnosis: Diagnosis, gap: Gap) -> str:
    """State a significant deviation below its limit, with its gap in held-out runs."""
    deviation, limit = deviation_and_limit(gap)
    where = "just below" if gap.material < CLEARLY_WORSE * gap.deviation else "below"
    words = (
        f"{capital(in_sentence(gap.name))} deviates significantly, but {where} its limit: by "
        f"{deviation} RMS (matters above {limit}, {p_equation(gap.p_value)})"
    )
    held_out = diagnosis.gap_heldout.balances.get(gap.name)
    if held_out is None or not held_out.refitted > CLEARLY_WORSE * held_out.floor:
        return f"{words}."
    return (
        f"{words}. In runs outside the fit its gap is "
        f"{gap_number(held_out.refitted)}; a correct model has {gap_number(held_out.floor)}."
    )


def _sizes(diagnosis: Diagnosis, gaps: Sequence[Gap]) -> str:
    """Write how far each quantity deviates; flows in common words."""
    sizes = [_size(diagnosis, gap, len(gaps) < 2) for gap in gaps]
    names = [gap.name for gap in gaps]
    if gaps[1:] and all(name in EDGES for name in names):
        numbers, units = zip(*(size.split(" ", 1) for size in sizes), strict=True)
        if len(set(units)) == 1:
            amounts = f"{listed(numbers)} {units[0]}"
            return f"{all_in_sentence(names)} deviate from the model by {amounts}"
    parts = [f"{in_sentence(name)} by {size}" for name, size in zip(names, sizes, strict=True)]
    parts[0] = parts[0].replace(" by ", " deviates from the model by ", 1)
    return listed(parts)


def _size(diagnosis: Diagnosis, gap: Gap, alone: bool) -> str:
    """Write a deviation in its unit and, if it is ``alone``, in per cent of its range."""
    if not isfinite(gap.deviation):
        return f"{in_unit(gap, gap.gap * gap.scatter)} RMS"
    size = f"{deviation_and_limit(gap)[0]} RMS"
    if not (alone and gap.material > 0 and isfinite(diagnosis.material)):
        return size
    share = diagnosis.material * gap.deviation / gap.material
    return f"{size} ({significant(100 * share, 2)} % of its range)"


def _repeats(gap: Gap) -> bool:
    """Return whether the trials of an operating point have a deviation in common."""
    return not gap.p_value >= SIGNIFICANT_P


def narrowing_words(diagnosis: Diagnosis, name: str) -> str:
    """Return which measurement narrows the cause of a balance's residual.

    Where no place stands out, one that is missing for a better verdict.
    """
    places = worst_places(diagnosis, name)
    if not all(_repeats(gap) for gap in diagnosis.rest if gap.name == name):
        return ""
    set_by_run = [place for place in places if place.axis != "time in the run"]
    if diagnosis.missing and not set_by_run:
        return f"To narrow the cause, measure {diagnosis.missing[0]}."
    if set_by_run and set_by_run[0].words == _REST:
        return "To narrow the cause, measure longer holds at rest, at several loads and pressures."
    where = "".join(f" {place.words}" for place in set_by_run[:1])
    varied = "speed and acceleration" if diagnosis.errors else "speed, load and pressure"
    kind = "runs" if diagnosis.errors else "steady runs"
    return f"To narrow the cause, measure more {kind}{where} and vary {varied} one at a time."
