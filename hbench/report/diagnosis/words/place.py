"""Places of a diagnosis in words: the working point, and where a gap is largest."""

from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple

from hbench.records import DIRECTION_WORDS, Change, Diagnosis, EffectInPractice, WorkingPoint
from hbench.report.diagnosis.names import (
    AXES,
    EDGES,
    added_words,
    balance,
    compared_model,
    in_sentence,
    in_unit,
    in_words,
    of_strokes,
    residual_name,
    shown,
)
from hbench.report.diagnosis.words.change import (
    largest_words,
    main_changes,
    phrase,
    rounded,
    wrong_readings,
)
from hbench.report.render.numbers import short, significant
from hbench.sentences import capital, listed, plural

CLEARLY_LARGER = 1.5  # gap of a region against that of the best region of its axis
_FEW = 2  # balances, places or changes in a sentence
_ELSEWHERE = {  # where an effect acts that changes nothing in steady motion at the working point
    "position_friction": "at other places of the stroke.",
    "end_cushion": "at other places of the stroke.",
    "oil_warming": "later in the campaign, as the oil warms.",
}
AT_POINT = "At the working point,"  # which is described elsewhere
_OF_CHANGES = "only while speed or pressure changes."
_WAYS = {**DIRECTION_WORDS, "rest": "at rest"}


def where_words(point: WorkingPoint | None) -> str:
    """Return the working point, medians of the campaign, as the beginning of a sentence."""
    if point is None:
        return "In these runs,"
    motion = _motion(point)
    if isfinite(point.f_applied_n):
        motion += f", load cell {short(point.f_applied_n)} N"
    pressures = {
        "piston side P_Tp": point.p_tp_pa,
        "rod side P_Tr": point.p_tr_pa,
        "supply P_S": point.p_s_pa,
    }
    parts = [f"{name} {short(p / 1e5)} bar" for name, p in pressures.items() if isfinite(p)]
    return f"At the median working point ({', '.join((motion, *parts))}),"


def _motion(point: WorkingPoint) -> str:
    return f"{_WAYS[point.direction]} at {short(1e3 * abs(point.v_m_s))} mm/s"


def at_point_words(point: WorkingPoint | None, effect: EffectInPractice) -> str:
    """Return what an effect changes at the working point."""
    if not effect.changes or point is None:
        return ""
    changes = main_changes(effect)
    if not changes:
        where = _ELSEWHERE.get(effect.name, _OF_CHANGES)
        return f"{where_words(point)} it changes nothing: it acts {where}"
    clauses = change_clauses(effect, changes, point)
    return f"{where_words(point)} {listed(clauses)}."


def size_words(diagnosis: Diagnosis, effect: EffectInPractice) -> str:
    """Return the first changes by an effect at the working point, and how large they become.

    The intervals are in the answers and the tables.
    """
    point, changes = diagnosis.working_point, _first_changes(diagnosis, effect)
    if point is None or not changes:
        still = "with cold oil" if effect.name == "oil_warming" else "in steady motion"
        nowhere = "" if point is None else f", but nothing {still} at the working point"
        return f"It changes {largest_words(effect)}{extent_words(diagnosis)}{nowhere}."
    clauses = change_clauses(effect, changes, point, brief=True)
    here = {rounded(change, abs(change.at_point)) for change in changes}
    most = dict.fromkeys(rounded(change, change.largest) for change in changes if change.largest)
    beyond = ""
    in_proportion = of_strokes(diagnosis) or wrong_readings(effect)  # to what the finding has
    if not (in_proportion or here.issuperset(most)):
        beyond = f"; in 95 % of the motion up to {listed(list(most))}"
    return f"At the working point ({_motion(point)}), {listed(clauses)}{beyond}."


def _first_changes(diagnosis: Diagnosis, effect: EffectInPractice) -> list[Change]:
    """Return the first changes by an effect; of an instrument's error, its gravest consequence."""
    changes = main_changes(effect)
    if not wrong_readings(effect) or len(changes) <= _FEW:
        return changes[:_FEW]
    reading, *computed = changes
    limits = {
        gap.name: shown(gap.material, balance(gap.name))
        for gap in diagnosis.where
        if gap.material > 0
    }
    known = [change for change in computed if change.quantity in limits]
    gravest = max(known, key=lambda c: abs(c.at_point) / limits[c.quantity], default=computed[0])
    return [reading, gravest]


