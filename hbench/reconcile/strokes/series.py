"""Steady strokes that another bench made, whose motion no simulation makes, for the search.

The balance of a stroke's means lacks r = F_T - F_applied - F_fT(v, P), no acceleration. A stroke
each way at one load is one window of two balances:

    force_band     N    (r_extend - r_retract) / 2: friction, free of a constant error in force
    force_middle   N    (r_extend + r_retract) / 2: what does not turn with the direction

A hypothesis "makes" a stroke again by giving the load cell's force at the measured velocity and
pressures. Its effects act as in the plant (``model/effects/applied.py``) on a state of these means,
with their own states settled, and in the sensors. The piston is in the middle of its stroke, for a
mean over a stroke has no position; nothing is known of load cylinder, valves and oil.
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
from hbench.reconcile.gap import GapMap, differences
from hbench.reconcile.linearised import (
    Coefficient,
    Column,
    Hypothesis,
    coefficients,
    mean_column,
    typical,
)
from hbench.reconcile.measured.balances import Windowed
from hbench.reconcile.nuisance import nuisances
from hbench.records import KINDS, RunPlan, ScreenedRun

BALANCES = ("force_band", "force_middle")
_STROKE_M = 1.0  # any: the piston stands in its middle
_STEP = 1e-3  # of a logarithm, and of an effect's state
_NOTHING_N = 1e-9  # change of force that a typical size must exceed to be one
_LEAST = 0.1  # of a coefficient's change in one balance: less in the other is left out
_PLACES = {"friction", "sensors"}  # where an effect can act on a stroke's forces
_ONE = SensorParameters((1.0,) * N_CHANNELS, (0.0,) * N_CHANNELS, 0.0, 0.0, False)
_P_TP, _P_TR, _FORCE = 1, 2, 6  # of sensors.CHANNELS


@dataclass(frozen=True)
class Stroke:
    """Means over one steady stroke, or over the strokes of one trial."""

    t_s: float  # middle of its window
    v_m_s: float
    p_tp_pa: float
    p_tr_pa: float  # 0 for a plunger
    f_applied_n: float


@dataclass(frozen=True)
class Pair:
    """A stroke each way at one load and pressure."""

    plan: RunPlan  # with no speed: that of the load
    extend: Stroke
    retract: Stroke


def pairs_of(screened: Iterable[ScreenedRun]) -> tuple[Pair, ...]:
    """Return accepted steady runs in pairs; one for each trial where trials repeat.

    Strokes of one trial share its set-up, so they are no independent repeats of it. Where no load
    has a second trial they are all the repeats that there are, and follow one another in pairs.
    """
    found: dict[RunPlan, dict[tuple[int, str], list[Stroke]]] = {}
    for one in screened:
        means, plan = one.means, one.run.plan
        if one.accepted and KINDS[plan.kind].has_constant_speed and means is not None:
            load = replace(plan, run="", trial=0, v_ref_m_s=0.0)
            middle = (means.t_start_s + means.t_stop_s) / 2
            pressures = means.p_tp_pa, means.p_tr_pa or 0.0
            stroke = Stroke(middle, means.v_m_s, *pressures, means.f_applied_n)
            ways = found.setdefault(load, defaultdict(list))
            ways[plan.trial, plan.direction].append(stroke)
    repeated = any(len({trial for trial, _ in ways}) > 1 for ways in found.values())
    pairs = []
    for load, ways in found.items():
        for trial in sorted({trial for trial, _ in ways}):
            out, back = ways[trial, "extend"], ways[trial, "retract"]
            if repeated and out and back:
                out, back = [_mean(out)], [_mean(back)]
            pairs += [Pair(load, *both) for both in zip(out, back, strict=False)]
    return tuple(pairs)


def _mean(strokes: Sequence[Stroke]) -> Stroke:
    return Stroke(*np.mean([astuple(one) for one in strokes], axis=0).tolist())


def parameters(plant: StrokePlant) -> PlantParameters:
    """Return a plant of which only the cylinder under test is told."""
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


def shown_force(stroke: Stroke, par: PlantParameters, sensors: SensorParameters) -> float:
    """Return what the load cell shows [N] with a model at a stroke's velocity and pressures."""
    p_tp, p_tr = (
        (logged - sensors.zero[i]) / sensors.per_unit[i]
        for i, logged in ((_P_TP, stroke.p_tp_pa), (_P_TR, stroke.p_tr_pa))
    )
    state = np.zeros(n_states(par))
    state[[V, P_TP, P_TR]] = stroke.v_m_s, p_tp, p_tr
    _settle(state, par)
    level, _, more, _ = friction_effects(1.0, 1.0, state, par, par.effects, np.zeros(len(state)))
    dry, viscous = steady_parts(stroke.v_m_s, p_tp, p_tr, level, par.test.friction)
    force = p_tp * par.test.area_piston_m2 - p_tr * par.test.area_rod_m2 - dry - viscous - more
    return float(sensors.per_unit[_FORCE] * force + sensors.zero[_FORCE])


