"""Measurement side of the search: the interface, and the runs of a campaign."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from hbench.config.bench import Bench, Plant
from hbench.config.scaling import scaled
from hbench.reconcile.gaps.columns import ModelColumn, residuals_of_runs
from hbench.reconcile.gaps.gap_map import GapMap, gap_map, point_of
from hbench.reconcile.hypothesis import CoefficientKey, Hypothesis
from hbench.reconcile.measured.balances import (
    BALANCES,
    BalanceModel,
    PreparedRun,
    balance_model,
    residuals,
)
from hbench.reconcile.nuisance import slopes
from hbench.records import Run


class MeasurementInterface(Protocol):
    """Measurement interface of the search."""

    @property
    def plant(self) -> Any:
        """The given model: a ``Plant`` or part of one."""

    def gap_map(self, hypothesis: Hypothesis, simulated: Any) -> GapMap:
        """Return the differences between the measured runs and those simulated."""

    def slopes(self, factors: Mapping[str, float]) -> dict[str, ModelColumn]:
        """Return the derivatives of the measured balances by the logarithm of each nuisance."""

    def signatures_at(
        self, hypothesis: Hypothesis, signatures: Mapping[CoefficientKey, ModelColumn]
    ) -> Mapping[CoefficientKey, ModelColumn]:
        """Return the signatures of the coefficients at a hypothesis, from those of the model."""


@dataclass(frozen=True)
class MeasuredCampaign:
    """Runs of a campaign, with the bench and the given model."""

    bench: Bench
    plant: Plant  # of the given model
    logs: tuple[PreparedRun, ...]

    @cached_property
    def first_trials(self) -> tuple[PreparedRun, ...]:
        """The first run of each operating point."""
        return tuple({point_of(log.run.plan): log for log in reversed(self.logs)}.values())

    def balance_model(self, hypothesis: Hypothesis) -> BalanceModel:
        """Return the balances' model with a hypothesis' factors; simulations have its effects."""
        return balance_model(self.bench, scaled(self.plant, hypothesis.factors))

    def gap_map(self, hypothesis: Hypothesis, simulated: Sequence[Run]) -> GapMap:
        """Return the differences between the measured runs and those simulated."""
        model = self.balance_model(hypothesis)
        measured = [residuals(log, model) for log in self.logs]
        return gap_map(measured, residuals_of_runs(simulated, model))

    def slopes(self, factors: Mapping[str, float]) -> dict[str, ModelColumn]:
        """Return the derivatives of the measured balances by the logarithm of each nuisance."""
        logs = self.first_trials
        points = [point_of(log.run.plan) for log in logs]
        by_path = slopes(logs, self.bench, self.plant, factors, BALANCES)
        return {path: dict(zip(points, runs, strict=True)) for path, runs in by_path.items()}

    def signatures_at(
        self, hypothesis: Hypothesis, signatures: Mapping[CoefficientKey, ModelColumn]
    ) -> Mapping[CoefficientKey, ModelColumn]:
        """Return the signatures unchanged: effects hardly change each other's signature."""
        return signatures
