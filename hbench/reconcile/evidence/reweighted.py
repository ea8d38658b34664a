"""Iteratively reweighted least squares within bounds, compiled: the fits of ``likelihood.py``.

A diagnosis makes some thousands of these fits, each of fewer than a hundred columns.
"""

from typing import NamedTuple

import numpy as np

from hbench.model.compiled import compiled, inlined

_REWEIGHTINGS = 6  # at most
_CONVERGED = 1e-4  # standard deviations of priors and typical sizes; no further reweighting below
_BOUND_ITERATIONS = 3  # each may fix further parameters at their bounds
_FIXED_WEIGHT = 1e9  # fixes a parameter at its bound


class Entries(NamedTuple):
    """Products of columns by part f and group, end to end; k groups have columns other than 0."""

    group: np.ndarray  # (k,) indices
    first_column: np.ndarray  # (k + 1,) where a group's columns begin in ``column``
    column: np.ndarray  # indices
    first_value: np.ndarray  # (k,) where a group's products begin in ``values``
    values: np.ndarray  # (f, n)


class Given(NamedTuple):
    """Sums of b data sets, as in ``products.Sums``, and priors of q columns."""

    entries: Entries
    mixed: np.ndarray  # (f, b, g, q)
    squares: np.ndarray  # (f, b, g)
    noise: np.ndarray  # (f, g)
    windows: np.ndarray  # (f, g)
    points: np.ndarray  # (f, g)
    centre: np.ndarray  # (q,)
    information: np.ndarray  # (q,)
    low: np.ndarray  # (q,)
    high: np.ndarray  # (q,)


class _Work(NamedTuple):
    """What a fit changes."""

    curved: np.ndarray  # (q, q) upper triangle of the normal equations
    driven: np.ndarray  # (q,) their right side
    factor: np.ndarray  # (q, q) upper triangle, while they are solved
    solved: np.ndarray  # (q,) without bounds
    beta: np.ndarray  # (q,) within bounds
    fixed: np.ndarray  # (q,) whether a parameter is at a bound


def reweighted_fits(given: Given, variance: np.ndarray) -> np.ndarray:
    """Return beta (s, f, b, q) of fits that start with variances (s, f, b, g).

    The variances become those of the fits.
    """
    q = len(given.centre)
    beta = np.full((*variance.shape[:3], q), np.inf)
    curved, factor = np.zeros((2, q, q))
    driven, solved, own = np.zeros((3, q))
    _fit_all(given, _Work(curved, driven, factor, solved, own, np.zeros(q, bool)), variance, beta)
    return beta


@compiled
def _fit_all(given: Given, work: _Work, variance: np.ndarray, beta: np.ndarray) -> None:
    for s in range(beta.shape[0]):
        for f in range(beta.shape[1]):
            for b in range(beta.shape[2]):
                _fit(given, f, b, work, variance[s, f, b], beta[s, f, b])


@inlined
def _fit(given: Given, f: int, b: int, work: _Work, variance: np.ndarray, beta: np.ndarray) -> None:
    """Fit data set ``b`` of part ``f``, from its ``variance`` (g,)."""
    for _ in range(_REWEIGHTINGS):
        _weigh(given, f, b, variance, work)
        _solve_within_bounds(given, work)
        moves = False
        for j in range(len(beta)):
            moves = moves or abs(work.beta[j] - beta[j]) > _CONVERGED
            beta[j] = work.beta[j]
        _find_variance(given, f, b, beta, variance)
        if not moves:
            break


@inlined
def _weigh(given: Given, f: int, b: int, variance: np.ndarray, work: _Work) -> None:
    """Write the normal equations with weights n_g / (m_g v_g)."""
    entries, curved, driven = given.entries, work.curved, work.driven
    curved[:], driven[:] = 0.0, 0.0
    for j in range(len(driven)):
        curved[j, j] = given.information[j]
        driven[j] = given.information[j] * given.centre[j]
    for k in range(len(entries.group)):
        g, at = entries.group[k], entries.first_value[k]
        own = entries.column[entries.first_column[k] : entries.first_column[k + 1]]
        weight = given.points[f, g] / given.windows[f, g] / variance[g]
        for i in range(len(own)):
            row = own[i]
            driven[row] += weight * given.mixed[f, b, g, row]
            for j in range(i, len(own)):
                column = own[j]
                value = weight * entries.values[f, at + i * len(own) + j]
                curved[min(row, column), max(row, column)] += value


@inlined
def _solve_within_bounds(given: Given, work: _Work) -> None:
    """Fix parameters beyond a bound there, and solve for the others."""
    q = len(work.beta)
    work.beta[:], work.fixed[:] = 0.0, False
    for _ in range(_BOUND_ITERATIONS):
        for i in range(q):
            work.solved[i] = work.driven[i]
            for j in range(i, q):
                work.factor[i, j] = work.curved[i, j]
        for j in range(q):
            if work.fixed[j]:
                stiff = _FIXED_WEIGHT * (1.0 + work.curved[j, j])
                work.factor[j, j] += stiff
                work.solved[j] += stiff * work.beta[j]
        _solve(work.factor, work.solved)
        beyond = False
        for j in range(q):
            work.beta[j] = min(max(work.solved[j], given.low[j]), given.high[j])
            if work.beta[j] != work.solved[j] and not work.fixed[j]:
                work.fixed[j] = beyond = True
        if not beyond:
            break


@inlined
def _solve(matrix: np.ndarray, right: np.ndarray) -> None:
    """Solve a symmetric positive definite system, of which ``matrix`` has the upper triangle.

    Both are changed: elimination with the pivots in their order, and ``right`` is the solution.
    """
    q = len(right)
    for k in range(q):
        for i in range(k + 1, q):
            share = matrix[k, i] / matrix[k, k]
            if share != 0.0:
                right[i] -= share * right[k]
                for j in range(i, q):
                    matrix[i, j] -= share * matrix[k, j]
    for k in range(q - 1, -1, -1):
        for j in range(k + 1, q):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]


@inlined
def _find_variance(given: Given, f: int, b: int, beta: np.ndarray, variance: np.ndarray) -> None:
    """Write the mean squares (g,) of what beta leaves, at least the noise."""
    entries = given.entries
    for g in range(len(variance)):
        variance[g] = given.squares[f, b, g]
    for k in range(len(entries.group)):
        g, at = entries.group[k], entries.first_value[k]
        own = entries.column[entries.first_column[k] : entries.first_column[k + 1]]
        for i in range(len(own)):
            product = -2.0 * given.mixed[f, b, g, own[i]]
            for j in range(len(own)):
                product += entries.values[f, at + i * len(own) + j] * beta[own[j]]
            variance[g] += product * beta[own[i]]
    for g in range(len(variance)):
        variance[g] = max(variance[g] / given.windows[f, g], given.noise[f, g])
