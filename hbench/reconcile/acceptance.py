"""Acceptance of candidate effects: thresholds of scores, least shares and sizes, and rivals."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.statistics.permutations import random_signs
from hbench.model.effects.catalogue import EFFECTS
from hbench.records import Candidate
from hbench.records.reconcile.diagnosis import LEAST_EXPLAINED, LEAST_SIZE

TIE = 1e-6  # nats: candidates whose scores differ by rounding keep the catalogue's order
NULLS = 50  # random null data sets
_FEW_NULLS = 10  # suffice where a score is far from the threshold that they alone give
_FAR = 3.0  # times as large or as small
_FALSE = 0.05  # probability that a round of a search accepts an effect where none is missing
_AMBIGUOUS_NATS, _AMBIGUOUS_SHARE = 3.0, 0.1  # of the best score; the larger one counts
ALIKE = 2.0  # times this margin, for effects that the runs are not expected to distinguish


@dataclass(frozen=True)
class AcceptanceCriteria:
    """Least score, explained share and size of an effect that may be added to a model."""

    score: float  # nats: least threshold
    explained: float  # share of the excess gap in the balances that the effect touches
    size: float  # largest coefficient, in typical sizes

    def accepts(self, candidate: Candidate) -> bool:
        """Return whether a candidate exceeds its own threshold and meets the other criteria."""
        return (
            candidate.score > candidate.threshold
            and candidate.explained > self.explained
            and candidate.size >= self.size
        )


# 5 nats are odds of 150 to 1. A quarter is enough: the remainder may be other effects.
CRITERIA = AcceptanceCriteria(score=5.0, explained=LEAST_EXPLAINED, size=LEAST_SIZE)
SMALL = replace(CRITERIA, size=1e-3)  # of effects that may be too small to be named


def ambiguity_margin(best: float) -> float:
    """Return the distance [nats] from the ``best`` score within which scores are close to it."""
    return max(_AMBIGUOUS_NATS, _AMBIGUOUS_SHARE * best)


def may_be_rival(candidate: Candidate, best: Candidate) -> bool:
    """Return whether a candidate is a rival of the ``best`` one, if the runs show them alike.

    An effect on other balances is no rival: it explains something else.
    """
    return _is_within(ALIKE, candidate, best) and not set(EFFECTS[best.name].balances).isdisjoint(
        EFFECTS[candidate.name].balances
    )


def indistinguishable(
    accepted: Sequence[Candidate], alike: Collection[str] = ()
) -> tuple[Candidate, ...]:
    """Return the first candidate, the best one, and its rivals, whose scores are close to its own.

    Those of ``alike``, effects that the runs are not expected to distinguish from the best one, may
    be twice as far from it: what decides then is chance, or what the model neglects.
    """
    best = accepted[0]
    return tuple(
        each
        for each in accepted
        if may_be_rival(each, best) and (each.name in alike or _is_within(1.0, each, best))
    )


def threshold_of(null_scores: np.ndarray, families: int) -> float:
    """Return the threshold of null data sets alone.

    ``null_scores`` (n,) are the largest scores of a family of candidates on them. A further one
    exceeds the threshold with a probability of 5 % divided by the number of ``families`` in a round
    (Bonferroni). The tail above the median is taken as exponential, as that of a gain in ln L is
    (Wilks); with k scores above it the predictive distribution is
    P(excess > t) = (1 + t / (k mean))^-k.
    """
    median = float(np.median(null_scores))
    above = null_scores[null_scores > median] - median
    odds = (0.5 * families / _FALSE) ** (1 / max(len(above), 1))
    return median + float(above.sum()) * (odds - 1)


def _is_within(count: float, candidate: Candidate, best: Candidate) -> bool:
    return candidate.score >= best.score - count * ambiguity_margin(best.score)


def score_to_exceed(
    score: float,
    scores_on_nulls: Callable[[np.ndarray], Sequence[np.ndarray]],
    points: int,
    families: int,
) -> float:
    """Return what a ``score`` must exceed: the threshold of a family of candidates, 5 nats or more.

    ``scores_on_nulls`` returns the scores (b,) of each candidate for random signs (b, ``points``).
    """
    largest = np.empty(0)
    for signs in np.split(random_signs(NULLS, points, seed=1), [_FEW_NULLS]):
        of_these = np.max(scores_on_nulls(signs), axis=0, initial=0.0)
        largest = np.append(largest, of_these)
        threshold = threshold_of(largest, families)
        if not threshold / _FAR < score < threshold * _FAR:
            break
    return max(CRITERIA.score, threshold)
