"""Test of the difference of two numbers, one of each campaign.

Trials are independent, so a difference d = sum_i w_i m_i of means over trials has

    se^2 = sum_i w_i^2 s_i^2 / n_i,    dof = se^4 / sum_i (w_i^2 s_i^2 / n_i)^2 / (n_i - 1)

(Welch, Satterthwaite). For the instruments: if both campaigns were measured with the same ones,
their errors are in both, and only the difference of the contributions counts; with different ones
both contributions count, as do those of a log's resolution in any case. Their degrees of freedom
are those of the uncertainty budget, combined with those of the trials by the same formula (JCGM
100, G.2b). A significant drift within a campaign has an independent part, ``sigma_drift_n`` of its
points, with their weights and signs.

In a mean over several curves, trials that were cut from one file, such as strokes out and back
(``summary/setups.py``), are not independent: of points that have the same set-ups, the weighted
sums of each trial count as one mean.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import stdtr

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.holm import holm
from hbench.analysis.statistics.student import satterthwaite, student_factor
from hbench.analysis.uncertainty.budget import (
    StandardUncertainty,
    combined,
    friction_contributions,
)
from hbench.analysis.uncertainty.input_errors import is_of_log
from hbench.config.sensors import Instruments
from hbench.records import Curve, Difference

Contributions = dict[str, StandardUncertainty]  # of the instruments' errors, with their signs
Terms = Sequence[tuple[float, Sequence[float]]]  # weight of a mean, and its trials

NO_SCATTER = "no scatter: a single trial"


class InstrumentPair(NamedTuple):
    """Instruments of both campaigns; None: not known."""

    a: Instruments | None
    b: Instruments | None
    same: bool  # whether their errors are the same in both campaigns

    @property
    def both(self) -> tuple[Instruments | None, Instruments | None]:
        """Those of A and of B."""
        return self.a, self.b

    @property
    def coverage(self) -> Instruments | None:
        """Those whose coverage factor a difference has; None, Student's, unless both agree."""
        if self.a is None or self.b is None or self.a.expansion != self.b.expansion:
            return None
        return self.a

    def parts(self, a: Contributions, b: Contributions) -> list[StandardUncertainty]:
        """Return the independent parts of the errors in B - A.

        ``a`` are the contributions to A with the sign that they have there, ``b`` those to B.
        """
        if not self.same:
            return [*a.values(), *b.values()]
        own = [part for side in (a, b) for name, part in side.items() if is_of_log(name)]
        common = weighted([(1.0, a), (1.0, b)])
        return [*own, *(part for name, part in common.items() if not is_of_log(name))]


def welch(terms: Terms) -> tuple[float, float] | None:
    """Return standard error and degrees of freedom of sum_i w_i mean(trials_i).

    None if a mean has fewer than two trials, or if no trials differ by more than rounding.
    """
    if any(len(trials) < 2 for _, trials in terms):
        return None
    variances = np.array([w**2 * np.var(trials, ddof=1) / len(trials) for w, trials in terms])
    se, dof = satterthwaite(variances, [len(trials) - 1 for _, trials in terms])
    size = sum(abs(w) * np.abs(trials).max() for w, trials in terms)
    return None if se <= ROUNDING * size else (se, dof)


class CampaignValue(NamedTuple):
    """A number of one campaign, with what is known of its errors."""

    value: float
    instruments: Contributions | None = None  # contributions of their errors; None: not known
    drift: float = 0.0  # standard uncertainty by a significant drift
    trials: tuple[float, float] | None = None  # standard error, and its degrees of freedom


def tested(
    a: CampaignValue,
    b: CampaignValue,
    se: float,
    dof: float,
    instruments: InstrumentPair,
) -> Difference:
    """Return the difference b - a with its interval and p value.

    ``se`` and ``dof`` are standard error and degrees of freedom of the difference by the trials.
    It has an expanded uncertainty if the instruments' contributions to both are known; a and b
    have one of their own if their ``trials`` are known too. The coverage factors are those that
    the files of the ``instruments`` ask for.
    """
    u95 = u95_a = u95_b = None
    if a.instruments is not None and b.instruments is not None:
        parts = [StandardUncertainty(se, dof), *map(StandardUncertainty, (a.drift, b.drift))]
        of_a = weighted([(-1.0, a.instruments)])
        parts += instruments.parts(of_a, b.instruments)
        u95 = combined(parts).expanded(instruments.coverage)
        u95_a, u95_b = (
            _own_u95(side.trials, side.instruments or {}, side.drift, known)
            for side, known in zip((a, b), instruments.both, strict=True)
        )
    return Difference(
        a=a.value,
        b=b.value,
        se=se,
        ci95=float(student_factor(dof) * se),
        u95=u95,
        p_value=float(2 * stdtr(dof, -abs(b.value - a.value) / se)),
        u95_a=u95_a,
        u95_b=u95_b,
        dof=dof,
    )


