"""Strategies of the velocities on one cylinder: what each spends, and what it gets for it."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hbench import workflow
from hbench.analysis.curves.average import curves
from hbench.analysis.screening.calibrate import calibrate
from hbench.analysis.screening.screen import screen
from hbench.config.files.loading import read_yaml
from hbench.records import Curve, ScreenedRun
from hbench.store.campaign.folder import load_campaign
from tests.support.analysis.fits import fit_tustin
from tests.support.rig_campaign import measure_on_rig

ROOT = Path(__file__).parents[2]
PLANTS = {"default rig": None, "data_samples/plant.yaml": ROOT / "data_samples" / "plant.yaml"}
ENDS = {"first": "5 mm/s", "last": "200 mm/s"}
ADAPTIVE = read_yaml(ROOT / "configs" / "adaptive.yaml")["experiments"][0]["velocities"]
STRATEGIES = {
    "polynomial": {**ENDS, "count": 15},
    "linear": {"strategy": "linear", **ENDS, "count": 15},
    "slope_adjusted": {
        "strategy": "slope_adjusted", **ENDS, "transition": "80 mm/s", "count": 15
    },
    "adaptive": ADAPTIVE,
}  # fmt: skip
KNEE_M_S = 0.08  # as the slope-adjusted strategy is told: two fifths of the range
SEEDS = range(1000, 1040)


@dataclass(frozen=True)
class Outcome:
    """What one campaign on one cylinder gave."""

    runs: tuple[ScreenedRun, ...]
    curve: Curve
    v_stribeck_m_s: float
    se_m_s: float | None


def measured(folder: Path, velocities: dict, plant: Path | None, seed: int) -> Outcome:
    """Make the source's extending experiment at 2000 N; every run must be accepted."""
    folder.mkdir(parents=True)
    data = read_yaml(ROOT / "configs" / "stribeck.yaml")
    change = {"loads": ["2000 N"], "velocities": velocities}
    data |= {"bench": str(ROOT / "configs" / "bench-aau.yaml"), "order": "experiments"}
    data |= {"experiments": [data["experiments"][1] | change]}
    schedule = folder / "schedule.yaml"
    schedule.write_text(json.dumps(data))
    measure_on_rig(
        workflow.load_experiment(schedule, None), folder / "campaign", plant=plant, seed=seed
    )
    campaign = load_campaign(folder / "campaign")
    bench, rules = campaign.bench(), campaign.screening()
    screened = [screen(calibrate(raw, bench), rules) for raw in campaign.raw_runs()]
    assert all(run.accepted for run in screened), [run.reasons for run in screened]
    (curve,) = curves(screened)
    v_stribeck = fit_tustin(curve).parameters["v_stribeck_m_s"]
    return Outcome(tuple(screened), curve, v_stribeck.value, v_stribeck.se)


@pytest.mark.parametrize("name", PLANTS)
def test_the_adaptive_speeds_lie_mostly_below_the_knee_on_any_plant(name, tmp_path):
    outcome = measured(tmp_path / "a", ADAPTIVE, PLANTS[name], seed=1)
    speeds = sorted({one.run.plan.v_ref_m_s for one in outcome.runs})
    steps = np.diff(speeds)
    assert speeds[0] == 0.005 and speeds[-1] == 0.2
    assert steps.min() >= 0.003 - 1e-12 and steps.max() <= 0.04 + 1e-12
    assert np.mean(np.array(speeds) < KNEE_M_S) > 0.5
    assert steps[-3:].mean() > 2 * steps[:3].mean()
    assert len(speeds) < 30  # of at most 66


@pytest.mark.parametrize("strategy", ["linear", "slope_adjusted"])
def test_a_strategy_without_friction_makes_the_speeds_that_it_says(strategy, tmp_path):
    short = STRATEGIES[strategy] | {"count": 5}
    outcome = measured(tmp_path / strategy, short, None, seed=1)
    expected = {
        "linear": [0.005, 0.05375, 0.1025, 0.15125, 0.2],
        "slope_adjusted": [0.005, 0.0425, 0.08, 0.14, 0.2],
    }
    assert [point.v_m_s for point in outcome.curve.points] == pytest.approx(
        expected[strategy], abs=0.2e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANTS)
def test_runs_that_each_strategy_needs_for_the_same_uncertainty(name, tmp_path):
    """Scatter of the fitted Stribeck velocity over seeds; its square falls with the runs.

    The polynomial's 45 runs set the mark. Of 40 seeds a standard deviation is known to 11 %, a
    ratio of two variances to 32 %. Linear steps are made again in the number that they need.
    """
    spread = np.sqrt(4 / (len(SEEDS) - 1))  # relative, of a ratio of two variances
    print(f"{name}, {len(SEEDS)} seeds; speeds in mm/s")
    print(f"{'':18}runs   mean     sd  se of fit  runs needed")

    def scatter(label: str, velocities: dict, mark: float | None) -> tuple[float, float]:
        """Print a row; return the scatter and the runs needed."""
        found = [
            measured(tmp_path / label / str(seed), velocities, PLANTS[name], seed) for seed in SEEDS
        ]
        runs = np.mean([len(one.runs) for one in found])
        v_s = 1e3 * np.array([one.v_stribeck_m_s for one in found])
        sd = np.std(v_s, ddof=1)
        se = 1e3 * np.median([one.se_m_s for one in found if one.se_m_s is not None])
        needed = runs * (sd / mark) ** 2 if mark else runs
        row = f"{label:18}{runs:4.1f}  {v_s.mean():5.1f}  {sd:5.2f}  {se:9.2f}  {needed:6.0f}"
        print(f"{row} +- {spread * needed:.0f}" if mark else row, flush=True)
        return sd, needed

    mark, _ = scatter("polynomial", STRATEGIES["polynomial"], None)
    needed = {
        strategy: scatter(strategy, STRATEGIES[strategy], mark)[1]
        for strategy in ("linear", "slope_adjusted", "adaptive")
    }
    count = round(needed["linear"] / 3)
    sd, _ = scatter(f"linear, {count}", STRATEGIES["linear"] | {"count": count}, mark)
    assert all(20 < runs < 150 for runs in needed.values()), needed
    assert 0.6 < sd / mark < 1.6  # three standard deviations of such a ratio
