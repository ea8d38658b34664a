"""Separability of effects by some runs: smallest detectable sizes and signatures that look alike.

About a linearised model (see ``linearised.py``) an effect with coefficients b causes the
differences d = C b. The search's likelihood (``evidence/likelihood.py``) gives its expected score,
without chance:

    gain(A) = loss(nuisances) - loss(nuisances and A)      loss: of the best fit, in nats

All fits have the nuisances with their priors and bounds, and the noise that the search assumes,
which contains deviations that are not material. Fits are not cross-validated: rivals seem a little
better than in a search.

- **Smallest detectable size** of a coefficient: its gain exceeds the least threshold of a score and
  it is as large as the search demands. What tolerances of the instruments may cause is a nuisance.
- **Pair**: A is the cause, B the rival. They are not distinguishable if the search would accept B
  and its gain is so close to that of A that both are in the ambiguous set. The pair's lead is
  gain(A) - gain(B) of the worst case: either effect as the cause, each coefficient, either sign.
  The cause has its typical size, or twice the smallest detectable one where that is larger. Effects
  that are not detectable at ten times their typical sizes are no causes.
- **Angle** of two signatures: the smallest principal angle of the spaces that their columns span in
  the metric of the noise, S = sum w_g C_g' C_g, after the nuisances n are projected out:

    S_ee - S_en (S_nn + prior^-2)^-1 S_ne,    w_g = n_g / (m_g v_g), as in the likelihood

  0 degrees: some coefficients of the two effects have the same signature. The angle does not depend
  on sizes and bounds; the lead does.

Source of the angles: Bjorck and Golub, Mathematics of Computation 27 (1973), theorem 1.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from math import isfinite
from typing import NamedTuple

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.parallel.process_pool import usable_cores
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.acceptance import CRITERIA, ambiguity_margin
from hbench.reconcile.column_names import CoefficientKey
from hbench.reconcile.evidence.likelihood import Priors, expected_loss, information
from hbench.reconcile.hypothesis import effect_coefficients
from hbench.reconcile.linearised import LinearisedModel
from hbench.records import DetectableSize, EffectPair, Separability

LARGEST = 10.0  # typical sizes: no larger effect is considered
_SMALLEST = 1e-2
_BISECTIONS = 9  # of a ratio of 1000: to 1.4 %
_BEYOND_SMALLEST = 2.0  # size of a cause whose typical size is hardly detectable
_NO_INFORMATION = 1e-9  # share of a column's information that rounding errors may leave


class Lead(NamedTuple):
    """Expected lead in score of a cause over a rival."""

    lead: float  # nats
    margin: float  # nats: a smaller lead makes an ambiguous set
    accepted: bool  # whether the rival could be added

    @property
    def distinguishable(self) -> bool:
        """Whether the search would not put the rival in an ambiguous set with the cause."""
        return self.lead > self.margin or not self.accepted

    @property
    def order(self) -> tuple[bool, float]:
        """Sort key: the worst case is the smallest."""
        return self.distinguishable, self.lead - self.margin


@dataclass(frozen=True)
class Separation:
    """Expected scores of effects, from a model that is linearised along some runs."""

    model: LinearisedModel
    points: np.ndarray  # indices of the operating points that a search uses
    added: tuple[str, ...] = ()  # effects that every fit has

    def separability(self, effects: Sequence[str]) -> Separability:
        """Return the smallest detectable sizes of some effects, and all their pairs."""
        keys = [key for name in effects for key in self._keys(name)]
        smallest = self.smallest_sizes(keys).tolist()
        sizes = tuple(map(self._size, keys, smallest))
        causes: dict[str, list[np.ndarray]] = defaultdict(list)
        for key, size in zip(keys, smallest, strict=True):
            if isfinite(size):
                causes[key[0]] += self._causes(key, max(1.0, _BEYOND_SMALLEST * size))
        leads = self.leads({name: np.array(rows) for name, rows in causes.items()}, effects)
        pairs = []
        for one, other in combinations(effects, 2):
            known = [leads[pair] for pair in ((one, other), (other, one)) if pair in leads]
            worst = min(known, key=lambda lead: lead.order, default=None)
            pairs.append(
                EffectPair(
                    one,
                    other,
                    self.angle_deg(one, other),
                    worst.lead if worst else float("nan"),
                    worst.distinguishable if worst else None,
                )
            )
        return Separability(sizes, tuple(pairs))

    def smallest_sizes(self, keys: Sequence[CoefficientKey]) -> np.ndarray:
        """Return the positive sizes (k,), in typical ones, that just exceed the least threshold.

        A fit with the effect has no loss but its prior's, at most half a nat, which is neglected.
        nan where ``LARGEST`` does not suffice.
        """
        low, high = np.full(len(keys), _SMALLEST), np.full(len(keys), LARGEST)
        found = self.exceeds(keys, high)
        for _ in range(_BISECTIONS):
            middle = np.sqrt(low * high)
            exceeds = self.exceeds(keys, middle)
            low, high = np.where(exceeds, low, middle), np.where(exceeds, middle, high)
        return np.where(found, high, np.nan)

    def exceeds(self, keys: Sequence[CoefficientKey], sizes: np.ndarray) -> np.ndarray:
        """Return which coefficients (k,) exceed the least threshold at sizes in typical ones."""
        causes = np.array([self._unit(key) for key in keys])
        return self._loss((), sizes[:, None] * causes) > CRITERIA.score

    def leads(
        self, causes: Mapping[str, np.ndarray], rivals: Sequence[str]
    ) -> dict[tuple[str, str], Lead]:
        """Return the smallest leads by cause and rival; ``causes`` are factors (b, q) by effect."""
        if not causes:
            return {}
        every = np.concatenate(list(causes.values()))
        without = self._loss((), every)
        loss = {name: self._loss((name,), every) for name in {*causes, *rivals}}
        leads, first = {}, 0
        for name, own in causes.items():
            rows = slice(first, first := first + len(own))
            gain = without[rows] - loss[name][rows]
            for rival in rivals:
                if rival == name:
                    continue
                rival_gain = without[rows] - loss[rival][rows]
                cases = (
                    Lead(mine - its, ambiguity_margin(mine), its > CRITERIA.score)
                    for mine, its in zip(gain.tolist(), rival_gain.tolist(), strict=True)
                )
                leads[name, rival] = min(cases, key=lambda lead: lead.order)
        return leads

    def angle_deg(self, first: str, second: str) -> float:
        """Return the angle of two effects' signatures; nan where the runs do not show one."""
        one, other = (
            [self.model.column(key) for key in self._keys(name)] for name in (first, second)
        )
        own = [*one, *other]
        nuisances = [j for j in self.model.index(self.added) if j not in own]
        stiff = self._information[np.ix_(nuisances, nuisances)]
        stiff = stiff + np.diag(self.model.priors(self.added).sigma[nuisances] ** -2.0)
        mixed = self._information[np.ix_(nuisances, own)]
        whole = self._information[np.ix_(own, own)]
        remaining = whole - mixed.T @ np.linalg.solve(stiff, mixed)
        return principal_angle_deg(remaining, np.diag(whole), len(one))

    def _loss(self, effects: Sequence[str], causes: np.ndarray) -> np.ndarray:
        """Return the expected loss (b,) of a fit with ``effects`` to causes (b, q)."""
        names = (*self.added, *effects)
        priors, chosen = self.model.priors(names), self.model.index(names)
        centred = Priors(np.zeros_like(priors.centre), priors.sigma, priors.low, priors.high)

        def loss(some: np.ndarray) -> np.ndarray:
            return expected_loss(self.model.data, centred, chosen, some, self.points)

        return np.concatenate(map_on_threads(loss, np.array_split(causes, usable_cores())))

    @cached_property
    def _information(self) -> np.ndarray:
        return information(self.model.data, self.points)

    def _keys(self, name: str) -> tuple[CoefficientKey, ...]:
        known = self.model.coefficients_of([name])
        return tuple(key for key in effect_coefficients(name) if key in known)

    def _unit(self, key: CoefficientKey) -> np.ndarray:
        """Return the factors (q,) of one typical size of a coefficient."""
        unit = np.zeros(len(self.model.data.names))
        unit[self.model.column(key)] = 1.0
        return unit

    def _causes(self, key: CoefficientKey, size: float) -> list[np.ndarray]:
        """Return the factors (q,) of a coefficient with either sign that it may have."""
        row = EFFECTS[key[0]].coefficients[key[1]]
        signs = [sign for sign, limit in ((1.0, row.high), (-1.0, -row.low)) if limit > 0]
        return [sign * size * self._unit(key) for sign in signs]

    def _size(self, key: CoefficientKey, size: float) -> DetectableSize:
        """Return a coefficient's smallest value, from the ``size`` [typical ones] by its gain."""
        row = EFFECTS[key[0]].coefficients[key[1]]
        if size < CRITERIA.size:
            return DetectableSize(*key, CRITERIA.size * row.typical, row.typical, row.unit, "size")
        return DetectableSize(*key, size * row.typical, row.typical, row.unit, "evidence")


