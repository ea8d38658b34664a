"""Search for learned laws where structured, material residuals remain that no effect explains.

For each balance that remains, tables over one and over two quantities are compared by their
cross-validated likelihood over the training points, as candidates are (folder ``evidence``): a
table over two quantities must be better by 5 nats; where it is not kept, the best over one is
tried. In a flow they compete with an error of the position sensor, which changes all four flows by
one table. It may repeat with the sensor's pitch, so it has 8, 16 or 32 knots along the stroke, the
number with the best score. The first of these that meets all of the following is kept, best score
first:

    its score exceeds 5 nats and the threshold of itself and of all tables over one quantity with
    null data sets: its own residuals with random signs (``acceptance.AcceptanceCriteria``),
    it explains more than a quarter of the excess gap of its balances at training points, and
    it reduces the residuals at held-out operating points: a permutation test with random signs of
    the points' logarithmic reductions has p < 0.05, which takes five points.

Up to three tables are tried at the same held-out points; p is that of a single one. The last two
are tested about the linearised model first, and again after the model is refitted with the table. A
learned law has no name, so it does not change the verdict.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from hbench.analysis.statistics.permutations import permutation_p, random_signs
from hbench.config.effects import MOST_KNOTS, TARGETS, target_quantities
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.acceptance import CRITERIA, score_to_exceed
from hbench.reconcile.column_names import mode_name
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.gaps.log_map import unexplained_at
from hbench.reconcile.learned.balance_products import (
    ALONG_STROKE,
    BalanceProducts,
    balance_products,
)
from hbench.reconcile.learned.table import (
    FAMILIES,
    LawFound,
    Table,
    balances_of,
)
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.search.candidates import CandidateEvaluator

_MOST_LAWS = 4
_SIGNIFICANCE = 0.05  # of the reduction at held-out points
_PERMUTATIONS = 9999
_OF_SENSOR = ALONG_STROKE, MOST_KNOTS // 2, MOST_KNOTS  # knots along the stroke


@dataclass(frozen=True)
class LawSearch:
    """Search for learned laws about a model with all effects that were found."""

    measured: MeasuredCampaign
    evaluator: CandidateEvaluator
    effects: tuple[str, ...]
    held_out: np.ndarray  # indices of operating points

    def run(self, model: LinearisedModel) -> tuple[LinearisedModel, tuple[LawFound, ...]]:
        """Return the model with the laws that are kept, and these."""
        laws: list[LawFound] = []
        refused: set[str] = set()
        while len(laws) < _MOST_LAWS:
            balance = self._worst(model, refused)
            if balance is None:
                break
            added = self._add(model, balance)
            if added is None:
                refused.add(balance)
                continue
            model, law = added
            laws.append(law)
        return model, tuple(laws)

    def _worst(self, model: LinearisedModel, refused: set[str]) -> str | None:
        """Return the balance with the largest material gap at training points, if any.

        A law explains what the verdict calls unexplained, so there must be a gap at all points too.
        """
        gaps = unexplained_at(model.gap_map, self.evaluator.train)
        everywhere = unexplained_at(model.gap_map, np.arange(len(model.gap_map.points)))
        known = {name for family in self._families for name in family}
        known &= {gap.name for gap in everywhere}
        names = [gap.name for gap in gaps if gap.name in known - refused]
        return names[0] if names else None

    @property
    def _families(self) -> list[tuple[str, ...]]:
        """Balances that have laws; a pump's pressure has a law of its own."""
        has_pump = self.measured.plant.supply.pump is not None
        return [family for family in FAMILIES if not (has_pump and family == ("supply",))]

    def _add(self, model: LinearisedModel, balance: str) -> tuple[LinearisedModel, LawFound] | None:
        """Return the model with the best law of a balance, if it is kept."""
        found = []
        for family in self._families:
            if balance in family:
                one = balance_products(self.measured, model, family, self.effects)
                tables = best_tables(one, self.evaluator.train)
                found += [(one, table, gain) for table, gain in tables if gain > CRITERIA.score]
        for each in sorted(found, key=lambda each: -each[2]):
            if kept := self._tried(model, *each):
                return kept
        return None

    def _tried(
        self, model: LinearisedModel, one: BalanceProducts, table: Table, gain: float
    ) -> tuple[LinearisedModel, LawFound] | None:
        """Return the model with a law of a score ``gain``, if it is kept."""
        points = self.evaluator.train
        null = one.without(table, points)
        if self._p_value(one.residuals, null.residuals, one.balances) is None:
            return None
        threshold = table_threshold(gain, one, null, table, points)
        if gain <= threshold:
            return None
        with_table = self._with_table(model, table)
        p_value = self._p_value(model.gap_map, with_table.gap_map, table.balances)
        if p_value is None or is_worse(model.gap_map, with_table.gap_map, self.held_out):
            return None
        number = len(with_table.hypothesis.tables) - 1
        return with_table, LawFound(number, gain, threshold, p_value)

    def _p_value(self, before: GapMap, after: GapMap, balances: Sequence[str]) -> float | None:
        """Return the p-value at held-out points; None if the reduction does not suffice."""
        left, total = (_excess(each, balances, self.evaluator.train) for each in (after, before))
        at = [before.names.index(name) for name in balances]
        changes = np.sum([reductions(before, after, i) for i in at], axis=0)
        p_value = sign_test(changes[self.held_out])
        enough = left < (1 - CRITERIA.explained) * total and p_value < _SIGNIFICANCE
        return p_value if enough else None

    def _with_table(self, model: LinearisedModel, table: Table) -> LinearisedModel:
        """Return the model with a table, refitted with its nuisances and effects."""
        tables = (*model.hypothesis.tables, table)
        hypothesis = replace(model.hypothesis, tables=tables)
        names = [mode_name(len(tables) - 1, j) for j in range(len(table.modes))]
        columns = {**model.columns, **self.measured.columns(hypothesis, names)}
        start = linearise(self.measured, hypothesis, columns, model.gap_map)
        return self.evaluator.refit(start, self.effects, renewed=())


