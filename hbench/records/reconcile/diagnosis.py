"""Results of ``reconcile``: gaps of a model, missing effects, and the revised model.

Gaps are in units of the trials' scatter: 1 is the repeatability of the bench. Quantities are SI.
"""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from hbench.records.numbers import FitParameter, FloatOrNan
from hbench.records.reconcile.gaps import Gap, GapTable, Region, ResidualMap, RunGap
from hbench.records.reconcile.separability import Separability
from hbench.records.runs import Provenance

Verdict = Literal["named", "ambiguous", "unknown", "none"]
REST_M_S = 2e-3  # windows with a lower speed are at rest
# Share of a signal's range: a fifth of the 1 % to which data sheets state cylinders and valves.
MATERIAL = 0.002
# Why an effect is not tried that is no candidate: a tolerance that every model is refitted with.
FITTED = "every bench has it; it is refitted with the parameters of the model"
# Or a part of a hydraulic bench that a driven mass does not have.
NO_PART = "does not change the force balance of a driven mass"
MOTION_BALANCE = "force_mass"  # force balance of a driven mass
SIGNIFICANT_P = 0.1  # p-value after Holm below which a gap is significant
LEVEL_SCATTER = 0.04  # of dry friction from run to run, standard deviation: assumed
UNEXPLAINED_GAP = 2.0  # trial scatters; a smaller one is no reason to look for a missing effect
LEAST_EXPLAINED = 0.25  # share of the excess gap that an effect must explain to be named
LEAST_SIZE = 0.25  # of its typical size that it must have
TOLERATED = "none of its coefficients alone is beyond its tolerance"  # of a size of 0


@dataclass(frozen=True)
class Candidate:
    """Effect that was tried in a step of the search."""

    name: str
    score: FloatOrNan  # gain of log-likelihood by cross-validation, nats
    explained: FloatOrNan  # share of the excess gap removed in it
    size: FloatOrNan  # largest coefficient over its typical size
    parameters: dict[str, FloatOrNan]
    tried: Literal["full", "linear"]  # at its fitted coefficients, or by its columns alone
    threshold: FloatOrNan = 0.0  # that its score must exceed
    balance: str = ""  # of steady strokes, whose gap it would explain; empty: those of its law


@dataclass(frozen=True)
class Rival:
    """Effect with the second-best score."""

    name: str
    margin: FloatOrNan  # by how much its score is below, nats


@dataclass(frozen=True)
class AddedEffect:
    """Effect that was added to the model."""

    name: str
    description: str  # the law in words
    parameters: dict[str, FitParameter]  # each in the unit that it carries, a bench's: l/min/bar
    of_sensor: bool
    # Of held-out runs in the balances it touches, less what the level of friction may differ from
    # run to run: refitted model without it
    gap_before: FloatOrNan
    gap_after: FloatOrNan  # with it and the other effects, without unnamed laws
    score: FloatOrNan
    runner_up: Rival | None
    shape: str = ""  # the shape parameter that held-out runs supported; empty: textbook form
    law: str = ""  # its formula

    @property
    def confirmed(self) -> bool:
        """Whether it reduces the gap of held-out runs."""
        return self.gap_after < self.gap_before


@dataclass(frozen=True)
class UnnamedLaw:
    """Learned law of balances: a table over one or two quantities that no effect explains.

    Knots and values are in their units. Over two quantities the values follow row by row, a row for
    each knot of the first.
    """

    adds_to: str  # ``config.effects.Target``
    balances: tuple[str, ...]
    unit: str
    quantities: tuple[str, ...]
    quantity_units: tuple[str, ...]
    knots: tuple[tuple[float, ...], ...]  # (n,), (m,)
    values: tuple[float, ...]  # (n,) or (n m,)
    low: tuple[float, ...]  # 95 % intervals of the values, pointwise
    high: tuple[float, ...]
    gap_before: FloatOrNan  # held-out runs, of the balances: the model with all effects
    gap_after: FloatOrNan  # with all learned laws
    score: FloatOrNan  # nats
    threshold: FloatOrNan
    p_value: FloatOrNan  # of the reduction at held-out operating points


@dataclass(frozen=True)
class WorkingPoint:
    """Working point of a campaign: medians over the steady windows of one operating point.

    It is the one nearest to the medians of speed, load and pressures of all runs in ``direction``.
    """

    direction: str  # in which most windows are
    windows: int
    v_m_s: FloatOrNan  # signed
    x_m: FloatOrNan
    # Readings; nan where no run has the channel.
    f_applied_n: FloatOrNan
    p_tp_pa: FloatOrNan
    p_tr_pa: FloatOrNan
    p_lp_pa: FloatOrNan
    p_lr_pa: FloatOrNan
    p_s_pa: FloatOrNan
    u_t_v: FloatOrNan
    u_l1_v: FloatOrNan
    u_l2_v: FloatOrNan
    # Of the revised model, in SI, by balance; "speed" and "pressure" as of a ``Change``.
    residuals: dict[str, FloatOrNan]


@dataclass(frozen=True)
class Change:
    """Change of one quantity by an effect: with it less without it, in ``unit``.

    Of a balance (flow into a chamber, friction against the motion, pressure of the source), of a
    sensor's reading, or of ``speed`` and ``pressure``: those of the piston and the fed chamber.
    """

    quantity: str
    unit: str  # a bench's
    at_point: FloatOrNan  # at the working point, in steady motion
    ci95: tuple[float, float] | None  # by the uncertainty of the effect's coefficients
    along: FloatOrNan  # root mean square over the measured windows in motion
    largest: FloatOrNan  # magnitude that 5 % of these windows exceed


