"""Next experiment: the one that separates an ambiguous set best, or those that show more effects.

Each experiment of ``discriminate.yaml`` is simulated once and linearised about the refitted model.
Its operating points are added to those of the campaign. For each effect of the set, with its fitted
coefficients as the cause, the expected lead in score over each of the others is computed (see
``separability.py``). The smallest of these leads is the separation.

Where no effect is missing, each experiment is added in the same way, and those are proposed with
which effects of a typical size become detectable that the campaign's runs do not show.
"""

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.files.examples import example
from hbench.config.files.loading import parse_yaml
from hbench.config.schedule import parse_schedule
from hbench.config.sensors import Instruments
from hbench.errors import ConfigError
from hbench.experiment.plan import plan_runs
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.evidence.products import Products
from hbench.reconcile.evidence.window_sums import GROUPS, LEVEL
from hbench.reconcile.hypothesis import Hypothesis, effect_coefficients, typical_size
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.separation.planned_runs import simulated_runs
from hbench.reconcile.separation.separability import Lead, Separation
from hbench.records import Run
from hbench.records.reconcile.diagnosis import MATERIAL
from hbench.sentences import listed

_LIBRARY = "discriminate.yaml"
_TRIALS = 3
_NOT_COMPARED = "Not compared as a next experiment: {}. Their simulation ended early ({})."


class Proposal(NamedTuple):
    """Proposed experiments, in words and as a schedule; None where none helps."""

    words: str | None
    schedule: dict[str, Any] | None
    notes: tuple[str, ...]  # experiments that were not compared


@dataclass(frozen=True)
class Undecided:
    """Ambiguous set of a search."""

    model: LinearisedModel  # without the set; its noise contains what no effect explains
    points: np.ndarray  # indices of the operating points of the search
    added: tuple[str, ...]  # effects that the model already has
    rivals: Mapping[str, Hypothesis]  # the set, each effect with its fitted coefficients


