"""Linearised model about a hypothesis: differences of the balances and their columns.

The columns (see ``evidence.py``) are: for a nuisance parameter the change of the measured balances,
by finite differences; for an effect's coefficient the difference of the balances between two
simulations, with the effect and without. So an effect acts only as simulated by plant, firmware and
log.

Units: nuisances in standard deviations of their priors (of the logarithm), coefficients in typical
sizes.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.evidence import Priors, Products
from hbench.reconcile.gaps.columns import ModelColumn
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import CoefficientKey, Hypothesis, typical_size
from hbench.reconcile.measured_campaign import MeasurementInterface
from hbench.reconcile.nuisance import BOUND, nuisances
from hbench.records.diagnosis import REST_M_S

MOTIONS = ("rest", "steady", "unsteady")
_COEFFICIENT_PRIOR = 10.0  # typical sizes
_SHAPE_PRIOR = 3.0  # quarters of the default
_UNSTEADY = 0.1  # relative change of the velocity over a window's width


@dataclass(frozen=True)
class LinearisedModel:
    """Linearised model about a hypothesis: simulated runs, differences, products of columns."""

    hypothesis: Hypothesis
    runs: tuple[Any, ...]  # simulated: ``Run``, or ``StrokePair``
    gap_map: GapMap
    data: Products
    priors: Priors

    def coefficients_of(self, names: Iterable[str]) -> tuple[CoefficientKey, ...]:
        """Return the coefficients of some effects that have a column, in column order."""
        wanted = set(names)
        split = (name.partition(".") for name in self.data.names if not name.startswith("/"))
        return tuple((effect, key) for effect, _, key in split if effect in wanted)

    def column(self, which: CoefficientKey) -> int:
        """Return the index of a coefficient's column."""
        return self.data.names.index(".".join(which))

    def index(self, coefficients: Iterable[CoefficientKey]) -> list[int]:
        """Return the indices of the columns of all nuisances and of some coefficients."""
        wanted = {f"{name}.{key}" for name, key in coefficients}
        return [
            i for i, name in enumerate(self.data.names) if name.startswith("/") or name in wanted
        ]


def linearise(
    measured: MeasurementInterface,
    hypothesis: Hypothesis,
    simulated: Sequence[Any],
    signatures: Mapping[CoefficientKey, ModelColumn],
    reference: GapMap | None = None,
) -> LinearisedModel:
    """Linearise about a hypothesis and its simulation; ``reference`` provides the scatter."""
    differences = measured.gap_map(hypothesis, simulated)
    scale = _scatter_at(reference or differences, differences)
    prior_widths = nuisances(measured.plant)
    signatures = measured.signatures_at(hypothesis, signatures)
    columns: dict[str, ModelColumn] = {}
    slopes = measured.slopes(hypothesis.factors)
    for path, one_sigma in prior_widths.items():
        columns[f"/{path}"] = {point: -one_sigma * rows for point, rows in slopes[path].items()}
    for (name, key), column in signatures.items():
        columns[f"{name}.{key}"] = column
    centre, sigma, low, high = [], [], [], []
    for path, width in prior_widths.items():
        at = np.log(hypothesis.factors.get(path, 1.0)) / width
        centre.append(-at)
        sigma.append(1.0)
        low.append(-BOUND - at)
        high.append(BOUND - at)
    for which in signatures:
        row, size = EFFECTS[which[0]].coefficients[which[1]], typical_size(which)
        at, neutral = hypothesis.coefficient(which) / size, row.to_si(row.default)
        centre.append(neutral / size - at)
        sigma.append(_COEFFICIENT_PRIOR if row.typical else _SHAPE_PRIOR)
        low.append(min(row.to_si(row.low), neutral) / size - at)
        high.append(row.to_si(row.high) / size - at)
    priors = Priors(*(np.array(values) for values in (centre, sigma, low, high)))
    products = _products(differences, scale, columns)
    return LinearisedModel(hypothesis, tuple(simulated), differences, products, priors)


