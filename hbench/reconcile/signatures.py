"""The signature of each coefficient: what it changes in the balances that its effect touches.

It is the difference of two simulations, with the coefficient at its typical size and without.
Balances are local: an effect shows only in those whose equation it enters. So effects that touch
different balances are simulated together, which saves nearly half of the simulations.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from hbench.analysis.rounding import ROUNDING
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.gap import by_point
from hbench.reconcile.linearised import (
    Coefficient,
    Column,
    Hypothesis,
    Simulate,
    coefficients,
    less,
    mean_column,
    typical,
    windows_of,
)
from hbench.reconcile.measured.balances import Model, Windowed
from hbench.records import Run

_SEEN = 2.0  # times the noise's variance: then a change is one
_SMALLER = 0.25  # of the typical size, where that stops the board


def signatures(
    names: Iterable[str], simulate: Simulate, known: Model, base: Sequence[Run]
) -> dict[Coefficient, Column]:
    """Return the columns of all coefficients of some effects, a typical size each.

    ``base`` are the runs of the model without them. One trial is simulated of each, or all of what
    builds up over them. Where the board stops, a quarter of the size is tried alone; an effect that
    still stops it has no signature.
    """
    wanted = [one for name in names for one in coefficients(name)]
    before = windows_of(base, known)
    most = max(len(own) for own in by_point(before).values())
    found: dict[Coefficient, Column] = {}
    for trials in {1, most}:
        own = [one for one in wanted if trials == (most if EFFECTS[one[0]].builds_up else 1)]
        groups = [(group, 1.0) for group in packed(own)]
        found |= _made(groups, simulate, trials, known, before)
        alone = [((one,), _SMALLER) for one in own if one not in found]
        found |= _made(alone, simulate, trials, known, before)
    return {one: found[one] for one in wanted if one in found}


def packed(wanted: Iterable[Coefficient]) -> list[tuple[Coefficient, ...]]:
    """Return groups of coefficients whose effects touch no balance in common."""
    groups: list[tuple[list[Coefficient], set[str]]] = []
    for one in sorted(wanted, key=lambda each: -len(EFFECTS[each[0]].balances)):
        own = set(EFFECTS[one[0]].balances)
        for group, touched in groups:
            if not own & touched:
                group.append(one)
                touched |= own
                break
        else:
            groups.append(([one], own))
    return [tuple(group) for group, _ in groups]


def _made(
    tasks: Sequence[tuple[tuple[Coefficient, ...], float]],
    simulate: Simulate,
    trials: int,
    known: Model,
    base: Sequence[Windowed],
) -> dict[Coefficient, Column]:
    hypotheses = [
        Hypothesis().with_coefficients({one: size * typical(one) for one in group})
        for group, size in tasks
    ]
    found = {}
    for (group, size), runs in zip(tasks, simulate(hypotheses, trials), strict=True):
        if runs is not None:
            made = windows_of(runs, known)
            for one in group:
                found[one] = _scaled(signature(one[0], made, base), 1 / size)
    return found


def _scaled(column: Mapping, factor: float) -> Column:
    return {point: factor * own for point, own in column.items()}


def signature(name: str, runs: Sequence[Windowed], base: Sequence[Windowed]) -> Column:
    """Return what an effect changes in the balances it touches, from simulations with and without.

    ``runs`` have one trial or more, ``base`` several. A balance in which the change is lost in the
    sensors' noise is left out: noise in a column would look like a misfit.
    """
    before = mean_column(base)
    change = less(mean_column(runs), before)
    trials = by_point(base)
    noise, energy = [], []
    for point, own in change.items():
        stack = np.array([one.values[: len(own)] for one in trials[point]])
        noise.append(stack.var(axis=0, ddof=1) * (1 + 1 / len(stack)))
        energy.append(own**2)
    largest = np.nanmax(np.abs(np.concatenate(list(before.values()))), axis=0)
    least = _SEEN * np.nanmean(np.concatenate(noise), axis=0) + (ROUNDING * largest) ** 2
    seen = np.nanmean(np.concatenate(energy), axis=0) > least
    keep = seen & np.isin(base[0].names, EFFECTS[name].balances)
    return {point: np.where(keep, own, 0.0) for point, own in change.items()}
