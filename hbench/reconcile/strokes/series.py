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
"""

from collections import defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from functools import cached_property

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.config.bench import Bore
from hbench.config.scaling import scaled
from hbench.config.stroke_model import StrokePlant
from hbench.model.effects.catalogue import EFFECTS, changed_by, read_effects
from hbench.model.parameters import PlantParameters
from hbench.model.sensors import SensorParameters, ideal_sensors
from hbench.reconcile.gaps.gap_map import GapMap, by_point, column_means, gap_map, gaps, point_of
from hbench.reconcile.hypothesis import CoefficientKey, Hypothesis, effect_coefficients, stepped
from hbench.reconcile.linearised import Columns
from hbench.reconcile.measured.balances import WindowedRun
from hbench.reconcile.nuisance import BACKGROUND, nuisances
from hbench.reconcile.strokes.load_cell import (
    Stroke,
    load_cell_reading,
    plant_with_test_cylinder,
)
from hbench.reconcile.strokes.within_stroke import change_over_window, contradiction
from hbench.records import KINDS, Gap, Run, RunPlan, ScreenedRun, Specimen, SteadyMeans

STROKE_BALANCES = ("force_band", "force_middle")
_STEP = 1e-3  # of a logarithm, and of typical sizes
_NEGLIGIBLE_N = 1e-9  # change of force by a typical size
_LEAST_SHARE = 0.1  # of a coefficient's larger change; a smaller change is set to zero
_LOAD_IN_BAND = 0.1  # share of the friction band that a difference of the load may have
_MAGNITUDES = {"coulomb", "stiction", "stribeck_force", "viscous"}  # of friction
_LAWS = {"friction", "sensors"}  # of effects that can act on a stroke's forces
# Forces alone do not show it: one pressure's gain is a gain of the load cell but for the other one.
_NEEDS_FLOWS = frozenset({"pressure_gain"})


@dataclass(frozen=True)
class StrokePair:
    """Strokes in both directions at one load and pressure."""

    plan: RunPlan  # of the load, without a speed
    extend: Stroke
    retract: Stroke


def stroke_pairs(screened: Iterable[ScreenedRun]) -> tuple[StrokePair, ...]:
    """Return accepted steady runs in pairs; one pair for each trial if a load has several trials.

    Strokes of one trial share its set-up, so they are not independent repeats. Where no load has a
    second trial, successive strokes are paired and serve as repeats.
    """
    strokes: dict[RunPlan, dict[tuple[int, str], list[Stroke]]] = {}
    for run in screened:
        means, plan = run.means, run.run.plan
        if run.accepted and KINDS[plan.kind].has_constant_speed and means is not None:
            load = replace(
                plan, run="", trial=0, v_ref_m_s=0.0, x_low_m=None, x_high_m=None
            )  # the positions to average over are those of a file
            by_trial = strokes.setdefault(load, defaultdict(list))
            by_trial[plan.trial, plan.direction].append(_stroke(run.run, means))
    repeated = any(len({trial for trial, _ in by_trial}) > 1 for by_trial in strokes.values())
    pairs = []
    for load, by_trial in strokes.items():
        for trial in sorted({trial for trial, _ in by_trial}):
            extending, retracting = by_trial[trial, "extend"], by_trial[trial, "retract"]
            if repeated and extending and retracting:
                extending, retracting = [_mean(extending)], [_mean(retracting)]
            pairs += [StrokePair(load, *both) for both in zip(extending, retracting, strict=False)]
    return tuple(pairs)


def has_force_sensor(screened: Iterable[ScreenedRun]) -> bool:
    """Return whether the applied force varies among the samples of a load, as readings do."""
    forces: dict[float | None, list[np.ndarray]] = defaultdict(list)
    for run in screened:
        if run.run.f_applied_n is not None:
            forces[run.run.plan.f_load_n].append(run.run.f_applied_n)
    return not all(is_constant(np.concatenate(of_load)) for of_load in forces.values())


def with_unknown_load(pairs: Iterable[StrokePair]) -> tuple[StrokePair, ...]:
    """Return pairs whose applied force is the mean pressure force of both directions.

    A pair is left out if its load differs between the mean positions of its strokes by more than a
    tenth of the friction band, since that difference would count as friction.
    """
    out = []
    for pair in pairs:
        strokes, areas = (pair.extend, pair.retract), pair.plan.specimen
        forces = [_pressure_force(stroke, areas) for stroke in strokes]
        travel = sum(stroke.travel_m for stroke in strokes)
        slope = sum(stroke.change_n for stroke in strokes) / travel if travel > 0 else 0.0
        of_load = slope * (pair.extend.x_m - pair.retract.x_m)
        if abs(of_load) <= _LOAD_IN_BAND * abs(forces[0] - forces[1]):
            load = sum(forces) / 2
            both = (replace(stroke, f_applied_n=load) for stroke in strokes)
            out.append(StrokePair(pair.plan, *both))
    return tuple(out)


def _stroke(run: Run, means: SteadyMeans) -> Stroke:
    assert means.p_tp_pa is not None and means.f_applied_n is not None  # of an accepted run
    centre = (means.t_start_s + means.t_stop_s) / 2
    x_m = run.x_m[(run.t_s >= means.t_start_s) & (run.t_s <= means.t_stop_s)]
    return Stroke(
        t_s=centre,
        v_m_s=means.v_m_s,
        p_tp_pa=means.p_tp_pa,
        p_tr_pa=means.p_tr_pa or 0.0,
        f_applied_n=means.f_applied_n,
        change_n=change_over_window(run, means),
        x_m=float(x_m.mean()) if len(x_m) else 0.0,
        travel_m=float(np.ptp(x_m)) if len(x_m) else 0.0,
    )


def _mean(strokes: Sequence[Stroke]) -> Stroke:
    return Stroke(*np.mean([astuple(stroke) for stroke in strokes], axis=0).tolist())


def _lost_force(stroke: Stroke, areas: Bore) -> float:
    """Return F_T - F_applied [N] of a stroke."""
    return _pressure_force(stroke, areas) - stroke.f_applied_n


def _pressure_force(stroke: Stroke, areas: Bore | Specimen) -> float:
    return stroke.p_tp_pa * areas.area_piston_m2 - stroke.p_tr_pa * areas.area_rod_m2


def pair_residuals(
    pair: StrokePair, par: PlantParameters, sensors: SensorParameters
) -> WindowedRun:
    """Return the residuals of a pair as one window, with the means of both strokes."""
    out, back = pair.extend, pair.retract
    r_out, r_back = (
        load_cell_reading(stroke, par, sensors) - stroke.f_applied_n for stroke in (out, back)
    )
    speed, load = (out.v_m_s - back.v_m_s) / 2, (out.f_applied_n + back.f_applied_n) / 2
    return WindowedRun(
        plan=pair.plan,
        names=STROKE_BALANCES,
        values=np.array([[(r_out - r_back) / 2, (r_out + r_back) / 2]]),
        t_s=np.array([(out.t_s + back.t_s) / 2]),
        x_m=np.array([np.nan]),
        v_m_s=np.array([speed]),
        load_n=np.array([load]),
        resolution=np.zeros(2),
    )


@dataclass(frozen=True)
class MeasuredStrokes:
    """Measured strokes of one series and the given model."""

    plant: StrokePlant  # the given model
    pairs: tuple[StrokePair, ...]
    load_is_known: bool = True  # False without a force sensor

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

    @property
    def tolerances(self) -> Mapping[CoefficientKey, float]:
        """Limits [SI] of the coefficients that are nuisances within them: none is known."""
        return {}

    @property
    def start(self) -> Hypothesis:
        """The given model."""
        return Hypothesis()

    @cached_property
    def mean_pairs(self) -> tuple[StrokePair, ...]:
        """The mean pair of each load, in the order of the gap map."""
        loads: dict[Hashable, list[StrokePair]] = defaultdict(list)
        for pair in self.pairs:
            loads[point_of(pair.plan)].append(pair)
        return tuple(
            StrokePair(
                own[0].plan,
                _mean([pair.extend for pair in own]),
                _mean([pair.retract for pair in own]),
            )
            for own in loads.values()
        )

    def gap_map(self, hypothesis: Hypothesis, reference: GapMap | None = None) -> GapMap:
        """Return the residuals of the loads with a hypothesis, in the scatter of a ``reference``.

        Raises ``DataError``.
        """
        residuals = self._compared(hypothesis)
        own = gap_map(residuals, _exact(residuals))
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
            np.array([(_lost_force(stroke, areas), stroke.change_n) for stroke in strokes])
            for strokes in (
                [pair.extend for pair in self.mean_pairs],
                [pair.retract for pair in self.mean_pairs],
            )
        )
        return contradiction(name, extend, retract)

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
        columns = self.columns(Hypothesis(), map(".".join, wanted))
        return tuple(which for which in wanted if columns[".".join(which)].any())

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
            for run in self._residuals(hypothesis, self.pairs)
        ]

    def _residuals(self, hypothesis: Hypothesis, pairs: Sequence[StrokePair]) -> list[WindowedRun]:
        plant = hypothesis.plant(self.plant)
        par = plant_with_test_cylinder(plant)
        sensors = changed_by("sensors", ideal_sensors(), read_effects(plant.effects))
        return [pair_residuals(pair, par, sensors) for pair in pairs]

    def _values(self, hypothesis: Hypothesis) -> np.ndarray:
        """Return the residuals (w, 2) of the mean pairs."""
        return np.concatenate([run.values for run in self._residuals(hypothesis, self.mean_pairs)])

    def _column(self, hypothesis: Hypothesis, name: str, before: np.ndarray) -> np.ndarray:
        """Return a column; one of an effect is zero where it is below a tenth of the other."""
        after, share = stepped(hypothesis, name, nuisances(self.plant), _STEP)
        change = (before - self._values(after)) / share
        if not name.startswith("/"):
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
