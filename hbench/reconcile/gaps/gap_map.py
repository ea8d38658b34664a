"""Gap between model and measurement, in units of the scatter of the trials.

Runs with the same plan are trials of one operating point. Measured trials r_1..r_n and simulated
ones q_1..q_k are compared window by window:

    d = mean r - mean q                         errors of the method itself cancel
    g^2 = 1 + mean of (d^2 - s^2/n - s_q^2/k) / s^2

s^2 is the variance between measured trials (pure error), s_q^2 that between simulated ones. The
noise of the means is subtracted, so a model that equals the expectation of the trials has g = 1:
its distance from a trial is that of another trial's expectation. sqrt(g^2 - 1) is the structured
part.

A single run differs by d_i = r_i - mean q, which includes its own scatter:

    g_i^2 = mean of (d_i^2 - s_q^2/k) / s^2

This is also 1 for a correct model. Over the trials of an operating point the mean of g_i^2 is g^2.

A variance of few trials is uncertain, so it is shrunk towards that of all windows by empirical
Bayes (Smyth, Stat. Appl. Genet. Mol. Biol. 3, 2004):
s^2 = (nu_0 s_0^2 + nu s^2) / (nu_0 + nu), with s_0 and nu_0 from the spread of ln s^2. The log's
rounding error is added where noise does not dither it.

p-values come from a permutation test: for a correct model, measured and simulated trials of an
operating point are exchangeable. Whole runs are exchanged at random 999 times, so the windows of a
run stay together.
"""

from collections import defaultdict
from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hbench.analysis.rounding import ROUNDING, ranked
from hbench.analysis.statistics.holm import holm
from hbench.analysis.statistics.permutations import permutation_p
from hbench.errors import DataError
from hbench.reconcile.measured.balances import WindowedRun
from hbench.records import Gap, RunPlan

PERMUTATIONS = 999
_NEGLIGIBLE_SPREAD = 1e-8  # of ln s^2, beyond chance: nu_0 of 1e8


@dataclass(frozen=True)
class RunLevel:
    """Level of one run in one balance that is not known, such as that of its friction."""

    windows: slice
    balance: int  # its index
    change: np.ndarray  # (m,) by one standard deviation of the level, in scatters
    ridge: float  # variance of the residuals, in squares of the scatter

    @property
    def square(self) -> float:
        """Sum of the squares of the change."""
        return float(self.change @ self.change)

    @property
    def unexpected(self) -> float:
        """Share of a level that is left where what is expected of it is taken out.

        With the covariance sigma^2 (1 + c c' / ridge), c the change, the residuals are white then.
        """
        return float(np.sqrt(self.ridge / (self.ridge + self.square)))


@dataclass(frozen=True)
class GapMap:
    """Differences of all compared windows, with their operating points: w windows, c names."""

    names: tuple[str, ...]
    difference: np.ndarray  # (w, c) d, in the balances' units; nan where not compared
    scatter: np.ndarray  # (w, c) s
    noise: np.ndarray  # (w, c) variance of d: s^2/n + s_q^2/k
    t_s: np.ndarray  # (w,) since the run's start
    x_m: np.ndarray  # (w,)
    v_m_s: np.ndarray  # (w,) signed by the direction
    load_n: np.ndarray  # (w,)
    point: np.ndarray  # (w,) index of the operating point
    points: tuple[Hashable, ...]  # keys of the operating points, see ``point_of``
    run: np.ndarray  # (w,) index of the run, or of the operating point for means of its runs
    levels: tuple[RunLevel, ...] = ()  # of runs
    white: np.ndarray | None = None  # (c,) share of s^2 that a window has for itself; None: unknown
    material: np.ndarray | None = None  # (c,) smaller deviations do not matter, in scatters

    @property
    def excess(self) -> np.ndarray:
        """(d^2 - noise) / s^2 (w, c); its mean is the square of the structured part."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return (self.difference**2 - self.noise) / self.scatter**2

    def in_units_of(self, other: "GapMap") -> "GapMap":
        """Return the same windows with the scatter of another map."""
        return replace(
            self,
            scatter=other.scatter,
            noise=other.noise,
            white=other.white,
            material=other.material,
            levels=other.levels,
        )

    def without_levels(self) -> "GapMap":
        """Return the map whose residuals have of each run's level what is not expected alone."""
        difference = self.difference.copy()
        for level in self.levels:
            own = level.windows, level.balance
            if level.square > 0.0:
                along = level.change @ np.nan_to_num(difference[own] / self.scatter[own])
                expected = (1 - level.unexpected) * along / level.square
                difference[own] -= expected * level.change * self.scatter[own]
        return replace(self, difference=difference)

    def select_points(self, points: np.ndarray) -> "GapMap":
        """Return the windows of the operating points with these indices."""
        selected = np.isin(self.point, points)
        rows = ("difference", "scatter", "noise", "t_s", "x_m", "v_m_s", "load_n", "point", "run")
        chosen = {name: getattr(self, name)[selected] for name in rows}
        return replace(self, **chosen, levels=())

    def at(self, points: Collection[Hashable]) -> np.ndarray:
        """Return whether each window (w,) is one of the operating points with these keys."""
        indices = [i for i, point in enumerate(self.points) if point in points]
        return np.isin(self.point, indices)

    def gaps(self, windows: np.ndarray) -> np.ndarray:
        """Return the gaps (c,) of the chosen windows (w,); nan where nothing is compared."""
        return gap_of(column_means(self.excess[windows]))

    def gap(self, balances: Collection[str], points: np.ndarray) -> float:
        """Return the gap over some balances together, at the operating points of these indices."""
        return float(gap_of(self.mean_excess(balances, np.isin(self.point, points))))

    def mean_excess(self, balances: Collection[str], windows: np.ndarray) -> float:
        """Return the mean excess over some balances together, in the chosen windows (w,).

        nan where nothing is compared.
        """
        chosen = self.excess[windows][:, np.isin(self.names, list(balances))]
        usable = np.isfinite(chosen)
        return float(np.where(usable, chosen, 0.0).sum() / (usable.sum() or np.nan))


