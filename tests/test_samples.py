"""The sample campaigns are analyzed as their truth says, and the intervals cover it as claimed."""

import json
import shutil
from pathlib import Path

import pytest

from hbench import workflow
from tests.support.analysis.chance import binomial_limits
from tests.support.rig_campaign import measure_on_rig

SAMPLES = Path(__file__).parents[1] / "data_samples"


@pytest.fixture
def sample(tmp_path):
    """Copy a sample campaign, so that no results are written into the checkout."""

    def copy(name: str) -> Path:
        shutil.copytree(SAMPLES / name, tmp_path / name, ignore=shutil.ignore_patterns("results"))
        return tmp_path / name

    return copy


def truth_of(name: str) -> dict:
    return json.loads((SAMPLES / f"{name}.truth.json").read_text())


def covered(results) -> list[bool]:
    """Whether each point's 95 % interval holds the plant's true steady friction."""
    points = truth_of("stribeck-small")["points"]
    inside = []
    for curve in results.curves:
        same = [
            p
            for p in points
            if (p["direction"], p["f_load_n"]) == (curve.direction, curve.f_load_n)
        ]
        for point in curve.points:
            true = min(same, key=lambda p: abs(p["v_ref_m_s"] - point.v_m_s))
            assert abs(true["v_ref_m_s"] - point.v_m_s) < 1e-3
            inside.append(abs(point.friction_n - true["friction_n"]) <= point.ci95_n)
    return inside


def test_each_bad_run_is_rejected_for_its_own_reason_and_the_good_one_is_not(sample):
    results = workflow.analyze(sample("bad-runs"))
    reasons = truth_of("bad-runs")["reasons"]
    assert len(set(reasons.values())) == 8
    for run in results.runs:
        codes = [reason.split(":")[0] for reason in run.reasons] or ["accepted"]
        assert codes[0] == reasons[run.run.plan.run], run.reasons
    assert [run.run.plan.run for run in results.runs] == sorted(reasons)


def test_the_sample_campaign_is_accepted_whole_and_its_intervals_hold_the_truth(sample):
    results = workflow.analyze(sample("stribeck-small"))
    assert len(results.runs) == 72 and all(run.accepted for run in results.runs)
    inside = covered(results)
    assert len(inside) == 24
    assert sum(inside) >= 0.9 * len(inside)


def test_fits_of_a_plant_of_another_form_stay_close_to_its_friction(sample):
    """The plant's Stribeck exponent is 1.6; Tustin's law has 1."""
    results = workflow.analyze(sample("stribeck-small"))
    for curve in results.curves:
        fit = curve.fits[0]
        assert fit.converged
        largest = max(abs(point.friction_n) for point in curve.points)
        assert 0 < fit.rmse_n < 0.03 * largest


def coverage(seeds: range, folder: Path) -> float:
    experiment = workflow.load_experiment(SAMPLES / "stribeck-small.yaml", None)
    one_law = folder / "fit.yaml"  # the fits are not looked at
    one_law.write_text("laws: [marton_lantos]\n")
    inside = []
    for seed in seeds:
        measure_on_rig(experiment, folder / str(seed), plant=SAMPLES / "plant.yaml", seed=seed)
        inside += covered(workflow.analyze(folder / str(seed), one_law))
    print(f"coverage {sum(inside)} of {len(inside)}")
    return sum(inside) / len(inside)


def test_the_truth_lies_in_the_95_percent_interval_neither_much_less_nor_always(tmp_path):
    least, _ = binomial_limits(48, 0.95)
    assert least / 48 <= coverage(range(100, 102), tmp_path) < 1.0


@pytest.mark.slow
def test_the_truth_lies_in_the_95_percent_interval_over_many_seeds(tmp_path):
    """480 points: two standard deviations of the share are 2 %."""
    assert 0.92 <= coverage(range(200, 220), tmp_path) <= 0.98


def test_a_fit_file_changes_bounds_laws_and_loss(sample, tmp_path):
    text = "laws: [tustin]\nloss: huber\nbounds:\n  f_coulomb_n: [0 N, 1 N]\nbootstrap: 50\n"
    (tmp_path / "fit.yaml").write_text(text)
    results = workflow.analyze(sample("stribeck-small"), tmp_path / "fit.yaml")
    assert results.joint_fits == ()
    for curve in results.curves:
        (fit,) = curve.fits
        assert fit.parameters["f_coulomb_n"].value <= 1.0
        assert set(fit.parameters["f_stiction_n"].intervals) == {
            "linearised",
            "profile",
            "bootstrap",
        }


def test_each_example_document_is_small_and_listed():
    words = (SAMPLES / "README.md").read_text()
    found = [*(SAMPLES / "documents").iterdir(), SAMPLES / "report.png"]
    assert len(found) >= 11
    for path in found:
        most = 300_000 if path.suffix == ".pdf" else 100_000
        assert path.stat().st_size < most, path
        assert f"({path.relative_to(SAMPLES).as_posix()})" in words, path
