"""A model and its surroundings: what its balances lack, and how that changes with what is unsure.

A hypothesis is the plant that was given with factors on its nuisances and with effects. Its columns
(see ``evidence.py``) are: for a nuisance, the change of the measured balances, by differences; for
an effect's coefficient, the difference of the balances of two simulations, with it and without.
So an effect is in the model as the plant, the firmware and the log make it, and nowhere else.

Units: nuisances in priors of their logarithms, coefficients in typical sizes.
"""

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.scaling import scaled
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.evidence import Freedom, Products
from hbench.reconcile.gap import GapMap, by_point, differences, point_of
from hbench.reconcile.gap_regions import REST_M_S
from hbench.reconcile.measured.balances import (
    BALANCES,
    Model,
    Prepared,
    Windowed,
    model,
    prepared,
    residuals,
)
from hbench.reconcile.nuisance import BOUND, nuisances, slopes
from hbench.records import Run
from hbench.units import parse_unit

MOTIONS = ("rest", "steady", "unsteady")
Coefficient = tuple[str, str]  # effect, its coefficient
Column = dict[Hashable, np.ndarray]  # by operating point: (m, balances)
_LOOSE = 10.0  # typical sizes: prior of a coefficient
_SHAPE = 3.0  # quarters of its default: prior of a shape
_UNSTEADY = 0.1  # change of the velocity over a window's width, of the velocity


@dataclass(frozen=True)
class Hypothesis:
    """Factors on nuisances by dotted path, and coefficients of effects in SI."""

    factors: Mapping[str, float] = field(default_factory=dict)
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def plant(self, given: Any) -> Any:
        """Return the plant that was given, or the part of one, with these."""
        changed = scaled(given, self.factors)
        return changed.model_copy(update={"effects": {**given.effects, **self.section()}})

    def section(self) -> dict[str, dict[str, str]]:
        """Return the effects as a file has them, in the units of the catalogue."""
        return {
            name: {
                key: _quantity(value, EFFECTS[name].coefficients[key].unit)
                for key, value in coefficients.items()
            }
            for name, coefficients in self.effects.items()
        }

    def with_coefficients(self, values: Mapping[Coefficient, float]) -> "Hypothesis":
        """Return it with coefficients [SI] changed or added."""
        effects = {name: dict(own) for name, own in self.effects.items()}
        for (name, key), value in values.items():
            effects.setdefault(name, {})[key] = value
        return replace(self, effects=effects)

    def coefficient(self, which: Coefficient) -> float:
        """Return a coefficient [SI]; its default where there is none."""
        name, key = which
        row = EFFECTS[name].coefficients[key]
        return self.effects.get(name, {}).get(key, row.to_si(row.default))


Simulate = Callable[[Sequence[Hypothesis], int], Iterable[Any]]
"""Makes the campaign's runs, as many trials as told, of each hypothesis; None where it stopped."""


def coefficients(name: str) -> tuple[Coefficient, ...]:
    """Return those of an effect's coefficients that switch it on."""
    rows = EFFECTS[name].coefficients.items()
    return tuple((name, key) for key, one in rows if one.typical)


def shapes(name: str) -> tuple[Coefficient, ...]:
    """Return those that only give an effect's law another shape."""
    rows = EFFECTS[name].coefficients.items()
    return tuple((name, key) for key, one in rows if not one.typical)


def typical(which: Coefficient) -> float:
    """Return a coefficient's typical size [SI]; for a shape a quarter of its default, or 0.25."""
    one = EFFECTS[which[0]].coefficients[which[1]]
    return one.to_si(one.typical or 0.25 * (one.default or 1.0))


def _quantity(si: float, unit: str) -> str:
    return f"{si / parse_unit(unit).factor:.9g} {unit}"


def windows_of(runs: Sequence[Run], known: Model) -> list[Windowed]:
    """Return the balances of runs."""
    return [residuals(prepared(run), known) for run in runs]


def mean_column(runs: Sequence[Windowed]) -> Column:
    """Return the means over the trials of each operating point."""
    return {
        point: np.mean(
            [one.values[: min(len(one.t_s) for one in trials)] for one in trials], axis=0
        )
        for point, trials in by_point(runs).items()
    }


def less(one: Column, other: Column) -> Column:
    """Return the difference where both have windows."""
    both = {}
    for point in one.keys() & other.keys():
        m = min(len(one[point]), len(other[point]))
        both[point] = one[point][:m] - other[point][:m]
    return both


