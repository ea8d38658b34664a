"""Which effects of the catalogue a model lacks: one after another, each must earn its place.

Around the refitted model every candidate is judged by its signature (``evidence.score``); the best
are simulated with the coefficient found, and judged again there. One is taken if, on operating
points left out,

    its score exceeds the largest that any candidate reaches in 98 % of nulls of this very plan,
    it explains more than half of the excess gap in the balances it touches, and
    its coefficient is at least a tenth of the typical size.

Candidates whose scores are too close to the best one's are an ambiguous set, and none is taken.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hbench.model.effects import EFFECTS
from hbench.reconcile.evidence import (
    LeftOut,
    fit,
    left_out,
    log_likelihood,
    random_signs,
    score,
)
from hbench.reconcile.linear import (
    Coefficient,
    Column,
    Hypothesis,
    Linear,
    Measured,
    Simulate,
    linearise,
    moved,
    typical,
)
from hbench.records import Candidate

_NULLS = 100
_QUANTILE = 0.98  # of the nulls' largest scores
_LEAST = 3.0  # nats: the least threshold, e^3 = 20 to 1
_EXPLAINED = 0.5
_MATERIAL = 0.1  # typical sizes
_CLOSE = 3.0, 0.1  # nats, share of the best score: closer candidates are ambiguous
_TRIED = 6  # candidates that are simulated
_WORTH = 0.3  # of the best score: others are not simulated
_MOST = 4  # effects
_ROUNDS = 3  # of simulating and refitting
_STILL = 0.05  # priors of nuisances and typical sizes: no need to simulate again


@dataclass(frozen=True)
class Tried:
    """A candidate, with its own simulation if it has one."""

    found: Candidate
    linear: Linear | None


@dataclass(frozen=True)
class Step:
    """One search: what was tried, best first, and what was taken."""

    before: Linear
    threshold: float
    tried: tuple[Tried, ...]
    taken: str | None
    close: tuple[Candidate, ...]  # the ambiguous set, where nothing was taken


@dataclass(frozen=True)
class Found:
    """The refitted model, the steps from it, and where they end."""

    refitted: Linear
    steps: tuple[Step, ...]
    final: Linear

    @property
    def names(self) -> tuple[str, ...]:
        """The effects that were taken, in order."""
        return tuple(step.taken for step in self.steps if step.taken)


@dataclass(frozen=True)
class Search:
    """What a search needs besides a model."""

    measured: Measured
    simulate: Simulate
    trials: int
    signatures: Mapping[Coefficient, Column]
    train: np.ndarray  # numbers of the operating points that may be seen
    candidates: tuple[str, ...]

    def run(self, given: Linear) -> Found:
        """Refit the nuisances of the model that was given, then look for effects."""
        here = refitted = self.settled(given, ())
        steps: list[Step] = []
        while len(steps) < _MOST:
            step, there = self._step(here, tuple(one.taken for one in steps if one.taken))
            steps.append(step)
            if there is None:
                break
            here = there
        return Found(refitted, tuple(steps), here)

    def at(self, hypothesis: Hypothesis) -> Linear | None:
        """Simulate a hypothesis and return its surroundings; None where the board stops."""
        (runs,) = self.simulate([hypothesis], self.trials)
        if runs is None:
            return None
        return linearise(self.measured, hypothesis, runs, self.signatures)

    def settled(self, start: Linear, effects: Sequence[str]) -> Linear:
        """Move to the best nuisances and coefficients of ``effects``."""
        which = start.coefficients_of(effects)
        here = start
        for _ in range(_ROUNDS):
            beta = fit(here.data, here.free, here.index(which), self.train)[0]
            if np.abs(beta).max() < _STILL:
                break
            there = self.at(moved(here, self.measured.plant, which, beta))
            if there is None:
                break
            here = there
        return here

    def _step(self, here: Linear, taken: tuple[str, ...]) -> tuple[Step, Linear | None]:
        base = here.index(here.coefficients_of(taken))
        rest = [
            name for name in self.candidates if name not in taken and here.coefficients_of([name])
        ]
        threshold = self._threshold(here, base, rest)
        judged = sorted(
            (self._linear(here, base, name) for name in rest),
            key=lambda one: -one.found.score,
        )
        best = judged[0].found.score if judged else 0.0
        worth = [one for one in judged if one.found.score > max(_WORTH * best, 0.5 * threshold)]
        simulated = self._simulated(here, taken, [one.found for one in worth[:_TRIED]])
        tried = sorted(
            (simulated.get(one.found.name, one) for one in judged),
            key=lambda one: -one.found.score,
        )
        good = [one for one in tried if one.linear and _earned(one.found, threshold)]
        if not good:
            return Step(here, threshold, tuple(tried), None, ()), None
        first = good[0]
        least = first.found.score - max(_CLOSE[0], _CLOSE[1] * first.found.score)
        close = tuple(one.found for one in good if one.found.score >= least)
        if len(close) > 1:
            return Step(here, threshold, tuple(tried), None, close), None
        name = first.found.name
        step = Step(here, threshold, tuple(tried), name, ())
        return step, self.settled(first.linear, (*taken, name))

    def _linear(self, here: Linear, base: Sequence[int], name: str) -> Tried:
        which = here.coefficients_of([name])
        more = [i for i in here.index(which) if i not in base]
        gain = float(score(here.data, here.free, base, more, self.train)[0])
        beta = fit(here.data, here.free, [*base, *more], self.train)[0][len(base) :]
        before = left_out(here.data, here.free, base, self.train)
        after = left_out(here.data, here.free, [*base, *more], self.train)
        values = {one: float(b) * typical(one) for one, b in zip(which, beta, strict=True)}
        return Tried(_candidate(name, gain, explained(name, here, before, after), values), None)

    def _simulated(
        self, here: Linear, taken: tuple[str, ...], worth: Sequence[Candidate]
    ) -> dict[str, Tried]:
        """Simulate candidates with the coefficients that the linear fit has found."""
        before = left_out(here.data, here.free, here.index(here.coefficients_of(taken)), self.train)
        hypotheses = []
        for one in worth:
            which = here.coefficients_of((*taken, one.name))
            beta = fit(here.data, here.free, here.index(which), self.train)[0]
            hypotheses.append(moved(here, self.measured.plant, which, beta))
        found = {}
        made = self.simulate(hypotheses, self.trials)
        for one, hypothesis, runs in zip(worth, hypotheses, made, strict=True):
            if runs is None:
                continue
            there = linearise(self.measured, hypothesis, runs, self.signatures, here.lacking)
            own = there.index(here.coefficients_of((*taken, one.name)))
            after = left_out(there.data, there.free, own, self.train)
            gain = float((log_likelihood(after) - log_likelihood(before))[0])
            beta = fit(there.data, there.free, own, self.train)[0].tolist()
            steps = dict(zip(own, beta, strict=True))
            values = {
                key: hypothesis.coefficient(key) + steps[there.column(key)] * typical(key)
                for key in there.coefficients_of([one.name])
            }
            share = explained(one.name, here, before, after)
            found[one.name] = Tried(_candidate(one.name, gain, share, values, True), there)
        return found

    def _threshold(self, here: Linear, base: Sequence[int], names: Sequence[str]) -> float:
        signs = random_signs(_NULLS, len(here.lacking.points), seed=1)
        best = np.zeros(_NULLS)
        for name in names:
            more = [i for i in here.index(here.coefficients_of([name])) if i not in base]
            best = np.maximum(best, score(here.data, here.free, base, more, self.train, signs))
        return max(_LEAST, float(np.quantile(best, _QUANTILE)))


def explained(name: str, here: Linear, before: LeftOut, after: LeftOut) -> float:
    """Return the share of the excess gap that goes in the balances that an effect touches."""
    own = np.isin([balance for balance, _ in here.data.groups], EFFECTS[name].balances)

    def excess(left: LeftOut) -> float:
        over = np.maximum(left.variance[0] - left.noise, 0.0) * left.windows
        return float(over[own].sum())

    whole = excess(before)
    return 1 - excess(after) / whole if whole > 0 else 0.0


def _earned(one: Candidate, threshold: float) -> bool:
    return one.score > threshold and one.explained > _EXPLAINED and one.size >= _MATERIAL


def _candidate(
    name: str, gain: float, share: float, values: Mapping[Coefficient, float], own: bool = False
) -> Candidate:
    size = max((abs(value) / typical(one) for one, value in values.items()), default=0.0)
    parameters = {key: value for (_, key), value in values.items()}
    return Candidate(name, gain, share, size, parameters, "simulated" if own else "linear")
