"""Effects that some runs detect, and pairs that they distinguish, in sentences and tables."""

from collections.abc import Mapping, Sequence
from math import isfinite

from hbench.records import (
    DetectableSize,
    Diagnosis,
    EffectPair,
    PlannedEffects,
    Separability,
    WordTable,
)
from hbench.records.reconcile.diagnosis import FITTED, NO_PART
from hbench.report.diagnosis.names import in_words
from hbench.report.render.numbers import NONE, number, significant
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import wrapped
from hbench.sentences import capital, listed, plural

MATRIX_TEXT = (
    "Angle of the signatures of two effects in these runs, after the refitted values are projected "
    "out: 90° is unlike, 0° alike for some coefficients, of either sign. An asterisk marks a pair "
    "that these runs do not distinguish: the wrong effect, with coefficients within their limits, "
    "is expected to score nearly as well. diagnosis.json contains all pairs and the smallest "
    "detectable size of every effect."
)
_SIZES = "Smallest effects that hbench reconcile would detect, by simulation of the runs"
_LEAST_SIZE = "*: limited by the least size that is named, not by the residuals"
_BEYOND = "-: not detectable at ten times the typical size"
_NO_PAIR = "All pairs of detectable effects are distinguishable."
_NEIGHBOURS = 3  # closest effects to each one that matters
_MOST = 8  # effects of the matrix


def sizes_table(separability: Separability) -> WordTable:
    """Return a row for each coefficient: its smallest detectable and its typical value."""
    rows = tuple(
        (
            f"{size.effect} {size.coefficient}",
            size.unit,
            significant(size.smallest, 2) + (" *" if _has_least_size(size) else ""),
            significant(size.typical, 2),
            "yes" if size.detectable else "no",
        )
        for size in separability.sizes
    )
    head = ("effect and coefficient", "unit", "smallest detectable", "typical")
    return WordTable(_SIZES, (*head, "typical detected"), rows)


def _has_least_size(size: DetectableSize) -> bool:
    return size.limit == "size" and isfinite(size.smallest)


def _size_notes(separability: Separability) -> list[str]:
    """Return the meaning of the signs in the table of sizes."""
    least = any(map(_has_least_size, separability.sizes))
    beyond = not all(isfinite(size.smallest) for size in separability.sizes)
    return [_LEAST_SIZE] * least + [_BEYOND] * beyond


def alike_table(separability: Separability) -> WordTable:
    """Return the pairs that are not distinguishable, those with the smallest angle first."""
    alike = [pair for pair in separability.pairs if pair.distinguishable is False]
    rows = tuple(
        (pair.first, pair.second, number(pair.angle_deg, 0), number(pair.lead, 1))
        for pair in sorted(alike, key=lambda pair: pair.angle_deg)
    )
    head = ("effect", "effect", "angle of signatures, degrees", "lead of the right one, nats")
    return WordTable("Pairs of effects that these runs do not distinguish", head, rows)


def planned_effects_text(planned: PlannedEffects) -> str:
    """Return the tables of planned runs and what is missing for more effects, in ASCII."""
    alike = alike_table(planned.separability)
    shortfalls = [f"no effect can be named; missing: {item}" for item in planned.shortfalls]
    missing = [f"missing to distinguish more effects: {item}" for item in planned.missing]
    remarks = [*shortfalls, *missing, *not_tried_lines(planned.not_tried)]
    sizes = table_lines(sizes_table(planned.separability))
    blocks = [
        "\n".join([*sizes, *_size_notes(planned.separability)]),
        "\n".join(table_lines(alike)) if alike.rows else _NO_PAIR,
        "\n".join(line for words in remarks for line in wrapped(words)),
    ]
    text = "\n\n".join(filter(None, blocks))
    return text.replace(NONE, "-").replace("\u2212", "-")


def matrix_table(diagnosis: Diagnosis) -> WordTable:
    """Return the angles between the effects that matter and those closest to them."""
    title = "Angles between effects"
    if diagnosis.separability is None:
        return WordTable(title, (), ())
    pairs = diagnosis.separability.pairs
    names = _that_matter(diagnosis, pairs)
    angles = {frozenset((pair.first, pair.second)): pair for pair in pairs}
    rows = tuple(
        (
            row,
            *(
                NONE if row == column else _cell(angles[frozenset((row, column))])
                for column in names
            ),
        )
        for row in names
    )
    return WordTable(title, ("", *names), rows)


