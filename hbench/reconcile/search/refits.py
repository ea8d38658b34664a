"""Refits of a model to measurements: its nuisances, with the coefficients of some effects."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from hbench.reconcile.evidence.cross_validation import CrossValidation, cross_validate
from hbench.reconcile.evidence.likelihood import cost, likeliest
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.linearised import (
    LinearisedModel,
    Measured,
    hypothesis_at,
    linearise_residuals,
)

_REFIT_ROUNDS = 50  # steps, or new columns, at most: from a bad guess some 20
_NEGLIGIBLE_STEP = 0.02  # priors of nuisances and typical sizes; no new evaluation below
# Radius of a step's damping, in priors of nuisances and typical sizes, and the share of the step.
SHORTER = ((np.inf, 1.0), (np.inf, 0.5), (np.inf, 0.25))
_DAMPED = ((1.0, 1.0), (0.3, 1.0), (0.1, 1.0))
NEGLIGIBLE_GAIN = 0.5  # nats of a step, a tenth of what an effect must gain; it is the last one


@dataclass(frozen=True)
class Refits:
    """Refits to one set of measurements."""

    measured: Measured
    train: np.ndarray  # indices of the operating points in use

    def linearise_at(self, start: LinearisedModel, hypothesis: Hypothesis) -> LinearisedModel:
        """Return the model at a hypothesis, with the columns of ``start``."""
        residuals = self.measured.gap_map(hypothesis, start.gap_map)
        return linearise_residuals(self.measured, hypothesis, residuals, start.columns, start.data)

    def with_columns(self, model: LinearisedModel, names: Iterable[str]) -> LinearisedModel:
        """Return a model with the columns ``names`` computed at its hypothesis."""
        columns = {**model.columns, **self.measured.columns(model.hypothesis, names)}
        return linearise_residuals(self.measured, model.hypothesis, model.gap_map, columns)

    def refit(
        self,
        start: LinearisedModel,
        effects: Sequence[str],
        renewed: Sequence[str] | None = None,
    ) -> LinearisedModel:
        """Refit the nuisances and the coefficients of ``effects``; never return a worse model.

        The columns ``renewed``, by default all that take part, are computed again once they gain
        no more: a step costs far less than its columns. With the same columns a step is at most one
        kind longer than the one before.
        """
        chosen = start.index(effects)
        names = [start.data.names[i] for i in chosen] if renewed is None else renewed
        current, stale, longest = start, False, 0
        for _ in range(_REFIT_ROUNDS):
            better, kind = self._better(current, effects, (SHORTER + _DAMPED)[longest:])
            gain = self._cost(current, effects) - self._cost(better, effects)
            current = better
            if gain >= NEGLIGIBLE_GAIN:
                stale, longest = True, max(longest + kind - 1, 0)
            elif not stale:
                break
            else:
                current, stale, longest = self.with_columns(current, names), False, 0
        return self.with_columns(current, names) if stale else current

    def _better(
        self,
        current: LinearisedModel,
        effects: Sequence[str],
        kinds: Sequence[tuple[float, float]],
    ) -> tuple[LinearisedModel, int]:
        """Return the model at a better step from ``current``, and the index of this kind of step.

        It is the same model where no step is better. The balances are not linear: where the whole
        step is not better, shorter ones are tried, and then damped ones, which leave alone what the
        data hardly determine.
        """
        chosen, before = current.index(effects), self._cost(current, effects)
        whole = cache(lambda radius: self._fit(current, effects, radius))
        for kind, (radius, share) in enumerate(kinds):
            beta = share * whole(radius)
            if np.abs(beta).max(initial=0.0) < _NEGLIGIBLE_STEP:
                break
            model = self.linearise_at(
                current, hypothesis_at(current, self.measured.plant, chosen, beta)
            )
            if self._cost(model, effects) < before:
                return model, kind
        return current, 0

    def _fit(
        self, model: LinearisedModel, effects: Sequence[str], radius: float = np.inf
    ) -> np.ndarray:
        """Return the most likely steps of the columns of ``model.index(effects)``."""
        alternatives = [each.damped(radius) for each in model.alternative_priors(effects)]
        return likeliest(model.data, alternatives, model.index(effects), self.train)

    def _cost(self, model: LinearisedModel, effects: Sequence[str]) -> float:
        return cost(model.data, model.priors(effects), model.index(effects), self.train)

    def _cross_validate(self, model: LinearisedModel, effects: Sequence[str]) -> CrossValidation:
        return cross_validate(model.data, model.priors(effects), model.index(effects), self.train)
