"""Steady strokes of another bench, whose motion is not simulated, as measurements of the search.

The residual of a stroke's means is r = F_T - F_applied - F_fT(v, P), without acceleration. A pair
of strokes, one in each direction at one load, is one window of two balances:

    force_band     N    (r_extend - r_retract) / 2: half the friction band, free of force offsets
    force_middle   N    (r_extend + r_retract) / 2: the part that is the same in both directions

The simulation of a stroke is the load cell's force at the measured velocity and pressures. Effects
act as in the plant (``model/effects/applied.py``) on a state of these means, with their own states
at equilibrium, and in the sensors. The piston is at mid-stroke, since a mean over a stroke has no
position. Load cylinder, valves and oil are unknown.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from functools import cached_property

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.config.scaling import scaled
from hbench.config.stroke_model import StrokePlant
from hbench.model.build import friction_parameters
from hbench.model.effects.applied import friction_effects
from hbench.model.effects.catalogue import EFFECTS, changed_by, read_effects, with_effects
from hbench.model.friction.laws import steady_friction, steady_parts
from hbench.model.parameters import (
    CylinderParameters,
    EndStopParameters,
    PlantParameters,
    SupplyParameters,
    ValveParameters,
)
from hbench.model.plant import P_TP, P_TR, V, bristles_end, n_states
from hbench.model.sensors import N_CHANNELS, SensorParameters
from hbench.reconcile.gaps.columns import ModelColumn, mean_column
from hbench.reconcile.gaps.gap_map import GapMap, gap_map
from hbench.reconcile.hypothesis import (
    CoefficientKey,
    Hypothesis,
    effect_coefficients,
    typical_size,
)
from hbench.reconcile.measured.balances import WindowedRun
from hbench.reconcile.nuisance import nuisances
from hbench.records import KINDS, RunPlan, ScreenedRun, SteadyMeans

STROKE_BALANCES = ("force_band", "force_middle")
_STROKE_M = 1.0  # arbitrary: the piston is at mid-stroke
_STEP = 1e-3  # finite difference of a logarithm, and of an effect's state
_NEGLIGIBLE_N = 1e-9  # change of force by a typical size
_LEAST_SHARE = 0.1  # of a coefficient's larger change; a smaller change is set to zero
_LAWS = {"friction", "sensors"}  # of effects that can act on a stroke's forces
_IDEAL_SENSORS = SensorParameters((1.0,) * N_CHANNELS, (0.0,) * N_CHANNELS, 0.0, 0.0, False)
_P_TP, _P_TR, _FORCE = 1, 2, 6  # of sensors.CHANNELS


@dataclass(frozen=True)
class Stroke:
    """Means over one steady stroke, or over the strokes of one trial."""

    t_s: float  # centre of its window
    v_m_s: float
    p_tp_pa: float
    p_tr_pa: float  # 0 for a plunger
    f_applied_n: float


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
            load = replace(plan, run="", trial=0, v_ref_m_s=0.0)
            by_trial = strokes.setdefault(load, defaultdict(list))
            by_trial[plan.trial, plan.direction].append(_stroke(means))
    repeated = any(len({trial for trial, _ in by_trial}) > 1 for by_trial in strokes.values())
    pairs = []
    for load, by_trial in strokes.items():
        for trial in sorted({trial for trial, _ in by_trial}):
            extending, retracting = by_trial[trial, "extend"], by_trial[trial, "retract"]
            if repeated and extending and retracting:
                extending, retracting = [_mean(extending)], [_mean(retracting)]
            pairs += [StrokePair(load, *both) for both in zip(extending, retracting, strict=False)]
    return tuple(pairs)


def _stroke(means: SteadyMeans) -> Stroke:
    assert means.p_tp_pa is not None and means.f_applied_n is not None  # of an accepted run
    centre = (means.t_start_s + means.t_stop_s) / 2
    return Stroke(centre, means.v_m_s, means.p_tp_pa, means.p_tr_pa or 0.0, means.f_applied_n)


def _mean(strokes: Sequence[Stroke]) -> Stroke:
    return Stroke(*np.mean([astuple(stroke) for stroke in strokes], axis=0).tolist())


def plant_with_test_cylinder(plant: StrokePlant) -> PlantParameters:
    """Return plant parameters in which only the test cylinder has values of the model."""
    bore, friction = plant.test_cylinder, friction_parameters(plant.friction.test)
    areas = bore.area_piston_m2, bore.area_rod_m2
    test = CylinderParameters(*areas, _STROKE_M, 1e-3, 1e-3, 0.5 * _STROKE_M, friction)
    par = PlantParameters(
        test=test,
        load=test,
        mass_test_kg=1.0,
        mass_load_kg=1.0,
        bulk_modulus_pa=1e9,
        supply=SupplyParameters(False, *[0.0] * 11),
        valve=ValveParameters(*[1.0] * 4),
        end_stop=EndStopParameters(0.0, 0.0),
        substeps=1,
    )
    return with_effects(par, read_effects(plant.effects))


def load_cell_reading(stroke: Stroke, par: PlantParameters, sensors: SensorParameters) -> float:
    """Return the load cell's reading [N] in a model at a stroke's velocity and pressures."""
    p_tp, p_tr = (
        (logged - sensors.zero[i]) / sensors.per_unit[i]
        for i, logged in ((_P_TP, stroke.p_tp_pa), (_P_TR, stroke.p_tr_pa))
    )
    state = np.zeros(n_states(par))
    state[[V, P_TP, P_TR]] = stroke.v_m_s, p_tp, p_tr
    _set_to_equilibrium(state, par)
    level, _, more, _ = friction_effects(1.0, 1.0, state, par, par.effects, np.zeros(len(state)))
    dry, viscous = steady_parts(stroke.v_m_s, p_tp, p_tr, level, par.test.friction)
    force = p_tp * par.test.area_piston_m2 - p_tr * par.test.area_rod_m2 - dry - viscous - more
    return float(sensors.per_unit[_FORCE] * force + sensors.zero[_FORCE])


def _set_to_equilibrium(state: np.ndarray, par: PlantParameters) -> None:
    """Set the effects' own states to equilibrium by one Newton step.

    Their rates are linear in them at constant speed.
    """
    first = bristles_end(par)
    count = len(state) - first
    if not count:
        return

    def rates(stepped: int | None) -> np.ndarray:
        at, out = state.copy(), np.zeros(len(state))
        if stepped is not None:
            at[first + stepped] += _STEP
        friction_effects(1.0, 1.0, at, par, par.effects, out)
        return out[first:]

    initial = rates(None)
    if not initial.any():
        return
    slope = np.column_stack([(rates(i) - initial) / _STEP for i in range(count)])
    state[first:] -= np.linalg.lstsq(slope, initial, rcond=None)[0]


def force_residual(stroke: Stroke, par: PlantParameters) -> float:
    """Return the residual of a stroke [N]: F_T - F_applied - F_fT, friction without effects."""
    test = par.test
    friction = steady_friction(stroke.v_m_s, stroke.p_tp_pa, stroke.p_tr_pa, test.friction)
    f_test = stroke.p_tp_pa * test.area_piston_m2 - stroke.p_tr_pa * test.area_rod_m2
    return f_test - stroke.f_applied_n - friction


def pair_residuals(pair: StrokePair, par: PlantParameters) -> WindowedRun:
    """Return the residuals of a pair as one window, with the means of both strokes."""
    out, back = pair.extend, pair.retract
    r_out, r_back = force_residual(out, par), force_residual(back, par)
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

    def simulate(
        self, hypotheses: Sequence[Hypothesis], trials: int
    ) -> list[tuple[StrokePair, ...]]:
        """Return the mean pairs as simulated with each hypothesis; ``trials`` has no effect."""
        return [self._simulated(hypothesis) for hypothesis in hypotheses]

    def _simulated(self, hypothesis: Hypothesis) -> tuple[StrokePair, ...]:
        plant = hypothesis.plant(self.plant)
        par = plant_with_test_cylinder(plant)
        sensors = changed_by("sensors", _IDEAL_SENSORS, read_effects(plant.effects))

        def simulated(stroke: Stroke) -> Stroke:
            return replace(stroke, f_applied_n=load_cell_reading(stroke, par, sensors))

        return tuple(
            replace(pair, extend=simulated(pair.extend), retract=simulated(pair.retract))
            for pair in self.mean_pairs
        )

    @cached_property
    def mean_pairs(self) -> tuple[StrokePair, ...]:
        """The mean pair of each load, which a hypothesis simulates."""
        loads: dict[RunPlan, list[StrokePair]] = defaultdict(list)
        for pair in self.pairs:
            loads[pair.plan].append(pair)
        return tuple(
            StrokePair(
                load, _mean([pair.extend for pair in own]), _mean([pair.retract for pair in own])
            )
            for load, own in loads.items()
        )

    def residuals(self, hypothesis: Hypothesis, pairs: Sequence[StrokePair]) -> list[WindowedRun]:
        """Return residuals with a hypothesis' factors; simulated pairs contain its effects."""
        par = plant_with_test_cylinder(scaled(self.plant, hypothesis.factors))
        return [pair_residuals(pair, par) for pair in pairs]

    def gap_map(self, hypothesis: Hypothesis, simulated: Sequence[StrokePair]) -> GapMap:
        """Return the differences between the measured strokes and those simulated."""
        return gap_map(
            self.residuals(hypothesis, self.pairs), self.residuals(hypothesis, simulated)
        )

    def slopes(self, factors: Mapping[str, float]) -> dict[str, ModelColumn]:
        """Return the derivatives of the measured balances by the logarithm of each nuisance."""
        before = mean_column(self.residuals(Hypothesis(factors), self.mean_pairs))
        derivatives = {}
        for path in nuisances(self.plant):
            value = factors.get(path, 1.0)
            step = -_STEP if value > 1 else _STEP  # towards a factor of 1
            stepped = Hypothesis({**factors, path: value * float(np.exp(step))})
            after = mean_column(self.residuals(stepped, self.mean_pairs))
            derivatives[path] = {
                point: (after[point] - values) / step for point, values in before.items()
            }
        return derivatives

    def signatures_at(
        self, hypothesis: Hypothesis, signatures: Iterable[CoefficientKey]
    ) -> dict[CoefficientKey, ModelColumn]:
        """Return the signatures at a hypothesis: a share of friction scales with the friction."""
        before = self._column(hypothesis, hypothesis)
        return {which: self._signature(hypothesis, which, before) for which in signatures}

    def _column(self, hypothesis: Hypothesis, simulated_with: Hypothesis) -> ModelColumn:
        return mean_column(self.residuals(hypothesis, self._simulated(simulated_with)))

    def _signature(
        self, hypothesis: Hypothesis, which: CoefficientKey, before: ModelColumn
    ) -> ModelColumn:
        """Return the change of the balances by a coefficient's typical size, from the slope.

        A change below a tenth of that of the other balance is set to zero.
        """
        row = EFFECTS[which[0]].coefficients[which[1]]
        step, current = _STEP * typical_size(which), hypothesis.coefficient(which)
        step = max(step, row.to_si(row.low) - current)
        if current + step > row.to_si(row.high):
            step = -step
        stepped = hypothesis.with_coefficients({which: current + step})
        scale = typical_size(which) / step
        after = self._column(hypothesis, stepped)
        column = {point: scale * (after[point] - values) for point, values in before.items()}
        most = np.max([np.abs(values).max(axis=0) for values in column.values()], axis=0)
        keep = (most > _LEAST_SHARE * most.max()) & (most > _NEGLIGIBLE_N)
        return {point: np.where(keep, values, 0.0) for point, values in column.items()}

    @cached_property
    def signatures(self) -> dict[CoefficientKey, ModelColumn]:
        """The coefficients that change the mean of a steady stroke, with their columns."""
        acting = [name for name, row in EFFECTS.items() if not _LAWS.isdisjoint(row.laws)]
        wanted = dict.fromkeys(which for name in acting for which in effect_coefficients(name))
        if not self._rod_side_measured:
            wanted.pop(("pressure_offset", "p_tr"), None)
        columns = self.signatures_at(Hypothesis(), wanted)
        return {
            which: column
            for which, column in columns.items()
            if any(values.any() for values in column.values())
        }

    @property
    def _rod_side_measured(self) -> bool:
        """Whether the rod-side pressure varies: a constant but for rounding is not a channel."""
        strokes = [stroke for pair in self.pairs for stroke in (pair.extend, pair.retract)]
        return not is_constant(np.array([stroke.p_tr_pa for stroke in strokes]))
