"""A law that no candidate has, from a campaign on the virtual rig to the revised model and back."""

import numpy as np
import pytest
import yaml

from hbench.config.bench import merge, parse_bench, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.experiment.closed_loop import record
from hbench.reconcile.diagnose import ReconcileTask, diagnose
from hbench.reconcile.measured.balances import FLOWS
from hbench.records import Provenance
from hbench.report.diagnosis.diagnosis_document import diagnosis_json
from hbench.report.diagnosis.revised_yaml import revised_yaml
from tests.support import ROOT
from tests.support.reconcile.rounds import schedule

BENCH = read_yaml(ROOT / "configs" / "bench-aau.yaml")
SPEEDS = ("15 mm/s", "30 mm/s", "50 mm/s", "80 mm/s", "110 mm/s", "150 mm/s")
# A parabola along the bore, where the candidates have no law of the position.
BORE = {"position_friction": {"slope": "60 N", "bow": "120 N"}}


# Per cents of the reading over its pitch, finer than the bore's tables.
PITCH_M, SHARE = 0.09, 2.0
PLACES_M = np.linspace(0.03, 0.37, 32)
SENSOR = {
    "adds_to": "position_sensor",
    "over": {"position": [f"{1e3 * x} mm" for x in PLACES_M]},
    "values": [f"{SHARE * np.sin(2 * np.pi * x / PITCH_M)} %" for x in PLACES_M],
}
# A filter: the square of the flow, behind more volume than the table's lag is of.
FILTER = {"supply_droop": {"slope": "0.3 bar min/l", "exponent": 2.0, "lag": "35 ms"}}


def reconciled(runs, bench, sections, monkeypatch, tried=("supply_droop", "velocity_filter_lag")):
    monkeypatch.setattr(
        "hbench.reconcile.diagnose.observable_effects", lambda runs, plant: (tried, {})
    )
    provenance = Provenance("bore", "simulated", "bench", "sim", "2026-01-01T00:00:00", "")
    plant = parse_plant(BENCH, sections, "model")
    return diagnose(
        ReconcileTask(
            provenance=provenance,
            model="model",
            plant_data=sections,
            bench=bench,
            plant=plant,
            runs=runs,
            instruments=bench.instruments,
        )
    )


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


def first_and_second(hidden, monkeypatch, tried):
    """Runs, their diagnosis with the given model, and with the revised one."""
    bench, model = parse_bench(BENCH, "bench"), read_yaml(ROOT / "configs" / "model-aau.yaml")
    changed = merge({"valve": {"gain": "7.5e-7 m^2/V"}}, hidden)
    made = record(
        bench, schedule(trials=2, speeds=SPEEDS), parse_plant(BENCH, changed, "x"), seed=11
    )
    first = reconciled(made.runs, bench, model, monkeypatch, tried)
    revised = yaml.safe_load(revised_yaml(first))
    return made.runs, first, reconciled(made.runs, bench, revised, monkeypatch, tried)


def gap_on_the_rig(runs, sections, channel):
    """Root mean square difference of a channel between runs and those of a model on the rig.

    Of means over 0.1 s: the noise of a command is larger than what a sensor's error changes.
    """
    bench, plant = parse_bench(BENCH, "bench"), parse_plant(BENCH, sections, "model")
    own = record(bench, schedule(trials=2, speeds=SPEEDS), plant, seed=12).runs
    pairs = [
        (getattr(one, channel), getattr(other, channel))
        for one, other in zip(runs, own, strict=True)
    ]
    changes = [np.subtract(*(each[: min(map(len, pair))] for each in pair)) for pair in pairs]
    smooth = [np.convolve(each, np.ones(20) / 20, "valid") for each in changes]
    return np.sqrt(np.mean(np.concatenate(smooth) ** 2))


def assert_rig_follows(runs, diagnosis, channel):
    """The rig reproduces a channel with the revised model, and without its law it does not."""
    revised = yaml.safe_load(revised_yaml(diagnosis))
    without = {key: value for key, value in revised.items() if key != "learned"}
    with_law, none = (gap_on_the_rig(runs, each, channel) for each in (revised, without))
    (law,) = diagnosis.unnamed
    print(channel, none, with_law, law.gap_before, law.gap_after)
    assert with_law < 0.5 * none


@pytest.mark.slow
def test_a_position_sensor_that_is_not_straight_is_found_in_all_flows(monkeypatch):
    tried = ("supply_droop", "velocity_filter_lag")
    runs, first, second = first_and_second({"learned": [SENSOR]}, monkeypatch, tried)
    assert first.verdict == "unknown"
    (law,) = first.unnamed
    assert law.adds_to == "position_sensor" and set(law.balances) == set(FLOWS)
    assert law.gap_after < 0.3 * law.gap_before and law.p_value < 0.05
    true = SHARE * np.sin(2 * np.pi * np.array(law.knots[0]) / (1e3 * PITCH_M))
    shape = (true - true.mean()) - (law.values - np.mean(law.values))
    assert np.abs(shape).max() < 0.35 * np.ptp(true)
    assert first.gap_heldout.balances["kinematics"].refitted < 1.2  # it does not show the error
    assert second.verdict == "none" and not second.unnamed
    assert_rig_follows(runs, first, "u_t_v")


@pytest.mark.slow
def test_a_supply_that_sags_as_no_candidate_does_gets_a_table_over_the_flow(monkeypatch):
    tried = ("internal_leakage", "velocity_filter_lag")
    runs, first, second = first_and_second({"effects": FILTER}, monkeypatch, tried)
    assert first.verdict == "unknown"
    (law,) = first.unnamed
    assert law.adds_to == "supply" and law.quantities[0] == "drawn_flow"
    assert law.gap_after < 0.3 * law.gap_before and law.p_value < 0.05
    if len(law.quantities) == 1:
        values = np.array(law.values)
        fall = 0.3 * np.array(law.knots[0]) ** 2 / 10  # the same as in proportion at 10 l/min
        assert np.abs(values - values[0] + fall - fall[0]).max() < 0.1 * np.ptp(fall)
    assert second.verdict == "none" and not second.unnamed
    assert_rig_follows(runs, first, "p_s_pa")


@pytest.mark.slow
def test_a_bench_without_such_errors_gets_no_law(monkeypatch):
    _, first, _ = first_and_second({}, monkeypatch, ("internal_leakage", "velocity_filter_lag"))
    assert first.verdict == "none" and not first.unnamed
