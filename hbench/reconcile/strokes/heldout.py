"""How well a model of steady strokes predicts a load that its parameters have not seen."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hbench.reconcile.estimates import Estimates
from hbench.reconcile.gap import GapMap
from hbench.reconcile.linearised import Hypothesis, Linear
from hbench.reconcile.strokes.search import SeriesSearch
from hbench.reconcile.strokes.series import BALANCES, Strokes
from hbench.records import BeforeAfter, GapTable

_DRAWS = 8
Stages = dict[str, GapMap]  # before, refitted, after: of some points, with parameters from others


def stages_at(
    search: SeriesSearch, given: Linear, names: Sequence[str], points: np.ndarray
) -> Stages:
    """Return what ``points`` lack: the model as given, refitted and with effects."""
    refitted = search.settled(given, ())
    after = search.settled(refitted, names) if names else refitted
    found = {"before": given.lacking}
    for stage, here, own in (("refitted", refitted, ()), ("after", after, names)):
        best = search.estimates(here, own)
        found[stage] = _lacking(search.measured, best.hypothesis(best.beta))
    return {stage: one.at(points) for stage, one in found.items()}


def without_each(search: SeriesSearch, given: Linear, names: Sequence[str]) -> list[Stages]:
    """Return the stages of each load, with parameters that have not seen it."""
    every = np.arange(len(given.lacking.points))
    return [
        stages_at(replace(search, train=np.setdiff1d(every, [out])), given, names, np.array([out]))
        for out in every
    ]


def _lacking(measured: Strokes, hypothesis: Hypothesis) -> GapMap:
    (made,) = measured.simulate([hypothesis], 1)
    return measured.lacking(hypothesis, made)


def floor(measured: Strokes, best: Estimates) -> np.ndarray:
    """Return the gaps of a right model whose parameters are as uncertain as these."""
    at = _lacking(measured, best.hypothesis(best.beta))
    over = [
        ((_lacking(measured, one).difference - at.difference) / at.scatter) ** 2
        for one in best.draws(_DRAWS)
    ]
    return np.sqrt(1 + np.mean(over, axis=(0, 1)))


def table(stages: Sequence[Stages], least: np.ndarray | None = None) -> GapTable:
    """Return the gaps over some stages; ``least`` (2,) are the floors."""
    values = {
        stage: np.sqrt(
            np.maximum(1 + np.mean([one[stage].excess for one in stages], axis=(0, 1)), 0)
        )
        for stage in ("before", "refitted", "after")
    }
    values["floor"] = np.ones(len(BALANCES)) if least is None else least
    total = BeforeAfter(*(float(np.sqrt(np.mean(one**2))) for one in values.values()))
    balances = {
        name: BeforeAfter(*(float(one[i]) for one in values.values()))
        for i, name in enumerate(BALANCES)
    }
    return GapTable(total, balances, {}, {})


def with_floor(held: GapTable, other: GapTable) -> GapTable:
    """Return a table with the floors of another."""
    balances = {
        name: replace(held.balances[name], floor=one.floor) for name, one in other.balances.items()
    }
    return replace(held, total=replace(held.total, floor=other.total.floor), balances=balances)


def errors(stages: Sequence[Stages]) -> str:
    """Write the errors in force by load, refitted and with the effects."""
    each = []
    for one in stages:
        was, now = (
            float(np.sqrt(np.sum(one[stage].difference ** 2))) for stage in ("refitted", "after")
        )
        each.append(f"{was:.2f} to {now:.2f} N at {one['after'].load_n[0]:.0f} N")
    return ", ".join(each)
