"""Leave-one-out prediction: the error of a stroke model at a load outside the fit."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.gaps.gap_map import GapMap, column_means, gap_of
from hbench.reconcile.gaps.model_gaps import residual_variance
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.strokes.stroke_search import SeriesSearch
from hbench.records import BeforeAfter, GapTable, HeldOutLoad

StageGaps = dict[str, GapMap]  # before, refitted, after: of some points, parameters from others


def gaps_at(
    search: SeriesSearch, start: LinearisedModel, names: Sequence[str], points: np.ndarray
) -> StageGaps:
    """Return the gap maps of ``points``: model as given, refitted and with effects."""
    refitted = search.refit(start, ())
    after = search.refit(refitted, names) if names else refitted
    stages = {"before": search.before}
    for stage, model, effects in (("refitted", refitted, ()), ("after", after, names)):
        best = search.estimates(model, effects)
        stages[stage] = search.measured.gap_map(best.hypothesis, start.gap_map)
    return {stage: differences.select_points(points) for stage, differences in stages.items()}


def leave_each_load_out(
    search: SeriesSearch, start: LinearisedModel, names: Sequence[str]
) -> list[StageGaps]:
    """Return the gap maps of each load, with parameters from the other loads."""
    points = np.arange(len(start.gap_map.points))
    return [
        gaps_at(replace(search, train=np.setdiff1d(points, [load])), start, names, np.array([load]))
        for load in points
    ]


def gap_floor(final: LinearisedModel, estimates: ParameterEstimates) -> np.ndarray:
    """Return the gaps (c,) of a correct model with parameters as uncertain as these."""
    variance = residual_variance(final, estimates, estimates.covariance)
    return np.sqrt(1 + column_means(variance))


def gap_table(stages: Sequence[StageGaps], floor: np.ndarray | None = None) -> GapTable:
    """Return the gaps over several sets of points; ``floor`` (c,) are the floors."""
    values = {
        stage: gap_of(np.concatenate([maps[stage].excess for maps in stages]).mean(axis=0))
        for stage in ("before", "refitted", "after")
    }
    names = stages[0]["after"].names
    values["floor"] = np.ones(len(names)) if floor is None else floor
    total = BeforeAfter(*(float(np.sqrt(np.mean(gaps**2))) for gaps in values.values()))
    balances = {
        name: BeforeAfter(*(float(gaps[i]) for gaps in values.values()))
        for i, name in enumerate(names)
    }
    return GapTable(total, balances)


def with_floor(held_out: GapTable, other: GapTable) -> GapTable:
    """Return a table with the floors of another."""
    balances = {
        name: replace(held_out.balances[name], floor=gap.floor)
        for name, gap in other.balances.items()
    }
    total = replace(held_out.total, floor=other.total.floor)
    return replace(held_out, total=total, balances=balances)


def held_out_loads(
    stages: Sequence[StageGaps], also: Mapping[str, Sequence[StageGaps]]
) -> tuple[HeldOutLoad, ...]:
    """Return the force errors of both directions at each load.

    ``stages`` are those of ``leave_each_load_out``, ``also`` those with one more effect, by name.
    """
    return tuple(
        HeldOutLoad(
            load_n=float(maps["after"].load_n.mean()),
            **{stage: _force_error(maps[stage]) for stage in ("before", "refitted", "after")},
            also={name: _force_error(more[i]["after"]) for name, more in also.items()},
            scatters=_scatters(maps["after"]),
        )
        for i, maps in enumerate(stages)
    )


def _force_error(gaps: GapMap) -> float:
    """Return the root mean square error [N] of both directions and all speeds at one load."""
    return float(np.sqrt(np.sum(gaps.difference**2, axis=1).mean()))


def _scatters(gaps: GapMap) -> dict[str, float]:
    """Return the root mean square scatter [N] of each balance over the speeds of a load."""
    pooled = np.sqrt(np.mean(gaps.scatter**2, axis=0))
    return dict(zip(gaps.names, pooled.tolist(), strict=True))
