"""Linearised model about a hypothesis: residuals of the balances and their columns.

The columns (see ``evidence.py``) are the derivatives of the measured residuals by the parameters.
Units: factors in standard deviations of their priors (of the logarithm), coefficients in typical
sizes, modes of learned laws in standard deviations of their priors.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.evidence import Priors, Products
from hbench.reconcile.gaps.gap_map import GapMap, RunLevel
from hbench.reconcile.gaps.log_map import between_runs
from hbench.reconcile.hypothesis import CoefficientKey, Hypothesis, typical_size
from hbench.reconcile.learned.table import is_mode, mode_of
from hbench.reconcile.nuisance import BOUND, nuisances, standard_deviation
from hbench.records.diagnosis import REST_M_S

MOTIONS = ("rest", "steady", "unsteady")
_COEFFICIENT_PRIOR = 10.0  # typical sizes
_SHAPE_PRIOR = 3.0  # quarters of the default
_LARGEST_MODE = 30.0  # of a learned law, in standard deviations of its prior
_UNSTEADY = 0.1  # relative change of the velocity over a window's width
Columns = Mapping[str, np.ndarray]  # by name: change of the residuals (w, c) by one unit


class Measured(Protocol):
    """Measurement side of the search."""

    @property
    def plant(self) -> Any:
        """The given model: a ``Plant`` or part of one."""

    @property
    def tolerances(self) -> Mapping[CoefficientKey, float]:
        """Limits [SI] of the coefficients that are nuisances within them."""

    def gap_map(self, hypothesis: Hypothesis, reference: GapMap | None = None) -> GapMap:
        """Return the residuals of the measured runs with a hypothesis.

        Their scatter is that of a ``reference``, if there is one.
        """

    def columns(self, hypothesis: Hypothesis, names: Iterable[str]) -> Columns:
        """Return the columns ``names`` at a hypothesis."""


@dataclass(frozen=True)
class LinearisedModel:
    """Linearised model about a hypothesis: residuals, and products of columns."""

    hypothesis: Hypothesis
    gap_map: GapMap
    columns: Columns
    data: Products
    tight: Priors  # coefficients with a tolerance are within it
    wide: Priors  # they are not

    def coefficients_of(self, names: Iterable[str]) -> tuple[CoefficientKey, ...]:
        """Return the coefficients of some effects that have a column, in column order."""
        wanted = set(names)
        split = (name.partition(".") for name in self.data.names if name[0] not in "/#")
        return tuple((effect, key) for effect, _, key in split if effect in wanted)

    def column(self, which: CoefficientKey) -> int:
        """Return the index of a coefficient's column."""
        return self.data.names.index(".".join(which))

    @property
    def nuisances(self) -> tuple[int, ...]:
        """Indices of the columns that take part in every fit."""
        return tuple(np.flatnonzero(np.isfinite(self.tight.sigma)).tolist())

    def index(self, names: Iterable[str]) -> list[int]:
        """Return the indices of the columns of all nuisances and of some effects."""
        chosen = {*self.nuisances, *(self.column(c) for c in self.coefficients_of(names))}
        return sorted(chosen)

    def about_itself(self, names: Iterable[str]) -> "LinearisedModel":
        """Return the model for data of its own: tolerances of ``names`` about its coefficients."""
        shift = np.zeros(len(self.data.names))
        for which in self.coefficients_of(names):
            shift[self.column(which)] = self.hypothesis.coefficient(which) / typical_size(which)
        tight = self.tight
        tight = Priors(tight.centre + shift, tight.sigma, tight.low + shift, tight.high + shift)
        return replace(self, tight=tight)

    def priors(self, names: Iterable[str]) -> Priors:
        """Return the priors of all columns where only the effects ``names`` may be any size."""
        own = np.zeros(len(self.data.names), bool)
        own[[self.column(which) for which in self.coefficients_of(names)]] = True
        return Priors(
            *(
                np.where(own, getattr(self.wide, name), getattr(self.tight, name))
                for name in ("centre", "sigma", "low", "high")
            )
        )