def _settle(state: np.ndarray, par: PlantParameters) -> None:
    """Put the effects' own states where friction's laws leave them: one step of Newton's rule.

    Their rates are linear in them at constant speed.
    """
    first = bristles_end(par)
    count = len(state) - first
    if not count:
        return

    def rates(moved: int | None) -> np.ndarray:
        at, out = state.copy(), np.zeros(len(state))
        if moved is not None:
            at[first + moved] += _STEP
        friction_effects(1.0, 1.0, at, par, par.effects, out)
        return out[first:]

    here = rates(None)
    if not here.any():
        return
    slope = np.column_stack([(rates(i) - here) / _STEP for i in range(count)])
    state[first:] -= np.linalg.lstsq(slope, here, rcond=None)[0]


def lacking_force(stroke: Stroke, par: PlantParameters) -> float:
    """Return the balance of a stroke [N]: F_T - F_applied - F_fT, friction without effects."""
    test = par.test
    friction = steady_friction(stroke.v_m_s, stroke.p_tp_pa, stroke.p_tr_pa, test.friction)
    f_test = stroke.p_tp_pa * test.area_piston_m2 - stroke.p_tr_pa * test.area_rod_m2
    return f_test - stroke.f_applied_n - friction


def window_of(pair: Pair, par: PlantParameters) -> Windowed:
    """Return the balances of a pair as its one window, with the means of both strokes."""
    out, back = pair.extend, pair.retract
    lacks = lacking_force(out, par), lacking_force(back, par)
    speed, load = (out.v_m_s - back.v_m_s) / 2, (out.f_applied_n + back.f_applied_n) / 2
    return Windowed(
        plan=pair.plan,
        names=BALANCES,
        values=np.array([[(lacks[0] - lacks[1]) / 2, (lacks[0] + lacks[1]) / 2]]),
        t_s=np.array([(out.t_s + back.t_s) / 2]),
        x_m=np.array([np.nan]),
        v_m_s=np.array([speed]),
        load_n=np.array([load]),
        resolution=np.zeros(2),
    )