def with_remaining_noise(
    model: LinearisedModel, explained: LinearisedModel, points: np.ndarray
) -> LinearisedModel:
    """Return a model whose noise also contains what another one does not explain at ``points``.

    Both have the same windows and scatter.
    """
    data = model.data
    noise, squares = (each[points].sum(axis=0) for each in (data.noise, explained.data.squares))
    factor = np.maximum(squares, noise) / np.where(noise > 0, noise, 1.0)
    return replace(model, data=replace(data, noise=data.noise * np.where(noise > 0, factor, 1.0)))


def principal_angle_deg(products: np.ndarray, before: np.ndarray, first: int) -> float:
    """Return the smallest principal angle of two spaces from the products of their columns.

    ``products`` (q, q) of which the ``first`` columns span one space and the others the other;
    ``before`` (q,) are the squares of the columns before others were projected out: what remains
    of a column at the level of rounding errors is none. nan where a space has no column.
    """
    bases = []
    for part in (slice(None, first), slice(first, None)):
        scale = np.sqrt(np.where(before[part] > 0, before[part], 1.0))
        values, vectors = np.linalg.eigh(products[part, part] / np.outer(scale, scale))
        kept = values > _NO_INFORMATION
        bases.append(vectors[:, kept] / np.sqrt(values[kept]) / scale[:, None])
    if not all(basis.shape[1] for basis in bases):
        return float("nan")
    cosines = np.linalg.svd(bases[0].T @ products[:first, first:] @ bases[1], compute_uv=False)
    return float(np.degrees(np.arccos(min(cosines.max(), 1.0))))