def linearise(
    measured: Measured,
    hypothesis: Hypothesis,
    columns: Columns,
    reference: GapMap | None = None,
) -> LinearisedModel:
    """Linearise about a hypothesis with these columns; ``reference`` provides the scatter."""
    residuals = measured.gap_map(hypothesis, reference)
    return linearise_residuals(measured, hypothesis, residuals, columns)


def linearise_residuals(
    measured: Measured, hypothesis: Hypothesis, residuals: GapMap, columns: Columns
) -> LinearisedModel:
    """Linearise about a hypothesis whose residuals are known."""
    widths = nuisances(measured.plant)
    tight, wide = [], []
    for name in columns:
        if name.startswith("/"):
            at = np.log(hypothesis.factors.get(name[1:], 1.0)) / widths[name[1:]]
            tight.append((-at, 1.0, -BOUND - at, BOUND - at))
            wide.append(tight[-1])
            continue
        if is_mode(name):
            table, mode = mode_of(name)
            at = hypothesis.tables[table].modes[mode]
            tight.append((-at, 1.0, -_LARGEST_MODE - at, _LARGEST_MODE - at))
            wide.append(tight[-1])
            continue
        effect, _, key = name.partition(".")
        which = effect, key
        row, size = EFFECTS[effect].coefficients[key], typical_size(which)
        at, neutral = hypothesis.coefficient(which) / size, row.to_si(row.default)
        sigma = _COEFFICIENT_PRIOR if row.typical else _SHAPE_PRIOR
        low, high = min(row.to_si(row.low), neutral) / size - at, row.to_si(row.high) / size - at
        wide.append((neutral / size - at, sigma, low, high))
        limit = measured.tolerances.get(which, 0.0) / size
        tight.append((-at, standard_deviation(limit), -limit - at, limit - at) if limit else _OFF)
    return LinearisedModel(
        hypothesis,
        residuals,
        columns,
        products(residuals, columns),
        Priors(*np.array(tight).reshape(-1, 4).T),
        Priors(*np.array(wide).reshape(-1, 4).T),
    )


_OFF = (0.0, np.nan, 0.0, 0.0)  # prior of a column that no fit has unless its effect is tried


def hypothesis_at(
    model: LinearisedModel, plant: Any, chosen: Sequence[int], beta: np.ndarray
) -> Hypothesis:
    """Return the hypothesis at steps ``beta`` (q,) of the ``chosen`` columns."""
    before, widths = model.hypothesis, nuisances(plant)
    factors, values, tables = dict(before.factors), {}, list(before.tables)
    for i, step in zip(chosen, beta.tolist(), strict=True):
        name = model.data.names[i]
        if name.startswith("/"):
            path = name[1:]
            factors[path] = float(factors.get(path, 1.0) * np.exp(step * widths[path]))
        elif is_mode(name):
            table, mode = mode_of(name)
            tables[table] = tables[table].stepped(mode, step)
        else:
            effect, _, key = name.partition(".")
            which = effect, key
            values[which] = before.coefficient(which) + step * typical_size(which)
    changed = replace(before, factors=factors, tables=tuple(tables))
    return changed.with_coefficients(values)


def window_motions(residuals: GapMap) -> np.ndarray:
    """Return the index (w,) in ``MOTIONS`` of each window."""
    v, run = residuals.v_m_s, residuals.run
    inside = run[:-2] == run[2:]
    change = np.zeros_like(v)
    change[1:-1] = np.where(inside, np.abs(v[2:] - v[:-2]), 0.0)
    for i in np.unique(run):
        windows = np.flatnonzero(run == i)
        if len(windows) > 2:  # a run's first and last window copy their neighbours
            change[windows[[0, -1]]] = change[windows[[1, -2]]]
    unsteady = change > _UNSTEADY * np.abs(v) + REST_M_S
    return np.where(unsteady, 2, np.where(np.abs(v) < REST_M_S, 0, 1))