@dataclass(frozen=True)
class Strokes:
    """The measured strokes, with what no hypothesis changes."""

    plant: StrokePlant  # the model that was given
    measured: tuple[Pair, ...]

    def simulate(self, hypotheses: Sequence[Hypothesis], trials: int) -> list[tuple[Pair, ...]]:
        """Return the mean pairs as some hypotheses would have them, whatever the ``trials``."""
        return [self._made(one) for one in hypotheses]

    def _made(self, hypothesis: Hypothesis) -> tuple[Pair, ...]:
        plant = hypothesis.plant(self.plant)
        par, sensors = parameters(plant), changed_by("sensors", _ONE, read_effects(plant.effects))

        def made(one: Stroke) -> Stroke:
            return replace(one, f_applied_n=shown_force(one, par, sensors))

        return tuple(
            replace(pair, extend=made(pair.extend), retract=made(pair.retract))
            for pair in self.means
        )

    @cached_property
    def means(self) -> tuple[Pair, ...]:
        """The mean pair of each load: what a hypothesis makes again."""
        loads: dict[RunPlan, list[Pair]] = defaultdict(list)
        for pair in self.measured:
            loads[pair.plan].append(pair)
        return tuple(
            Pair(load, _mean([one.extend for one in own]), _mean([one.retract for one in own]))
            for load, own in loads.items()
        )

    def windows(self, hypothesis: Hypothesis, pairs: Sequence[Pair]) -> list[Windowed]:
        """Return balances with a hypothesis' nuisances; its effects are in what it makes."""
        par = parameters(scaled(self.plant, hypothesis.factors))
        return [window_of(one, par) for one in pairs]

    def lacking(self, hypothesis: Hypothesis, simulated: Sequence[Pair]) -> GapMap:
        """Return what the balances lack."""
        return differences(
            self.windows(hypothesis, self.measured), self.windows(hypothesis, simulated)
        )

    def slopes(self, factors: Mapping[str, float]) -> dict[str, Column]:
        """Return the change of the measured balances with the logarithm of each nuisance."""
        before, found = mean_column(self.windows(Hypothesis(factors), self.means)), {}
        for path in nuisances(self.plant):
            value = factors.get(path, 1.0)
            step = -_STEP if value > 1 else _STEP  # inwards
            there = Hypothesis({**factors, path: value * float(np.exp(step))})
            after = mean_column(self.windows(there, self.means))
            found[path] = {point: (after[point] - own) / step for point, own in before.items()}
        return found

    def around(
        self, hypothesis: Hypothesis, signatures: Iterable[Coefficient]
    ) -> dict[Coefficient, Column]:
        """Return the signatures at a hypothesis: a share of friction grows with the friction."""
        before = self._column(hypothesis, hypothesis)
        return {one: self._signature(hypothesis, one, before) for one in signatures}

    def _column(self, hypothesis: Hypothesis, made_by: Hypothesis) -> Column:
        return mean_column(self.windows(hypothesis, self._made(made_by)))

    def _signature(self, hypothesis: Hypothesis, which: Coefficient, before: Column) -> Column:
        """Return what a coefficient changes in the balances, a typical size of it: the slope here.

        A balance that it changes by less than a tenth of the other's change is left out.
        """
        row = EFFECTS[which[0]].coefficients[which[1]]
        step, now = _STEP * typical(which), hypothesis.coefficient(which)
        step = max(step, row.to_si(row.low) - now)
        if now + step > row.to_si(row.high):
            step = -step
        there = hypothesis.with_coefficients({which: now + step})
        way = typical(which) / step
        after = self._column(hypothesis, there)
        column = {point: way * (after[point] - own) for point, own in before.items()}
        most = np.max([np.abs(own).max(axis=0) for own in column.values()], axis=0)
        keep = (most > _LEAST * most.max()) & (most > _NOTHING_N)
        return {point: np.where(keep, own, 0.0) for point, own in column.items()}

    @cached_property
    def signatures(self) -> dict[Coefficient, Column]:
        """The coefficients that change a steady stroke's mean at all."""
        acting = [name for name, row in EFFECTS.items() if not _PLACES.isdisjoint(row.laws)]
        wanted = dict.fromkeys(one for name in acting for one in coefficients(name))
        if not self._rod_side_measured:
            wanted.pop(("pressure_offset", "p_tr"), None)
        columns = self.around(Hypothesis(), wanted)
        return {
            one: column
            for one, column in columns.items()
            if any(own.any() for own in column.values())
        }

    @property
    def _rod_side_measured(self) -> bool:
        """A pressure that is the same but for rounding in all strokes is a constant, no channel."""
        strokes = [one for pair in self.measured for one in (pair.extend, pair.retract)]
        return not is_constant(np.array([one.p_tr_pa for one in strokes]))
