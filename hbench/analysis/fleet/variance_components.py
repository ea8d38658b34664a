"""Variance components of random factors: REML with profile intervals, and ANOVA.

Model of the mean y_c of campaign c over n_c trials, with an effect for each level of each factor k:

    y_c = m + sum_k u_k(c) + e_c,   u_k ~ N(0, s_k^2),   e_c ~ N(0, s_r^2 / n_c)

The trials scatter about the means of their campaigns with SS ~ s_r^2 chi^2(nu). With K_k the matrix
that is 1 where two campaigns have the same level, V = sum_k s_k^2 K_k + s_r^2 diag(1 / n_c), and A
an orthonormal basis of contrasts (A 1 = 0), REML maximises the likelihood of A y and SS:

    -2 l = log |A V A'| + (A y)' (A V A')^-1 (A y) + nu log s_r^2 + SS / s_r^2

(Patterson and Thompson, Biometrika 58, 1971; Searle, Casella and McCulloch, Variance Components,
1992, section 6.6), with s^2 >= 0. The interval of a sum of components c' s^2 are the values that
lower the likelihood, maximised over the others, by less than chi^2(1) at 95 % (profile likelihood).

ANOVA equates the sums of squares of the factors, those with few levels first and each adjusted for
the ones before, to their expectations (Henderson's method III; Searle et al., section 5.5). In a
balanced plan both agree where no ANOVA estimate is negative.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

REPEATS = "trials"  # the component of repeated trials
_CHI2_95 = 3.841458820694124  # of one degree of freedom
_LEAST = 1e-9  # of the total variance: smallest s_r^2, and smallest change that is followed
_NOTHING = 1e-6  # of the sum of the variances: a smaller estimate is zero
_CONFOUNDED = 1e-6  # relative length of the part of K_k that no other component explains
_SMALL = 1e-3  # variances below have this scale in a search
_RESTARTS, _GAIN = 5, 1e-6  # searches, while another one lowers -2 l by so much
_FACTOR_LIMIT = 1e8  # of a component's estimate: an interval has no end beyond
_EDGE_TOLERANCE = 1e-3  # relative, of an interval's end


class Component(NamedTuple):
    """A variance, or a sum of variances."""

    value: float
    low: float  # 95 % interval
    high: float  # infinite where the plan sets no bound


@dataclass(frozen=True)
class PlanData:
    """Means of the campaigns, and the levels of each factor."""

    means: np.ndarray  # (n,)
    trials: np.ndarray  # (n,) of each mean
    scatter: float  # SS of the trials about their campaign's mean
    dof: float  # of it; 0 without repeated trials
    levels: dict[str, np.ndarray]  # factor -> (n,) levels, compared by equality


@dataclass(frozen=True)
class Separated:
    """Factors that a plan can separate, and why the others can't be."""

    levels: dict[str, np.ndarray]
    merged: tuple[tuple[str, str], ...]  # factor, and the one with the same levels
    dependent: tuple[str, ...]  # factors whose effect others can replace in this plan


def separated(data: PlanData) -> Separated:
    """Return the factors whose variances the plan determines, in their order.

    A component is determined if its K, seen by contrasts, is no linear combination of the others'.
    """
    contrasts = _contrasts(len(data.means))
    repeats = _seen(contrasts, np.diag(1.0 / data.trials), data.dof)
    basis = [repeats / np.linalg.norm(repeats)]
    kept: dict[str, np.ndarray] = {}
    merged, dependent = [], []
    for name, levels in data.levels.items():
        numbers = np.unique(levels, return_inverse=True)[1]
        same = next((k for k, other in kept.items() if np.array_equal(other, numbers)), "")
        if same:
            merged.append((name, same))
            continue
        column = _seen(contrasts, _same(numbers), 0.0)
        length = np.linalg.norm(column)
        rest = column.copy()
        for direction in (*basis, *basis):  # twice, against rounding
            rest -= (direction @ rest) * direction
        if numbers.max() == 0:
            continue  # not varied
        if np.linalg.norm(rest) <= _CONFOUNDED * length:
            everywhere = len(np.unique(numbers)) == len(numbers) and data.dof == 0
            merged.append((name, REPEATS)) if everywhere else dependent.append(name)
            continue
        basis.append(rest / np.linalg.norm(rest))
        kept[name] = numbers
    return Separated(kept, tuple(merged), tuple(dependent))


