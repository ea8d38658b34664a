"""Sums of products of residuals and columns over windows, for ``likelihood.py``.

The windows of a balance are grouped by motion: at rest, steady, unsteady, or reversing. Each group
has a variance of its own, and a model's error in it is as large as the group's residuals. Most of
that error is slow: the level of friction, ripple along the bore, a drift. An effect that acts for a
moment, as at a step or after a reversal, would be lost in it. Groups of changes therefore stand
beside those of the values:

    (r_(i+1) - r_(i-1)) / sqrt 2        windows of one run that share no sample

Slow errors cancel in a change. Its variance is at least that of a single window's noise, so that
what the log can't resolve is no evidence.

The level of a run that is not known, such as that of its friction, is taken out of its windows and
has a group of its own, with one row a run: what a run shows of a level is the same, however many
windows it has.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hbench.reconcile.evidence.products import Block, ColumnProducts, Products
from hbench.reconcile.gaps.gap_map import GapMap, RunLevel
from hbench.reconcile.gaps.log_map import between_runs, like_runs
from hbench.records.reconcile.diagnosis import REST_M_S

MOTIONS = ("rest", "steady", "unsteady", "reversing")
_REVERSING = MOTIONS.index("reversing")
GROUPS = (*MOTIONS, "level", "change", "step", "change at a reversal")  # of each balance
LEVEL = GROUPS.index("level")
STEADY = ("steady", "level")  # of motion: at rest a law of friction has no direction
_STEP = 0.6  # relative change of the velocity
_IMMATERIAL_CHANGE = 0.2  # of what is not material: root mean square over a group, not its largest
_UNSTEADY = 0.1  # relative change of the velocity over a window's width


class _Rows(NamedTuple):
    """Values or changes of m windows, or levels of m runs, in units of the scatter."""

    # Of each balance (m, 1 + u + 1): residuals, the u columns that change it, what is not material.
    matrices: tuple[np.ndarray, ...]
    usable: np.ndarray  # (m, c)
    dof: np.ndarray  # (m, c) degrees of freedom that each has: 1 less what a level takes
    point: np.ndarray  # (m,) index of the operating point
    kind: np.ndarray  # (m,) index in ``GROUPS``


def is_change(kind: str) -> bool:
    """Return whether a group among ``GROUPS`` is one of changes."""
    return not (kind in MOTIONS or is_level(kind))


def is_level(kind: str) -> bool:
    """Return whether a group among ``GROUPS`` is one of levels."""
    return kind == GROUPS[LEVEL]


def window_motions(residuals: GapMap) -> np.ndarray:
    """Return the index (w,) in ``MOTIONS`` of each window."""
    v, run = residuals.v_m_s, residuals.run
    inside = run[:-2] == run[2:]
    change, reversing = np.zeros_like(v), np.zeros(len(v), bool)
    change[1:-1] = np.where(inside, np.abs(v[2:] - v[:-2]), 0.0)
    reversing[1:-1] = inside & (v[2:] * v[:-2] < 0)
    for i in np.unique(run):
        windows = np.flatnonzero(run == i)
        if len(windows) > 2:  # a run's first and last window copy their neighbours
            change[windows[[0, -1]]] = change[windows[[1, -2]]]
    unsteady = change > _UNSTEADY * np.abs(v) + REST_M_S
    motion = np.where(unsteady, 2, np.where(np.abs(v) < REST_M_S, 0, 1))
    return np.where(unsteady & reversing, _REVERSING, motion)


def products(
    residuals: GapMap, columns: Mapping[str, np.ndarray], known: Products | None = None
) -> Products:
    """Return the sums of products of residuals and columns (w, c) by name.

    ``known`` are those of other residuals with the same columns and scatter.
    """
    used = _used(columns.values(), len(residuals.names))
    values = _values(residuals, list(columns.values()), used)
    every, levels = [values], _levels_taken_out(residuals, values)
    if residuals.levels:
        every.append(levels)
    if residuals.white is not None:
        every.append(_changes(residuals, values))
    groups = tuple((name, kind) for name in residuals.names for kind in GROUPS)
    size = len(residuals.points), len(groups)
    mixed = np.zeros((*size, len(columns)))
    squares, immaterial, counts = np.zeros((3, *size))
    blocks = None if known else _empty_blocks(used, len(residuals.points))
    for rows in every:
        _add(rows, used, mixed, squares, immaterial, counts, blocks)
    if residuals.white is None:
        noise = _noise(residuals, values, counts)
    else:
        squares, noise = _without_noise(residuals, values, levels, squares, counts)
        noise = noise + immaterial
    if known is not None:
        return known.with_residuals(mixed, squares, noise)
    assert blocks is not None
    blocks = tuple(block for block in blocks if len(block.columns))
    of_columns = ColumnProducts(blocks, (*size, len(columns)))
    return Products(tuple(columns), of_columns, mixed, squares, noise, counts, groups)


def _used(columns: Iterable[np.ndarray], balances: int) -> list[np.ndarray]:
    """Return the indices of the columns that change each balance: few do."""
    nonzero = [(np.abs(column) > 0).any(axis=0) for column in columns]
    every = np.reshape(nonzero, (-1, balances))
    return [np.flatnonzero(every[:, c]) for c in range(balances)]


def _empty_blocks(used: Sequence[np.ndarray], points: int) -> tuple[Block, ...]:
    """Return a block of zeros for each balance, of the columns that change it."""
    blocks = []
    for c, own in enumerate(used):
        groups = np.arange(c * len(GROUPS), (c + 1) * len(GROUPS))
        blocks.append(Block(groups, own, np.zeros((points, len(groups), len(own), len(own)))))
    return tuple(blocks)


def _values(residuals: GapMap, columns: Sequence[np.ndarray], used: Sequence[np.ndarray]) -> _Rows:
    with np.errstate(divide="ignore", invalid="ignore"):
        per_unit = 1 / residuals.scatter
        relative = residuals.noise * per_unit**2
    usable = np.isfinite(residuals.difference * per_unit) & np.isfinite(relative)
    per_unit = np.where(usable, per_unit, 0.0)
    matrices = []
    for c, own in enumerate(used):
        matrix = np.zeros((len(usable), 1 + len(own) + 1))
        for k, column in enumerate([residuals.difference, *(columns[j] for j in own)]):
            matrix[:, k] = np.nan_to_num(column[:, c]) * per_unit[:, c]
        if residuals.material is not None:
            matrix[:, -1] = np.nan_to_num(residuals.material[c]) * np.sign(residuals.v_m_s)
        matrices.append(matrix)
    dof = usable.astype(float)
    return _Rows(tuple(matrices), usable, dof, residuals.point, window_motions(residuals))


def _levels_taken_out(residuals: GapMap, values: _Rows) -> _Rows:
    """Take the levels out of the rows of windows, and return them as rows of their own.

    A level that changes less than the noise of the run, such as that of friction at rest, stays.
    """
    every = residuals.levels
    matrices = tuple(np.zeros((len(every), matrix.shape[1])) for matrix in values.matrices)
    usable = np.zeros((len(every), len(matrices)), bool)
    for k, level in enumerate(every):
        windows, balance = level.windows, level.balance
        if level.square > level.ridge:
            matrices[balance][k] = _take_out(values.matrices[balance][windows], level)
            values.dof[windows, balance] *= 1 - level.change**2 / level.square
            usable[k, balance] = True
    point = residuals.point[[level.windows.start for level in every]]
    kind = np.full(len(every), LEVEL)
    return _Rows(matrices, usable, usable.astype(float), point, kind)


def _changes(residuals: GapMap, values: _Rows) -> _Rows:
    """Return the changes over inner windows in unsteady motion.

    What is not material has the sign of the velocity, so it changes at a reversal. Elsewhere a
    fifth of it is not material either: an effect that acts for a moment is larger then.
    """
    v, run, motion = residuals.v_m_s, residuals.run, values.kind
    usable = values.usable[2:] & values.usable[:-2] & (run[2:] == run[:-2])[:, None]
    fastest = np.maximum(np.abs(v[2:]), np.abs(v[:-2]))
    turn = (np.sign(v[2:]) - np.sign(v[:-2])) / np.sqrt(2)
    reversing = (v[2:] * v[:-2] < 0) & (fastest > REST_M_S)
    share = np.where(reversing, turn, _IMMATERIAL_CHANGE)
    matrices = []
    for c, matrix in enumerate(values.matrices):
        change = (matrix[2:] - matrix[:-2]) / np.sqrt(2)
        material = 0.0 if residuals.material is None else np.nan_to_num(residuals.material[c])
        change[:, -1] = material * share
        matrices.append(change * usable[:, c, None])
    step = np.abs(v[2:] - v[:-2]) > _STEP * fastest + REST_M_S
    kind = GROUPS.index("change") + np.select([reversing, step], [2, 1], 0)
    moving = np.maximum.reduce([motion[2:], motion[1:-1], motion[:-2]]) > MOTIONS.index("steady")
    usable &= moving[:, None]
    return _Rows(tuple(matrices), usable, usable.astype(float), values.point[1:-1], kind)


def _add(
    rows: _Rows,
    used: Sequence[np.ndarray],
    mixed: np.ndarray,
    squares: np.ndarray,
    immaterial: np.ndarray,
    counts: np.ndarray,
    blocks: tuple[Block, ...] | None,
) -> None:
    """Add the products of some rows to those of their operating points and groups.

    ``mixed`` (p, g, q) are those of the residuals with the columns, ``blocks`` those of the columns
    ``used`` by a balance.
    """
    order = np.lexsort((rows.kind, rows.point))
    point, kind = rows.point[order], rows.kind[order]
    first = np.flatnonzero(np.diff(point * len(GROUPS) + kind, prepend=-1))
    point, kind = point[first], kind[first]
    for c, matrix in enumerate(rows.matrices):
        usable, group = rows.usable[order, c], c * len(GROUPS) + kind
        part = np.where(usable[:, None], matrix[order], 0.0)
        sums = np.add.reduceat(part * part[:, :1], first)
        squares[point, group] += sums[:, 0]
        mixed[point[:, None], group[:, None], used[c]] += sums[:, 1:-1]
        immaterial[point, group] += np.add.reduceat(part[:, -1] ** 2, first)
        counts[point, group] += np.add.reduceat(rows.dof[order, c], first)
        if blocks is not None:
            runs = np.split(np.ascontiguousarray(part[:, 1:-1]), first[1:])
            blocks[c].values[point, kind] += np.array([run.T @ run for run in runs])


def _noise(residuals: GapMap, values: _Rows, counts: np.ndarray) -> np.ndarray:
    """Return the expected sums of squares (p, g) of the noise of means over trials."""
    noise = np.zeros_like(counts)
    relative = np.where(values.usable, (residuals.noise / residuals.scatter**2), 0.0)
    for p in range(len(counts)):
        for k in range(len(MOTIONS)):
            members = (values.point == p) & (values.kind == k)
            noise[p, k :: len(GROUPS)] = relative[members].sum(axis=0)
    return noise


def _without_noise(
    residuals: GapMap, values: _Rows, levels: _Rows, squares: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sums of squares (p, g) without the noise of single windows, and their error.

    What remains is structured. It is no evidence below the chance error of the noise's own sum of
    squares plus what changes between the trials of an operating point; in changes, plus the noise
    of a single window: that is the least variance of a group. The noise of a level is its own
    standard deviation.
    """
    assert residuals.white is not None  # of a map of logs
    shape = len(residuals.names), len(GROUPS)
    white = np.tile(np.nan_to_num(residuals.white)[:, None], len(GROUPS))
    for level in residuals.levels:
        white[level.balance, LEVEL] = level.ridge
    with np.errstate(divide="ignore", invalid="ignore"):
        chance = white * np.sqrt(2 / counts.sum(axis=0).reshape(shape))
    first = np.unique(residuals.run, return_index=True)[1]
    trials = like_runs(residuals.run, residuals.point[first], residuals.v_m_s)
    least = np.tile(_between(values, residuals.run, trials)[:, None], len(GROUPS))
    run_of_level = residuals.run[[level.windows.start for level in residuals.levels]]
    least[:, LEVEL] = _between(levels, run_of_level, trials)
    least = np.where([is_change(kind) for kind in GROUPS], white, least)
    least += np.nan_to_num(chance, posinf=0.0)
    return squares - counts * white.ravel(), counts * least.ravel()


def _between(rows: _Rows, run: np.ndarray, trials: np.ndarray) -> np.ndarray:
    """Return the variance (c,) of the residuals' means between runs of the same ``trials`` (r,)."""
    deviations = np.column_stack([matrix[:, 0] for matrix in rows.matrices])
    deviations = np.where(rows.usable, deviations, np.nan)
    return np.nan_to_num(between_runs(deviations, run, trials))


def _take_out(rows: np.ndarray, level: RunLevel) -> np.ndarray:
    """Take the level of a run out of its windows ``rows`` (m, q); return it as a row (q,).

    The row is c' / |c| times the windows' rows, c the change by one standard deviation of the
    level, less what is expected of it.
    """
    unit = level.change / np.sqrt(level.square)
    along = unit @ rows
    rows -= np.outer(unit, along)
    return level.unexpected * along
