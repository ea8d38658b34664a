"""What ``reconcile`` finds out: where a model is wrong, which effect it lacks, what adding it did.

Gaps are in trial scatters: 1 is as good as the bench repeats itself. Quantities are in SI.
"""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from hbench.records.flow import FitParameter, Provenance, RunPlan
from hbench.records.numbers import FloatOrNan

Verdict = Literal["named", "ambiguous", "unknown", "none"]


@dataclass(frozen=True)
class Gap:
    """One balance or signal: its gap, and what of it is no scatter."""

    name: str
    gap: FloatOrNan  # 1: as good as the bench repeats itself
    structured: FloatOrNan  # sqrt(gap^2 - 1), 0 below
    p_value: FloatOrNan  # after Holm
    scatter: FloatOrNan  # root mean square of s, in the balance's unit
    windows: int


@dataclass(frozen=True)
class Region:
    """A stretch of one axis with the gap of each balance in it, nan where nothing is compared."""

    axis: str  # direction, speed_m_s, load_n, position_m, time_s
    label: str  # of a direction; empty for the others
    low: FloatOrNan  # smallest and largest value in it
    high: FloatOrNan
    windows: int
    gaps: dict[str, FloatOrNan]  # by balance


@dataclass(frozen=True)
class ResidualMap:
    """What the balances lack at every window, in trial scatters: w windows, c balances."""

    names: tuple[str, ...]
    value: np.ndarray  # (w, c) signed; nan where not compared
    v_m_s: np.ndarray  # (w,) signed
    load_n: np.ndarray  # (w,)
    x_m: np.ndarray  # (w,)
    t_s: np.ndarray  # (w,) since the run's start
    held_out: np.ndarray  # (w,) bool


@dataclass(frozen=True)
class BeforeAfter:
    """A gap on the way from the model as it was given to the revised one."""

    before: FloatOrNan  # model as given
    refitted: FloatOrNan  # its badly tuned parameters refitted
    after: FloatOrNan  # with the effects
    floor: FloatOrNan  # of a model that is right, with its parameters as uncertain as they are


@dataclass(frozen=True)
class GapTable:
    """Gaps over some runs; the total is the root mean square of the balances'."""

    total: BeforeAfter
    balances: dict[str, BeforeAfter]
    signals: dict[str, BeforeAfter]  # closed loop
    open_loop: dict[str, BeforeAfter]  # how far the model goes astray under measured commands


@dataclass(frozen=True)
class RunGap:
    """The gaps of a single run; the floors are those of its operating point."""

    plan: RunPlan
    held_out: bool
    gap: GapTable


@dataclass(frozen=True)
class Candidate:
    """An effect that was tried in the first search."""

    name: str
    score: FloatOrNan  # gain of log-likelihood on operating points left out, nats
    explained: FloatOrNan  # share of the excess gap that goes, in the balances it touches, left out
    size: FloatOrNan  # largest coefficient over its typical size
    parameters: dict[str, FloatOrNan]
    tried: Literal["simulated", "linear"]  # with its own simulation, or by its signature alone
    threshold: FloatOrNan = 0.0  # that its score must exceed


@dataclass(frozen=True)
class Rival:
    """The effect that came second where another was named."""

    name: str
    margin: FloatOrNan  # by how much its score is below, nats


@dataclass(frozen=True)
class AddedEffect:
    """An effect that the revised model has."""

    name: str
    says: str  # the law in words
    parameters: dict[str, FitParameter]  # each in the unit that it carries, a bench's: l/min/bar
    of_sensor: bool
    gap_before: FloatOrNan  # held-out runs, over the balances it touches: refitted model without it
    gap_after: FloatOrNan
    score: FloatOrNan
    runner_up: Rival | None
    shape: str = ""  # the shape parameter that held-out runs supported; empty: textbook form


@dataclass(frozen=True)
class Overlay:
    """A signal of one held-out run: measured, and simulated before and after."""

    run: str
    signal: str
    unit: str  # of the three
    t_s: np.ndarray  # (n,)
    measured: np.ndarray  # (n,)
    before: np.ndarray  # (n,) the refitted model without the effects
    after: np.ndarray  # (n,)


@dataclass(frozen=True)
class Diagnosis:
    """Where model and measurement disagree, why, and what the revised model makes of it."""

    provenance: Provenance
    model: str  # file name
    verdict: Verdict
    why: str  # the verdict in a sentence or two
    where: tuple[Gap, ...]  # balances of the refitted model, worst first
    regions: tuple[Region, ...]  # of the refitted model
    effects: tuple[AddedEffect, ...]  # in order of adding
    alternatives: tuple[Candidate, ...]  # the ambiguous set
    rest: tuple[Gap, ...]  # balances that still lack something after adding
    next_experiment: str | None  # in words
    next_schedule: dict[str, Any] | None  # for `hbench run`
    gap_heldout: GapTable
    gap_train: GapTable
    gap_runs: tuple[RunGap, ...]  # in the campaign's order; none where strokes are compared
    ranking: tuple[Candidate, ...]  # of the first search, best first
    threshold: FloatOrNan  # score that a candidate must exceed, from nulls of this plan
    refitted: dict[str, FitParameter]  # factors on the model's values, by dotted path
    residuals_before: ResidualMap  # refitted model
    residuals_after: ResidualMap
    overlays: tuple[Overlay, ...]
    heldout_runs: tuple[str, ...]
    not_tried: dict[str, str]  # effects that these data can't tell, with the reason
    missing: tuple[str, ...]  # what the data lacks for a better verdict
    left_out: tuple[str, ...]  # runs that took no part, each with its reason
    revised: dict[str, Any] = field(default_factory=dict)  # the revised model's file
    notes: tuple[str, ...] = ()
