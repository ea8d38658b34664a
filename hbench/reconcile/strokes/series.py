"""Steady strokes of another bench, whose motion is not simulated, as measurements of the search.

The residual of a stroke's means is the model's reading of the load cell less the measured one. For
ideal sensors it is r = F_T - F_applied - F_fT(v, P), without acceleration: a force against
extension that the model does not contain. A pair of strokes, one in each direction at one load, is
one window of two balances:

    force_band     N    (r_extend - r_retract) / 2: half the friction band, free of force offsets
    force_middle   N    (r_extend + r_retract) / 2: the part that is the same in both directions

Without a force sensor the applied force is a constant of the import's map, and the load that acts
is unknown. It is the same in both directions at the same positions, so force_band does not depend
on it. force_middle contains it and is not compared.

The model reads the load cell at the measured velocity and pressures. Effects act as in the plant
(``model/effects/applied.py``) on a state of these means, with their own states at equilibrium, and
in the sensors. The piston is at mid-stroke, since a mean over a stroke has no position. Load
cylinder, valves and oil are unknown.

Each speed that was set is a window of its own: friction is not linear in the speed, so the mean of
several speeds is not the friction at their mean. A load's operating point has the windows of all.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.config.scaling import scaled
from hbench.config.sensors import Instruments
from hbench.config.stroke_model import StrokePlant
from hbench.model.effects.catalogue import EFFECTS, changed_by, read_effects
from hbench.model.parameters import PlantParameters
from hbench.model.sensors import SensorParameters, ideal_sensors
from hbench.reconcile.column_names import CoefficientKey, coefficient_name, is_coefficient
from hbench.reconcile.gaps.gap_map import GapMap, by_point, column_means, gap_map, gaps
from hbench.reconcile.hypothesis import Hypothesis, effect_coefficients, stepped
from hbench.reconcile.linearised import Columns
from hbench.reconcile.measured.balances import WindowedRun
from hbench.reconcile.nuisance import BACKGROUND, nuisances, sensor_tolerances
from hbench.reconcile.practice.fitted import without_effect
from hbench.reconcile.strokes.load_cell import (
    load_cell_reading,
    plant_with_test_cylinder,
)
from hbench.reconcile.strokes.pairs import StrokePair, lost_force, mean_pair, repeats
from hbench.reconcile.strokes.within_stroke import contradiction
from hbench.records import Gap

STROKE_BALANCES = ("force_band", "force_middle")
_STEP = 1e-3  # of a logarithm, and of typical sizes
_NEGLIGIBLE_N = 1e-9  # change of force by a typical size
_LEAST_SHARE = 0.1  # of a coefficient's larger change; a smaller change is set to zero
_MAGNITUDES = {"coulomb", "stiction", "stribeck_force", "viscous"}  # of friction
_LAWS = {"friction", "sensors"}  # of effects that can act on a stroke's forces
# Forces alone do not show it: one pressure's gain is a gain of the load cell but for the other one.
_NEEDS_FLOWS = frozenset({"pressure_gain"})


def residuals_of(
    pairs: Sequence[StrokePair], par: PlantParameters, sensors: SensorParameters
) -> WindowedRun:
    """Return the residuals of pairs at one load as windows, with the means of both strokes."""
    both = [(pair.extend, pair.retract) for pair in pairs]
    values = np.array(
        [
            [load_cell_reading(stroke, par, sensors) - stroke.f_applied_n for stroke in strokes]
            for strokes in both
        ]
    )
    r_out, r_back = values.T
    return WindowedRun(
        plan=pairs[0].plan,
        names=STROKE_BALANCES,
        values=np.column_stack([(r_out - r_back) / 2, (r_out + r_back) / 2]),
        t_s=np.array([(out.t_s + back.t_s) / 2 for out, back in both]),
        x_m=np.full(len(both), np.nan),
        v_m_s=np.array([(out.v_m_s - back.v_m_s) / 2 for out, back in both]),
        load_n=np.array([(out.f_applied_n + back.f_applied_n) / 2 for out, back in both]),
        resolution=np.zeros(2),
    )


@dataclass(frozen=True)
class MeasuredStrokes:
    """Measured strokes of one series and the given model."""

    plant: StrokePlant  # the given model
    pairs: tuple[StrokePair, ...]
    load_is_known: bool = True  # False without a force sensor
    instruments: Instruments | None = None  # as the campaign states them

    @property
    def balances(self) -> tuple[str, ...]:
        """Names of the balances that are compared."""
        return STROKE_BALANCES if self.load_is_known else STROKE_BALANCES[:1]

    @cached_property
    def levels(self) -> dict[str, float]:
        """Factors on friction's magnitudes with which the mean half band is the measured one.

        All are equal: the level of friction is measured, so that of the given model is no evidence.
        Where effects of the given model exceed the band, it is kept.
        """
        names = [path for path in nuisances(self.plant) if path.split(".")[-1] in _MAGNITUDES]
        raised = Hypothesis(factors=dict.fromkeys(names, 1.0 + _STEP))
        half_band = self._values(Hypothesis())[:, 0].mean()
        friction = (half_band - self._values(raised)[:, 0].mean()) / _STEP
        level = 1.0 + half_band / friction if friction > 0 else 1.0
        return dict.fromkeys(names, float(level) if level > 0 else 1.0)

    @property
    def levelled(self) -> "MeasuredStrokes":
        """The same strokes with the factors ``levels`` applied to the given model."""
        return replace(self, plant=scaled(self.plant, self.levels))

    @cached_property
    def tolerances(self) -> Mapping[CoefficientKey, float]:
        """Limits [SI] of the coefficients that are nuisances within them, of stated instruments.

        A gain of the load cell represents that of the pressures too, which may add to it.
        """
        if self.instruments is None or not self.load_is_known:
            return {}
        strokes = [stroke for pair in self.pairs for stroke in (pair.extend, pair.retract)]
        largest_pa = max(max(stroke.p_tp_pa, stroke.p_tr_pa) for stroke in strokes)
        largest_n = max(abs(stroke.f_applied_n) for stroke in strokes)
        limits = sensor_tolerances(self.instruments, largest_pa, largest_n)
        limits["load_cell_gain", "error"] += self.instruments.pressure.tolerance
        return {which: limit for which, limit in limits.items() if which in self.observable}

    @property
    def start(self) -> Hypothesis:
        """The given model."""
        return Hypothesis()

    @cached_property
    def runs(self) -> tuple[tuple[StrokePair, ...], ...]:
        """The repeats of all loads."""
        return tuple(run for of_load in repeats(self.pairs).values() for run in of_load)

    @cached_property
    def mean_runs(self) -> tuple[tuple[StrokePair, ...], ...]:
        """The mean pairs of each load, one of each speed."""
        return tuple(
            tuple(mean_pair(of_speed) for of_speed in zip(*of_load, strict=True))
            for of_load in repeats(self.pairs).values()
        )

    @property
    def mean_pairs(self) -> tuple[StrokePair, ...]:
        """The mean pair of each load and speed, in the order of the gap map."""
        return tuple(pair for run in self.mean_runs for pair in run)

    def gap_map(self, hypothesis: Hypothesis, reference: GapMap | None = None) -> GapMap:
        """Return the residuals of the loads with a hypothesis, in the scatter of a ``reference``.

        Raises ``DataError``.
        """
        residuals = self._compared(hypothesis)
        own = gap_map(residuals, _exact(residuals))
        own = replace(own, run=np.arange(len(own.run)))  # speeds are no changes within a motion
        return own if reference is None else own.in_units_of(reference)

    def ranked_gaps(self, hypothesis: Hypothesis) -> tuple[Gap, ...]:
        """Return the gaps of both balances with a hypothesis, largest first.

        Their deviations are root mean squares over all pairs of strokes, with their scatter.
        """
        residuals = self._compared(hypothesis)
        ranked, differences = gaps(residuals, _exact(residuals))
        squares = column_means(differences.difference**2)
        deviations = dict(zip(differences.names, np.sqrt(squares).tolist(), strict=True))
        return tuple(replace(gap, deviation=deviations[gap.name]) for gap in ranked)

    def contradiction(self, name: str) -> str:
        """Return why an effect can't explain the mean of both directions; empty if it can."""
        areas = self.plant.test_cylinder
        extend, retract = (
            np.array([(lost_force(stroke, areas), stroke.change_n) for stroke in strokes])
            for strokes in (
                [pair.extend for pair in self.mean_pairs],
                [pair.retract for pair in self.mean_pairs],
            )
        )
        return contradiction(name, extend, retract)

    def excess_friction(self, hypothesis: Hypothesis, name: str) -> str:
        """Return where an effect has more friction than was measured; empty if it has not.

        That of the law would be negative. A search does not see it: it is linear in the changes.
        """
        without = self._values(without_effect(hypothesis, name))[:, 0]
        of_effect = without - self._values(hypothesis)[:, 0]
        areas = self.plant.test_cylinder
        measured = np.array(
            [
                (lost_force(pair.extend, areas) - lost_force(pair.retract, areas)) / 2
                for pair in self.mean_pairs
            ]
        )
        worst = int(np.argmax(of_effect - measured))
        if of_effect[worst] <= measured[worst]:
            return ""
        pair = self.mean_pairs[worst].extend
        return (
            f"it would be {of_effect[worst]:.0f} N of friction where {measured[worst]:.0f} N were "
            f"measured (piston side {pair.p_tp_pa / 1e5:.3g} bar, {1e3 * pair.v_m_s:.3g} mm/s)"
        )

    def columns(self, hypothesis: Hypothesis, names: Iterable[str]) -> Columns:
        """Return the columns ``names`` at a hypothesis: changes by one unit, times -1.

        By finite differences at the mean strokes of each load.
        """
        before = self._values(hypothesis)
        return {name: self._column(hypothesis, name, before) for name in names}

    @cached_property
    def observable(self) -> tuple[CoefficientKey, ...]:
        """The coefficients of effects that change the mean of a steady stroke."""
        acting = [
            name
            for name, row in EFFECTS.items()
            if row.balances
            and name not in BACKGROUND | _NEEDS_FLOWS
            and not _LAWS.isdisjoint(row.laws)
        ]
        wanted = dict.fromkeys(which for name in acting for which in effect_coefficients(name))
        if not self._rod_side_measured:
            wanted.pop(("pressure_offset", "p_tr"), None)
        columns = self.columns(Hypothesis(), map(coefficient_name, wanted))
        return tuple(which for which in wanted if columns[coefficient_name(which)].any())

    def _compared(self, hypothesis: Hypothesis) -> list[WindowedRun]:
        """Return the residuals of the balances that are compared."""
        count = len(self.balances)
        return [
            replace(
                run,
                names=self.balances,
                values=run.values[:, :count],
                resolution=run.resolution[:count],
            )
            for run in self._residuals(hypothesis, self.runs)
        ]

    def _residuals(
        self, hypothesis: Hypothesis, runs: Sequence[Sequence[StrokePair]]
    ) -> list[WindowedRun]:
        plant = hypothesis.plant(self.plant)
        par = plant_with_test_cylinder(plant)
        sensors = changed_by("sensors", ideal_sensors(), read_effects(plant.effects))
        return [residuals_of(pairs, par, sensors) for pairs in runs]

    def _values(self, hypothesis: Hypothesis) -> np.ndarray:
        """Return the residuals (w, 2) of the mean pairs."""
        return np.concatenate([run.values for run in self._residuals(hypothesis, self.mean_runs)])

    def _column(self, hypothesis: Hypothesis, name: str, before: np.ndarray) -> np.ndarray:
        """Return a column; one of an effect is zero where it is below a tenth of the other."""
        after, share = stepped(hypothesis, name, nuisances(self.plant), _STEP)
        change = (before - self._values(after)) / share
        if is_coefficient(name):
            most = np.abs(change).max(axis=0)
            large = (most > _LEAST_SHARE * most.max()) & (most > _NEGLIGIBLE_N)
            change = np.where(large, change, 0.0)
        return change[:, : len(self.balances)]

    @property
    def _rod_side_measured(self) -> bool:
        """Whether the rod-side pressure varies: a constant but for rounding is not a channel."""
        strokes = [stroke for pair in self.pairs for stroke in (pair.extend, pair.retract)]
        return not is_constant(np.array([stroke.p_tr_pa for stroke in strokes]))


def _exact(residuals: Sequence[WindowedRun]) -> list[WindowedRun]:
    """Return the residuals of a model that is exact, one run for each operating point."""
    return [replace(runs[0], values=0 * runs[0].values) for runs in by_point(residuals).values()]
