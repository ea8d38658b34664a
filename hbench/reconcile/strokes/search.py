"""The search for effects in steady strokes: few operating points, two balances, several series.

The band and the middle are searched one after the other: what turns with the direction and what
does not are told apart whatever explains either. Where several explain the band alike, the middle
is searched with the best of them, for a share of friction may stand in it. Operating points are
few, so nulls are drawn by rotation (``evidence.rotated``).

Series of one cylinder at one bench differ in the seal alone. So they share the verdict: scores and
nulls are summed. And what is not the seal's must have one coefficient in all of them; an effect
whose coefficients differ beyond their 95 % intervals is ruled out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from hbench.analysis.rounding import ranked
from hbench.analysis.statistics.student import student_factor
from hbench.reconcile.estimates import Estimates, estimate, whole_dof
from hbench.reconcile.evidence import rotated, score
from hbench.reconcile.linearised import Hypothesis, Linear, linearise
from hbench.reconcile.search import TIE, Search, Tried
from hbench.reconcile.strokes.series import BALANCES, Strokes
from hbench.records import Candidate

OF_THE_SEAL = ("seal_pressure_friction", "direction_asymmetry")
_NULLS = 200
_QUANTILE = 0.98  # of the nulls' largest scores
_LEAST = 3.0  # nats, e^3 = 20 to 1: what four operating points can tell
_EXPLAINED = 0.5
_MATERIAL = 0.1  # typical sizes
_CLOSE = 3.0, 0.1  # nats, share of the best score


class SeriesSearch(Search):
    """One series."""

    def judged(
        self, here: Linear, taken: tuple[str, ...], names: Sequence[str]
    ) -> dict[str, Tried]:
        """Judge candidates with a simulation of each."""
        base = here.index(here.coefficients_of(taken))
        linear = [self._linear(here, base, name).found for name in names]
        return self._simulated(here, taken, linear)

    def nulls(self, here: Linear, taken: tuple[str, ...], name: str, seed: int) -> np.ndarray:
        """Return a candidate's scores where nothing is to be found."""
        base = here.index(here.coefficients_of(taken))
        more = [i for i in here.index(here.coefficients_of([name])) if i not in base]
        turned = rotated(here.data, _NULLS, seed)
        return score(here.data, here.free, base, more, self.train, turned)

    def estimates(self, here: Linear, names: Sequence[str]) -> Estimates:
        """Return the parameters around a model with the effects ``names``."""
        return estimate(self.measured.plant, here, names, self.train)


@dataclass(frozen=True)
class StrokeStep:
    """One step in one balance, with the candidates' summed scores, best first."""

    balance: str
    before: Linear  # of the first series
    tried: tuple[Candidate, ...]  # numbers of the first series, scores of all
    taken: str | None
    close: tuple[Candidate, ...]
    ruled_out: dict[str, str]  # candidates, each with the reason


@dataclass(frozen=True)
class StrokesFound:
    """What the search found in the first series."""

    given: Linear
    refitted: Linear
    steps: tuple[StrokeStep, ...]
    final: Linear

    @property
    def names(self) -> tuple[str, ...]:
        """The effects that were taken, in order."""
        return tuple(step.taken for step in self.steps if step.taken)


def series_search(strokes: Strokes) -> tuple[SeriesSearch, Linear]:
    """Return the search of a series and the model that was given. Raises ``DataError``."""
    signatures = strokes.signatures
    names = tuple(dict.fromkeys(name for name, _ in signatures))
    (runs,) = strokes.simulate([Hypothesis()], 1)
    given = linearise(strokes, Hypothesis(), runs, signatures)
    points = np.arange(len(given.lacking.points))
    return SeriesSearch(strokes, strokes.simulate, 1, signatures, points, names), given