class Compared(Protocol):
    """What a search needs of the measurement."""

    @property
    def plant(self) -> Any:
        """The model that was given: a ``Plant`` or a part of one."""

    def lacking(self, hypothesis: Hypothesis, simulated: Any) -> GapMap:
        """Return what the balances lack, with the runs that the hypothesis made."""

    def slopes(self, factors: Mapping[str, float]) -> dict[str, Column]:
        """Return the change of the measured balances with the logarithm of each nuisance."""

    def around(
        self, hypothesis: Hypothesis, signatures: Mapping[Coefficient, Column]
    ) -> Mapping[Coefficient, Column]:
        """Return the signatures of the coefficients at a hypothesis, from those of the model."""


@dataclass(frozen=True)
class Measured:
    """The campaign's runs, with what no hypothesis changes."""

    bench: Bench
    plant: Plant  # the model that was given
    logs: tuple[Prepared, ...]

    @cached_property
    def first(self) -> tuple[Prepared, ...]:
        """One run of each operating point."""
        return tuple({point_of(log.run.plan): log for log in reversed(self.logs)}.values())

    def known(self, hypothesis: Hypothesis) -> Model:
        """Return the balances' model of a hypothesis: its nuisances; effects are in simulations."""
        return model(self.bench, scaled(self.plant, hypothesis.factors))

    def lacking(self, hypothesis: Hypothesis, simulated: Sequence[Run]) -> GapMap:
        """Return what the balances lack."""
        known = self.known(hypothesis)
        own = [residuals(log, known) for log in self.logs]
        return differences(own, windows_of(simulated, known))

    def slopes(self, factors: Mapping[str, float]) -> dict[str, Column]:
        """Return the change of the measured balances with the logarithm of each nuisance."""
        first = self.first
        points = [point_of(log.run.plan) for log in first]
        found = slopes(first, self.bench, self.plant, factors, BALANCES)
        return {path: dict(zip(points, own, strict=True)) for path, own in found.items()}

    def around(
        self, hypothesis: Hypothesis, signatures: Mapping[Coefficient, Column]
    ) -> Mapping[Coefficient, Column]:
        """Return the signatures as they are: effects hardly change one another's."""
        return signatures


@dataclass(frozen=True)
class Linear:
    """A hypothesis, what its balances lack, and its columns' products."""

    hypothesis: Hypothesis
    runs: tuple[Any, ...]  # simulated: ``Run``, or what stands for one
    lacking: GapMap
    data: Products
    free: Freedom

    def coefficients_of(self, names: Iterable[str]) -> tuple[Coefficient, ...]:
        """Return the columns of some effects, in the order of the columns."""
        wanted = set(names)
        split = (name.partition(".") for name in self.data.names if not name.startswith("/"))
        return tuple((effect, key) for effect, _, key in split if effect in wanted)

    def column(self, which: Coefficient) -> int:
        """Return the place of a coefficient's column."""
        return self.data.names.index(".".join(which))

    def index(self, chosen: Iterable[Coefficient]) -> list[int]:
        """Return the columns of the nuisances and of some coefficients."""
        wanted = {f"{name}.{key}" for name, key in chosen}
        return [
            i for i, name in enumerate(self.data.names) if name.startswith("/") or name in wanted
        ]


def linearise(
    measured: Compared,
    hypothesis: Hypothesis,
    simulated: Sequence[Any],
    signatures: Mapping[Coefficient, Column],
    unit: GapMap | None = None,
) -> Linear:
    """Return the surroundings of a hypothesis with its simulation; ``unit`` gives the scatters."""
    lacking = measured.lacking(hypothesis, simulated)
    scale = _like(unit or lacking, lacking)
    priors = nuisances(measured.plant)
    signatures = measured.around(hypothesis, signatures)
    columns: dict[str, Column] = {}
    found = measured.slopes(hypothesis.factors)
    for path, one_sigma in priors.items():
        columns[f"/{path}"] = {point: -one_sigma * own for point, own in found[path].items()}
    for (name, key), column in signatures.items():
        columns[f"{name}.{key}"] = column
    centre, prior, low, high = [], [], [], []
    for path, width in priors.items():
        at = np.log(hypothesis.factors.get(path, 1.0)) / width
        centre.append(-at)
        prior.append(1.0)
        low.append(-BOUND - at)
        high.append(BOUND - at)
    for which in signatures:
        row, size = EFFECTS[which[0]].coefficients[which[1]], typical(which)
        at, neutral = hypothesis.coefficient(which) / size, row.to_si(row.default)
        centre.append(neutral / size - at)
        prior.append(_LOOSE if row.typical else _SHAPE)
        low.append(min(row.to_si(row.low), neutral) / size - at)
        high.append(row.to_si(row.high) / size - at)
    free = Freedom(*(np.array(one) for one in (centre, prior, low, high)))
    return Linear(hypothesis, tuple(simulated), lacking, _products(lacking, scale, columns), free)


