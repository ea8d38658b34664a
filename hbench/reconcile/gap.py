"""How far model and measurement are apart, in units of the trials' own scatter.

Runs with the same plan are trials of one operating point. Measured trials r_1..r_n and simulated
ones q_1..q_k are compared window by window:

    d = mean r - mean q                         the pipeline's own residual cancels
    g^2 = 1 + mean of (d^2 - s^2/n - s_q^2/k) / s^2

s^2 is the variance between measured trials (pure error), s_q^2 that between simulated ones. Noise
of the means is subtracted, so a model that is the trials' expectation has g = 1: it is as far from
a trial as another trial's expectation is. sqrt(g^2 - 1) is the structured part.

A single run is off by d_i = r_i - mean q, with its own scatter in it:

    g_i^2 = mean of (d_i^2 - s_q^2/k) / s^2

It is 1 too where the model is right; over an operating point's trials the mean of g_i^2 is g^2.

A variance of few trials is uncertain, so it is drawn towards that of all windows by empirical Bayes
(Smyth, Stat. Appl. Genet. Mol. Biol. 3, 2004): s^2 = (nu_0 s_0^2 + nu s^2) / (nu_0 + nu), with
s_0 and nu_0 from the spread of ln s^2. The log's rounding adds to it where it is no noise.

p-values: were the model right, measured and simulated trials of an operating point could be
exchanged. So whole runs change places at random, 999 times; windows of a run stay together.
"""

from collections import defaultdict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hbench.analysis.rounding import ROUNDING, ranked
from hbench.analysis.statistics.holm import holm
from hbench.errors import DataError
from hbench.reconcile.measured.balances import Windowed
from hbench.records import Gap, RunPlan

_EXCHANGES = 999
_CHANCE = 1e-8  # spread of ln s^2 that is none: nu_0 of 1e8


