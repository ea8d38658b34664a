"""What a diagnosis of steady strokes says beside its numbers: notes, tests, what was not tried."""

from collections.abc import Iterator, Sequence

from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.strokes.stroke_search import (
    OF_THE_SEAL,
    SeriesSearch,
    StrokeSearchResult,
)
from hbench.records import Candidate
from hbench.sentences import listed

BALANCE_TEXTS = {
    "force_band": "the friction band",
    "force_middle": "the mean offset of both directions",
}
NO_SENSOR_NOTE = (
    "No force sensor: the applied force is not measured, so the load is unknown. Only the friction "
    "band is compared, half the difference of both directions at the same positions. The mean of "
    "both directions contains the load: a gain, an offset, a wrong area or an asymmetry of the "
    "directions cannot be determined. The loads shown are the mean pressure forces of both "
    "directions."
)
DRIFT_NOTE = (
    "A load that changes along the stroke appears as a drift of friction. To accept such strokes, "
    "set screening.friction_drift in the import map above this change."
)
GAIN_NOTE = (
    "load_cell_gain represents any gain error between pressure and force: load cell, pressure "
    "transducer, or piston area of the model. Steady strokes show the same with each."
)


def not_tried(search: SeriesSearch) -> dict[str, str]:
    """Return the effects that strokes do not show, with the reason."""
    reason = "does not change the mean of a steady stroke"
    if not search.measured.load_is_known:
        reason = "needs a force sensor, or does not change the friction band of steady strokes"
    return {name: reason for name in EFFECTS if name not in search.candidates}


def next_experiment(result: StrokeSearchResult) -> str | None:
    """Return the tests that distinguish the effects of each ambiguous set; None without any."""
    sets = [step.ambiguous for step in result.steps if step.ambiguous]
    sentences = []
    for candidates in sets:
        names = [candidate.name for candidate in candidates]
        tests = dict.fromkeys(filter(None, (EFFECTS[name].inspect for name in names)))
        them = listed([name.replace("_", " ") for name in names]) if sets[1:] else "them"
        if tests:
            sentences.append(f"Tests that distinguish {them}: {'; '.join(tests)}.")
    return " ".join(sentences) or None


def stroke_notes(
    labels: Sequence[str],
    search: SeriesSearch,
    names: Sequence[str],
    alternatives: Sequence[Candidate],
) -> Iterator[str]:
    """Yield the notes on a series, the first of ``labels``, with the effects ``names``."""
    if not search.measured.load_is_known:
        yield NO_SENSOR_NOTE
    yield (
        "Leave-one-out: the gaps of held-out runs are predictions of each load with parameters "
        "from the other loads. The effects were chosen with all loads."
    )
    if "load_cell_gain" in (*(candidate.name for candidate in alternatives), *names):
        yield GAIN_NOTE
    if len(labels) > 1:
        yield (
            f"Other series used as evidence: {', '.join(labels[1:])}. They are assumed to be the "
            f"same cylinder with other seals; only {listed(OF_THE_SEAL)} may differ."
        )