def _own_u95(
    error: tuple[float, float] | None,
    contributions: Contributions,
    drift: float,
    instruments: Instruments | None,
) -> float | None:
    """Return the expanded uncertainty of one campaign's number; None without scatter."""
    if error is None:
        return None
    parts = [StandardUncertainty(*error), StandardUncertainty(drift), *contributions.values()]
    return combined(parts).expanded(instruments)


class WeightedCurve(NamedTuple):
    """A curve of one campaign, with the weights of its points in a mean difference."""

    factor: float  # of all weights: negative for A, positive for B
    curve: Curve
    weights: Mapping[int, float]
    setups: Mapping[str, str]  # of the campaign's runs; a run without one has its own


def mean_with_test(value: float, curves: Iterable[WeightedCurve]) -> tuple[float, float] | None:
    """Return the half-width of the 95 % interval of a mean difference ``value``, and its p value.

    Both are those of the trials alone. None where a point has a single trial, or no scatter.
    """
    error = _mean_error(curves)
    if error is None:
        return None
    se, dof = error
    return float(student_factor(dof) * se), float(2 * stdtr(dof, -abs(value) / se))


def mean_u95(curves: Sequence[WeightedCurve], instruments: Instruments | None) -> float | None:
    """Return the expanded uncertainty of a mean of |F| over curves of one campaign.

    An instrument's error is the same in all curves: its contributions are added with their signs,
    which differ between the directions, before they are squared. None where a part is not known.
    """
    common = _common_errors(curves, instruments)
    return None if common is None else _own_u95(_mean_error(curves), *common, instruments)


def mean_difference_u95(
    curves: Sequence[WeightedCurve], instruments: InstrumentPair
) -> float | None:
    """Return the expanded uncertainty of a mean difference over curves of both campaigns.

    Errors are added as in ``mean_u95``; those of the same instruments have opposite signs in A and
    B. None where a part is not known.
    """
    error = _mean_error(curves)
    a, b = (
        _common_errors([each for each in curves if sign * each.factor > 0], known)
        for sign, known in zip((-1, 1), instruments.both, strict=True)
    )
    if error is None or a is None or b is None:
        return None
    parts = [StandardUncertainty(*error), *(StandardUncertainty(drift) for _, drift in (a, b))]
    parts += instruments.parts(a[0], b[0])
    return combined(parts).expanded(instruments.coverage)


def _common_errors(
    curves: Iterable[WeightedCurve], instruments: Instruments | None
) -> tuple[Contributions, float] | None:
    """Return the sums of instruments' errors and of drift over curves; None where not known."""
    if instruments is None:
        return None
    points = [(c, w, c.curve.points[i]) for c in curves for i, w in c.weights.items()]
    errors = [
        (
            c.factor * w * c.curve.against_motion,
            friction_contributions(point, c.curve.specimen, instruments),
        )
        for c, w, point in points
    ]
    if not all(contributions for _, contributions in errors):
        return None
    drift = sum(c.factor * w * (point.sigma_drift_n or 0.0) for c, w, point in points)
    return weighted(errors), drift


def _mean_error(curves: Iterable[WeightedCurve]) -> tuple[float, float] | None:
    """Return standard error and degrees of freedom of a mean over curves, by the trials alone."""
    sums: dict[tuple, np.ndarray] = {}
    for factor, curve, weights, setups in curves:
        for i, weight in weights.items():
            point = curve.points[i]
            order = np.argsort(point.trials)
            shared = frozenset(setups.get(run, f"run {run}") for run in point.runs)
            key = (factor > 0, shared, tuple(sorted(point.trials)))
            trials = factor * weight * curve.against_motion * np.array(point.trials_n)[order]
            sums[key] = sums.get(key, 0.0) + trials
    return welch([(1.0, trials.tolist()) for trials in sums.values()])


def untested(a: float, b: float, reason: str) -> Difference:
    """Return a difference without a test."""
    return Difference(a, b, None, None, None, None, untested=reason)


def corrected(differences: Sequence[Difference]) -> Iterator[Difference]:
    """Yield the differences of one kind with p values after Holm, if they have one."""
    p_values = [difference.p_value for difference in differences]
    after = iter(holm([p for p in p_values if p is not None]).tolist())
    for difference, p in zip(differences, p_values, strict=True):
        yield difference if p is None else replace(difference, p_holm=next(after))


def weighted(terms: Iterable[tuple[float, Contributions]]) -> Contributions:
    """Return the contributions to a weighted sum of points measured with the same instruments.

    An error has the same degrees of freedom at all points.
    """
    total: Contributions = {}
    for weight, contributions in terms:
        for name, part in contributions.items():
            before = total[name].value if name in total else 0.0
            total[name] = part._replace(value=before + weight * part.value)
    return total