@dataclass(frozen=True)
class GapMap:
    """Every window that was compared, with its operating point: w windows, c names."""

    names: tuple[str, ...]
    difference: np.ndarray  # (w, c) d, in the names' units; nan where not compared
    scatter: np.ndarray  # (w, c) s
    noise: np.ndarray  # (w, c) s^2/n + s_q^2/k, that of d
    t_s: np.ndarray  # (w,) since the run's start
    x_m: np.ndarray  # (w,)
    v_m_s: np.ndarray  # (w,) signed: its sign is the direction
    load_n: np.ndarray  # (w,)
    point: np.ndarray  # (w,) number of the operating point
    points: tuple[Hashable, ...]  # their names, see ``point_of``

    @property
    def excess(self) -> np.ndarray:
        """(d^2 - noise) / s^2 (w, c): its mean is the square of the structured part."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return (self.difference**2 - self.noise) / self.scatter**2

    def at(self, points: np.ndarray) -> "GapMap":
        """Return the windows of some operating points, told by their numbers."""
        own = np.isin(self.point, points)
        rows = ("difference", "scatter", "noise", "t_s", "x_m", "v_m_s", "load_n", "point")
        return replace(self, **{name: getattr(self, name)[own] for name in rows})

    def over(self, bins: np.ndarray) -> np.ndarray:
        """Return gaps (b, c) of the windows in each of the bins 0..b-1 that ``bins`` (w,) tells.

        nan where a bin has no windows; a negative number is in no bin.
        """
        excess = self.excess
        gaps = np.full((int(bins.max()) + 1, len(self.names)), np.nan)
        for number in np.unique(bins[bins >= 0]):
            own = excess[bins == number]
            some = np.isfinite(own).any(axis=0)
            gaps[number, some] = _gap(own[:, some])
        return gaps


def point_of(plan: RunPlan) -> Hashable:
    """Return what makes runs trials of one operating point."""
    load = plan.f_load_n, plan.p_lr_ref_pa, plan.p_lp_ref_pa
    return plan.kind, plan.label, plan.v_ref_m_s, plan.a_ref_m_s2, load, plan.motion


def by_point(runs: Sequence[Windowed]) -> dict[Hashable, list[Windowed]]:
    """Return the trials of each operating point."""
    points: dict[Hashable, list[Windowed]] = defaultdict(list)
    for run in runs:
        points[point_of(run.plan)].append(run)
    return points


def stacked(trials: Sequence[Windowed], windows: int) -> np.ndarray:
    """Return the values (trials, windows, c) of the first windows."""
    return np.array([trial.values[:windows] for trial in trials])


def gaps(
    measured: Sequence[Windowed], modelled: Sequence[Windowed], seed: int = 0
) -> tuple[tuple[Gap, ...], GapMap]:
    """Return the gaps of all names, the largest first, and the map behind them.

    Operating points with fewer than two measured trials, or none simulated, take no part. Raises
    ``DataError`` where none is left.
    """
    pairs = _pairs(measured, modelled)
    found = _map(pairs)
    p_values = holm(_exchange(pairs, np.random.default_rng(seed)))
    excess = found.excess
    worst = []
    for i, name in enumerate(found.names):
        own = np.isfinite(excess[:, i])
        if not own.any():
            continue
        gap = float(_gap(excess[own, i]))
        scatter = float(np.sqrt(np.mean(found.scatter[own, i] ** 2)))
        structured = float(np.sqrt(max(gap**2 - 1, 0.0)))
        worst.append(Gap(name, gap, structured, float(p_values[i]), scatter, int(own.sum())))
    return tuple(ranked(worst, lambda one: one.gap, ROUNDING)), found


def differences(measured: Sequence[Windowed], modelled: Sequence[Windowed]) -> GapMap:
    """Return the map of ``gaps`` alone. Raises ``DataError``."""
    return _map(_pairs(measured, modelled))


def gaps_of_runs(
    measured: Sequence[Windowed], modelled: Sequence[Windowed]
) -> dict[str, np.ndarray]:
    """Return the gaps (c,) of each measured run, by its id; nan where nothing was compared.

    Runs are left out as in ``gaps``. Raises ``DataError``.
    """
    pairs = _pairs(measured, modelled)
    found = _map(pairs)
    single = {}
    for number, (_, trials, r, q) in enumerate(pairs):
        own = found.at(np.array([number]))
        of_model = own.noise - own.scatter**2 / len(r)
        for trial, values in zip(trials, r, strict=True):
            off = values - q.mean(axis=0)
            with np.errstate(divide="ignore", invalid="ignore"):
                square = column_means((off**2 - of_model) / own.scatter**2)
                single[trial.plan.run] = np.sqrt(np.maximum(square, 0.0))
    return single


def pooled_variance(variance: np.ndarray, dof: np.ndarray) -> np.ndarray:
    """Draw variances (w,), each with its degrees of freedom (w,), towards one another.

    nan and zero take no part in what they are drawn to.
    """
    from scipy.special import digamma, polygamma

    usable = np.isfinite(variance) & (variance > 0)
    if usable.sum() < 3:
        return variance
    half = dof[usable] / 2
    log = np.log(variance[usable]) - digamma(half) + np.log(half)
    spread = log.var(ddof=1) - polygamma(1, half).mean()
    if spread <= _CHANCE:  # no more than chance: all are the same
        return np.where(np.isfinite(variance), np.exp(log.mean()), np.nan)
    half_prior = _inverse_trigamma(spread)
    prior = np.exp(log.mean() + digamma(half_prior) - np.log(half_prior))
    return (2 * half_prior * prior + dof * variance) / (2 * half_prior + dof)


def _inverse_trigamma(y: float) -> float:
    from scipy.optimize import brentq
    from scipy.special import polygamma

    return float(np.exp(brentq(lambda ln: np.log(polygamma(1, np.exp(ln)) / y), -20, 20)))


def column_means(values: np.ndarray) -> np.ndarray:
    """Return the means (c,) of what is finite in each column of (w, c); nan where nothing is."""
    usable = np.isfinite(values)
    count = np.where(usable.any(axis=0), usable.sum(axis=0), np.nan)
    return np.where(usable, values, 0.0).sum(axis=0) / count


def _gap(excess: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(1 + np.nanmean(excess, axis=0), 0.0))


class _Pair(NamedTuple):
    point: Hashable
    trials: list[Windowed]  # measured
    r: np.ndarray  # (n, m, c) measured
    q: np.ndarray  # (k, m, c) simulated


def _pairs(measured: Sequence[Windowed], modelled: Sequence[Windowed]) -> list[_Pair]:
    simulated, pairs = by_point(modelled), []
    for point, trials in by_point(measured).items():
        others = simulated.get(point, [])
        if len(trials) < 2 or not others:
            continue
        windows = min(len(one.t_s) for one in (*trials, *others))
        pairs.append(_Pair(point, trials, stacked(trials, windows), stacked(others, windows)))
    if not pairs:
        raise DataError(
            "no operating point has two measured trials and a simulated one to compare with",
            "Give the schedule two trials or more.",
        )
    return pairs


def _map(pairs: Sequence[_Pair]) -> GapMap:
    variance = np.concatenate([pair.r.var(axis=0, ddof=1) for pair in pairs])
    variance = np.where(variance <= _of_rounding(pairs), 0.0, variance)
    dof = np.concatenate([np.full(pair.r.shape[1], len(pair.r) - 1.0) for pair in pairs])
    first = pairs[0].trials[0]
    pooled = np.column_stack([pooled_variance(own, dof) for own in variance.T])
    pooled = pooled + first.resolution**2
    n = np.concatenate([np.full((pair.r.shape[1], 1), len(pair.r)) for pair in pairs])
    of_model = [
        pair.q.var(axis=0, ddof=1) / len(pair.q) if len(pair.q) > 1 else np.zeros(pair.q.shape[1:])
        for pair in pairs
    ]

    def operating(name: str) -> np.ndarray:
        """Mean over the trials of each window's coordinate."""
        return np.concatenate(
            [
                np.mean([getattr(one, name)[: pair.r.shape[1]] for one in pair.trials], axis=0)
                for pair in pairs
            ]
        )

    return GapMap(
        names=first.names,
        difference=np.concatenate([pair.r.mean(axis=0) - pair.q.mean(axis=0) for pair in pairs]),
        scatter=np.sqrt(pooled),
        noise=pooled / n + np.concatenate(of_model),
        t_s=operating("t_s"),
        x_m=operating("x_m"),
        v_m_s=operating("v_m_s"),
        load_n=operating("load_n"),
        point=np.repeat(np.arange(len(pairs)), [pair.r.shape[1] for pair in pairs]),
        points=tuple(pair.point for pair in pairs),
    )