def _that_matter(diagnosis: Diagnosis, pairs: Sequence[EffectPair]) -> tuple[str, ...]:
    """Return the named effects and the ambiguous set, with those closest to them.

    Where there are none, the effects of the pairs that are not distinguishable.
    """
    known = {name for pair in pairs for name in (pair.first, pair.second)}
    every = [effect.name for effect in diagnosis.effects]
    every += [candidate.name for candidate in diagnosis.alternatives]
    chosen = [name for name in dict.fromkeys(every) if name in known]
    close = sorted((p for p in pairs if isfinite(p.angle_deg)), key=lambda pair: pair.angle_deg)
    if not chosen:
        alike = [each for each in close if each.distinguishable is False]
        chosen = [name for each in alike for name in (each.first, each.second)]
    neighbours: list[str] = []
    for name in chosen:
        own = [pair for pair in close if name in (pair.first, pair.second)]
        neighbours += [p.second if p.first == name else p.first for p in own[:_NEIGHBOURS]]
    return tuple(dict.fromkeys([*chosen, *neighbours]))[:_MOST]


def _cell(pair: EffectPair) -> str:
    angle = number(pair.angle_deg, 0)
    return f"{angle}°{' *' if pair.distinguishable is False else ''}" if angle != NONE else NONE


def detectable(diagnosis: Diagnosis) -> str:
    """Return how many effects of a typical size these runs would show, and which ones not."""
    seen, unseen = _detectable(diagnosis), _unseen(diagnosis)
    if not seen:
        return ""
    rest = f" They would not show {listed(unseen)}: these can be present." if unseen else ""
    count = f"{sum(seen.values())} of {len(seen)}"
    fitted = [in_words(name) for name, why in diagnosis.not_tried.items() if why == FITTED]
    verb = plural(len(fitted), "is", "are")
    more = f" {capital(listed(fitted))} {verb} fitted with the model's values." if fitted else ""
    untried = [in_words(name) for name in seen if name in diagnosis.not_tried]
    tried = f" ({len(seen) - len(untried)} tried, and {listed(untried)})" if untried else ""
    return f"These runs would show {count} known effects{tried} at a typical size.{rest}{more}"


def undetectable(diagnosis: Diagnosis) -> str:
    """Return how many effects of a typical size the runs would not show."""
    unseen = _unseen(diagnosis)
    if not unseen:
        return ""
    every = len(_detectable(diagnosis))
    return (
        f"However, {len(unseen)} of {every} known effects at a typical size could be present "
        "without showing in these runs."
    )


def unseen_line(diagnosis: Diagnosis) -> str:
    """Return which effects could be present without showing, where none is found."""
    if diagnosis.verdict != "none":
        return ""
    unseen = [name for name, known in _detectable(diagnosis).items() if not known]
    tried = [in_words(name) for name in unseen if name not in diagnosis.not_tried]
    others = [in_words(name) for name in unseen if name in diagnosis.not_tried]
    parts = filter(None, (", ".join(tried), f"not tried: {', '.join(others)}" if others else ""))
    return f"Could be present at a typical size: {'; '.join(parts)}" if unseen else ""


def untried_words(diagnosis: Diagnosis) -> str:
    """Return the unseen effects for which no experiment was simulated, with the reasons."""
    unseen = [name for name, known in _detectable(diagnosis).items() if not known]
    untried = {name: diagnosis.not_tried[name] for name in unseen if name in diagnosis.not_tried}
    parts = [
        f"{listed([in_words(name) for name in names])} ({reason})"
        for reason, names in by_reason(untried).items()
    ]
    return f"Not simulated: {'; '.join(parts)}." if parts else ""


def _unseen(diagnosis: Diagnosis) -> list[str]:
    return [
        f"{in_words(name)}{' (not tried)' if name in diagnosis.not_tried else ''}"
        for name, known in _detectable(diagnosis).items()
        if not known
    ]


def _detectable(diagnosis: Diagnosis) -> dict[str, bool]:
    """Return each known effect, and whether these runs would show a typical size of it."""
    if diagnosis.separability is None:
        return {}
    seen: dict[str, bool] = {}
    for size in diagnosis.separability.sizes:
        seen[size.effect] = seen.get(size.effect, False) or size.detectable
    unseen = [name for name, why in diagnosis.not_tried.items() if why not in (FITTED, NO_PART)]
    return {**seen, **dict.fromkeys(unseen, False)}


def lookalikes_tables(diagnosis: Diagnosis) -> tuple[WordTable, ...]:
    """Return what each effect is confused with, and the runs that separate the two."""
    head = ("effect", "runs that separate", "why")
    return tuple(
        WordTable(
            f"What looks like {in_words(effect.name)}",
            head,
            tuple((other.name, other.kind, other.why) for other in effect.lookalikes),
        )
        for effect in diagnosis.practice
    )


def not_tried_lines(not_tried: Mapping[str, str]) -> list[str]:
    """Return a line for each reason for which effects were not tried."""
    every = by_reason(not_tried).items()
    return [f"not tried ({reason}): {', '.join(names)}" for reason, names in every]


def by_reason(not_tried: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the names of the effects that were not tried, by the reason."""
    names: dict[str, list[str]] = {}
    for name, reason in not_tried.items():
        names.setdefault(reason, []).append(name)
    return names
