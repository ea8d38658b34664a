"""Makes the sample campaigns anew: ``python data_samples/make.py`` (simulated, half a minute).

``stribeck-small`` comes from a plant other than the bench file's (``plant.yaml``); what that
plant's steady friction truly is stands in ``stribeck-small.truth.json``. ``bad-runs`` holds one
run for each reason of the screening, each spoilt by its own cause; ``bad-runs.truth.json`` names
the reason.
"""

import itertools
import json
import math
import shutil
import tempfile
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from hbench import workflow
from hbench.analysis.screening.calibrate import calibrate
from hbench.analysis.screening.screen import screen
from hbench.config.bench import Plant, merge, parse_bench, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.experiment.runner import run_campaign
from hbench.records import ScreenedRun
from hbench.rig.client import BoardClient
from hbench.rig.virtual import VirtualRig
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.writer import CampaignWriter

HERE = Path(__file__).parent
SEED = 20
QUIET = {
    "friction": {"test": {"scatter": 0}, "load": {"scatter": 0}},
    "sensors": {"adc": {"noisy": False, "quantised": False}},
}


def true_friction(run: ScreenedRun, plant: Plant) -> float:
    """Return the test cylinder's true steady friction [N], signed, at a run's reference.

    The law of the plant, written out, at the reference speed and the mean chamber pressures of
    ``run``, which was made without noise and scatter. (The pressures can't be had from the load
    alone: the test chambers' common pressure creeps for many seconds after a reversal.)
    """
    friction, v_ref = plant.friction.test, run.run.plan.v_ref_m_s
    p_p, p_r, v = run.means.p_tp_pa, run.means.p_tr_pa, abs(v_ref)
    seal = friction.piston_seal * abs(p_p - p_r) + friction.rod_seal * p_r
    decay = math.exp(-((v / friction.stribeck_velocity) ** friction.stribeck_exponent))
    dry = friction.coulomb + seal + (friction.stiction - friction.coulomb) * decay
    return math.copysign(dry + friction.viscous * v, v_ref)


def clock():
    """Return a clock of fixed times: the files say nothing about when they were made."""
    seconds = itertools.count()
    return lambda: datetime(2026, 1, 1, tzinfo=UTC) + timedelta(seconds=next(seconds))


def measure(experiment: workflow.Experiment, folder: Path, plant: Path | None, now) -> None:
    """Make the runs of an experiment on the virtual rig, with ``plant`` behind it."""
    workflow.measure(
        experiment,
        folder,
        workflow.Line(plant=plant, seed=SEED),
        resume=False,
        clock=now,
        report=lambda progress: None,
    )


def make_stribeck() -> None:
    """Measure the small Stribeck schedule on the other plant, and once more for the truth."""
    experiment = workflow.load_experiment(HERE / "stribeck-small.yaml", None)
    measure(experiment, HERE / "stribeck-small", HERE / "plant.yaml", clock())

    quiet = merge(read_yaml(HERE / "plant.yaml"), QUIET)
    plant = parse_plant(experiment.files["bench"]["content"], quiet, "quiet plant")
    with tempfile.TemporaryDirectory() as scratch:
        plant_file = Path(scratch) / "plant.yaml"
        plant_file.write_text(json.dumps(quiet))
        measure(experiment, Path(scratch) / "quiet", plant_file, clock())
        campaign = load_campaign(Path(scratch) / "quiet")
        runs = [
            screen(calibrate(raw, experiment.bench), campaign.screening())
            for raw in campaign.raw_runs()
        ]
    truth = [
        {
            "direction": run.run.plan.direction,
            "f_load_n": run.run.plan.f_load_n,
            "v_ref_m_s": run.run.plan.v_ref_m_s,
            "friction_n": round(true_friction(run, plant), 3),
        }
        for run in runs
        if run.run.plan.trial == 2
    ]
    _write_json("stribeck-small.truth.json", {"simulated": True, "points": truth})


class Losing(CampaignWriter):
    """Writes logs that lack records 104 to 119."""

    def finish_run(self, plan, words, *rest) -> None:
        """Write what is left of the log."""
        super().finish_run(plan, np.delete(words, slice(104, 120), axis=0), *rest)


# Lets a run whose speed is far off come to its end.
LENIENT = {"limits": {"speed_error": "400 mm/s"}}

# One run a cause, in the order of bad-runs.yaml after its first, good run. ``plant`` and ``bench``
# replace keys of the bench file: for the simulated physics, and for what the board is told.
TABLE_6_2 = {
    "law": "tustin",
    "coulomb": "1 N",
    "stiction": "616 N",
    "stribeck_velocity": "100 mm/s",
    "viscous": "1341 N s/m",
}
BAD_RUNS = (
    {
        "reason": "off_reference",  # the integral part twenty times too slow
        "bench": {"controllers": {"velocity": {"gain": "40 V/m", "time_constant": "1200 ms"}}},
    },
    {"reason": "stalled", "plant": {"test_cylinder": {"stroke": "200 mm"}}},  # a spacer inside
    {
        "reason": "not_steady",  # the source's own fit as a static law: the loop does not hold
        "plant": {"friction": {"test": TABLE_6_2, "load": {"viscous": "1800 N s/m"}}},
    },
    {"reason": "truncated", "keep_lines": 1500},  # the file was cut
    {"reason": "gapped", "writer": Losing},
    {"reason": "sensor_saturated", "plant": {"sensors": {"load_cell": {"amplifier": 1900}}}},
    {
        "reason": "valve_saturated",  # the load's piston side can't empty against the tank
    },
)


def make_bad_runs() -> None:
    """Measure the bad runs, each on its own rig, into one campaign."""
    experiment = workflow.load_experiment(HERE / "bad-runs.yaml", None)
    bench_data, folder, now = experiment.files["bench"]["content"], HERE / "bad-runs", clock()
    measure(
        replace(experiment, plan=replace(experiment.plan, runs=experiment.plans[:1])),
        folder,
        None,
        now,
    )
    for plan, bad in zip(experiment.plans[1:], BAD_RUNS, strict=True):
        bench = parse_bench(merge(merge(bench_data, LENIENT), bad.get("bench", {})), "bench")
        rig = VirtualRig(bench, parse_plant(bench_data, bad.get("plant", {}), "plant"), SEED)
        journal = bad.get("writer", CampaignWriter).resume(folder)
        run_campaign([plan], bench, BoardClient(rig), journal, now, lambda progress: None)
        if "keep_lines" in bad:
            log = folder / "runs" / f"{plan.run}.dat"
            log.write_bytes(b"".join(log.read_bytes().splitlines(True)[: bad["keep_lines"]]))
    reasons = ["accepted", *(bad["reason"] for bad in BAD_RUNS)]
    truth = {plan.run: reason for plan, reason in zip(experiment.plans, reasons, strict=True)}
    _write_json("bad-runs.truth.json", {"simulated": True, "reasons": truth})


def _write_json(name: str, data: dict) -> None:
    (HERE / name).write_text(json.dumps(data, indent=1) + "\n")


if __name__ == "__main__":
    for name in ("stribeck-small", "bad-runs"):
        shutil.rmtree(HERE / name, ignore_errors=True)
    make_stribeck()
    make_bad_runs()