def best_tables(one: BalanceProducts, points: np.ndarray) -> list[tuple[Table, float]]:
    """Return the best tables of a family over one quantity and over two, and their scores."""
    single, single_score = _best(one, _tables(one, 1), points, 0.0)
    pair, pair_score = _best(one, _tables(one, 2), points, single_score + CRITERIA.score)
    best = (single, single_score), (pair, pair_score)
    return [(table, score) for table, score in best if table]


def table_threshold(
    score: float, one: BalanceProducts, null: BalanceProducts, table: Table, points: np.ndarray
) -> float:
    """Return what the ``score`` of a table must exceed; ``null`` are residuals without it."""
    family = [*_tables(one, 1), *([table] if len(table.knots) > 1 else [])]

    def scores(signs: np.ndarray) -> list[np.ndarray]:
        return map_on_threads(lambda other: null.score(other, points, signs), family)

    return score_to_exceed(score, scores, int(points.max()) + 1, families=len(FAMILIES))


def _tables(one: BalanceProducts, count: int) -> list[Table]:
    """Return the empty tables of a family over ``count`` quantities."""
    targets = [target for target in TARGETS if balances_of(target) == one.balances]
    return [
        one.table(target, names, knots)
        for target in targets
        for names in combinations(target_quantities(target), count)
        for knots in (_OF_SENSOR if target == "position_sensor" else (ALONG_STROKE,))
    ]


def _best(
    one: BalanceProducts, tables: Iterable[Table], points: np.ndarray, least: float
) -> tuple[Table | None, float]:
    """Return the table with the largest score above ``least``, if any.

    Cross-validation is for tables whose gain at the points of the fit is not clearly less.
    """
    gains = map_on_threads(lambda table: (one.gain(table, points), table), tables)
    best, largest = None, least
    for gain, table in sorted(gains, key=lambda each: -each[0]):
        if gain <= largest - CRITERIA.score:
            break
        score = float(one.score(table, points)[0])
        if score > largest:
            best, largest = table, score
    return best, largest


def reductions(before: GapMap, after: GapMap, at: int = 0) -> np.ndarray:
    """Return ln of mean squares before over after (points,), in the balance with index ``at``.

    What a deviation of material size and the scatter of the trials contribute is added to both,
    so that a point without material residuals does not count.
    """
    material = 0.0 if before.material is None else before.material[at]
    least = (1 + material**2) * before.scatter[0, at] ** 2
    first, second = (_mean_squares(each, at) + least for each in (before, after))
    return np.log(first / second)


def is_worse(before: GapMap, after: GapMap, points: np.ndarray) -> bool:
    """Return whether the residuals of all balances together have grown at some points.

    Nuisances that are refitted with a law can disturb balances that the law does not touch.
    """
    left, total = (_excess(each, each.names, points) for each in (after, before))
    return left > total


def _mean_squares(residuals: GapMap, at: int) -> np.ndarray:
    """Return the mean square (points,) of a balance's residuals; 0 where none is compared."""
    squares = residuals.difference[:, at] ** 2
    known = np.isfinite(squares)
    points = len(residuals.points)
    sums = np.bincount(residuals.point[known], squares[known], minlength=points)
    return sums / np.maximum(np.bincount(residuals.point[known], minlength=points), 1)


def _excess(residuals: GapMap, balances: Sequence[str], points: np.ndarray) -> float:
    return max(residuals.mean_excess(balances, np.isin(residuals.point, points)), 0.0)


def sign_test(changes: np.ndarray) -> float:
    """Return the one-sided p-value of a mean above 0: the share of random signs as large."""
    signs = random_signs(_PERMUTATIONS, len(changes))
    return float(permutation_p(changes.sum(), signs @ changes))
