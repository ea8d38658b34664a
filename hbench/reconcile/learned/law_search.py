"""Search for learned laws where structured, material residuals remain that no effect explains.

For each balance that remains, tables over one and over two quantities are compared by their
cross-validated likelihood over the training points, as candidates are (``evidence.py``): a table
over two quantities must be better by 5 nats. The best is kept if

    its score exceeds 5 nats and the threshold of all tables with null data sets, which are its own
    residuals with random signs (``candidates.AcceptanceCriteria``),
    it explains more than a quarter of the excess gap of its balance at training points, and
    it reduces the residuals at held-out operating points: a permutation test with random signs of
    the points' logarithmic reductions has p < 0.05, which takes five points.

The last two are tested about the linearised model first, and again after the model is refitted with
the table. A learned law has no name, so it does not change the verdict.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from hbench.config.effects import QUANTITIES, TARGETS
from hbench.reconcile.candidates import CRITERIA, NULLS, CandidateEvaluator
from hbench.reconcile.evidence import random_signs
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.gaps.log_map import ranked_gaps
from hbench.reconcile.learned.balance_products import BalanceProducts, balance_products
from hbench.reconcile.learned.table import LawFound, Table, mode_name
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.measured.balances import BALANCES
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.verdict import unexplained_gaps

_MOST_LAWS = 4
_SIGNIFICANCE = 0.05  # of the reduction at held-out points
_PERMUTATIONS = 9999


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
        """Return the balance with the largest material gap at training points, if any."""
        residuals = model.gap_map.select_points(self.evaluator.train)
        residuals = replace(residuals, run=np.unique(residuals.run, return_inverse=True)[1])
        gaps = unexplained_gaps(ranked_gaps(residuals, np.zeros(len(BALANCES))))
        targets = {target.replace("friction", "force") for target in TARGETS}
        names = [gap.name for gap in gaps if gap.name in targets - refused]
        return names[0] if names else None

    def _add(self, model: LinearisedModel, balance: str) -> tuple[LinearisedModel, LawFound] | None:
        """Return the model with the best law of a balance, if it is kept."""
        one = balance_products(self.measured, model, balance, self.effects)
        points = self.evaluator.train
        table, gain = best_table(one, points)
        if table is None or gain <= CRITERIA.score:
            return None
        null = one.without(table, points)
        if self._p_value(one.residuals, null.residuals, 0) is None:
            return None
        threshold = score_to_exceed(one, null, table, points)
        if gain <= threshold:
            return None
        with_table = self._with_table(model, table)
        p_value = self._p_value(model.gap_map, with_table.gap_map, BALANCES.index(balance))
        if p_value is None:
            return None
        number = len(with_table.hypothesis.tables) - 1
        return with_table, LawFound(number, gain, threshold, p_value)

    def _p_value(self, before: GapMap, after: GapMap, at: int) -> float | None:
        """Return the p-value at held-out points; None if the reduction does not suffice.

        ``at`` is the index of the balance in the maps.
        """
        left, total = (_excess(each, at, self.evaluator.train) for each in (after, before))
        p_value = sign_test(reductions(before, after, at)[self.held_out])
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


def best_table(one: BalanceProducts, points: np.ndarray) -> tuple[Table | None, float]:
    """Return the best table of a balance and its score; None where none has a score above 0."""
    single, single_score = _best(one, _tables(one, 1), points, 0.0)
    pair, pair_score = _best(one, _tables(one, 2), points, single_score + CRITERIA.score)
    return (pair, pair_score) if pair else (single, single_score)


def score_to_exceed(
    one: BalanceProducts, null: BalanceProducts, table: Table, points: np.ndarray
) -> float:
    """Return the score that a table of a balance must exceed; ``null`` are residuals without it."""
    signs = random_signs(NULLS, int(points.max()) + 1, seed=1)
    largest = np.zeros(NULLS)
    for other in [*_tables(one, 1), *([table] if len(table.knots) > 1 else [])]:
        largest = np.maximum(largest, null.score(other, points, signs))
    return CRITERIA.threshold(largest, families=len(BALANCES))


def _tables(one: BalanceProducts, count: int) -> list[Table]:
    """Return the empty tables of a balance over ``count`` quantities."""
    quantities = [name for name in QUANTITIES if name != "opening" or one.balance in TARGETS[:4]]
    targets = [t for t in TARGETS if t.replace("friction", "force") == one.balance]
    return [one.table(t, names) for t in targets for names in combinations(quantities, count)]


def _best(
    one: BalanceProducts, tables: Iterable[Table], points: np.ndarray, least: float
) -> tuple[Table | None, float]:
    """Return the table with the largest score above ``least``, if any.

    Cross-validation is for tables whose gain at the points of the fit is not clearly less.
    """
    gains = [(one.gain(table, points), table) for table in tables]
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


def _mean_squares(residuals: GapMap, at: int) -> np.ndarray:
    """Return the mean square (points,) of a balance's residuals; 0 where none is compared."""
    squares = residuals.difference[:, at] ** 2
    known = np.isfinite(squares)
    points = len(residuals.points)
    sums = np.bincount(residuals.point[known], squares[known], minlength=points)
    return sums / np.maximum(np.bincount(residuals.point[known], minlength=points), 1)


def sign_test(changes: np.ndarray, seed: int = 0) -> float:
    """Return the one-sided p-value of a mean above 0: the share of random signs as large."""
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], (_PERMUTATIONS, len(changes)))
    largest = changes.sum() * (1 - 1e-9)
    return float((1 + (signs @ changes >= largest).sum()) / (1 + _PERMUTATIONS))


def _excess(residuals: GapMap, at: int, points: np.ndarray) -> float:
    chosen = residuals.select_points(points)
    return max(float(np.nanmean(chosen.excess[:, at])), 0.0)
