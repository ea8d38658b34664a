"""Runs of a campaign as measurements of the search: residuals and columns along their logs."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.sensors import Instruments
from hbench.model.effects.catalogue import EFFECTS, read_effects
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.column_names import (
    CoefficientKey,
    coefficient_name,
    coefficient_of,
    delay_name,
    drift_name,
    factor_name,
    factor_path,
    is_coefficient,
    is_disturbance,
    is_mode,
    is_ripple,
    mode_of,
    ripple_name,
)
from hbench.reconcile.gaps.gap_map import GapMap, RunLevel, point_of
from hbench.reconcile.gaps.log_map import Windows, log_map, ranked_gaps
from hbench.reconcile.hypothesis import Hypothesis, stepped
from hbench.reconcile.learned.columns import hats, knots_of, table_columns
from hbench.reconcile.learned.table import Table, empty_table
from hbench.reconcile.linearised import Columns
from hbench.reconcile.measured.along import ALL_PARTS, connected
from hbench.reconcile.measured.balances import (
    BALANCES,
    FLOWS,
    FORCES,
    BalanceModel,
    balance_model,
    balance_values,
    measured_laws,
    operating_conditions,
    rounding_error,
)
from hbench.reconcile.measured.disturbances import (
    ALL_COMMANDS,
    CYLINDERS,
    DELAY_S,
    POSITION,
    Ripples,
)
from hbench.reconcile.measured.integration import Parts
from hbench.reconcile.measured.session import PRESSURES, Session
from hbench.reconcile.nuisance import drift_deviations, nuisances, standard_deviation, tolerances
from hbench.records import Gap
from hbench.records.reconcile.diagnosis import LEVEL_SCATTER

_STEP = 1e-3  # of a logarithm
_SHARE = 0.05  # of a typical size: its law is nearly a line over this step
_COLUMN_STEP_S = 5e-3  # of the laws' states: derivatives need not be as exact as residuals
_LAGS = frozenset(  # columns of times as short as such a step
    ["/valve.bandwidth"]
    + [f"{name}.{key}" for name, row in EFFECTS.items() for key, c in row.coefficients.items()
       if c.unit == "ms" or (name, key) == ("valve_lag", "second")]
)  # fmt: skip
_RIPPLE = standard_deviation(0.02)  # of dry friction along a honed bore: assumed
_RIPPLE_KNOTS = 8  # over the positions that were reached


@dataclass(frozen=True)
class MeasuredCampaign:
    """Runs of a campaign in their order, with the bench and the given model."""

    bench: Bench | None  # None: the board and its sensors are unknown
    plant: Plant  # of the given model
    instruments: Instruments | None
    logs: tuple[Session, ...]
    material: float  # share of a signal's range: a smaller deviation does not matter
    late_position: bool = field(default=False, kw_only=True)  # against all other sensors

    @cached_property
    def tolerances(self) -> Mapping[CoefficientKey, float]:
        """Limits [SI] of the coefficients that are nuisances within them."""
        pressure = max(np.max(log.channels[name]) for log in self.logs for name in PRESSURES)
        force = max(np.abs(log.channels["f_applied_n"]).max() for log in self.logs)
        return tolerances(self.plant, self.instruments, float(pressure), float(force))

    @cached_property
    def drifts(self) -> Mapping[str, float]:
        """Standard deviations [SI] of the sensors' drifts over the campaign, by channel."""
        return drift_deviations(self.tolerances)

    @property
    def delayed(self) -> tuple[str, ...]:
        """What may be late against the position; nothing where the board is known.

        It reads all channels at the same time.
        """
        position = [POSITION] if self.late_position else []
        return (*self.drifts, ALL_COMMANDS, *position) if self.bench is None else ()

    @property
    def cylinders(self) -> tuple[str, ...]:
        """Those whose dry friction has a ripple."""
        return CYLINDERS

    @cached_property
    def ripple(self) -> Table:
        """Table of a share of dry friction over the position, with its modes."""
        positions = np.concatenate([log.channels["x_m"] for log in self.logs])
        knots = {"position": knots_of(positions, _RIPPLE_KNOTS)}
        return empty_table("friction_test", knots, _RIPPLE)

    @property
    def nuisance_columns(self) -> list[str]:
        """Names of the columns of all nuisances."""
        return [
            *map(factor_name, nuisances(self.plant)),
            *map(coefficient_name, self.tolerances),
            *map(drift_name, self.drifts),
            *map(delay_name, self.delayed),
            *(ripple_name(each, mode) for each in self.cylinders for mode in range(_RIPPLE_KNOTS)),
        ]

    @cached_property
    def start(self) -> Hypothesis:
        """The given model, with the values of all coefficients that are nuisances."""
        given, effects = read_effects(self.plant.effects), {}
        for name in dict.fromkeys(name for name, _ in self.tolerances):
            rows = EFFECTS[name].coefficients.items()
            effects[name] = {key: row.to_si(row.default) for key, row in rows} | given.get(name, {})
        return Hypothesis(effects=effects)

    def balance_model(self, hypothesis: Hypothesis) -> BalanceModel:
        """Return the balances' model of a hypothesis."""
        return self._disturbed(balance_model(self.bench, hypothesis.plant(self.plant)), hypothesis)

    def _disturbed(self, model: BalanceModel, hypothesis: Hypothesis) -> BalanceModel:
        """Return the model with the disturbances of a hypothesis."""
        at = hypothesis.disturbances
        drifts = {name: at.get(drift_name(name), 0.0) * size for name, size in self.drifts.items()}
        delays = {name: DELAY_S * at.get(delay_name(name), 0.0) for name in self.delayed}
        modes = [
            [at.get(ripple_name(each, i), 0.0) for i in range(_RIPPLE_KNOTS)] for each in CYLINDERS
        ]
        (knots,) = self.ripple.knots.values()
        ripples = Ripples(np.array(knots), modes @ self.ripple.basis.T)
        return replace(model, drifts=drifts, delays_s=delays, ripples=ripples)

    def gap_map(self, hypothesis: Hypothesis, reference: GapMap | None = None) -> GapMap:
        """Return the residuals of all runs, with the levels of friction that are not known.

        A ``reference`` gives all but the residuals.
        """
        model = self.balance_model(hypothesis)
        values = self._values(self.logs, model)
        if reference is not None:
            return replace(reference, difference=values)
        residuals = log_map(self._windows, BALANCES, values, rounding_error(model))
        material = self.material * self._ranges(model) / residuals.scatter[0]
        levels = tuple(self._levels(model, residuals))
        return replace(residuals, levels=levels, material=material)

    def ranked_gaps(self, residuals: GapMap, allowed: np.ndarray) -> tuple[Gap, ...]:
        """Return the gaps of all balances, largest first; see ``log_map.ranked_gaps``."""
        return ranked_gaps(residuals, allowed)

    @property
    def compares_rest(self) -> bool:
        """Whether forces are compared at rest, where friction is what holds the piston."""
        return False

    def _values(self, logs: Sequence[Session], model: BalanceModel) -> np.ndarray:
        return self._without_rest(_values(logs, model))

    def _without_rest(self, values: np.ndarray) -> np.ndarray:
        """Return values (w, c) that are nan where they are not compared because of rest."""
        if not self.compares_rest:
            resting = np.concatenate([log.resting for log in self.logs])
            values[np.ix_(resting, np.isin(BALANCES, FORCES))] = np.nan
        return values

    def _ranges(self, model: BalanceModel) -> np.ndarray:
        """Return the largest magnitude (c,) of what each balance is made of."""
        v = np.abs(np.concatenate([log.velocity_m_s for log in self.logs])).max()
        test, load = model.par.test, model.par.load
        areas = test.area_piston_m2, test.area_rod_m2, load.area_piston_m2, load.area_rod_m2
        forces = [np.abs(log.channels["f_applied_n"]).max() for log in self.logs]
        force = max(forces) or model.par.supply.pressure_pa * test.area_piston_m2
        return np.array(
            [*(area * v for area in areas), force, force, v, model.par.supply.pressure_pa]
        )

    @cached_property
    def _windows(self) -> Windows:
        model = self.balance_model(self.start)
        runs, counts = [run for log in self.logs for run in log.runs], [0]
        for log in self.logs:
            counts.append(counts[-1] + len(log.runs))
        conditions = zip(*(operating_conditions(log, model) for log in self.logs), strict=True)
        return Windows(
            np.concatenate(
                [log.run_of_window + first for log, first in zip(self.logs, counts, strict=False)]
            ),
            tuple(point_of(run.plan) for run in runs),
            *(np.concatenate(values) for values in conditions),
        )

    def _levels(self, model: BalanceModel, residuals: GapMap) -> Iterable[RunLevel]:
        """Yield a level of friction for each run and cylinder."""
        edges = np.flatnonzero(np.diff(residuals.run)) + 1
        starts = [0, *edges.tolist(), len(residuals.run)]
        dry = self._without_rest(dry_friction(self.smoothed_sessions, model))
        with np.errstate(invalid="ignore"):
            change = np.nan_to_num(LEVEL_SCATTER * dry / residuals.scatter)
        for balance in (BALANCES.index(name) for name in FORCES):
            for start, stop in zip(starts[:-1], starts[1:], strict=True):
                windows = slice(start, stop)
                yield RunLevel(windows, balance, change[windows, balance], 1.0)

    @cached_property
    def smoothed_sessions(self) -> tuple[Session, ...]:
        """The logs with smoothed pressures, for columns."""
        return tuple(log.smoothed() for log in self.logs)

    def columns(self, hypothesis: Hypothesis, names: Iterable[str]) -> Columns:
        """Return the columns ``names`` at a hypothesis: changes by one unit, times -1.

        By finite differences along the logs, on all cores; those of tables directly.
        """
        wanted, model = list(names), self.balance_model(hypothesis)
        coarse = replace(model, step_s=_COLUMN_STEP_S)
        differences = [name for name in wanted if not (is_mode(name) or is_ripple(name))]
        modes: dict[str, np.ndarray] = {}
        if any(map(is_ripple, wanted)):
            modes |= self._ripple_columns(coarse)
        for i in dict.fromkeys(mode_of(name)[0] for name in wanted if is_mode(name)):
            modes |= table_columns(hypothesis.tables[i], i, self.smoothed_sessions, coarse)
        stepped_to = {name: self._stepped(hypothesis, name) for name in differences}
        divisions = {(each.step_s, each.parts) for each, _ in stepped_to.values()}
        before = {
            (step_s, parts): self._values(
                self.smoothed_sessions, replace(model, step_s=step_s, parts=parts)
            )
            for step_s, parts in divisions
        }
        columns = map_on_threads(
            lambda name: self._column(name, *stepped_to[name], before), differences
        )
        found = dict(zip(differences, columns, strict=True)) | modes
        return {name: found[name] for name in wanted}

    def _ripple_columns(self, model: BalanceModel) -> Columns:
        """Return the columns (w, c) of the modes of the ripples of both cylinders."""
        raised = _raised(model)
        (knots,) = self.ripple.knots.values()
        parts = []
        for log in self.smoothed_sessions:
            more, at = measured_laws(log, raised), measured_laws(log, model)
            dry = [more.friction_test - at.friction_test, more.friction_load - at.friction_load]
            modes = (hats(log.channels["x_m"], knots) @ self.ripple.basis).T
            parts.append([log.mean(each / _STEP * modes) for each in dry])
        columns = {}
        for cylinder, *own in zip(CYLINDERS, *parts, strict=True):
            for i, mode in enumerate(np.concatenate(own, axis=-1)):
                column = np.zeros((len(mode), len(BALANCES)))
                column[:, BALANCES.index(f"force_{cylinder}")] = mode
                columns[ripple_name(cylinder, i)] = column
        return columns

    def _stepped(self, hypothesis: Hypothesis, name: str) -> tuple[BalanceModel, float]:
        """Return the model with one parameter changed, and the change in its units.

        It has the laws alone that depend on the parameter, unless a state connects them.
        """
        size = _STEP if factor_path(name) else _SHARE
        at_step, share = stepped(hypothesis, name, nuisances(self.plant), size)
        model = self.balance_model(at_step)
        step_s = model.step_s if name in _LAGS else _COLUMN_STEP_S
        parts = ALL_PARTS if connected(model.par) else parts_of(name)
        return replace(model, step_s=step_s, parts=model.parts.both(parts)), share

    def _column(
        self,
        name: str,
        model: BalanceModel,
        share: float,
        before: Mapping[tuple[float, Parts], np.ndarray],
    ) -> np.ndarray:
        """Return a column; ``before`` are the residuals at the hypothesis, by step and parts."""
        after = self._values(self.smoothed_sessions, model)
        change = (before[model.step_s, model.parts] - after) / share
        if not is_coefficient(name):
            return change
        touched = np.isin(BALANCES, EFFECTS[coefficient_of(name)[0]].balances)
        return np.where(touched, change, 0.0)


def parts_of(name: str) -> Parts:
    """Return the laws that the parameter of a column changes."""
    if is_disturbance(name):
        return ALL_PARTS
    if factor_path(name):
        flows = not name.startswith(("/friction.", "/moving_mass."))
        return Parts(flows, name.startswith("/friction."))
    balances = EFFECTS[coefficient_of(name)[0]].balances
    return Parts(not {*FLOWS, "supply"}.isdisjoint(balances), not set(FORCES).isdisjoint(balances))


def dry_friction(logs: Sequence[Session], model: BalanceModel) -> np.ndarray:
    """Return the derivatives (w, c) of the balances by the level of dry friction of all logs."""
    raised, given = (_values(logs, each) for each in (_raised(model), model))
    return (raised - given) / _STEP


def _raised(model: BalanceModel) -> BalanceModel:
    """Return a model with slightly more dry friction."""
    return replace(model, levels=(1.0 + _STEP, 1.0 + _STEP))


def _values(logs: Sequence[Session], model: BalanceModel) -> np.ndarray:
    return np.concatenate([balance_values(log, model) for log in logs])
