"""Next experiment: the one with which the effects of an ambiguous set are separated best.

Each experiment of ``discriminate.yaml`` is simulated once and linearised about the refitted model.
Its operating points are added to those of the campaign. For each effect of the set, with its fitted
coefficients as the cause, the expected lead in score over each of the others is computed (see
``separability.py``). The smallest of these leads is the separation.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.files.examples import example
from hbench.config.files.loading import parse_yaml
from hbench.config.schedule import parse_schedule
from hbench.config.sensors import Instruments
from hbench.errors import ConfigError
from hbench.experiment.plan import plan_runs
from hbench.reconcile.hypothesis import Hypothesis, effect_coefficients, typical_size
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.products import Products
from hbench.reconcile.separation.planned_runs import simulated_runs
from hbench.reconcile.separation.separability import Lead, Separation
from hbench.reconcile.window_sums import GROUPS
from hbench.records import Run
from hbench.records.diagnosis import MATERIAL

_LIBRARY = "discriminate.yaml"
_TRIALS = 3


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

    def propose(self, undecided: Undecided) -> tuple[str, dict[str, Any]] | None:
        """Return the experiment that separates the effects best, in words and as a schedule.

        The schedule is the campaign's with this experiment. None where the effects are not
        distinguishable with any of the experiments.
        """
        before = separation(undecided)
        best, chosen = before, None
        for experiment in parse_yaml(example(_LIBRARY).decode())["experiments"]:
            runs = self._runs(experiment, undecided.model.hypothesis)
            after = separation(self._with_runs(undecided, runs)) if runs else before
            if after.distinguishable and after.order > best.order:
                best, chosen = after, experiment
        if chosen is None:
            return None
        return self._words(chosen, undecided, before, best), self._schedule(chosen, undecided)

    def _runs(self, experiment: Mapping[str, Any], at: Hypothesis) -> tuple[Run, ...]:
        """Return one simulated trial of an experiment; no runs if the bench can't make them."""
        try:
            schedule = {"name": "next", "experiments": [{**experiment, "trials": 1}]}
            plans = plan_runs(parse_schedule(schedule, "next"), self.bench, "next").runs
        except ConfigError:
            return ()
        return simulated_runs(self.bench, self.plant, plans, at)

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

    def _schedule(self, chosen: Mapping[str, Any], undecided: Undecided) -> dict[str, Any]:
        own = {key: value for key, value in self.schedule.items() if key != "bench"}
        own = own or {"order": "passes"}
        added = {**chosen, "trials": _TRIALS}
        if "order" in own:  # which applies to all experiments
            added.pop("order", None)
        return {
            **own,
            "name": f"Distinguish {' and '.join(undecided.rivals)}",
            "experiments": [*own.get("experiments", ()), added],
        }

    def _words(
        self, chosen: Mapping[str, Any], undecided: Undecided, before: Lead, after: Lead
    ) -> str:
        label = f" {chosen['label']!r}" if "label" in chosen else ""
        which = "repeats the schedule and adds" if self.schedule else "contains"
        return (
            f"next.yaml {which} the {chosen['kind']} runs{label}. With these runs the score of the "
            f"right effect among {' and '.join(undecided.rivals)} is expected to lead by "
            f"{round(after.lead)} nats, without them by {round(before.lead)}; "
            f"{round(after.margin)} are needed."
        )


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
    unit = np.repeat(planned.gap_map.scatter[0] / campaign.gap_map.scatter[0], len(GROUPS))
    windows, noise = data.windows.sum(axis=0), data.noise.sum(axis=0)
    balances = windows.reshape(-1, len(GROUPS)).sum(axis=1) > 0
    measured = np.repeat(balances, len(GROUPS)) & np.isfinite(unit)
    square = np.where(measured, np.nan_to_num(unit), 0.0) ** 2
    per_window = noise / np.maximum(windows, 1)
    new_noise = np.where(windows > 0, more.windows * per_window, more.noise * square)
    return Products(
        names=data.names,
        columns=np.concatenate([data.columns, more.columns * square[:, None, None]]),
        mixed=np.concatenate([data.mixed, more.mixed * square[:, None]]),
        squares=np.concatenate([data.squares, more.squares * square]),
        noise=np.concatenate([data.noise, np.where(measured, new_noise, 0.0)]),
        windows=np.concatenate([data.windows, np.where(measured, more.windows, 0)]),
        groups=data.groups,
    )