def hypothesis_at(
    start: LinearisedModel, plant: Any, coefficients: Sequence[CoefficientKey], beta: np.ndarray
) -> Hypothesis:
    """Return the hypothesis at ``beta`` (q,): steps of the nuisances, then of ``coefficients``."""
    priors = nuisances(plant)
    steps = dict(zip(priors, beta[: len(priors)].tolist(), strict=True))
    before = start.hypothesis
    factors = {
        path: float(before.factors.get(path, 1.0) * np.exp(steps[path] * prior))
        for path, prior in priors.items()
    }
    values = {
        which: before.coefficient(which) + float(step) * typical_size(which)
        for which, step in zip(coefficients, beta[len(priors) :], strict=True)
    }
    return replace(before, factors=factors).with_coefficients(values)


def _scatter_at(reference: GapMap, other: GapMap) -> tuple[np.ndarray, np.ndarray]:
    """Return scatter and noise of ``reference`` at the windows of ``other``."""
    if reference is other:
        return reference.scatter, reference.noise
    windows = {
        point: np.flatnonzero(reference.point == i) for i, point in enumerate(reference.points)
    }
    rows = []
    for i, point in enumerate(other.points):
        available, count = windows[point], int(np.sum(other.point == i))
        rows.append(available[np.minimum(np.arange(count), len(available) - 1)])
    row = np.concatenate(rows)
    return reference.scatter[row], reference.noise[row]


def window_motions(differences: GapMap) -> np.ndarray:
    """Return the index (w,) in ``MOTIONS`` of each window."""
    v = differences.v_m_s
    inside = differences.point[:-2] == differences.point[2:]
    change = np.zeros_like(v)
    change[1:-1] = np.where(inside, np.abs(v[2:] - v[:-2]), 0.0)
    for i in range(len(differences.points)):
        windows = np.flatnonzero(differences.point == i)
        if len(windows) > 2:  # a run's first and last window copy their neighbours
            change[windows[[0, -1]]] = change[windows[[1, -2]]]
    unsteady = change > _UNSTEADY * np.abs(v) + REST_M_S
    return np.where(unsteady, 2, np.where(np.abs(v) < REST_M_S, 0, 1))


def _products(
    differences: GapMap, scale: tuple[np.ndarray, np.ndarray], columns: Mapping[str, ModelColumn]
) -> Products:
    """Return the sums of products of differences and columns, both in units of the scatter."""
    scatter, noise = scale
    w, c = differences.difference.shape
    with np.errstate(divide="ignore", invalid="ignore"):
        d = differences.difference / scatter
        relative = noise / scatter**2
    usable = np.isfinite(d) & np.isfinite(relative)
    windows = [np.flatnonzero(differences.point == i) for i in range(len(differences.points))]
    matrix = np.zeros((w, c, len(columns) + 1))
    matrix[:, :, 0] = d
    for j, column in enumerate(columns.values(), start=1):
        for rows, point in zip(windows, differences.points, strict=True):
            values = column.get(point)
            if values is not None:
                m = min(len(rows), len(values))
                matrix[rows[:m], :, j] = values[:m] / scatter[rows[:m]]
    matrix = np.where(usable[:, :, None], np.nan_to_num(matrix), 0.0)
    motion = window_motions(differences)
    shape = len(differences.points), c * len(MOTIONS)
    sums = np.zeros((*shape, matrix.shape[2], matrix.shape[2]))
    noises, counts = np.zeros(shape), np.zeros(shape)
    for p, rows in enumerate(windows):
        for k in range(len(MOTIONS)):
            members = rows[motion[rows] == k]
            if not len(members):
                continue
            part = matrix[members].transpose(1, 2, 0)  # (c, q, m)
            at = slice(k, None, len(MOTIONS))
            sums[p, at] = part @ part.transpose(0, 2, 1)
            counts[p, at] = usable[members].sum(axis=0)
            noises[p, at] = np.where(usable[members], relative[members], 0.0).sum(axis=0)
    return Products(
        names=tuple(columns),
        columns=sums[:, :, 1:, 1:],
        mixed=sums[:, :, 0, 1:],
        squares=sums[:, :, 0, 0],
        noise=noises,
        windows=counts,
        groups=tuple((name, motion) for name in differences.names for motion in MOTIONS),
    )