def gap_of(mean_excess: ArrayLike) -> np.ndarray:
    """Return the gap of a mean excess, sqrt(1 + mean); 0 where that is below -1."""
    return np.sqrt(np.maximum(1 + np.asarray(mean_excess), 0.0))


def point_of(plan: RunPlan) -> Hashable:
    """Return the key of a run's operating point, equal for all its trials."""
    load = plan.f_load_n, plan.p_lr_ref_pa, plan.p_lp_ref_pa
    return plan.kind, plan.label, plan.v_ref_m_s, plan.a_ref_m_s2, load, plan.motion


def by_point(runs: Sequence[WindowedRun]) -> dict[Hashable, list[WindowedRun]]:
    """Return the trials of each operating point."""
    points: dict[Hashable, list[WindowedRun]] = defaultdict(list)
    for run in runs:
        points[point_of(run.plan)].append(run)
    return points


def stacked(trials: Sequence[WindowedRun], windows: int) -> np.ndarray:
    """Return the values (trials, windows, c) of the first windows."""
    return np.array([trial.values[:windows] for trial in trials])


def gaps(
    measured: Sequence[WindowedRun], simulated: Sequence[WindowedRun]
) -> tuple[tuple[Gap, ...], GapMap]:
    """Return the gaps of all names, largest first, and the map behind them.

    Operating points with fewer than two measured trials or without a simulated one are left out.
    Raises ``DataError`` where none remains.
    """
    pairs = _paired_trials(measured, simulated)
    differences = _gap_map(pairs)
    p_values = holm(_permutation_p_values(pairs, np.random.default_rng(0)))
    excess = differences.excess
    unordered = []
    for i, name in enumerate(differences.names):
        compared = np.isfinite(excess[:, i])
        if not compared.any():
            continue
        gap = float(gap_of(excess[compared, i].mean()))
        scatter = float(np.sqrt(np.mean(differences.scatter[compared, i] ** 2)))
        unordered.append(Gap(name, gap, float(p_values[i]), scatter, int(compared.sum())))
    return tuple(ranked(unordered, lambda balance: balance.gap, ROUNDING)), differences


def gap_map(measured: Sequence[WindowedRun], simulated: Sequence[WindowedRun]) -> GapMap:
    """Return the map of ``gaps`` alone. Raises ``DataError``."""
    return _gap_map(_paired_trials(measured, simulated))


def run_gaps(
    measured: Sequence[WindowedRun], simulated: Sequence[WindowedRun]
) -> dict[str, np.ndarray]:
    """Return the gaps (c,) of each measured run, by its id; nan where nothing was compared.

    Runs are left out as in ``gaps``. Raises ``DataError``.
    """
    pairs = _paired_trials(measured, simulated)
    differences = _gap_map(pairs)
    by_run = {}
    for number, (_, trials, r, q) in enumerate(pairs):
        windows = differences.select_points(np.array([number]))
        model_noise = windows.noise - windows.scatter**2 / len(r)
        for trial, values in zip(trials, r, strict=True):
            difference = values - q.mean(axis=0)
            with np.errstate(divide="ignore", invalid="ignore"):
                square = column_means((difference**2 - model_noise) / windows.scatter**2)
                by_run[trial.plan.run] = np.sqrt(np.maximum(square, 0.0))
    return by_run


def pooled_variance(variance: np.ndarray, dof: np.ndarray) -> np.ndarray:
    """Shrink variances (w,), with degrees of freedom ``dof`` (w,), towards their common prior.

    nan and zero do not contribute to the prior.
    """
    from scipy.special import digamma, polygamma

    usable = np.isfinite(variance) & (variance > 0)
    if usable.sum() < 3:
        return variance
    half = dof[usable] / 2
    log = np.log(variance[usable]) - digamma(half) + np.log(half)
    spread = log.var(ddof=1) - polygamma(1, half).mean()
    if spread <= _NEGLIGIBLE_SPREAD:  # no more than by chance: one common variance
        return np.where(np.isfinite(variance), np.exp(log.mean()), np.nan)
    half_prior = _inverse_trigamma(spread)
    prior = np.exp(log.mean() + digamma(half_prior) - np.log(half_prior))
    return (2 * half_prior * prior + dof * variance) / (2 * half_prior + dof)


