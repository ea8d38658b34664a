"""Logs of a driven mass as measurements of the search: its force balance in weak form.

    <F_drive - F_applied - F_friction(v, ...)> - m <x''>        force against extension

It is the balance ``force_test`` of a campaign: the drive's force replaces that of the test
cylinder's chambers, as a pressure on a piston of 1 m^2. Position and drive force are measured;
the position is not differentiated. Without a force sensor the applied force is 0. Each run is an
operating point of its own, so that cross-validation leaves out whole runs.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hbench.analysis.rounding import ROUNDING, is_constant
from hbench.config.stroke_model import MotionPlant
from hbench.errors import DataError
from hbench.model.build import friction_parameters, lone_cylinder
from hbench.model.effects.catalogue import EFFECTS, read_effects, with_all_effects
from hbench.model.parameters import CylinderParameters
from hbench.model.sensors import ideal_sensors
from hbench.reconcile.column_names import CoefficientKey
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.linearised import Columns
from hbench.reconcile.measured.balances import BALANCES, BalanceModel, sensor_maps
from hbench.reconcile.measured.integration import Parts
from hbench.reconcile.measured.session import Session, sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign, dry_friction
from hbench.reconcile.motion.force_unit import in_unit, unit_of
from hbench.reconcile.nuisance import ASSUMED_TOLERANCE
from hbench.records import Gap, Run
from hbench.records.reconcile.diagnosis import NO_PART, REST_M_S

BALANCE = "force_test"
_AREA_M2 = 1.0
_OIL = frozenset({"seal_pressure_friction", "pressure_offset", "pressure_gain", "oil_warming"})
_OFFSET = ("load_cell_offset", "force")


@dataclass(frozen=True)
class MeasuredMotion(MeasuredCampaign):
    """Logs of a driven mass and the given model, both in a unit of force."""

    plant: Any  # a ``MotionPlant``
    unit_n: float
    ends_m: tuple[float, float]  # least and largest position of all logs

    @property
    def largest_force(self) -> float:
        """Largest magnitude of the drive's force, in the unit."""
        return _AREA_M2 * max(float(np.abs(log.channels["p_tp_pa"]).max()) for log in self.logs)

    @cached_property
    def tolerances(self) -> Mapping[CoefficientKey, float]:
        """Limits of the coefficients that are nuisances within them: the offset of the force."""
        return {_OFFSET: ASSUMED_TOLERANCE * self.largest_force}

    @cached_property
    def drifts(self) -> Mapping[str, float]:
        """No drift of a sensor: the order of imported files need not be that of the time."""
        return {}

    @property
    def delayed(self) -> tuple[str, ...]:
        """No delay: the drive's force alone is compared with the motion."""
        return ()

    @property
    def cylinders(self) -> tuple[str, ...]:
        """The driven mass is that of the test cylinder."""
        return ("test",)

    @property
    def compares_rest(self) -> bool:
        """The force of a drive at rest is compared: it shows the drive's offset."""
        return True

    def balance_model(self, hypothesis: Hypothesis) -> BalanceModel:
        """Return the balances' model of a hypothesis."""
        plant = hypothesis.plant(self.plant)
        effects = read_effects(plant.effects)
        low, high = self.ends_m
        friction = friction_parameters(plant.friction.test)
        mass = CylinderParameters(_AREA_M2, _AREA_M2, high - low, 1.0, 1.0, -low, friction)
        par = with_all_effects(lone_cylinder(mass, float(plant.moving_mass.test)), effects, ())
        sensors = sensor_maps(ideal_sensors(), ideal_sensors(), effects)
        alone = Parts(flows=False)
        return self._disturbed(BalanceModel(par, sensors, None, {}, parts=alone), hypothesis)

    def gap_map(self, hypothesis: Hypothesis, reference: GapMap | None = None) -> GapMap:
        """Return the residuals of all runs. Their scatter is noise and the runs' own friction.

        Runs need not be repeated, so their residuals do not show what a window has by chance.
        """
        residuals = super().gap_map(hypothesis, reference)
        if reference is not None:
            return residuals
        model = self.balance_model(hypothesis)
        noise, variance = np.full((2, len(BALANCES)), np.nan)
        column = BALANCES.index(BALANCE)
        rounding = (ROUNDING * self.largest_force) ** 2
        noise[column] = self._noise(model.par.mass_test_kg) + rounding
        own = self._level_variance(model, residuals.difference[:, column], residuals.run)
        variance[column] = noise[column] + own
        scatter = np.tile(np.sqrt(variance), (len(residuals.run), 1))
        return replace(
            residuals,
            scatter=scatter,
            noise=scatter**2,
            white=noise / variance,
            material=self.material * self._ranges(model) / scatter[0],
            levels=(),
            load_n=np.concatenate(
                [self.unit_n * log.mean(log.channels["f_applied_n"]) for log in self.logs]
            ),
        )

    def ranked_gaps(self, residuals: GapMap, allowed: np.ndarray) -> tuple[Gap, ...]:
        """Return the gaps, with a p-value for runs that are not repeated.

        In a correct model the mean square of a run exceeds that of noise as often as not (sign
        test).
        """
        from scipy.stats import binomtest  # slow import

        column = residuals.names.index(BALANCE)
        relative = residuals.difference[:, column] / residuals.scatter[:, column]
        runs = np.unique(residuals.run)
        above = sum(np.nanmean(relative[residuals.run == run] ** 2) > 1 for run in runs)
        p_value = float(binomtest(int(above), len(runs), alternative="greater").pvalue)
        gaps = super().ranked_gaps(residuals, allowed)
        return tuple(replace(gap, p_value=p_value) for gap in gaps)

    def _noise(self, mass: float) -> float:
        """Return the variance of a window's force by noise of the samples, of the median log.

        White noise: <F> has sum w^2 of a force's variance, m <x''> m^2 sum w''^2 of the position's.
        """
        variances = []
        for log in self.logs:
            forces = log.window.value @ log.window.value
            positions = mass**2 * (log.window.bend @ log.window.bend)
            variances.append(
                forces * (_AREA_M2**2 * _white(log, "p_tp_pa") + _white(log, "f_applied_n"))
                + positions * _white(log, "x_m")
            )
        return float(np.median(variances))

    def _level_variance(self, model: BalanceModel, force: np.ndarray, run: np.ndarray) -> float:
        """Return the variance of a window's force by the level of dry friction of its run.

        The level of each run is fitted to the residuals ``force`` (w,).
        """
        dry = np.nan_to_num(dry_friction(self.logs, model)[:, BALANCES.index(BALANCE)])
        squares = np.bincount(run, dry**2)
        driven = np.bincount(run, dry * np.nan_to_num(force))
        levels = driven[squares > 0] / squares[squares > 0]
        return float(levels.var(ddof=1) * np.mean(dry**2)) if len(levels) > 1 else 0.0

    def columns(self, hypothesis: Hypothesis, names: Iterable[str]) -> Columns:
        """Return the columns ``names`` at a hypothesis, without those of a load cylinder."""
        return super().columns(hypothesis, [n for n in names if not n.endswith(".load")])

    def _ranges(self, model: BalanceModel) -> np.ndarray:
        return np.full(len(BALANCES), self.largest_force)


