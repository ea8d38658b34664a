"""A law that no candidate has, from a campaign on the virtual rig to the revised model and back."""

import numpy as np
import pytest
import yaml

from hbench.config.bench import merge, parse_bench, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.experiment.closed_loop import record
from hbench.reconcile.diagnose import ReconcileTask, diagnose
from hbench.records import Provenance
from hbench.report.diagnosis.diagnosis_document import diagnosis_json
from hbench.report.diagnosis.revised_yaml import revised_yaml
from tests.support import ROOT
from tests.support.reconcile.rounds import schedule

BENCH = read_yaml(ROOT / "configs" / "bench-aau.yaml")
SPEEDS = ("15 mm/s", "30 mm/s", "50 mm/s", "80 mm/s", "110 mm/s", "150 mm/s")
# A parabola along the bore, where the candidates have no law of the position.
BORE = {"position_friction": {"slope": "60 N", "bow": "120 N"}}


def reconciled(runs, bench, sections, monkeypatch):
    monkeypatch.setattr(
        "hbench.reconcile.diagnose.observable_effects",
        lambda runs, plant: (("supply_droop", "velocity_filter_lag"), {}),
    )
    provenance = Provenance("bore", "simulated", "bench", "sim", "2026-01-01T00:00:00", "")
    plant = parse_plant(BENCH, sections, "model")
    task = ReconcileTask(provenance, bench, "model", plant, sections, runs, bench.instruments)
    return diagnose(task)


@pytest.mark.slow
def test_an_unnamed_law_is_fitted_written_and_read_back(monkeypatch):
    bench = parse_bench(BENCH, "bench")
    hidden = parse_plant(BENCH, merge({"valve": {"gain": "7.5e-7 m^2/V"}}, {"effects": BORE}), "x")
    made = record(bench, schedule(trials=2, speeds=SPEEDS), hidden, seed=11)
    model = read_yaml(ROOT / "configs" / "model-aau.yaml")
    first = reconciled(made.runs, bench, model, monkeypatch)
    assert first.verdict == "unknown"
    law = first.unnamed[0]
    assert (law.adds_to, law.quantities[0]) == ("friction_test", "position")
    assert law.gap_after < 0.5 * law.gap_before and law.p_value < 0.05
    if len(law.quantities) == 1:
        s = 2 * np.array(law.knots[0]) / (1e3 * bench.test_cylinder.stroke) - 1
        true, values = 60 * s + 120 * s**2, np.array(law.values)
        shape = (true - true.mean()) - (values - values.mean())  # the level is the friction law's
        assert np.abs(shape).max() < 0.35 * np.ptp(true)
    assert '"adds_to": "friction_test"' in diagnosis_json(first)
    revised = yaml.safe_load(revised_yaml(first))
    second = reconciled(made.runs, bench, revised, monkeypatch)
    assert second.verdict == "none" and not second.unnamed
    after, again = (
        first.gap_heldout.balances["force_test"],
        second.gap_heldout.balances["force_test"],
    )
    assert again.refitted == pytest.approx(after.after, rel=0.1)
