"""How well changes of a model explain what its balances lack, on operating points left out.

Around one model the differences d of a window (see ``gap.py``) are linear in what may change:

    d ~ sum beta_j c_j        c_j: the column of nuisance or coefficient j, like d in trial scatters

Windows fall into groups: a balance, and how the bench moves (rest, steady, unsteady). What a model
lacks besides has in each group a variance v_g of its own, that is not known beforehand and stays
the same within a run; so an operating point counts once:

    ln L = - sum_g n_g / 2 ln v_g - |(beta - b) / prior|^2 / 2,    v_g = mean of (d - beta c)^2

n_g is the number of operating points in the group. v_g is not taken for less than the noise of d.
The maximum is found by weighted least squares with weights n_g / v_g, a few times over.

The score of a candidate is its gain in ln L on operating points that its fit has not seen: each of
five folds is predicted by the others. Nulls are differences with the sign of each operating point
drawn at random, which keeps their sizes and whatever holds within a run. A candidate's are those
that it leaves itself: what it does not explain, however large it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

FOLDS = 5
_ROUNDS = 6  # of reweighting
_SOLVES = 3  # with more and more parameters held at their bounds
_HARD = 1e9  # weight that holds a parameter at its bound


@dataclass(frozen=True)
class Products:
    """Sums of products over the windows of each operating point and group: p, g; q columns."""

    names: tuple[str, ...]  # (q,) of the columns
    columns: np.ndarray  # (p, g, q, q)
    mixed: np.ndarray  # (p, g, q) with d
    squares: np.ndarray  # (p, g) of d
    noise: np.ndarray  # (p, g) what the squares of d's noise sum up to
    windows: np.ndarray  # (p, g) their number
    groups: tuple[tuple[str, str], ...]  # (g,) balance and motion


@dataclass(frozen=True)
class Freedom:
    """What the columns may be multiplied by: each has a prior and bounds."""

    centre: np.ndarray  # (q,)
    prior: np.ndarray  # (q,) standard deviation
    low: np.ndarray  # (q,)
    high: np.ndarray  # (q,)

    def of(self, chosen: Sequence[int]) -> "Freedom":
        """Return that of some columns."""
        return Freedom(*(np.asarray(one)[list(chosen)] for one in self._all()))

    def _all(self) -> tuple[np.ndarray, ...]:
        return self.centre, self.prior, self.low, self.high


def fit(
    data: Products,
    free: Freedom,
    chosen: Sequence[int],
    points: np.ndarray,
    signs: np.ndarray | None = None,
) -> np.ndarray:
    """Return the most likely beta (b, chosen) over some ``points``; ``signs`` (b, p) are nulls'."""
    own, sums = free.of(chosen), _summed(data, chosen, points, signs)
    settled = _settled(sums, own, np.broadcast_to(sums.noise, (len(sums.mixed), len(sums.noise))))
    centre = np.tile(np.clip(own.centre, own.low, own.high), (len(sums.mixed), 1))
    other = _settled(sums, own, sums.variance(centre))
    better = _cost(sums, own, other) < _cost(sums, own, settled)
    return np.where(better[:, None], other, settled)


def cost(data: Products, free: Freedom, chosen: Sequence[int], points: np.ndarray) -> float:
    """Return - ln L of a model as it is, less a constant: at beta = 0 of what is ``chosen``."""
    sums = _summed(data, chosen, points, None)
    return float(_cost(sums, free.of(chosen), np.zeros((1, len(chosen))))[0])


def _cost(sums: "_Sums", own: Freedom, beta: np.ndarray) -> np.ndarray:
    """Return - ln L (b,) of beta (b, q), less a constant."""
    off = (beta - own.centre) / own.prior
    return 0.5 * (np.log(sums.variance(beta)) @ sums.points + np.sum(off**2, axis=1))


