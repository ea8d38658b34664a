"""Which effects of the catalogue a model lacks: one after another, each must earn its place.

Around the refitted model every candidate is judged by its signature (``evidence.score``); the best
are simulated with the coefficient found, and judged again there. One is taken if, on operating
points left out,

    its score exceeds 5 nats, and the largest that any candidate for the same balances reaches in
    98 % of nulls of this very plan: what it leaves itself, with random signs,
    it explains more than a quarter of the excess gap in the balances it touches, and
    its coefficient is at least a fifth of the typical size.

Candidates whose scores are too close to the best one's are an ambiguous set, and none is taken.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from hbench.analysis.rounding import ranked
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.evidence import (
    LeftOut,
    cost,
    fit,
    left_out,
    log_likelihood,
    random_signs,
    score,
)
from hbench.reconcile.linearised import (
    Coefficient,
    Column,
    Hypothesis,
    Linear,
    Simulate,
    linearise,
    moved,
    shapes,
    typical,
    windows_of,
)
from hbench.reconcile.signatures import signature
from hbench.records import Candidate

_NULLS = 200
_QUANTILE = 0.98  # of the nulls' largest scores
_LEAST = 5.0  # nats: the least threshold, e^5 = 150 to 1
_EXPLAINED = 0.25  # the rest may be other effects'
_MATERIAL = 0.2  # typical sizes
_CLOSE = 3.0, 0.1  # nats, share of the best score: closer candidates are ambiguous
TIE = 1e-6  # nats: scores that differ by rounding keep the catalogue's order
_TRIED = 6  # candidates that are simulated
_WORTH = 0.3  # of the best score: others are not simulated
_PROMISING = 0.5  # of the least threshold: others are not simulated
_MOST = 4  # effects
_ROUNDS = 2  # of simulating and refitting
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
        return _taken(self.steps)


@dataclass(frozen=True)
class Search:
    """What a search needs besides a model."""

    measured: Any  # ``Measured``, or strokes of another bench
    simulate: Simulate
    trials: int
    signatures: Mapping[Coefficient, Column]
    train: np.ndarray  # numbers of the operating points that may be seen
    candidates: tuple[str, ...]

    def run(self, given: Linear) -> Found:
        """Refit the nuisances of the model that was given, then look for effects."""
        here = refitted = self.settled(given, ())
        steps: list[Step] = []
        search = self
        while len(steps) < _MOST:
            step, there = search._step(here, _taken(steps))
            steps.append(step)
            if there is None:
                break
            search, here = search._refined(there, _taken(steps))
        return Found(refitted, tuple(steps), here)

    def at(self, hypothesis: Hypothesis) -> Linear | None:
        """Simulate a hypothesis and return its surroundings; None where the board stops."""
        (runs,) = self.simulate([hypothesis], self.trials)
        if runs is None:
            return None
        return linearise(self.measured, hypothesis, runs, self.signatures)

    def settled(self, start: Linear, effects: Sequence[str]) -> Linear:
        """Move to the best nuisances and coefficients of ``effects``, but nowhere that is worse."""
        which = start.coefficients_of(effects)
        here, lacks = start, self._cost(start, which)
        for _ in range(_ROUNDS):
            beta = fit(here.data, here.free, here.index(which), self.train)[0]
            if np.abs(beta).max() < _STILL:
                break
            there = self.at(moved(here, self.measured.plant, which, beta))
            if there is None or (less := self._cost(there, which)) > lacks + _LEAST:
                break
            here, lacks = there, less
        return here

    def _cost(self, here: Linear, which: Sequence[Coefficient]) -> float:
        return cost(here.data, here.free, here.index(which), self.train)

    def _refined(self, here: Linear, taken: tuple[str, ...]) -> tuple["Search", Linear]:
        """Give the effect that was taken last the shape that operating points left out support."""
        before = log_likelihood(self._left_out(here, taken))
        best, found = _LEAST, (self, here)
        for which in shapes(taken[-1]):
            other = here.hypothesis.with_coefficients(
                {which: here.hypothesis.coefficient(which) + typical(which)}
            )
            (runs,) = self.simulate([other], 1)
            if runs is None:
                continue
            known = self.measured.known(here.hypothesis)
            column = signature(which[0], windows_of(runs, known), windows_of(here.runs, known))
            search = replace(self, signatures={**self.signatures, which: column})
            start = linearise(
                self.measured, here.hypothesis, here.runs, search.signatures, here.lacking
            )
            there = search.settled(start, taken)
            own = linearise(
                self.measured, there.hypothesis, there.runs, search.signatures, here.lacking
            )
            gain = float((log_likelihood(search._left_out(own, taken)) - before)[0])
            if gain > best:
                best, found = gain, (search, there)
        return found

    def _left_out(self, here: Linear, taken: Sequence[str]) -> LeftOut:
        chosen = here.index(here.coefficients_of(taken))
        return left_out(here.data, here.free, chosen, self.train)

    def _step(self, here: Linear, taken: tuple[str, ...]) -> tuple[Step, Linear | None]:
        base = here.index(here.coefficients_of(taken))
        rest = [
            name for name in self.candidates if name not in taken and here.coefficients_of([name])
        ]
        judged = ranked(
            [self._linear(here, base, name) for name in rest], lambda one: one.found.score, TIE
        )
        best = judged[0].found.score if judged else 0.0
        worth = [one for one in judged if one.found.score > max(_WORTH * best, _PROMISING * _LEAST)]
        simulated = self._simulated(here, taken, [one.found for one in worth[:_TRIED]])
        tried = ranked(
            [
                self._with_threshold(simulated.get(one.found.name, one), here, base, rest)
                for one in judged
            ],
            lambda one: one.found.score,
            TIE,
        )
        good = [one for one in tried if one.linear and _earned(one.found)]
        if not good:
            return Step(here, tuple(tried), None, ()), None
        first = good[0]
        least = first.found.score - max(_CLOSE[0], _CLOSE[1] * first.found.score)
        close = tuple(one.found for one in good if one.found.score >= least)
        if len(close) > 1:
            return Step(here, tuple(tried), None, close), None
        name = first.found.name
        step = Step(here, tuple(tried), name, ())
        return step, self.settled(first.linear, (*taken, name))

    def _linear(self, here: Linear, base: Sequence[int], name: str) -> Tried:
        which = here.coefficients_of([name])
        more = [i for i in here.index(which) if i not in base]
        gain = float(score(here.data, here.free, base, more, self.train)[0])
        beta = fit(here.data, here.free, [*base, *more], self.train)[0][len(base) :]
        before = left_out(here.data, here.free, base, self.train)
        after = left_out(here.data, here.free, [*base, *more], self.train)
        values = {one: float(b) * typical(one) for one, b in zip(which, beta, strict=True)}
        share = explained(name, here, before, after)
        return Tried(_candidate(name, gain, share, values, "linear"), None)

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
            found[one.name] = Tried(_candidate(one.name, gain, share, values, "simulated"), there)
        return found

    def _with_threshold(
        self, one: Tried, here: Linear, base: Sequence[int], names: Sequence[str]
    ) -> Tried:
        """Return a candidate with what its score must exceed, if it could earn its place.

        Nulls are what its own simulation lacks, with random signs: not yet what it explains.
        """
        if one.linear is None or not _earned(one.found):
            return one
        data = one.linear.data
        signs = random_signs(_NULLS, len(here.lacking.points), seed=1)
        largest = np.zeros(_NULLS)
        own = set(EFFECTS[one.found.name].balances)
        for name in names:
            if own.issuperset(EFFECTS[name].balances):
                more = [i for i in here.index(here.coefficients_of([name])) if i not in base]
                reached = score(data, here.free, base, more, self.train, signs)
                largest = np.maximum(largest, reached)
        threshold = max(_LEAST, float(np.quantile(largest, _QUANTILE)))
        return replace(one, found=replace(one.found, threshold=threshold))


def _taken(steps: Sequence[Step]) -> tuple[str, ...]:
    return tuple(step.taken for step in steps if step.taken)


def explained(name: str, here: Linear, before: LeftOut, after: LeftOut) -> float:
    """Return the share of the excess gap that goes in the balances that an effect shows in."""
    which = [here.column(one) for one in here.coefficients_of([name])]
    shown = np.einsum("pgjj->gj", here.data.columns)[:, which].any(axis=1)
    balances = {balance for (balance, _), own in zip(here.data.groups, shown, strict=True) if own}
    own = np.isin([balance for balance, _ in here.data.groups], list(balances))

    def excess(left: LeftOut) -> float:
        over = np.maximum(left.variance[0] - left.noise, 0.0) * left.windows
        return float(over[own].sum())

    whole = excess(before)
    return 1 - excess(after) / whole if whole > 0 else 0.0


def _earned(one: Candidate) -> bool:
    return one.score > one.threshold and one.explained > _EXPLAINED and one.size >= _MATERIAL


def _candidate(
    name: str,
    gain: float,
    share: float,
    values: Mapping[Coefficient, float],
    tried: Literal["simulated", "linear"],
) -> Candidate:
    size = max((abs(value) / typical(one) for one, value in values.items()), default=0.0)
    parameters = {key: value for (_, key), value in values.items()}
    return Candidate(name, gain, share, size, parameters, tried, _LEAST)