def _of_rounding(pairs: Sequence[_Pair]) -> np.ndarray:
    """Return the variance (c,) that is rounding, beside the largest measured values."""
    return (ROUNDING * np.max([_largest(pair.r) for pair in pairs], axis=0)) ** 2


def _largest(values: np.ndarray) -> np.ndarray:
    return np.abs(np.nan_to_num(values, posinf=0.0, neginf=0.0)).max(axis=(0, 1), initial=0.0)


def _exchange(pairs: Sequence[_Pair], rng: np.random.Generator) -> np.ndarray:
    """Return p-values (c,): how often exchanged trials are as far apart.

    The sum of d^2 over the variance of all trials, which the exchange does not change.
    """
    observed, exchanged, nothing = 0.0, 0.0, _of_rounding(pairs)
    for _, _, r, q in pairs:
        both = np.concatenate([r, q])
        total = both.var(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            # Products of whole runs (n + k, n + k, c): every d^2 is a quadratic form of the labels.
            scaled = np.nan_to_num((both - both.mean(axis=0)) / np.sqrt(total), posinf=0, neginf=0)
        scaled = np.where(total <= nothing, 0.0, scaled)
        products = np.einsum("iwc,jwc->ijc", scaled, scaled)
        labels = np.concatenate([np.full(len(r), 1 / len(r)), np.full(len(q), -1 / len(q))])
        orders = rng.permuted(np.tile(labels, (_EXCHANGES, 1)), axis=1)
        observed = observed + np.einsum("i,j,ijc->c", labels, labels, products)
        exchanged = exchanged + np.einsum("ei,ej,ijc->ec", orders, orders, products, optimize=True)
    return (1 + np.sum(exchanged >= observed * (1 - 1e-9), axis=0)) / (1 + _EXCHANGES)
