"""Signature of each coefficient: its change of the balances that its effect touches.

A signature is the difference of two simulations, with the coefficient at its typical size and
without. Balances are local: an effect changes only those whose equation it enters. So effects that
touch different balances are simulated together, which saves nearly half of the simulations.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from hbench.analysis.rounding import ROUNDING
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.gaps.columns import (
    ModelColumn,
    column_difference,
    mean_column,
    residuals_of_runs,
)
from hbench.reconcile.gaps.gap_map import by_point
from hbench.reconcile.hypothesis import (
    CoefficientKey,
    Hypothesis,
    Simulate,
    effect_coefficients,
    typical_size,
)
from hbench.reconcile.measured.balances import BalanceModel, WindowedRun
from hbench.records import Run

_DETECTABLE = 2.0  # times the noise's variance: least mean square of a change
_REDUCED_SIZE = 0.25  # of the typical size, where the typical size stops the board


def signatures(
    names: Iterable[str], simulate: Simulate, model: BalanceModel, base: Sequence[Run]
) -> dict[CoefficientKey, ModelColumn]:
    """Return the columns of all coefficients of some effects, for a typical size of each.

    ``base`` are the runs of the model without the effects. Each coefficient is simulated with one
    trial, or with all trials if its effect accumulates over them. Where the board stops, a quarter
    of the size is simulated alone. An effect that still stops the board has no signature.
    """
    wanted = [which for name in names for which in effect_coefficients(name)]
    before = residuals_of_runs(base, model)
    most = max(len(trials) for trials in by_point(before).values())
    columns: dict[CoefficientKey, ModelColumn] = {}
    for trials in {1, most}:
        batch = [
            which for which in wanted if trials == (most if EFFECTS[which[0]].builds_up else 1)
        ]
        groups = [(group, 1.0) for group in disjoint_groups(batch)]
        columns |= _simulated_columns(groups, simulate, trials, model, before)
        alone = [((which,), _REDUCED_SIZE) for which in batch if which not in columns]
        columns |= _simulated_columns(alone, simulate, trials, model, before)
    return {which: columns[which] for which in wanted if which in columns}


def disjoint_groups(wanted: Iterable[CoefficientKey]) -> list[tuple[CoefficientKey, ...]]:
    """Return groups of coefficients whose effects have no balance in common."""
    groups: list[tuple[list[CoefficientKey], set[str]]] = []
    for which in sorted(wanted, key=lambda each: -len(EFFECTS[each[0]].balances)):
        balances = set(EFFECTS[which[0]].balances)
        for group, touched in groups:
            if not balances & touched:
                group.append(which)
                touched |= balances
                break
        else:
            groups.append(([which], balances))
    return [tuple(group) for group, _ in groups]


def _simulated_columns(
    tasks: Sequence[tuple[tuple[CoefficientKey, ...], float]],
    simulate: Simulate,
    trials: int,
    model: BalanceModel,
    base: Sequence[WindowedRun],
) -> dict[CoefficientKey, ModelColumn]:
    """Simulate groups of coefficients, each at a share of its typical size."""
    hypotheses = [
        Hypothesis().with_coefficients({which: share * typical_size(which) for which in group})
        for group, share in tasks
    ]
    columns = {}
    for (group, share), runs in zip(tasks, simulate(hypotheses, trials), strict=True):
        if runs is not None:
            with_group = residuals_of_runs(runs, model)
            for which in group:
                columns[which] = _scaled(signature(which[0], with_group, base), 1 / share)
    return columns


def _scaled(column: Mapping, factor: float) -> ModelColumn:
    return {point: factor * values for point, values in column.items()}


def signature(name: str, runs: Sequence[WindowedRun], base: Sequence[WindowedRun]) -> ModelColumn:
    """Return an effect's change of the balances it touches, from simulations with and without.

    ``runs`` have one trial or more, ``base`` several. A balance whose change is below the sensors'
    noise is set to zero: noise in a column would appear as a misfit.
    """
    before = mean_column(base)
    change = column_difference(mean_column(runs), before)
    trials = by_point(base)
    noise, energy = [], []
    for point, values in change.items():
        stack = np.array([trial.values[: len(values)] for trial in trials[point]])
        noise.append(stack.var(axis=0, ddof=1) * (1 + 1 / len(stack)))
        energy.append(values**2)
    largest = np.nanmax(np.abs(np.concatenate(list(before.values()))), axis=0)
    least = _DETECTABLE * np.nanmean(np.concatenate(noise), axis=0) + (ROUNDING * largest) ** 2
    detectable = np.nanmean(np.concatenate(energy), axis=0) > least
    keep = detectable & np.isin(base[0].names, EFFECTS[name].balances)
    return {point: np.where(keep, values, 0.0) for point, values in change.items()}