class VarianceComponents:
    """REML estimates of the variances of ``data``'s factors and of its trials."""

    def __init__(self, data: PlanData):
        self.names = (*data.levels, REPEATS)
        contrasts = _contrasts(len(data.means))
        y = contrasts @ data.means
        self._unit = (y @ y + data.scatter) / (len(y) + data.dof)  # the variance that is 1 inside
        self._scatter, self._dof = data.scatter / self._unit, data.dof
        matrices = [_same(levels) for levels in data.levels.values()]
        matrices.append(np.diag(1.0 / data.trials))
        seen = np.array([contrasts @ k @ contrasts.T for k in matrices])
        self._y, self._k = _diagonal(y / np.sqrt(self._unit), seen)
        start = np.full(len(self.names), 1.0 / len(self.names))
        best, self._least = self._minimum(start)
        self._best = np.where(best > _NOTHING * best.sum(), best, 0.0)

    @property
    def variances(self) -> dict[str, float]:
        """Estimate of each component."""
        return dict(zip(self.names, (self._unit * self._best).tolist(), strict=True))

    def component(self, names: Sequence[str]) -> Component:
        """Return the sum of some components with its interval."""
        weights = np.array([float(name in names) for name in self.names])
        value = float(weights @ self._best)
        low, high = self._ends(value, lambda t: (weights, t), bounded_below=REPEATS in names)
        return Component(*(self._unit * np.array([value, low, high])).tolist())

    def share(self, names: Sequence[str]) -> Component:
        """Return the share of some components in the sum of all, 0 to 1, with its interval.

        ``names`` contain the trials, whose variance is not zero: the profile is that of the ratio
        of the other components to them.
        """
        weights = np.array([float(name in names) for name in self.names])
        inside = float(weights @ self._best)
        ratio = float((1 - weights) @ self._best) / inside
        low, high = self._ends(ratio, lambda t: (1 - weights - t * weights, 0.0), False)
        return Component(1 / (1 + ratio), 1 / (1 + high), 1 / (1 + low))

    def _ends(
        self,
        value: float,
        constraint: Callable[[float], tuple[np.ndarray, float]],
        bounded_below: bool,
    ) -> tuple[float, float]:
        """Return the ends of the profile interval of t around its estimate ``value``.

        ``constraint`` returns a and b of the plane a' s^2 = b on which t has a value.
        """

        def excess(t: float) -> float:
            return self._minimum(self._best, constraint(t))[1] - self._least - _CHI2_95

        if not bounded_below and (value == 0.0 or excess(0.0) <= 0):
            low = 0.0
        else:
            low = _root(excess, value, 0.5, _LEAST * value)
        begin = value
        if value == 0.0:  # somewhere inside of the interval
            begin = float(self._best.max())
            while excess(begin) > 0 and begin > _LEAST:
                begin /= 8
        return low, _root(excess, begin, 2.0, _FACTOR_LIMIT * max(begin, 1.0))

    def _minimum(
        self, start: np.ndarray, plane: tuple[np.ndarray, float] | None = None
    ) -> tuple[np.ndarray, float]:
        """Return where -2 l is least, and its value; on a plane a' s^2 = b if given."""
        from scipy.optimize import minimize  # slow import

        a, b = plane if plane is not None else (np.zeros(len(start)), 0.0)
        if plane is not None:
            start = min(_onto(start, a, b), key=lambda s2: self._minus_twice_log(s2)[0])
        size = np.maximum(start, _SMALL)  # in which all variances are of the order of 1
        bounds = [(0.0, None)] * (len(start) - 1) + [(_LEAST / size[-1], None)]
        normal = a * size / (np.linalg.norm(a * size) or 1.0)
        equal = {
            "type": "eq",
            "fun": lambda z: normal @ (z - start / size),
            "jac": lambda z: normal,
        }

        def scaled(z: np.ndarray) -> tuple[float, np.ndarray]:
            value, slopes = self._minus_twice_log(z * size)
            return value, slopes * size

        z, least = start / size, np.inf
        for _ in range(_RESTARTS):  # each with a fresh estimate of the curvature
            found = minimize(
                scaled, z, jac=True, method="SLSQP", bounds=bounds,
                constraints=[] if plane is None else [equal],
                options={"ftol": 1e-11, "maxiter": 300},
            )  # fmt: skip
            gained = least - found.fun
            if gained > 0:
                z, least = found.x, float(found.fun)
            if gained < _GAIN:
                break
        return z * size, least

    def _minus_twice_log(self, s2: np.ndarray) -> tuple[float, np.ndarray]:
        """Return -2 l at variances s2 (k,) and its derivatives (k,)."""
        s2 = np.append(np.maximum(s2[:-1], 0.0), max(float(s2[-1]), _LEAST))
        v = np.tensordot(s2, self._k, axes=1)
        if v.ndim == 1:
            inverse, log_det = 1 / v, np.log(v).sum()
            residual = inverse * self._y
            slopes = self._k @ inverse - self._k @ residual**2
        else:
            factor = np.linalg.cholesky(v)
            inverse, log_det = np.linalg.inv(v), 2 * np.log(np.diag(factor)).sum()
            residual = inverse @ self._y
            slopes = np.tensordot(self._k, inverse) - self._k @ residual @ residual
        value = log_det + self._y @ residual
        value += self._dof * np.log(s2[-1]) + self._scatter / s2[-1]
        slopes[-1] += self._dof / s2[-1] - self._scatter / s2[-1] ** 2
        return float(value), slopes


