"""Campaigns of hidden plants, through the real firmware on the virtual rig.

Its process needs ``HBENCH_EFFECTS``, as ``generate.py`` sets it.
"""

from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from hbench.analysis.screening.calibrate import calibrate
from hbench.config.bench import Bench, Plant
from hbench.config.friction import Leuven
from hbench.config.scaling import scaled
from hbench.config.schedule import parse_schedule
from hbench.experiment.campaign_header import campaign_header
from hbench.experiment.plan import plan_runs
from hbench.experiment.recorder import LOG_CHANNELS
from hbench.experiment.runner import run_campaign
from hbench.model.build import plant_parameters
from hbench.model.sensors import sensor_parameters
from hbench.protocol.dictionary import RECORD_FLAGS
from hbench.records import Outcome, RawRun, Run, RunPlan
from hbench.rig.client import BoardClient
from hbench.rig.virtual import VirtualRig
from hbench.store.campaign.writer import CampaignWriter
from hbench.workflow import Experiment
from tests.support.hidden.background import SIDES, wandering
from tests.support.hidden.cases import Case, truth
from tests.support.hidden.draws import Drawn
from tests.support.hidden.instruments import astray, rewritten
from tests.support.hidden.laws.table import EFFECTS

_RIGID = (
    0.4  # of an added mass; the rest is a column of oil, which damps what the rigid part excites
)
_START = datetime(2026, 1, 1, tzinfo=UTC)


def generate(case: Case, schedule: Mapping[str, Any], bench: Bench) -> tuple[Run, ...]:
    """Return a case's runs, calibrated with the model's bench.

    Raises ``DeviceError`` where the board stops itself.
    """
    plans = plan_runs(parse_schedule(dict(schedule), case.name), bench, case.name).runs
    kept = _Kept(bench)
    _make(case, plans, bench, lambda client: kept)
    return tuple(kept.runs)


def write(case: Case, experiment: Experiment, folder: Path) -> None:
    """Write a case's campaign. Raises ``DeviceError`` where the board stops itself."""

    def journal(client: BoardClient) -> CampaignWriter:
        header = campaign_header(
            experiment.schedule.name,
            experiment.files,
            client.identify(),
            experiment.bench,
            "sim",
            _START,
        )
        return CampaignWriter.create(folder, header)

    _make(case, experiment.plans, experiment.bench, journal)


def compile_for(listed: Sequence[Case], bench: Bench) -> None:
    """Compile the rigs of these cases once, before each process would: a minute or more each."""
    for hidden in {truth(case).leuven: truth(case) for case in listed}.values():
        rig = VirtualRig(bench, plant_of(bench, hidden))
        rig.read(0.0)
        rig.close()


class _Kept:
    """Keeps runs where a campaign's journal writes them."""

    def __init__(self, bench: Bench):
        self.runs: list[Run] = []
        self._bench = bench

    def start_run(self, *told: Any) -> None:
        pass

    def finish_run(
        self, plan: RunPlan, words: np.ndarray, outcome: Outcome, why: str, at: datetime
    ) -> None:
        rate = self._bench.controllers.log_rate
        raw = RawRun(plan, words, LOG_CHANNELS, RECORD_FLAGS, rate, outcome, why)
        self.runs.append(calibrate(raw, self._bench))


def _make(
    case: Case, plans: Sequence[RunPlan], bench: Bench, journal: Callable[[BoardClient], Any]
) -> None:
    hidden = truth(case)
    rig = _Rig(bench, hidden, plans, case.seed)
    try:
        client = BoardClient(rig)
        kept = _Rewriting(journal(client), rig)
        run_campaign(plans, rig.on_board, client, kept, lambda: _START, lambda progress: None)
    finally:
        rig.close()


class _Rewriting:
    """Passes runs on to a journal with the errors of their instruments; then the rig drifts."""

    def __init__(self, journal: Any, rig: "_Rig"):
        self._journal, self._rig = journal, rig

    def start_run(self, plan: RunPlan, at: datetime, after: str) -> None:
        self._journal.start_run(plan, at, after)

    def finish_run(
        self, plan: RunPlan, words: np.ndarray, outcome: Outcome, why: str, at: datetime
    ) -> None:
        self._journal.finish_run(plan, self._rig.log(words), outcome, why, at)
        self._rig.after(plan)


