"""Sentences of a diagnosis: where, how large, how sure, and what to do."""

from collections.abc import Sequence
from math import exp, isfinite

from hbench.records import (
    AddedEffect,
    Candidate,
    Change,
    Diagnosis,
    EffectInPractice,
    Gap,
    WorkingPoint,
)
from hbench.records.summary import SIGNIFICANCE
from hbench.report.diagnosis.change_words import main_changes, phrase, wrong_readings
from hbench.report.diagnosis.names import (
    AXES,
    EDGES,
    balance,
    compared_model,
    deviation_and_limit,
    in_sentence,
    in_words,
    p_equation,
    p_words,
    residual_name,
    share,
    shown,
)
from hbench.report.render.numbers import number, short, significant
from hbench.report.render.symbols import listed

_MOST_ODDS = 1000.0  # larger ones are not stated: the model of the residuals is not that exact
CLEARLY_LARGER = 1.5  # gap of a region against that of the best region of its axis
_FEW = 2  # balances, or unexplained gaps, in a sentence
_CLEARLY_WORSE = 1.1  # gap of the revised model against that without effects
_WAYS = {"extend": "extending", "retract": "retracting", "rest": "at rest"}


def where_words(point: WorkingPoint | None) -> str:
    """Return the working point, medians of the campaign, as the beginning of a sentence."""
    if point is None:
        return "In these runs,"
    motion = f"{_WAYS[point.direction]} at {short(1e3 * abs(point.v_m_s))} mm/s"
    if isfinite(point.f_applied_n):
        motion += f", load cell {short(point.f_applied_n)} N"
    pressures = {
        "piston side P_Tp": point.p_tp_pa,
        "rod side P_Tr": point.p_tr_pa,
        "supply P_S": point.p_s_pa,
    }
    parts = [f"{name} {short(p / 1e5)} bar" for name, p in pressures.items() if isfinite(p)]
    return f"At the median working point ({', '.join((motion, *parts))}),"


def at_point_words(
    point: WorkingPoint | None, effect: EffectInPractice, *, brief: bool = False
) -> str:
    """Return what an effect changes at the working point, its main changes if ``brief``."""
    if not effect.changes or point is None:
        return ""
    changes = main_changes(effect)
    if not changes:
        return (
            f"{where_words(point)} it changes nothing: it acts only while speed or pressure "
            "changes, or at other places of the stroke."
        )
    if brief:
        changes = [change for change in changes if change.quantity not in ("pressure",)][:2]
    clauses = change_clauses(effect, changes, point)
    return f"{where_words(point)} {listed(clauses)}."


def change_clauses(
    effect: EffectInPractice, changes: Sequence[Change], point: WorkingPoint
) -> list[str]:
    """Return changes of an effect at the working point, a clause each."""
    readings = wrong_readings(effect)
    return [phrase(change, point.direction, readings) for change in changes]


def gap_change(effect: AddedEffect) -> str:
    """Return how an effect changes the gap of held-out runs, also where it does not reduce it."""
    before, after, where = effect.gap_before, effect.gap_after, "in the balances that it touches"
    if not after >= before:
        return (
            f"It reduces the gap of held-out runs {where} from {number(before, 1)} to "
            f"{number(after, 1)}, where 1 is the repeatability of the bench."
        )
    return (
        f"It does not reduce the gap of held-out runs {where}: {number(before, 2)} without it and "
        f"{number(after, 2)} with it, where 1 is the repeatability of the bench."
    )


def odds_words(effect: AddedEffect) -> str:
    """Return how clearly the cross-validation favours an effect over the next best one."""
    rival = effect.runner_up
    if rival is None or not isfinite(rival.margin):
        return "No other effect of the catalogue explains these residuals."
    return (
        "The cross-validation favours it over the next best explanation, "
        f"{in_words(rival.name)}, by {_ratio(rival.margin)}."
    )