def each_size(diagnosis: Diagnosis, effects: Sequence[EffectInPractice]) -> str:
    """Return the first change by each of several effects at the working point, in one sentence."""
    point = diagnosis.working_point
    if point is None or not effects:
        return ""
    parts, still = [], []
    alone = sum(not wrong_readings(effect) for effect in effects) == 1
    for effect in effects:
        changes, computed = main_changes(effect)[:1], wrong_readings(effect)
        clauses = change_clauses(effect, changes, point, brief=True)
        due = "" if alone or computed else f" due to {in_words(effect.name)}"
        most = [
            rounded(change, change.largest)
            for change in changes
            if rounded(change, change.largest) != rounded(change, abs(change.at_point))
        ]
        beyond = f" (elsewhere up to {listed(most)})" if most and not computed else ""
        parts += [f"{clause}{due}{beyond}" for clause in clauses]
        still += [] if clauses else [in_words(effect.name)]
    if still:
        parts.append(f"{listed(still)} {plural(len(still), 'changes', 'change')} nothing")
    return f"At the working point ({_motion(point)}), {', and '.join(parts)}."


def extent_words(diagnosis: Diagnosis) -> str:
    """Return which part of the motion the largest changes are those of."""
    return "" if of_strokes(diagnosis) else " (in 95 % of the motion)"


def change_clauses(
    effect: EffectInPractice, changes: Sequence[Change], point: WorkingPoint, *, brief: bool = False
) -> list[str]:
    """Return changes of an effect at the working point, a clause each."""
    readings = wrong_readings(effect)
    return [phrase(change, point.direction, readings, brief=brief) for change in changes]


def residual_words(diagnosis: Diagnosis, names: Sequence[str]) -> str:
    """Return the residuals at the working point, also as speed and pressure."""
    point = diagnosis.working_point
    if point is None:
        return ""
    model = "revised model" if added_words(diagnosis) else compared_model(diagnosis)
    shown_names = list(names[:_FEW])
    shown_names += ["speed"] if any(name.startswith("flow_t") for name in shown_names) else []
    shown_names += ["pressure"] if "force_test" in shown_names else []
    parts = []
    for name in shown_names:
        value, display = point.residuals.get(name, float("nan")), residual_name(name)
        if isfinite(value):
            parts.append(
                f"{significant(shown(value, display), 2)} {display.unit} ({display.title})"
            )
    return f"{where_words(point)} the {model} is off by {listed(parts)}." if parts else ""


def edge_gaps(diagnosis: Diagnosis, name: str) -> dict[str, float]:
    """Return the gap of a chamber's flow by the metering edge of its valve, as far as known."""
    ways = {region.label: region for region in diagnosis.regions if region.axis == "direction"}
    edges = zip(EDGES.get(name, ()), ("extend", "retract"), strict=False)
    known = [(edge, ways[way].gaps) for edge, way in edges if way in ways]
    return {edge: gaps[name] for edge, gaps in known if name in gaps}


class Place(NamedTuple):
    """Region of the largest gap on an axis, which is clearly larger than the smallest one."""

    gap: float
    axis: str
    words: str  # adverb of place


def worst_places(diagnosis: Diagnosis, name: str) -> list[Place]:
    """Return where the gap of a balance is clearly larger than elsewhere on an axis.

    The axes of the largest gaps come first.
    """
    axes = dict.fromkeys(region.axis for region in diagnosis.regions)
    places = [place for axis in axes if (place := worst_place(diagnosis, name, axis))]
    return sorted(places, key=lambda place: -place.gap)[:_FEW]


def worst_place(diagnosis: Diagnosis, name: str, axis: str) -> Place | None:
    """Return where on an axis the gap of a balance is clearly larger than elsewhere; or None."""
    own = [
        region
        for region in diagnosis.regions
        if region.axis == axis and isfinite(region.gaps.get(name, float("nan")))
    ]
    if len(own) < 2:
        return None
    worst = max(own, key=lambda region: region.gaps[name])
    largest, least = worst.gaps[name], min(region.gaps[name] for region in own)
    if not largest > CLEARLY_LARGER * least:
        return None
    display = AXES[axis]
    low, high = (significant(shown(end, display), 2) for end in (worst.low, worst.high))
    stretch = f"at a {display.title} of {low} to {high} {display.unit}"
    way = f"while {_WAYS.get(worst.label, worst.label)}" if worst.label else ""
    return Place(largest, display.title, way or stretch)


def rms_words(diagnosis: Diagnosis, name: str, gap: float) -> str:
    """Write the gap of a region, which is in scatters of the model without effects, in its unit."""
    (without,) = (each for each in diagnosis.where if each.name == name)
    return f"{in_unit(without, gap * without.scatter)} RMS"


def places_words(diagnosis: Diagnosis, names: Sequence[str]) -> str:
    """Return where the gaps of balances are largest, a sentence for each such place.

    Empty where no place stands out.
    """
    found = dict[str, list[str]]()
    for name in names:
        for place in worst_places(diagnosis, name)[:1]:
            parts = found.setdefault(place.words, [])
            size = rms_words(diagnosis, name, place.gap)
            parts.append(f"{in_sentence(name)}{'' if parts else ' deviates'} by {size}")
    return " ".join(f"{capital(where)}, {listed(parts)}." for where, parts in found.items())
