"""Signals of held-out runs, measured and simulated, whose gap was reduced most or is largest."""

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np

from hbench.reconcile.gaps.gap_map import column_means, gap_map, point_of
from hbench.reconcile.measured.balances import BalanceModel
from hbench.reconcile.measured.window_signals import signal_field, signals
from hbench.records import Overlay, Run

_LARGEST_COUNT = 4  # overlays
_UNITS = {"p": "Pa", "f": "N", "u": "V", "v": "m/s", "x": "m"}


class _Excess(NamedTuple):
    """Mean excess of a signal at an operating point, with the models before and after."""

    signal: str
    point: Hashable
    before: float
    after: float


def overlays(
    measured: Sequence[Run],
    before: Sequence[Run],
    after: Sequence[Run],
    model: BalanceModel,
    points: frozenset[Hashable],
) -> tuple[Overlay, ...]:
    """Return the signals whose gap shrank most over the held-out ``points``, a run each.

    Where no gap shrank, as when nothing was added to the model, those with the largest gaps.
    """
    held_out, *simulated = (
        [run for run in runs if point_of(run.plan) in points] for runs in (measured, before, after)
    )
    means = [signals(run, model) for run in held_out]
    maps = [gap_map(means, [signals(run, model) for run in runs]) for runs in simulated]
    every = [
        _Excess(name, point, *values)
        for i, point in enumerate(maps[0].points)
        for name, *values in zip(
            maps[0].names,
            *(column_means(each.excess[each.point == i]) for each in maps),
            strict=True,
        )
        if np.isfinite(values).all() and signal_field(name)
    ]
    if shrunk := [each for each in every if each.before > each.after]:
        every = sorted(shrunk, key=lambda each: each.after - each.before)
    else:
        every = sorted(every, key=lambda each: -each.after)
    chosen: dict[str, Hashable] = {}
    for each in every:
        if each.signal not in chosen and len(chosen) < _LARGEST_COUNT:
            chosen[each.signal] = each.point
    return tuple(
        _overlay(name, point, held_out, *simulated, shrank=bool(shrunk))
        for name, point in chosen.items()
    )


def _overlay(
    name: str,
    point: Hashable,
    measured: Sequence[Run],
    before: Sequence[Run],
    after: Sequence[Run],
    *,
    shrank: bool,
) -> Overlay:
    runs = [
        next(run for run in side if point_of(run.plan) == point)
        for side in (measured, before, after)
    ]
    n = min(len(run.t_s) for run in runs)
    field = signal_field(name)
    assert field is not None  # ``overlays`` selects logged signals
    logged, without, with_addition = (getattr(run, field)[:n] for run in runs)
    t = runs[0].t_s[:n] - runs[0].t_s[0]
    unit = _UNITS[name[0]]
    return Overlay(runs[0].plan.run, name, unit, t, logged, without, with_addition, shrank)