def closeness(candidates: Sequence[Candidate]) -> str:
    """Return how close the scores of an ambiguous set are."""
    explained = [f"{in_words(each.name)} {share(each.explained)}" for each in candidates]
    scores = [f"{in_words(each.name)} {number(each.score, 0)}" for each in candidates]
    return (
        f"Share of the excess gap that each explains in cross-validation: {', '.join(explained)}. "
        f"Their scores ({', '.join(scores)} nats) are too close to decide. The laws "
        "of the catalogue are approximations: the effect with the better score may be the wrong "
        "one."
    )


def _ratio(nats: float) -> str:
    """Return the odds that correspond to a gain of log-likelihood."""
    odds = exp(min(max(nats, 0.0), 700.0))
    if odds > _MOST_ODDS:
        return f"odds of more than {_MOST_ODDS:.0f} to 1"
    return f"odds of {significant(odds, 2)} to 1"


def advice(effect: EffectInPractice) -> str:
    """Return what to inspect and what to do then."""
    inspect = f"Inspect {effect.inspect}." if effect.inspect else ""
    return " ".join(filter(None, (inspect, effect.repair)))


def best_candidate(diagnosis: Diagnosis) -> str:
    """Return how much the best candidate explains, with its score and size."""
    if not diagnosis.ranking:
        return ""
    best = diagnosis.ranking[0]
    small = (
        " Its size, or the share that it explains, is too small for it to be named."
        if best.score > best.threshold and diagnosis.verdict == "unknown"
        else ""
    )
    return (
        f"The best of {len(diagnosis.ranking)} effects, {in_words(best.name)}, explains "
        f"{share(best.explained)} of the gap; its score is {number(best.score + 0.0, 1)} nats "
        f"({number(best.threshold, 1)} needed), its size {significant(best.size, 2)} times a "
        f"typical one.{small}"
    )


def agreement(diagnosis: Diagnosis) -> str:
    """Return the gap of held-out runs with the refitted model, beside that of a correct one."""
    total = diagnosis.gap_heldout.total
    if not isfinite(total.refitted):
        return ""
    return (
        f"The gap of {len(diagnosis.heldout_runs)} held-out runs is {number(total.refitted, 1)} "
        f"with the {compared_model(diagnosis)}, where 1 is the repeatability of the bench. A "
        f"correct model whose values are as uncertain would have {number(total.floor, 1)} on "
        "average."
    )


def worse_words(diagnosis: Diagnosis) -> str:
    """Return which gaps of held-out runs the model of model.yaml increases beyond repeatability.

    It is compared with the model that it was made from: an effect's with the refitted one, and the
    refitted one with the given one.
    """
    revised = diagnosis.effects or diagnosis.unnamed
    if not revised and diagnosis.refit_refused:
        return ""
    start, end = ("refitted", "after") if revised else ("before", "refitted")
    model = "revised model" if revised else "refitted model"
    base = compared_model(diagnosis) if revised else "given model"
    table = diagnosis.gap_heldout
    groups = (
        ("", table.balances),
        (" in closed loop", table.signals),
        (" in open loop", table.open_loop),
    )
    parts = [
        f"{in_sentence(name)}{where} ({number(before, 1)} to {number(after, 1)})"
        for where, gaps in groups
        for name, gap in gaps.items()
        for before, after in [(getattr(gap, start), getattr(gap, end))]
        if after > max(1.0, _CLEARLY_WORSE * before)
    ]
    if not parts:
        return ""
    return f"The {model} is worse than the {base} in the gaps of {listed(parts)}."


def deviations(gaps: Sequence[Gap]) -> str:
    """Return gaps in their units, with the limits below which they do not matter."""
    parts = []
    for gap in gaps[:_FEW]:
        size = f"{number(gap.gap, 1)} trial scatters"
        if isfinite(gap.deviation):
            size = "{} RMS (limit {})".format(*deviation_and_limit(gap))
        parts.append(f"{in_sentence(gap.name)} deviates by {size}")
    more = f"; and {len(gaps) - _FEW} more" if len(gaps) > _FEW else ""
    return f"{'; '.join(parts)}{more}"


def largest_deviation(gaps: Sequence[Gap]) -> Gap | None:
    """Return the gap whose deviation exceeds its limit most; None where no limit is known."""
    known = [gap for gap in gaps if isfinite(gap.deviation) and gap.material > 0]
    return max(known, key=lambda gap: gap.deviation / gap.material, default=None)