def _inverse_trigamma(y: float) -> float:
    from scipy.optimize import brentq
    from scipy.special import polygamma

    return float(np.exp(brentq(lambda ln: np.log(polygamma(1, np.exp(ln)) / y), -20, 20)))


def column_means(values: np.ndarray) -> np.ndarray:
    """Return the means (c,) of the finite values in each column of (w, c); nan without any."""
    usable = np.isfinite(values)
    count = np.where(usable.any(axis=0), usable.sum(axis=0), np.nan)
    return np.where(usable, values, 0.0).sum(axis=0) / count


class _Pair(NamedTuple):
    point: Hashable
    trials: list[WindowedRun]  # measured
    r: np.ndarray  # (n, m, c) measured
    q: np.ndarray  # (k, m, c) simulated


def _paired_trials(
    measured: Sequence[WindowedRun], simulated: Sequence[WindowedRun]
) -> list[_Pair]:
    simulated_by_point, pairs = by_point(simulated), []
    for point, trials in by_point(measured).items():
        others = simulated_by_point.get(point, [])
        if len(trials) < 2 or not others:
            continue
        windows = min(len(trial.t_s) for trial in (*trials, *others))
        pairs.append(_Pair(point, trials, stacked(trials, windows), stacked(others, windows)))
    if not pairs:
        raise DataError(
            "no operating point has two measured trials and a simulated one",
            "Set `trials` in the schedule to 2 or more.",
        )
    return pairs


def _gap_map(pairs: Sequence[_Pair]) -> GapMap:
    variance = np.concatenate([pair.r.var(axis=0, ddof=1) for pair in pairs])
    variance = np.where(variance <= _rounding_variance(pairs), 0.0, variance)
    dof = np.concatenate([np.full(pair.r.shape[1], len(pair.r) - 1.0) for pair in pairs])
    first = pairs[0].trials[0]
    pooled = np.column_stack([pooled_variance(column, dof) for column in variance.T])
    pooled = pooled + first.resolution**2
    n = np.concatenate([np.full((pair.r.shape[1], 1), len(pair.r)) for pair in pairs])
    model_noise = [
        pair.q.var(axis=0, ddof=1) / len(pair.q) if len(pair.q) > 1 else np.zeros(pair.q.shape[1:])
        for pair in pairs
    ]

    def operating(name: str) -> np.ndarray:
        """Return the mean over the trials of each window's coordinate."""
        return np.concatenate(
            [
                np.mean([getattr(trial, name)[: pair.r.shape[1]] for trial in pair.trials], axis=0)
                for pair in pairs
            ]
        )

    return GapMap(
        names=first.names,
        difference=np.concatenate([pair.r.mean(axis=0) - pair.q.mean(axis=0) for pair in pairs]),
        scatter=np.sqrt(pooled),
        noise=pooled / n + np.concatenate(model_noise),
        t_s=operating("t_s"),
        x_m=operating("x_m"),
        v_m_s=operating("v_m_s"),
        load_n=operating("load_n"),
        point=(point := np.repeat(np.arange(len(pairs)), [pair.r.shape[1] for pair in pairs])),
        points=tuple(pair.point for pair in pairs),
        run=point,
    )


def _rounding_variance(pairs: Sequence[_Pair]) -> np.ndarray:
    """Return the largest variance (c,) that rounding errors of the measured values can cause."""
    return (ROUNDING * np.max([_largest(pair.r) for pair in pairs], axis=0)) ** 2


def _largest(values: np.ndarray) -> np.ndarray:
    return np.abs(np.nan_to_num(values, posinf=0.0, neginf=0.0)).max(axis=(0, 1), initial=0.0)


def _permutation_p_values(pairs: Sequence[_Pair], rng: np.random.Generator) -> np.ndarray:
    """Return p-values (c,): the share of permutations with a statistic at least as large.

    The statistic is the sum of d^2 over the variance of all trials, which is invariant.
    """
    count, negligible = pairs[0].r.shape[-1], _rounding_variance(pairs)
    observed, exchanged = np.zeros(count), np.zeros((PERMUTATIONS, count))
    for _, _, r, q in pairs:
        both = np.concatenate([r, q])
        total = both.var(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            # Products of whole runs (n + k, n + k, c): each d^2 is a quadratic form of the labels.
            scaled = np.nan_to_num((both - both.mean(axis=0)) / np.sqrt(total), posinf=0, neginf=0)
        scaled = np.where(total <= negligible, 0.0, scaled)
        products = np.einsum("iwc,jwc->ijc", scaled, scaled)
        labels = np.concatenate([np.full(len(r), 1 / len(r)), np.full(len(q), -1 / len(q))])
        orders = rng.permuted(np.tile(labels, (PERMUTATIONS, 1)), axis=1)
        observed = observed + np.einsum("i,j,ijc->c", labels, labels, products)
        exchanged = exchanged + np.einsum("ei,ej,ijc->ec", orders, orders, products, optimize=True)
    return permutation_p(observed, exchanged)