@dataclass(frozen=True)
class ExperimentLibrary:
    """Experiments that a bench can run after a campaign with some schedule."""

    bench: Bench
    plant: Plant  # of the given model
    instruments: Instruments | None
    schedule: Mapping[str, Any]  # as in its file; empty: unknown
    bench_file: str = "BENCH"

    def propose(self, undecided: Undecided) -> Proposal:
        """Return the experiment that separates the effects best.

        The schedule is the campaign's with this experiment. No experiment is proposed where the
        effects are not distinguishable with any of them.
        """
        before = separation(undecided)
        best, chosen = before, None
        simulated, notes = self._simulated(undecided.model.hypothesis)
        for experiment, runs in simulated:
            after = separation(self._with_runs(undecided, runs))
            if after.distinguishable and after.order > best.order:
                best, chosen = after, experiment
        if chosen is None:
            return Proposal(None, None, notes)
        name = f"Distinguish {listed(list(undecided.rivals))}"
        words = self._words(chosen, undecided, before, best)
        return Proposal(words, self._schedule(name, [chosen]), notes)

    def reveal(self, compared: Separation, effects: Sequence[str]) -> Proposal:
        """Return the experiments that show more of some effects.

        Each is the one that shows most of the effects that neither the campaign nor those before
        it show at a typical size. None is proposed where no experiment shows another one.
        """
        model = compared.model
        known = Undecided(model, compared.points, (), dict.fromkeys(effects, model.hypothesis))
        hidden = set(effects) - detectable(compared, effects)
        simulated, notes = self._simulated(model.hypothesis)
        shown = []
        for experiment, runs in simulated:
            joint = self._with_runs(known, runs)
            seen = detectable(Separation(joint.model, joint.points), sorted(hidden))
            shown.append((experiment, seen))
        chosen = []
        while shown and hidden:
            experiment, seen = max(shown, key=lambda each: len(each[1] & hidden))
            if not seen & hidden:
                break
            chosen.append((experiment, [name for name in effects if name in seen & hidden]))
            hidden -= seen
        if not chosen:
            return Proposal(None, None, notes)
        added = listed([described(one) for one, _ in chosen])
        shown_then = [name for name in effects if any(name in names for _, names in chosen)]
        words = (
            f"{self._added()} {added}. By simulation they would show {listed(shown_then)} at a "
            f"typical size. {self._command()}"
        )
        if never := [name for name in effects if name in hidden]:
            words += f" No single experiment of {_LIBRARY} shows {listed(never)}."
        schedule = self._schedule("Show more effects", [one for one, _ in chosen])
        return Proposal(words, schedule, notes)

    def _simulated(
        self, at: Hypothesis
    ) -> tuple[list[tuple[dict[str, Any], tuple[Run, ...]]], tuple[str, ...]]:
        """Return one simulated trial of each experiment that the bench can make.

        Those whose simulation ended early are in notes instead.
        """
        experiments, planned = [], []
        for experiment in _experiments():
            schedule = {"name": "next", "experiments": [{**experiment, "trials": 1}]}
            with suppress(ConfigError):
                plans = plan_runs(parse_schedule(schedule, "next"), self.bench, "next").runs
                experiments.append(experiment)
                planned.append(plans)
        made = map_on_threads(
            lambda plans: simulated_runs(self.bench, self.plant, plans, at), planned
        )
        simulated, notes = [], []
        for experiment, runs in zip(experiments, made, strict=True):
            if isinstance(runs, str):
                notes.append(_NOT_COMPARED.format(described(experiment), runs))
            else:
                simulated.append((experiment, runs))
        return simulated, tuple(notes)

    def _with_runs(self, undecided: Undecided, runs: tuple[Run, ...]) -> Undecided:
        """Return an ambiguous set with the operating points of some runs added."""
        model = undecided.model
        names, used = model.data.names, model.index((*undecided.added, *undecided.rivals))
        campaign = MeasuredCampaign(
            self.bench, self.plant, self.instruments, sessions(runs), MATERIAL
        )
        known = campaign.columns(model.hypothesis, [names[i] for i in used])
        blank = np.zeros_like(next(iter(known.values())))
        columns = {name: known.get(name, blank) for name in names}
        more = linearise(campaign, model.hypothesis, columns)
        first = len(model.data.squares)
        return replace(
            undecided,
            model=replace(model, data=joined(model, more)),
            points=np.concatenate([undecided.points, first + np.arange(len(more.data.squares))]),
        )

    def _schedule(self, name: str, chosen: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        own = {key: value for key, value in self.schedule.items() if key != "bench"}
        own = own or {"order": "passes"}
        # An order of the schedule applies to all experiments.
        added = [
            {key: value for key, value in one.items() if key != "order" or "order" not in own}
            | {"trials": _TRIALS}
            for one in chosen
        ]
        return {**own, "name": name, "experiments": [*own.get("experiments", ()), *added]}

    def _command(self) -> str:
        return (
            f"The command is: hbench run next.yaml --bench {self.bench_file} -o next (on a board "
            "with --port). Then reconcile next."
        )

    def _added(self) -> str:
        return f"next.yaml {'repeats the schedule and adds' if self.schedule else 'contains'}"

    def _words(
        self, chosen: Mapping[str, Any], undecided: Undecided, before: Lead, after: Lead
    ) -> str:
        right = f"the score of the right effect among {listed(list(undecided.rivals))}"
        lead = f"{after.lead:.2g} nats, without them by {max(before.lead, 0.0):.2g}"
        needed = f"{round(after.margin)} are needed"
        gain = f"With these runs {right} is expected to lead by {lead}; {needed}."
        if after.lead <= after.margin:
            gain = (
                "Of the experiments that the bench can make they separate best, but may not "
                f"decide: {right} is expected to lead by {lead}; {needed}. Effects that act for a "
                "moment often score more than expected."
            )
        return f"{self._added()} the {described(chosen)}. {gain} {self._command()}"


def described(experiment: Mapping[str, Any]) -> str:
    """Return an experiment's kind, label, direction, loads and speeds in words."""
    label = f" {experiment['label']!r}" if "label" in experiment else ""
    speeds = experiment.get("velocities") or experiment.get("levels") or [experiment.get("speed")]
    parts = (
        experiment.get("direction"),
        f"loads {listed(experiment['loads'])}" if experiment.get("loads") else "",
        f"p_lr {experiment['p_lr']}" if "p_lr" in experiment else "",
        f"speeds {listed(list(dict.fromkeys(speeds)))}" if all(speeds) else "",
    )
    text = f"{experiment['kind']} runs{label} ({'; '.join(filter(None, parts))})"
    return re.sub(r"(?<=[ (])-(?=\d)", "−", text)


def detectable(compared: Separation, effects: Sequence[str]) -> set[str]:
    """Return the effects of which some coefficient would be detectable at its typical value."""
    keys = [key for name in effects for key in effect_coefficients(name)]
    keys = [key for key in keys if key in compared.model.coefficients_of([key[0]])]
    seen = compared.exceeds(keys, np.ones(len(keys))) if keys else ()
    return {name for (name, _), exceeds in zip(keys, seen, strict=True) if exceeds}


def _experiments() -> list[dict[str, Any]]:
    return parse_yaml(example(_LIBRARY).decode())["experiments"]


def separation(undecided: Undecided) -> Lead:
    """Return the lead of the worst case among the effects of an ambiguous set."""
    base, causes = undecided.model.hypothesis, {}
    for name, hypothesis in undecided.rivals.items():
        cause = np.zeros((1, len(undecided.model.data.names)))
        for key in effect_coefficients(name):
            change = hypothesis.coefficient(key) - base.coefficient(key)
            cause[0, undecided.model.column(key)] = change / typical_size(key)
        causes[name] = cause
    expected = Separation(undecided.model, undecided.points, undecided.added)
    leads = expected.leads(causes, tuple(undecided.rivals))
    return min(leads.values(), key=lambda lead: lead.order)


def joined(campaign: LinearisedModel, planned: LinearisedModel) -> Products:
    """Return the products of a campaign and of planned runs, in the scatters of the campaign.

    The planned runs have the campaign's noise where it has such windows. Balances that the campaign
    has no channels for are left out.
    """
    data, more = campaign.data, planned.data
    square = _squared_units(planned, campaign)
    windows, noise = data.windows.sum(axis=0), data.noise.sum(axis=0)
    balances = windows.reshape(-1, len(GROUPS)).sum(axis=1) > 0
    measured = np.repeat(balances, len(GROUPS)) & np.isfinite(square).all(axis=0)
    square = np.where(measured, square, 0.0)
    per_window = noise / np.maximum(windows, 1)
    new_noise = np.where(windows > 0, more.windows * per_window, more.noise * square)
    return Products(
        names=data.names,
        columns=data.columns.followed_by(more.columns.scaled(square)),
        mixed=np.concatenate([data.mixed, more.mixed * square[..., None]]),
        squares=np.concatenate([data.squares, more.squares * square]),
        noise=np.concatenate([data.noise, np.where(measured, new_noise, 0.0)]),
        windows=np.concatenate([data.windows, np.where(measured, more.windows, 0)]),
        groups=data.groups,
    )


def _squared_units(planned: LinearisedModel, campaign: LinearisedModel) -> np.ndarray:
    """Return the squares (p, g) of planned rows' units in those of the campaign.

    Units are the scatters, but a level's is sqrt(s^2 + |c|^2) with its change c by one standard
    deviation in the balance's unit (``evidence/window_sums.py``).
    """
    scatters = (planned.gap_map.scatter[0] / campaign.gap_map.scatter[0]) ** 2
    square = np.tile(np.repeat(scatters, len(GROUPS)), (len(planned.data.squares), 1))
    for level in planned.gap_map.levels:
        unit, change = scatters[level.balance], level.change @ level.change / level.ridge
        group = level.balance * len(GROUPS) + LEVEL
        point = planned.gap_map.point[level.windows.start]
        square[point, group] = unit * (1 + change) / (1 + unit * change)
    return square