def significant_gaps(gaps: Sequence[Gap]) -> str:
    """Return the gaps that are significant where no missing effect is found; empty without any."""
    parts = [
        f"{in_sentence(gap.name)} by {deviation} RMS ({p_equation(gap.p_value)}, limit {limit})"
        for gap in gaps
        if gap.p_value < SIGNIFICANCE and isfinite(gap.deviation)
        for deviation, limit in [deviation_and_limit(gap)]
    ]
    return f"Significant, but no missing effect by their size: {listed(parts)}." if parts else ""


def significance(gaps: Sequence[Gap]) -> str:
    """Return how probable such deviations are with a correct model."""
    parts = [f"{p_words(gap.p_value)} ({balance(gap.name).title})" for gap in gaps[:_FEW]]
    return f"Probability of such a deviation with a correct model, after Holm: {listed(parts)}."


def detectable(diagnosis: Diagnosis) -> str:
    """Return how many effects of a typical size these runs would show, and which ones not."""
    seen = _detectable(diagnosis)
    if not seen:
        return ""
    unseen = [in_words(name) for name, known in seen.items() if not known]
    rest = f" They would not show {listed(unseen)}: these can be present." if unseen else ""
    count = f"{sum(seen.values())} of {len(seen)}"
    return f"These runs would show {count} known effects at a typical size.{rest}"


def undetectable(diagnosis: Diagnosis) -> str:
    """Return how many effects of a typical size these runs would not show; empty for none."""
    seen = _detectable(diagnosis)
    unseen = len(seen) - sum(seen.values())
    if not unseen:
        return ""
    return f"These runs would not show {unseen} of {len(seen)} known effects at a typical size."


def _detectable(diagnosis: Diagnosis) -> dict[str, bool]:
    """Return each known effect, and whether these runs would show a typical size of it."""
    if diagnosis.separability is None:
        return {}
    seen: dict[str, bool] = {}
    for size in diagnosis.separability.sizes:
        seen[size.effect] = seen.get(size.effect, False) or size.detectable
    return {**seen, **dict.fromkeys(diagnosis.not_tried, False)}


def residual_words(diagnosis: Diagnosis, names: Sequence[str]) -> str:
    """Return the residuals at the working point, also as speed and pressure."""
    point = diagnosis.working_point
    if point is None:
        return ""
    revised = diagnosis.effects or diagnosis.unnamed
    model = "revised model" if revised else compared_model(diagnosis)
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


def worst_region(diagnosis: Diagnosis, name: str) -> str:
    """Return a sentence on where the gap of a balance is largest; empty if nowhere clearly."""
    places = worst_places(diagnosis, name)
    return f"Over all runs, the gap of {in_sentence(name)} is largest {places}." if places else ""


def worst_places(diagnosis: Diagnosis, name: str) -> str:
    """Return where the gap of a balance is clearly larger than elsewhere, as adverbs of place.

    The regions of the largest gaps come first.
    """
    places = []
    for axis in dict.fromkeys(region.axis for region in diagnosis.regions):
        own = [
            region
            for region in diagnosis.regions
            if region.axis == axis and isfinite(region.gaps.get(name, float("nan")))
        ]
        if len(own) < 2:
            continue
        worst = max(own, key=lambda region: region.gaps[name])
        contrast = worst.gaps[name] / min(region.gaps[name] for region in own)
        if contrast > CLEARLY_LARGER:
            display = AXES[axis]
            low, high = (significant(shown(end, display), 2) for end in (worst.low, worst.high))
            stretch = f"at a {display.title} of {low} to {high} {display.unit}"
            way = f"while {_WAYS.get(worst.label, worst.label)}" if worst.label else ""
            places.append((worst.gaps[name], way or stretch))
    places.sort(key=lambda place: -place[0])
    return " and ".join(words for _, words in places[:_FEW])


def title(name: str) -> str:
    """Return an effect's name as the beginning of a sentence."""
    text = in_words(name)
    return text[:1].upper() + text[1:]