class _Rig(VirtualRig):
    """A rig with a hidden plant, a little different in each pass of trials and in each run."""

    def __init__(self, bench: Bench, hidden: Drawn, plans: Sequence[RunPlan], seed: int):
        plant = plant_of(bench, hidden)
        super().__init__(bench, plant, seed)
        filter_s = hidden.effects.get("velocity_filter_lag", {}).get("time", 0.0)
        slower = bench.controllers.velocity_filter + 0.5 * filter_s  # the log has the other half
        self.on_board = bench.model_copy(
            update={"controllers": bench.controllers.model_copy(update={"velocity_filter": slower})}
        )
        self._hidden, self._plans = hidden, list(plans)
        self._rng = np.random.default_rng([seed, 21])
        self._plant, self._levels = plant, _levels(hidden, len(plans), seed)
        self._rate_hz = bench.controllers.log_rate
        self._true, self._sensors = self._bench.par, sensor_parameters(plant.sensors)
        self._next = 0
        self._drift()
        self._become()

    def log(self, words: np.ndarray) -> np.ndarray:
        """Return a run's words with its instruments' errors."""
        return rewritten(words, self._hidden, self._sensors, self._rate_hz, self._session)

    def after(self, plan: RunPlan) -> None:
        """Change what changes between runs: the next begins, maybe with another pass."""
        self._next = 1 + self._plans.index(plan)
        if self._next < len(self._plans) and _pass(self._plans[self._next]) != _pass(plan):
            self._drift()
        self._become()

    @property
    def _session(self) -> float:
        return self._next / len(self._plans)

    def _drift(self) -> None:
        hidden, normal = self._hidden, self._rng.standard_normal
        par = self._true
        valve, supply = par.valve, par.supply
        self._par = par._replace(
            bulk_modulus_pa=par.bulk_modulus_pa * (1 + hidden.bulk_modulus * normal()),
            valve=valve._replace(flow_gain=valve.flow_gain * (1 + hidden.valve_gain * normal())),
            supply=supply._replace(tank_pa=supply.tank_pa + hidden.tank_pa * normal()),
        )
        self._zeros = hidden.zero_counts * normal(len(self._sensors.zero))

    def _become(self) -> None:
        sensors = astray(self._sensors, self._hidden, self._zeros, self._session)
        levels = self._levels[min(self._next, len(self._levels) - 1)]
        plant = self._plant.model_copy(update={"effects": _rows(self._hidden, levels)})
        par = self._par._replace(effects=plant_parameters(plant).effects)
        self._bench = self._bench._replace(par=par, sensors=sensors)


def _levels(hidden: Drawn, runs: int, seed: int) -> list[dict[str, float]]:
    """Return the relative change of each cylinder's dry friction, run by run."""
    rng = np.random.default_rng([seed, 23])
    change = {side: wandering(hidden.background.wander[side], runs, rng) for side in SIDES}
    return [{side: float(change[side][run]) for side in SIDES} for run in range(runs)]


def _pass(plan: RunPlan) -> tuple[str, str, int]:
    return plan.kind, plan.label, plan.trial


def plant_of(bench: Bench, hidden: Drawn) -> Plant:
    """Return the hidden plant."""
    plant = Plant.model_construct(**{key: getattr(bench, key) for key in Plant.model_fields})
    plant = scaled(plant, hidden.factors | {"sensors.adc.noise": hidden.noise})
    added = hidden.effects.get("added_mass", {"test": 0.0, "load": 0.0})
    masses = {side: getattr(plant.moving_mass, side) + _RIGID * added[side] for side in SIDES}
    pair = plant.friction
    return plant.model_copy(
        update={
            "moving_mass": plant.moving_mass.model_copy(update=masses),
            "friction": pair.model_copy(
                update={side: _friction(getattr(pair, side), hidden) for side in SIDES}
            ),
            "effects": _rows(hidden, dict.fromkeys(SIDES, 0.0)),
        }
    )


def _friction(law: Any, hidden: Drawn) -> Any:
    """Return another law with LuGre's parameters: four elements with its stiffness at rest."""
    values = law.model_dump() | {"scatter": hidden.scatter}
    if not hidden.leuven:
        return law.model_copy(update={"scatter": hidden.scatter})
    stiffness = values.pop("bristle_stiffness")
    carried = 3 * values["stiction"] + 300.0
    stiffer = sum(1 / (i + 1) for i in range(4))  # elements that slip first are stiffer
    values |= {
        "law": "leuven",
        "elements": (carried / 4,) * 4,
        "presliding": stiffer * carried / stiffness,
        "shape": 1.0,
    }
    return Leuven.model_construct(**values)


def _rows(hidden: Drawn, levels: Mapping[str, float]) -> dict[str, dict[str, str]]:
    """Return the section ``effects``: the laws of ``laws/table.py``, and what ``own`` adds.

    ``levels`` are relative changes of the cylinders' dry friction.
    """
    errors = hidden.background
    nulls = {f"null_{valve}": volts for valve, volts in errors.valve_null_v.items()}
    background = {
        "valve_spread": errors.valve_gain | nulls,
        "laminar_ports": {"transition": errors.transition_pa},
        "friction_level": dict(levels),
        "gain_curvature": {"share": hidden.gain_curvature},
        "bore_ripple": {
            "share": hidden.ripple_share,
            "period": hidden.ripple_period_m,
            "phase": hidden.ripple_phase,
        },
    }
    section = {name: dict(values) for name, values in hidden.own.items()}
    for name, values in (background | hidden.effects).items():
        row = EFFECTS.get(f"hidden_{name}")  # without a law: instruments.py
        if row is not None:
            units = {key: one.unit for key, one in row.coefficients.items()}
            if name == "added_mass":
                values = values | {side: (1 - _RIGID) * values[side] for side in SIDES}
            section[f"hidden_{name}"] = {key: f"{v!r} {units[key]}" for key, v in values.items()}
    return section