def products(residuals: GapMap, columns: Columns) -> Products:
    """Return the sums of products of residuals and columns, both in units of the scatter."""
    w, c = residuals.difference.shape
    with np.errstate(divide="ignore", invalid="ignore"):
        per_unit = 1 / residuals.scatter
        relative = residuals.noise * per_unit**2
    usable = np.isfinite(residuals.difference * per_unit) & np.isfinite(relative)
    per_unit = np.where(usable, per_unit, 0.0)
    matrix = np.zeros((w, c, len(columns) + 2))  # residuals, columns, what is not material
    matrix[:, :, 0] = np.nan_to_num(residuals.difference) * per_unit
    for j, column in enumerate(columns.values(), start=1):
        matrix[:, :, j] = np.nan_to_num(column) * per_unit
    if residuals.material is not None:
        matrix[:, :, -1] = np.nan_to_num(residuals.material) * np.sign(residuals.v_m_s)[:, None]
    for level in residuals.levels:
        _take_out(matrix[level.windows, level.balance], level)
    motion = window_motions(residuals)
    points = len(residuals.points)
    shape = points, c * len(MOTIONS)
    sums = np.zeros((*shape, matrix.shape[2], matrix.shape[2]))
    counts = np.zeros(shape)
    for p in range(points):
        for k in range(len(MOTIONS)):
            members = np.flatnonzero((residuals.point == p) & (motion == k))
            if not len(members):
                continue
            part = matrix[members].transpose(1, 2, 0)  # (c, q, m)
            at = slice(k, None, len(MOTIONS))
            sums[p, at] = part @ part.transpose(0, 2, 1)
            counts[p, at] = usable[members].sum(axis=0)
    squares = sums[:, :, 0, 0]
    if residuals.white is None:
        noises = _noises(residuals, relative, usable, motion)
    else:
        squares, noises = _without_noise(residuals, matrix[:, :, 0], squares, counts)
        noises = noises + sums[:, :, -1, -1]
    return Products(
        names=tuple(columns),
        columns=sums[:, :, 1:-1, 1:-1],
        mixed=sums[:, :, 0, 1:-1],
        squares=squares,
        noise=noises,
        windows=counts,
        groups=tuple((name, motion) for name in residuals.names for motion in MOTIONS),
    )


def _noises(
    residuals: GapMap, relative: np.ndarray, usable: np.ndarray, motion: np.ndarray
) -> np.ndarray:
    """Return the expected sums of squares (p, g) of the noise of means over trials."""
    noises = np.zeros((len(residuals.points), usable.shape[1] * len(MOTIONS)))
    values = np.where(usable, relative, 0.0)
    for p in range(len(residuals.points)):
        for k in range(len(MOTIONS)):
            members = (residuals.point == p) & (motion == k)
            noises[p, k :: len(MOTIONS)] = values[members].sum(axis=0)
    return noises


def _without_noise(
    residuals: GapMap, d: np.ndarray, squares: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sums of squares (p, g) without the noise of single windows, and their error.

    ``d`` (w, c) are residuals in scatters. What remains is structured. It is no evidence below what
    changes between the trials of an operating point plus the chance error of the noise's own sum
    of squares: that is the least variance of a group.
    """
    assert residuals.white is not None  # of a map of logs
    white = np.repeat(np.nan_to_num(residuals.white), len(MOTIONS))
    with np.errstate(divide="ignore", invalid="ignore"):
        chance = white * np.sqrt(2 / counts.sum(axis=0))
    first = np.unique(residuals.run, return_index=True)[1]
    between = np.repeat(between_runs(d, residuals.run, residuals.point[first]), len(MOTIONS))
    least = np.nan_to_num(chance + between)
    return squares - counts * white, counts * least


def _take_out(rows: np.ndarray, level: RunLevel) -> None:
    """Take the level of a run out of its windows ``rows`` (m, q), as far as it is not known.

    The covariance sigma^2 (1 + c c' / ridge), c the change by one standard deviation of the level,
    is whitened: 1 - (1 - sqrt(ridge / (ridge + c'c))) c c' / c'c.
    """
    square = level.change @ level.change
    if square > 0:
        kept = np.sqrt(level.ridge / (level.ridge + square))
        rows -= np.outer((1 - kept) / square * level.change, level.change @ rows)