def moved(
    start: Linear, plant: Plant, which: Sequence[Coefficient], beta: np.ndarray
) -> Hypothesis:
    """Return the hypothesis at ``beta`` of the nuisances and of the coefficients ``which``."""
    priors = nuisances(plant)
    steps = dict(zip(priors, beta[: len(priors)].tolist(), strict=True))
    before = start.hypothesis
    factors = {
        path: float(before.factors.get(path, 1.0) * np.exp(steps[path] * prior))
        for path, prior in priors.items()
    }
    values = {
        one: before.coefficient(one) + float(step) * typical(one)
        for one, step in zip(which, beta[len(priors) :], strict=True)
    }
    return replace(before, factors=factors).with_coefficients(values)


def _like(unit: GapMap, other: GapMap) -> tuple[np.ndarray, np.ndarray]:
    """Return scatter and noise of ``unit`` at the windows of ``other``."""
    if unit is other:
        return unit.scatter, unit.noise
    places = {point: np.flatnonzero(unit.point == i) for i, point in enumerate(unit.points)}
    rows = []
    for i, point in enumerate(other.points):
        own, count = places[point], int(np.sum(other.point == i))
        rows.append(own[np.minimum(np.arange(count), len(own) - 1)])
    row = np.concatenate(rows)
    return unit.scatter[row], unit.noise[row]


def motion_of(found: GapMap) -> np.ndarray:
    """Return the place (w,) in ``MOTIONS`` of each window."""
    v = found.v_m_s
    inside = found.point[:-2] == found.point[2:]
    change = np.zeros_like(v)
    change[1:-1] = np.where(inside, np.abs(v[2:] - v[:-2]), 0.0)
    for i in range(len(found.points)):
        own = np.flatnonzero(found.point == i)
        if len(own) > 2:  # a run's first and last window are like their neighbours
            change[own[[0, -1]]] = change[own[[1, -2]]]
    unsteady = change > _UNSTEADY * np.abs(v) + REST_M_S
    return np.where(unsteady, 2, np.where(np.abs(v) < REST_M_S, 0, 1))


def _products(
    found: GapMap, scale: tuple[np.ndarray, np.ndarray], columns: Mapping[str, Column]
) -> Products:
    scatter, noise = scale
    w, c = found.difference.shape
    with np.errstate(divide="ignore", invalid="ignore"):
        d = found.difference / scatter
        relative = noise / scatter**2
    usable = np.isfinite(d) & np.isfinite(relative)
    places = [np.flatnonzero(found.point == i) for i in range(len(found.points))]
    matrix = np.zeros((w, c, len(columns) + 1))
    matrix[:, :, 0] = d
    for j, column in enumerate(columns.values(), start=1):
        for rows, point in zip(places, found.points, strict=True):
            own = column.get(point)
            if own is not None:
                m = min(len(rows), len(own))
                matrix[rows[:m], :, j] = own[:m] / scatter[rows[:m]]
    matrix = np.where(usable[:, :, None], np.nan_to_num(matrix), 0.0)
    motion = motion_of(found)
    shape = len(found.points), c * len(MOTIONS)
    sums = np.zeros((*shape, matrix.shape[2], matrix.shape[2]))
    noises, counts = np.zeros(shape), np.zeros(shape)
    for p, rows in enumerate(places):
        for k in range(len(MOTIONS)):
            own = rows[motion[rows] == k]
            if not len(own):
                continue
            part = matrix[own].transpose(1, 2, 0)  # (c, q, m)
            at = slice(k, None, len(MOTIONS))
            sums[p, at] = part @ part.transpose(0, 2, 1)
            counts[p, at] = usable[own].sum(axis=0)
            noises[p, at] = np.where(usable[own], relative[own], 0.0).sum(axis=0)
    return Products(
        names=tuple(columns),
        columns=sums[:, :, 1:, 1:],
        mixed=sums[:, :, 0, 1:],
        squares=sums[:, :, 0, 0],
        noise=noises,
        windows=counts,
        groups=tuple((name, motion) for name in found.names for motion in MOTIONS),
    )