def measured_motion(plant: MotionPlant, runs: Sequence[Run], material: float) -> MeasuredMotion:
    """Return the measurements of some runs with a drive force. Raises ``DataError``."""
    friction = _friction(_with_unit(plant, runs, material, 1.0))
    if not friction > 0:
        raise DataError(
            "the drive force less inertia is constant in all motion, so no friction is measured",
            "Check columns.x_m and columns.f_drive_n of the import map.",
        )
    return _with_unit(plant, runs, material, unit_of(friction))


def _with_unit(
    plant: MotionPlant, runs: Sequence[Run], material: float, unit_n: float
) -> MeasuredMotion:
    logs = sessions([_as_test_cylinder(run, unit_n) for run in runs])
    positions = np.concatenate([run.x_m for run in runs])
    ends = float(positions.min()), float(positions.max())
    return MeasuredMotion(None, in_unit(plant, unit_n), None, logs, material, unit_n, ends)


def _as_test_cylinder(run: Run, unit_n: float) -> Run:
    """Return a run whose drive force is the pressure on a piston, as an operating point."""
    zeros = np.zeros(len(run.t_s))
    applied = zeros if run.f_applied_n is None else run.f_applied_n / unit_n
    return Run(
        plan=replace(run.plan, label=f"{run.plan.label} {run.plan.run}".strip()),
        t_s=run.t_s,
        x_m=run.x_m,
        p_tp_pa=run.channel("f_drive_n") / (unit_n * _AREA_M2),
        p_tr_pa=zeros,
        f_applied_n=applied,
    )


def _friction(measured: MeasuredMotion) -> float:
    """Return the standard deviation of the measured friction in motion [N]."""
    mass = measured.plant.moving_mass.test
    parts = []
    for log in measured.logs:
        force = _AREA_M2 * log.channels["p_tp_pa"] - log.channels["f_applied_n"]
        friction = log.mean(force) - mass * log.second(log.channels["x_m"])
        parts.append(friction[np.abs(log.rate(log.channels["x_m"])) > REST_M_S])
    every = np.concatenate(parts)
    return float(every.std()) if len(every) else 0.0


def _white(log: Session, name: str) -> float:
    """Return the variance of a channel's noise: its third differences, of the median window.

    A third difference has 20 times the variance of a sample and no part of a parabola.
    """
    third = np.convolve(log.channels[name], (1.0, -3.0, 3.0, -1.0), "same")
    return float(np.median(log.mean(third**2))) / 20


def observable_in_motion(
    runs: Sequence[Run], plant: MotionPlant
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return the effects that the force balance can show, and why the others are not tried."""
    loads = [run.f_applied_n for run in runs if run.f_applied_n is not None]
    has_load = bool(loads) and not is_constant(np.concatenate(loads))
    observable, not_tried = [], {}
    for name, row in EFFECTS.items():
        if BALANCE not in row.balances:
            not_tried[name] = NO_PART
        elif name in _OIL:
            not_tried[name] = "needs the pressures of a hydraulic bench"
        elif name == "load_friction" and not has_load:
            not_tried[name] = "needs a measured load: the drive's force contains the friction"
        elif name in plant.effects:
            not_tried[name] = "the model already contains it; its coefficients are not changed"
        elif name == "load_cell_gain" and not has_load:
            not_tried[name] = "needs a measured load: a gain scales mass and friction alike"
        else:
            observable.append(name)
    return tuple(observable), not_tried
