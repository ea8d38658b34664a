"""Products of all balances for tables of one or some of them, about a linearised model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hbench.config.effects import Target
from hbench.reconcile.evidence.cross_validation import predicted, touched
from hbench.reconcile.evidence.likelihood import Fit, Priors, least_cost, maximum_likelihood
from hbench.reconcile.evidence.products import ColumnProducts, Products
from hbench.reconcile.evidence.window_sums import products
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.learned.columns import (
    knots_of,
    quantity_samples,
    size_in_balances,
    table_columns,
)
from hbench.reconcile.learned.table import Table, empty_table
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.measured.balances import BALANCES, BalanceModel
from hbench.reconcile.measured_campaign import MeasuredCampaign

_KNOTS, _KNOTS_OF_TWO = 6, 4
ALONG_STROKE = 8  # knots of the position, over which a bore changes most
_SIZE = 2.0  # prior standard deviation of a value, in root mean squares of the residual


@dataclass(frozen=True)
class BalanceProducts:
    """Products with the nuisances and effects of a model, for tables of the same balances.

    The nuisances take part in every fit, so a table explains only what they do not; the other
    balances determine them too.
    """

    measured: MeasuredCampaign
    balances: tuple[str, ...]
    model: BalanceModel
    residuals: GapMap  # of these balances alone
    columns: dict[str, np.ndarray]  # (w, balances) of nuisances and effects
    base: Products  # of these, the others included
    priors: Priors

    @cached_property
    def root_mean_square(self) -> float:
        """Root mean square of the balances' residuals [SI]."""
        return float(np.sqrt(np.nanmean(self.residuals.difference**2)))

    @cached_property
    def _samples(self) -> dict[tuple[Target, str], np.ndarray]:
        return {}

    def table(
        self, target: Target, quantities: Sequence[str], along_stroke: int = ALONG_STROKE
    ) -> Table:
        """Return an empty table of a target over one or two quantities.

        ``along_stroke`` is its number of knots over the position.
        """
        knots = {}
        for name in quantities:
            if (target, name) not in self._samples:
                self._samples[target, name] = np.concatenate(
                    [quantity_samples(name, target, log, self.model) for log in self.measured.logs]
                )
            count = _KNOTS if len(quantities) == 1 else _KNOTS_OF_TWO
            count = along_stroke if name == "position" else count
            knots[name] = knots_of(self._samples[target, name], count)
        one = size_in_balances(target, self.measured.logs, self.model)
        return empty_table(target, knots, _SIZE * self.root_mean_square / one)

    def score(
        self, table: Table, points: np.ndarray, signs: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the cross-validated gain (b,) of a table in nats, or its scores on nulls."""
        data, before, after, groups = self._fits(table)
        # The products of the nuisances are the same for every table: they keep their prediction.
        known = predicted(self.base, before, points, signs, groups)
        with_table = predicted(data, after, points, signs, groups)
        return with_table.gains_over(known).sum(axis=-1)

    def gain(self, table: Table, points: np.ndarray) -> float:
        """Return the gain of a table in nats at the points that it is fitted to."""
        data, before, after, groups = self._fits(table)
        known = least_cost(self.base, before, points, groups)
        return known - least_cost(data, after, points, groups)

    def _fits(self, table: Table) -> tuple[Products, Fit, Fit, np.ndarray]:
        """Return the products with a table, the fits without and with it, and its groups."""
        data, priors = self._with(table)
        n, q = len(self.columns), len(data.names)
        groups = touched(data, range(n), range(n, q))
        return data, Fit(range(n), self.priors), Fit(range(q), priors), groups

    def without(self, table: Table, points: np.ndarray) -> "BalanceProducts":
        """Return the products of the residuals that remain at the fit of a table."""
        data, priors = self._with(table)
        n, q = len(self.columns), len(data.names)
        beta = maximum_likelihood(data, priors, range(q), points)
        every = {**self.columns, **self._modes(table)}
        fitted = sum(np.nan_to_num(c) * b for c, b in zip(every.values(), beta, strict=True))
        steps, base = beta[:n], self.base
        curved = base.columns.times(steps)
        rest = replace(
            base,
            mixed=base.mixed - curved,
            squares=base.squares - 2 * base.mixed @ steps + curved @ steps,
        )
        residuals = replace(self.residuals, difference=self.residuals.difference - fitted)
        own, groups = products(residuals, self.columns), self._groups
        rest.mixed[:, groups], rest.squares[:, groups] = own.mixed, own.squares
        return replace(self, residuals=residuals, base=rest, priors=self.priors.shifted(steps))

    @property
    def _groups(self) -> np.ndarray:
        """Indices of the balances' groups."""
        return np.flatnonzero([name in self.balances for name, _ in self.base.groups])

    def _modes(self, table: Table) -> dict[str, np.ndarray]:
        at = [BALANCES.index(name) for name in self.balances]
        columns = table_columns(table, 0, self.measured.smoothed_sessions, self.model)
        return {f"table {name}": column[:, at] for name, column in columns.items()}

    def _with(self, table: Table) -> tuple[Products, Priors]:
        """Return the products with a table's modes, and the priors of all columns."""
        modes, base, n = self._modes(table), self.base, len(self.columns)
        own = products(self.residuals, {**self.columns, **modes})
        q, groups = n + len(modes), self._groups
        mixed = np.zeros((*base.squares.shape, q))
        mixed[..., :n], mixed[:, groups] = base.mixed, own.mixed
        squares = base.squares.copy()
        squares[:, groups] = own.squares
        others = (each for each in base.columns.blocks if not np.isin(each.groups, groups).any())
        changed = (each._replace(groups=groups[each.groups]) for each in own.columns.blocks)
        columns = ColumnProducts((*others, *changed), mixed.shape)
        wide = zip(
            (self.priors.centre, self.priors.sigma, self.priors.low, self.priors.high),
            (0.0, 1.0, -np.inf, np.inf),
            strict=True,
        )
        priors = Priors(*(np.concatenate([known, np.full(q - n, more)]) for known, more in wide))
        names = (*base.names, *modes)
        return (
            replace(base, names=names, columns=columns, mixed=mixed, squares=squares),
            priors,
        )


def balance_products(
    measured: MeasuredCampaign,
    model: LinearisedModel,
    balances: tuple[str, ...],
    effects: Sequence[str],
) -> BalanceProducts:
    """Return the products of one or some balances about a model with some effects."""
    at, chosen = [BALANCES.index(name) for name in balances], model.index(effects)
    names = tuple(model.data.names[i] for i in chosen)
    data = model.data
    base = replace(
        data,
        names=names,
        columns=data.columns.select(np.array(chosen)),
        mixed=data.mixed[..., chosen],
    )
    return BalanceProducts(
        measured,
        balances,
        measured.balance_model(model.hypothesis),
        _of_balances(model.gap_map, at),
        {name: model.columns[name][:, at] for name in names},
        base,
        model.priors(effects).select(chosen),
    )


def _of_balances(residuals: GapMap, at: list[int]) -> GapMap:
    """Return the map of some balances, by their indices."""
    levels = tuple(
        replace(each, balance=at.index(each.balance))
        for each in residuals.levels
        if each.balance in at
    )
    rows = {name: getattr(residuals, name)[:, at] for name in ("difference", "scatter", "noise")}
    assert residuals.white is not None and residuals.material is not None
    return replace(
        residuals,
        names=tuple(residuals.names[i] for i in at),
        levels=levels,
        white=residuals.white[at],
        material=residuals.material[at],
        **rows,
    )