def _settled(sums: "_Sums", own: Freedom, variance: np.ndarray) -> np.ndarray:
    """Return beta (b, q) after some rounds that begin with the groups' variances (b, g).

    ln L has several maxima: a group that one beta fits well then outweighs the others. Those that
    begin with the noise let what stands out most speak first.
    """
    for _ in range(_ROUNDS):
        weight = sums.points / (sums.windows * variance)
        curved = np.einsum("bg,gjk->bjk", weight, sums.columns)
        driven = np.einsum("bg,bgj->bj", weight, sums.mixed)
        beta = np.zeros_like(driven)
        held = np.zeros_like(driven, bool)
        for _ in range(
            _SOLVES
        ):  # those beyond their bounds are held there, the others solved again
            stiff = np.where(held, _HARD * (1 + _diagonal(curved)), own.prior**-2.0)
            aim = np.where(held, beta, own.centre)
            matrix = curved + stiff[:, :, None] * np.eye(len(own.prior))
            beta = np.linalg.solve(matrix, (driven + stiff * aim)[..., None])[..., 0]
            held |= (beta < own.low) | (beta > own.high)
            beta = np.clip(beta, own.low, own.high)
            if not held.any():
                break
        variance = sums.variance(beta)
    return beta


def intervals(
    data: Products, free: Freedom, chosen: Sequence[int], beta: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the covariance (q, q) of ``beta`` (q,) and each one's degrees of freedom (q,).

    Over whole operating points (a sandwich), which is narrow where they are few: of drawn 95 %
    intervals 91 % held the truth, with 12 and with 40 points. A variance is not taken for less than
    what the curvature of ln L tells. Degrees of freedom are the operating points that tell the
    parameter.
    """
    own, sums = free.of(chosen), _summed(data, chosen, points, None)
    weight = (sums.points / (sums.windows * sums.variance(beta[None])))[0]
    told = np.einsum("g,gjj->gj", weight, sums.columns)
    inverse = np.linalg.inv(np.einsum("g,gjk->jk", weight, sums.columns) + np.diag(own.prior**-2.0))
    some = np.ix_(points, np.arange(len(weight)), np.array(chosen, dtype=int))
    columns = data.columns[points][..., list(chosen), :][..., list(chosen)]
    left = data.mixed[some] - columns @ beta
    slope = np.einsum("g,pgj->pj", weight, left)
    meat = slope.T @ slope * len(points) / max(len(points) - 1, 1) + np.diag(own.prior**-2.0)
    spread = inverse @ meat @ inverse
    wider = np.sqrt(np.maximum(np.diag(inverse) / np.diag(spread), 1.0))
    share = told / np.maximum(told.sum(axis=0), 1e-300)
    return spread * np.outer(wider, wider), np.maximum(share.T @ sums.points - 1, 1.0)


def score(
    data: Products,
    free: Freedom,
    base: Sequence[int],
    more: Sequence[int],
    points: np.ndarray,
    signs: np.ndarray | None = None,
) -> np.ndarray:
    """Return how much ln L grows (b,) on points left out, when ``more`` columns join ``base``."""
    part, own, joined, groups = _touched(data, base, more)
    if signs is not None and signs.ndim == 3:
        signs = signs[:, :, groups]
    before = log_likelihood(left_out(part, free, own, points, signs))
    return log_likelihood(left_out(part, free, joined, points, signs)) - before


def _touched(
    data: Products, base: Sequence[int], more: Sequence[int]
) -> tuple[Products, list[int], list[int], np.ndarray]:
    """Return the groups that ``more`` columns show in, or share a column with: others cancel."""
    shown = np.einsum("pgjj->gj", data.columns) > 0  # (g, q)
    groups = shown[:, list(more)].any(axis=1)
    shared = [j for j in base if shown[groups, j].any()]
    groups |= shown[:, shared].any(axis=1)
    part = replace(
        data,
        **{
            name: getattr(data, name)[:, groups]
            for name in ("columns", "mixed", "squares", "noise", "windows")
        },
        groups=tuple(one for one, own in zip(data.groups, groups, strict=True) if own),
    )
    return part, shared, [*shared, *more], groups


@dataclass(frozen=True)
class LeftOut:
    """What is left of d at points that the fit had not seen, by group."""

    variance: np.ndarray  # (b, g) mean square over the windows, in trial scatters
    noise: np.ndarray  # (g,) of it
    points: np.ndarray  # (g,)
    windows: np.ndarray  # (g,)


def left_out(
    data: Products,
    free: Freedom,
    chosen: Sequence[int],
    points: np.ndarray,
    signs: np.ndarray | None = None,
) -> LeftOut:
    """Predict each fold of the operating points by a fit to the others."""
    total = np.zeros(1)
    for number in range(min(FOLDS, len(points))):
        out = np.arange(len(points)) % FOLDS == number
        beta = fit(data, free, chosen, points[~out], signs)
        sums = _summed(data, chosen, points[out], signs)
        total = total + sums.squares_left(beta)
    whole = _summed(data, chosen, points, signs)
    return LeftOut(total / whole.windows, whole.noise, whole.points, whole.windows)


def log_likelihood(left: LeftOut) -> np.ndarray:
    """Return ln L (b,) less a constant; no group is known better than its noise."""
    return -0.5 * np.sum(left.points * np.log(np.maximum(left.variance, left.noise)), axis=-1)


def rotated(data: Products, count: int, seed: int) -> np.ndarray:
    """Return factors (count, points, groups) on d for nulls of few points with a window each.

    d of each group is turned at random: it keeps its length over the points, as in Langsrud's
    rotation tests (Statistics and Computing 15, 2005). Signs of few points have few patterns.
    """
    turned = np.random.default_rng(seed).standard_normal((count, *data.squares.shape))
    turned *= np.sqrt(data.squares.sum(axis=0) / np.sum(turned**2, axis=1))[:, None]
    return turned / np.sqrt(np.maximum(data.squares, 1e-30))


def random_signs(count: int, points: int, seed: int) -> np.ndarray:
    """Return signs (count, points) for nulls."""
    return np.random.default_rng(seed).choice([-1.0, 1.0], (count, points))


@dataclass(frozen=True)
class _Sums:
    """Products summed over some points."""

    columns: np.ndarray  # (g, q, q)
    mixed: np.ndarray  # (b, g, q)
    squares: np.ndarray  # (g,) or (b, g)
    noise: np.ndarray  # (g,) a window
    windows: np.ndarray  # (g,), 1 where there are none
    points: np.ndarray  # (g,)

    def squares_left(self, beta: np.ndarray) -> np.ndarray:
        """Return sums (b, g) of (d - beta c)^2."""
        crossed = np.einsum("bj,bgj->bg", beta, self.mixed)
        curved = np.einsum("bj,gjk,bk->bg", beta, self.columns, beta, optimize=True)
        return np.maximum(self.squares - 2 * crossed + curved, 0.0)

    def variance(self, beta: np.ndarray) -> np.ndarray:
        return np.maximum(self.squares_left(beta) / self.windows, self.noise)


def _summed(
    data: Products, chosen: Sequence[int], points: np.ndarray, signs: np.ndarray | None
) -> _Sums:
    some = np.ix_(points, np.arange(data.mixed.shape[1]), np.array(chosen, dtype=int))
    windows = data.windows[points].sum(axis=0)
    mixed, squares = data.mixed[some], data.squares[points].sum(axis=0)
    if signs is None:
        mixed = mixed.sum(axis=0)[None]
    elif signs.ndim == 2:
        mixed = np.einsum("bp,pgj->bgj", signs[:, points], mixed)
    else:
        mixed = np.einsum("bpg,pgj->bgj", signs[:, points], mixed)
        squares = np.einsum("bpg,pg->bg", signs[:, points] ** 2, data.squares[points])
    columns = data.columns[points].sum(axis=0)[:, list(chosen)][:, :, list(chosen)]
    return _Sums(
        columns=columns,
        mixed=mixed,
        squares=squares,
        noise=np.maximum(data.noise[points].sum(axis=0) / np.maximum(windows, 1), 1e-12),
        windows=np.maximum(windows, 1),
        points=(data.windows[points] > 0).sum(axis=0),
    )


def _diagonal(matrices: np.ndarray) -> np.ndarray:
    return np.einsum("bjj->bj", matrices)