@dataclass(frozen=True)
class Lookalike:
    """Effect that another one is confused with, and the run that separates the two."""

    name: str
    kind: str  # of experiment
    why: str


@dataclass(frozen=True)
class EffectInPractice:
    """What an effect changes at the bench, and what to do about it."""

    name: str
    changes: tuple[Change, ...]
    inspect: str  # what confirms it: a noun phrase
    repair: str  # a sentence
    lookalikes: tuple[Lookalike, ...]


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
    # Why it is shown: its gap shrank most. False: no signal's gap shrank, and its gap is largest.
    shrank: bool = True


@dataclass(frozen=True)
class HeldOutError:
    """Root mean square error of the models of a driven mass over held-out runs, in ``unit``.

    Of ``force``, that of the force balance along the measured motion; of ``position``, that of the
    motion simulated under the measured drive force from each run's first sample.
    """

    quantity: Literal["force", "position"]
    unit: str  # a bench's
    before: FloatOrNan  # model as given
    refitted: FloatOrNan
    after: FloatOrNan  # with the effects


@dataclass(frozen=True)
class HeldOutLoad:
    """Root mean square force error of models of steady strokes at a load outside their fit."""

    load_n: FloatOrNan
    before: FloatOrNan  # N: model as given
    refitted: FloatOrNan
    after: FloatOrNan  # with the effects
    also: dict[str, FloatOrNan]  # with one more effect of the ambiguous set, by its name
    scatters: dict[str, FloatOrNan]  # N: of the trials, by balance


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """Disagreement of model and measurement, its cause, and the revised model.

    A field that a form of data does not have, such as schedules of strokes, keeps its default.
    """

    provenance: Provenance
    model: str  # file name
    verdict: Verdict
    why: str  # the verdict in a sentence or two
    where: tuple[Gap, ...] = ()  # balances of the refitted model, worst first
    regions: tuple[Region, ...] = ()  # of the refitted model
    # In order of adding; the revised model has the confirmed ones.
    effects: tuple[AddedEffect, ...] = ()
    alternatives: tuple[Candidate, ...] = ()  # the ambiguous set
    rest: tuple[Gap, ...] = ()  # balances whose residuals no effect explains
    # Effects too small to be named, and not in the revised model. With them ``rest`` is empty.
    small_effects: tuple[AddedEffect, ...] = ()
    next_experiment: str | None = None  # in words
    next_schedule: dict[str, Any] | None = None  # for `hbench run`
    gap_heldout: GapTable = field(default_factory=GapTable)
    gap_train: GapTable = field(default_factory=GapTable)
    gap_runs: tuple[RunGap, ...] = ()  # in the campaign's order; none where strokes are compared
    ranking: tuple[Candidate, ...] = ()  # of the first search, best first
    # Score that a candidate must exceed, from nulls of this plan.
    threshold: FloatOrNan = float("nan")
    # Factors on the model's values, by dotted path.
    refitted: dict[str, FitParameter] = field(default_factory=dict)
    residuals_before: ResidualMap = field(default_factory=ResidualMap.empty)  # refitted model
    residuals_after: ResidualMap = field(default_factory=ResidualMap.empty)
    overlays: tuple[Overlay, ...] = ()
    heldout_runs: tuple[str, ...] = ()
    # Effects that these data do not determine, with the reason.
    not_tried: dict[str, str] = field(default_factory=dict)
    # Candidates with a sufficient score that are not named, with the reason.
    ruled_out: dict[str, str] = field(default_factory=dict)
    missing: tuple[str, ...] = ()  # data that would improve the verdict
    left_out: tuple[str, ...] = ()  # runs left out, each with its reason
    revised: dict[str, Any] = field(default_factory=dict)  # the revised model's file
    unnamed: tuple[UnnamedLaw, ...] = ()  # in order of adding
    notes: tuple[str, ...] = ()
    separability: Separability | None = None  # None where strokes are compared
    working_point: WorkingPoint | None = None
    practice: tuple[EffectInPractice, ...] = ()  # of the effects and the ambiguous set
    regions_after: tuple[Region, ...] = ()  # of the final model, in the same scatters
    # Why the refit without effects was refused: "refitted" then is the model as given. Empty: not.
    refit_refused: str = ""
    errors: tuple[HeldOutError, ...] = ()  # of the motion of a driven mass
    within_tolerance: tuple[str, ...] = ()  # errors that every bench has, in the revised model
    held_out_loads: tuple[HeldOutLoad, ...] = ()  # where strokes are compared
    # Assumed standard deviation of the logarithm of each refitted factor, by dotted path.
    refit_priors: dict[str, FloatOrNan] = field(default_factory=dict)
    # Of readings and commands [ms] against the position, where they matter, by channel.
    delays: dict[str, FitParameter] = field(default_factory=dict)
    # Largest offset of each sensor within its tolerance, by reading, in a bench's unit.
    zero_tolerances: dict[str, FloatOrNan] = field(default_factory=dict)
    material: FloatOrNan = float("nan")  # share of a quantity's range up to which it may deviate

    @property
    def in_practice(self) -> dict[str, EffectInPractice]:
        """What effects change at the bench, by their names."""
        return {effect.name: effect for effect in self.practice}

    @property
    def alternative_sets(self) -> list[list[Candidate]]:
        """The ambiguous sets: of each one effect is missing. Strokes have one for each balance."""
        sets = dict[str, list[Candidate]]()
        for candidate in self.alternatives:
            sets.setdefault(candidate.balance, []).append(candidate)
        return list(sets.values())

    @property
    def confirmed(self) -> tuple[AddedEffect, ...]:
        """The effects that the revised model contains: those that held-out runs confirm."""
        return tuple(effect for effect in self.effects if effect.confirmed)
