"""Signals of held-out runs, measured and simulated, where the added effects changed most."""

from collections.abc import Hashable, Sequence

import numpy as np

from hbench.reconcile.gaps.gap_map import gap_map, point_of
from hbench.reconcile.measured.balances import BalanceModel
from hbench.reconcile.measured.window_signals import signal_field, signals
from hbench.records import Overlay, Run

_LARGEST_COUNT = 4  # overlays
_UNITS = {"p": "Pa", "f": "N", "u": "V", "v": "m/s", "x": "m"}


def overlays(
    measured: Sequence[Run],
    before: Sequence[Run],
    after: Sequence[Run],
    model: BalanceModel,
    points: frozenset[Hashable],
) -> tuple[Overlay, ...]:
    """Return the signals whose gap shrank most over the held-out ``points``, a run each."""
    held_out, *simulated = (
        [run for run in runs if point_of(run.plan) in points] for runs in (measured, before, after)
    )
    means = [signals(run, model) for run in held_out]
    map_before, map_after = (
        gap_map(means, [signals(run, model) for run in runs]) for runs in simulated
    )
    reductions = []
    for i, point in enumerate(map_before.points):
        with np.errstate(invalid="ignore"):
            reduction = np.nanmean(map_before.excess[map_before.point == i], axis=0) - np.nanmean(
                map_after.excess[map_after.point == i], axis=0
            )
        for value, name in zip(reduction, map_before.names, strict=True):
            if np.isfinite(value) and signal_field(name):
                reductions.append((value, name, point))
    chosen: dict[str, Hashable] = {}
    for _, name, point in sorted(reductions, key=lambda row: -row[0]):
        if name not in chosen and len(chosen) < _LARGEST_COUNT:
            chosen[name] = point
    return tuple(_overlay(name, point, held_out, *simulated) for name, point in chosen.items())


def _overlay(
    name: str, point: Hashable, measured: Sequence[Run], before: Sequence[Run], after: Sequence[Run]
) -> Overlay:
    runs = [
        next(run for run in side if point_of(run.plan) == point)
        for side in (measured, before, after)
    ]
    n = min(len(run.t_s) for run in runs)
    field = signal_field(name)
    assert field is not None  # ``overlays`` selects logged signals
    values = [getattr(run, field)[:n] for run in runs]
    t = runs[0].t_s[:n] - runs[0].t_s[0]
    return Overlay(runs[0].plan.run, name, _UNITS[name[0]], t, *values)
