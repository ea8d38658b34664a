"""Deviations that no known effect explains: their size, where they are, and what is ruled out."""

from collections.abc import Iterator, Sequence
from math import isfinite

from hbench.records import Diagnosis, Gap
from hbench.report.diagnosis.names import all_in_sentence, deviation_and_limit, in_sentence, in_unit
from hbench.report.diagnosis.words.deviation import exceeding
from hbench.report.diagnosis.words.place import rms_words, worst_places
from hbench.report.render.numbers import significant
from hbench.report.render.symbols import capital, listed

_MOST = 2  # quantities with their sizes; the table has all


def unexplained_words(diagnosis: Diagnosis, gaps: Sequence[Gap]) -> Iterator[str]:
    """Yield how far the first quantities deviate, and where the first one deviates most."""
    sizes = [_size(diagnosis, gap) for gap in gaps[:_MOST]]
    first, *second = (in_sentence(gap.name) for gap in gaps[:_MOST])
    parts = [f"{first} deviates from the model by {sizes[0]}"]
    parts += [f"{name} by {size}" for name, size in zip(second, sizes[1:], strict=True)]
    yield f"{capital(listed(parts))}; no known effect explains this."
    for gap in gaps[:1]:
        for place in worst_places(diagnosis, gap.name)[:1]:
            size = rms_words(diagnosis, gap.name, place.gap)
            which = f" of {in_sentence(gap.name)}" if len(gaps) > 1 else ""
            yield f"The deviation{which} is largest {place.words} ({size})."


def agreeing_words(diagnosis: Diagnosis, gaps: Sequence[Gap]) -> str:
    """Return which quantities agree where some deviate; empty where none does."""
    names = {gap.name for gap in gaps} | {gap.name for gap in exceeding(diagnosis.where)}
    agreeing = [gap.name for gap in diagnosis.where if gap.name not in names]
    if not agreeing:
        return ""
    verb = "agrees" if len(agreeing) == 1 else "agree"
    return f"{capital(all_in_sentence(agreeing))} {verb} within the limits that matter."


def _size(diagnosis: Diagnosis, gap: Gap) -> str:
    """Write a deviation in its unit and in per cent of the quantity's range."""
    if not isfinite(gap.deviation):
        return f"{in_unit(gap, gap.gap * gap.scatter)} RMS"
    size = f"{deviation_and_limit(gap)[0]} RMS"
    if not (gap.material > 0 and isfinite(diagnosis.material)):
        return size
    share = diagnosis.material * gap.deviation / gap.material
    return f"{size} ({significant(100 * share, 2)} % of its range)"


def narrowing_words(diagnosis: Diagnosis, name: str) -> str:
    """Return which measurement narrows the cause of a balance's residual.

    Where no place stands out, one that is missing for a better verdict.
    """
    places = worst_places(diagnosis, name)
    set_by_run = [place for place in places if place.axis != "time in the run"]
    if diagnosis.missing and not set_by_run:
        return f"To narrow the cause, measure {diagnosis.missing[0]}."
    where = "".join(f" {place.words}" for place in set_by_run[:1])
    varied = "speed and acceleration" if diagnosis.errors else "speed, load and pressure"
    kind = "runs" if diagnosis.errors else "steady runs"
    return f"To narrow the cause, measure more {kind}{where} and vary {varied} one at a time."