def _diagonal(y: np.ndarray, matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return y (n,) and covariances (k, n, n) in axes that make all of them diagonal (k, n).

    These exist in a balanced plan. Otherwise both are returned as they are.
    """
    weights = 1 + np.sqrt(np.arange(len(matrices)) + 2.0)  # in no simple ratio to each other
    axes = np.linalg.eigh(np.tensordot(weights, matrices, axes=1))[1]
    turned = axes.T @ matrices @ axes
    diagonals = np.diagonal(turned, axis1=1, axis2=2)
    size = np.abs(turned).max()
    if np.abs(turned - diagonals[:, :, None] * np.eye(len(y))).max() > 1e-9 * size:
        return y, matrices
    return axes.T @ y, np.maximum(diagonals, 0.0)


def anova(data: PlanData) -> dict[str, float]:
    """Return the ANOVA estimate of each variance; a negative one stays negative."""
    root = np.sqrt(data.trials)
    y = root * data.means
    names = sorted(data.levels, key=lambda name: data.levels[name].max())  # nested ones come last
    designs = [root[:, None] * _indicators(data.levels[name]) for name in names]
    span = _basis(root[:, None])
    sums, expectations = [], []
    for design in (*designs, np.diag(root)):
        wider = _basis(np.hstack([span, design]))
        squares = np.sum((wider.T @ y) ** 2) - np.sum((span.T @ y) ** 2)
        dof = wider.shape[1] - span.shape[1]
        traces = [
            np.sum((wider.T @ other) ** 2) - np.sum((span.T @ other) ** 2) for other in designs
        ]
        sums.append(squares)
        expectations.append([*traces, dof])
        span = wider
    # The last sum is that of the means after all factors; with the trials' it estimates s_r^2.
    sums[-1] += data.scatter
    expectations[-1][-1] += data.dof
    found = np.linalg.lstsq(np.array(expectations, dtype=float), np.array(sums), rcond=None)[0]
    return dict(zip((*names, REPEATS), found.tolist(), strict=True))


def numbered(levels: Sequence[object]) -> np.ndarray:
    """Return the levels (n,) of a factor as numbers."""
    numbers: dict[object, int] = {}
    return np.array([numbers.setdefault(level, len(numbers)) for level in levels])


def _contrasts(n: int) -> np.ndarray:
    """Return an orthonormal basis (n - 1, n) of the contrasts of n numbers (Helmert)."""
    rows = np.tril(np.ones((n, n)), -1)[1:]
    rows[np.arange(n - 1), np.arange(1, n)] = -np.arange(1, n)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def _same(levels: np.ndarray) -> np.ndarray:
    return (levels[:, None] == levels).astype(float)


def _indicators(levels: np.ndarray) -> np.ndarray:
    return (levels[:, None] == np.unique(levels)).astype(float)


def _seen(contrasts: np.ndarray, k: np.ndarray, dof: float) -> np.ndarray:
    """Return a covariance as the data sees it, as a vector; trials are also seen by scatter."""
    return np.append((contrasts @ k @ contrasts.T).ravel(), np.sqrt(dof))


def _basis(columns: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the span of some columns."""
    u, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return u[:, sizes > 1e-9 * sizes[0]]


def _onto(s2: np.ndarray, a: np.ndarray, b: float) -> list[np.ndarray]:
    """Return variances near ``s2`` (k,) with a' s^2 = b: all with a > 0 scaled, or one changed."""
    raised = a > 0
    wanted = b + np.maximum(-a, 0.0) @ s2
    have = a[raised] @ s2[raised]
    shares = s2 * wanted / have if have > 0 else np.full(len(s2), wanted / a[raised].sum())
    starts = [np.where(raised, shares, s2)]
    largest = int(np.argmax(np.where(raised, s2, -1.0)))
    one = s2.copy()
    one[largest] += (wanted - have) / a[largest]
    return starts if one[largest] < 0 else [*starts, one]


def _root(excess: Callable[[float], float], begin: float, factor: float, limit: float) -> float:
    """Return where ``excess`` changes its sign, from ``begin`` towards ``limit`` in steps."""
    from scipy.optimize import brentq  # slow import

    inside, outside = begin, begin * factor
    while excess(outside) < 0:
        inside, outside = outside, outside * factor
        if not min(limit, begin) <= outside <= max(limit, begin):
            return 0.0 if factor < 1 else np.inf
    ends = sorted((np.log(inside), np.log(outside)))
    return float(np.exp(brentq(lambda u: excess(np.exp(u)), *ends, xtol=_EDGE_TOLERANCE)))
