"""Signals of held-out runs, measured and simulated, where adding the effects changed most."""

from collections.abc import Hashable, Sequence

import numpy as np

from hbench.reconcile.gap import differences, point_of
from hbench.reconcile.measured.balances import Model, prepared
from hbench.reconcile.measured.window_signals import signal_field, signals
from hbench.records import Overlay, Run

_SHOWN = 4
_UNITS = {"p": "Pa", "f": "N", "u": "V", "v": "m/s", "x": "m"}


def overlays(
    measured: Sequence[Run],
    before: Sequence[Run],
    after: Sequence[Run],
    known: Model,
    points: frozenset[Hashable],
) -> tuple[Overlay, ...]:
    """Return the signals whose gap shrank most over the held-out ``points``, a run each."""
    own, *models = (
        [run for run in runs if point_of(run.plan) in points] for runs in (measured, before, after)
    )
    seen = [signals(prepared(run), known) for run in own]
    far, near = (
        differences(seen, [signals(prepared(run), known) for run in runs]) for runs in models
    )
    shrunk = []
    for i, point in enumerate(far.points):
        with np.errstate(invalid="ignore"):
            gain = np.nanmean(far.excess[far.point == i], axis=0) - np.nanmean(
                near.excess[near.point == i], axis=0
            )
        shrunk += [(g, name, point) for g, name in zip(gain, far.names, strict=True)]
    shrunk = [one for one in shrunk if np.isfinite(one[0]) and signal_field(one[1])]
    chosen: dict[str, tuple[str, Hashable]] = {}
    for _, name, point in sorted(shrunk, key=lambda one: -one[0]):
        if name not in chosen and len(chosen) < _SHOWN:
            chosen[name] = name, point
    return tuple(_overlay(name, point, own, *models) for name, point in chosen.values())


def _overlay(
    name: str, point: Hashable, measured: Sequence[Run], before: Sequence[Run], after: Sequence[Run]
) -> Overlay:
    runs = [
        next(run for run in side if point_of(run.plan) == point)
        for side in (measured, before, after)
    ]
    n = min(len(run.t_s) for run in runs)
    values = [getattr(run, signal_field(name))[:n] for run in runs]
    t = runs[0].t_s[:n] - runs[0].t_s[0]
    return Overlay(runs[0].plan.run, name, _UNITS[name[0]], t, *values)