def search_strokes(series: Sequence[tuple[SeriesSearch, Linear]]) -> StrokesFound:
    """Look for effects; ``series`` are those of one cylinder, the first is asked for."""
    searches = [search for search, _ in series]
    here = [search.settled(given, ()) for search, given in series]
    refitted, steps = here[0], []
    assumed: tuple[str, ...] = ()
    for balance in BALANCES:
        while True:
            step, there = _step(searches, here, assumed, balance)
            steps.append(step)
            first = step.taken or (step.close[0].name if step.close else None)
            if first is None:
                break
            here, assumed = there, (*assumed, first)
            if step.taken is None:
                break
    names = tuple(step.taken for step in steps if step.taken)
    final = here[0] if assumed == names else searches[0].settled(refitted, names)
    return StrokesFound(series[0][1], refitted, tuple(steps), final)


def _step(
    searches: Sequence[SeriesSearch], here: list[Linear], taken: tuple[str, ...], balance: str
) -> tuple[StrokeStep, list[Linear]]:
    """Return a step, and where the best candidate that has earned its place leads."""
    shown = [_shown(one, balance) for one in here]
    names = [n for n in searches[0].candidates if n not in taken and all(n in s for s in shown)]
    judged = [one.judged(at, taken, names) for one, at in zip(searches, here, strict=True)]
    largest = np.zeros(_NULLS)
    for name in names:
        drawn = [
            one.nulls(at, taken, name, seed)
            for seed, (one, at) in enumerate(zip(searches, here, strict=True))
        ]
        largest = np.maximum(largest, np.sum(drawn, axis=0))
    threshold = max(_LEAST, float(np.quantile(largest, _QUANTILE)))
    summed = (
        replace(
            judged[0][name].found,
            score=sum(one[name].found.score for one in judged),
            threshold=threshold,
        )
        for name in names
    )
    tried = tuple(ranked(tuple(summed), lambda one: one.score, TIE))
    good = [one for one in tried if _earned(one)]
    ruled_out = {}
    for one in good:
        if one.name not in OF_THE_SEAL:
            own = [j[one.name].linear for j in judged]
            found = [
                s.estimates(at, (*taken, one.name)) for s, at in zip(searches, own, strict=True)
            ]
            if why := _differ(found, one.name):
                ruled_out[one.name] = why
    good = [one for one in good if one.name not in ruled_out]
    tried = (*good, *(one for one in tried if one not in good))
    if not good:
        return StrokeStep(balance, here[0], tried, None, (), ruled_out), here
    least = good[0].score - max(_CLOSE[0], _CLOSE[1] * good[0].score)
    close, name = tuple(one for one in good if one.score >= least), good[0].name
    there = [
        one.settled(j[name].linear, (*taken, name)) for one, j in zip(searches, judged, strict=True)
    ]
    if len(close) > 1:
        return StrokeStep(balance, here[0], tried, None, close, ruled_out), there
    return StrokeStep(balance, here[0], tried, name, (), ruled_out), there


def _shown(here: Linear, balance: str) -> set[str]:
    """Return the effects whose columns show in a balance."""
    own = [i for i, (name, _) in enumerate(here.data.groups) if name == balance]
    energy = np.einsum("pgjj->gj", here.data.columns)[own].sum(axis=0)
    named = zip(here.data.names, energy, strict=True)
    return {name.partition(".")[0] for name, e in named if e > 0 and not name.startswith("/")}


def _earned(one: Candidate) -> bool:
    return one.score > one.threshold and one.explained > _EXPLAINED and one.size >= _MATERIAL


def _differ(found: Sequence[Estimates], name: str) -> str:
    """Tell where a coefficient is not the same in two series, beyond its 95 % interval."""
    for one, other in combinations(found, 2):
        for key, (a, b) in _both(one, other, name).items():
            own = [x.dof[x.which.index((name, key)) - len(x.which)] for x in (one, other)]
            dof = whole_dof(min(own))
            if abs(a.value - b.value) > student_factor(dof) * np.hypot(a.se, b.se):
                return (
                    f"series of this cylinder with other seals differ in its {key}: "
                    f"{a.value:.3g} and {b.value:.3g} {a.unit}, "
                    f"standard errors {a.se:.1g} and {b.se:.1g}; only a seal's may"
                )
    return ""


def _both(one: Estimates, other: Estimates, name: str) -> dict:
    first, second = one.coefficients(name), other.coefficients(name)
    return {key: (first[key], second[key]) for key in first}
