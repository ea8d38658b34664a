"""``analyze`` of half the 360-run campaign, against pandas and lmfit doing the same plainly."""

import time
import tracemalloc
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from hbench import workflow
from hbench.analysis.tustin import TABLE_6_1
from hbench.config.bench import parse_bench
from hbench.model.sensors import sensor_gains
from hbench.store.campaign import load_campaign

CONFIGS = Path(__file__).parents[2] / "configs"
LOADS = 2  # of four: 180 runs
ROUNDS = 2


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("speed") / "campaign"
    schedule = yaml.safe_load((CONFIGS / "stribeck.yaml").read_text())
    for one in schedule["experiments"]:
        one["loads"] = one["loads"][:LOADS]
    (folder.parent / "half.yaml").write_text(yaml.safe_dump(schedule))
    workflow.measure(
        workflow.load_experiment(folder.parent / "half.yaml", CONFIGS / "bench-aau.yaml"),
        folder,
        port="sim",
        plant=None,
        seed=1,
        resume=False,
        clock=lambda: datetime(2026, 1, 1, tzinfo=UTC),
        report=lambda progress: None,
    )
    return folder


def plain_pipeline(folder):
    """What a script of a page would do: read, scale, average the window, group, fit, write."""
    lmfit = pytest.importorskip("lmfit")
    header, runs = load_yaml(folder / "campaign.yaml")
    bench = parse_bench(header["bench"]["content"], "bench")
    gains = sensor_gains(bench.sensors)
    channels = header["log"]["channels"]
    names = [channel["name"] for channel in channels]
    rows = []
    for plan in runs:
        cells = pd.read_csv(folder / "runs" / f"{plan['run']}.dat", skiprows=1, header=None)[0]
        words = cells.map(lambda word: int(str(word), 16)).to_numpy().reshape(-1, len(names))
        log = pd.DataFrame(words, columns=names)
        for name in ("x", "p_tp", "p_tr", "f_applied"):
            gain, offset = gains[name]
            log[name] = gain * log[name] / 16 + offset
        t = (log["index"] + 0.5) / 100
        reached = (log["flags"] & 1 == 1).idxmax()
        travelled = (log.x - log.x[reached]).abs() >= 0.02
        window = log[(t >= t[reached] + 0.3) & travelled & (log.index >= reached)]
        specimen = plan["specimen"]
        f_test = window.p_tp * specimen["area_piston_m2"] - window.p_tr * specimen["area_rod_m2"]
        slope = np.polyfit(t[window.index], window.x, 1)[0]
        mean = {"v": slope, "friction": (f_test - window.f_applied).mean(), "f_test": f_test.mean()}
        rows.append({**plan, **mean, "f_applied": window.f_applied.mean()})
    table = pd.DataFrame(rows)
    table["direction"] = np.sign(table.v_ref_m_s)
    points = table.groupby(["direction", "f_load_n", "v_ref_m_s"], as_index=False).agg(
        v=("v", "mean"), friction=("friction", "mean"), s=("friction", "std"), n=("v", "size"),
        f_test=("f_test", "mean"), f_applied=("f_applied", "mean"),
    )  # fmt: skip
    points["ci95"] = 4.303 * points.s / np.sqrt(points.n)
    points["efficiency"] = points.f_applied / points.f_test

    def tustin(v, f_coulomb_n, f_stiction_n, v_stribeck_m_s, b_viscous_n_s_m):
        e = np.exp(-v / v_stribeck_m_s)
        return f_coulomb_n + (f_stiction_n - f_coulomb_n) * e + b_viscous_n_s_m * v

    model, fits = lmfit.Model(tustin), []
    for key, curve in points.groupby(["direction", "f_load_n"]):
        parameters = model.make_params(
            f_coulomb_n=200, f_stiction_n=500, v_stribeck_m_s=0.07, b_viscous_n_s_m=2000
        )
        for name, (low, high) in TABLE_6_1.items():
            parameters[name].set(min=low, max=high)
        friction = curve.friction.abs().to_numpy()
        fit = model.fit(friction, parameters, v=curve.v.abs().to_numpy())
        fits.append({"curve": key, **fit.best_values})
    out = folder / "plain"
    out.mkdir(exist_ok=True)
    table.drop(columns="specimen").to_csv(out / "runs.csv")
    points.to_csv(out / "curves.csv")
    pd.DataFrame(fits).to_csv(out / "fits.csv")
    return points


def load_yaml(path):
    """The campaign's header and its plans."""
    content = yaml.load(path.read_text(), Loader=yaml.CSafeLoader)
    starts = [item for item in content["runs"] if "plan" in item]
    return content, [{"run": item["run"], **item["plan"]} for item in starts]


def best(function):
    times = []
    for _ in range(ROUNDS):
        before = time.process_time()
        result = function()
        times.append(time.process_time() - before)
    return min(times), result


def test_analyze_is_faster_than_a_plain_pipeline_and_finds_the_same_friction(campaign):
    """CPU time, without start-up. ``analyze`` also screens, selects and judges the fits."""
    ours, results = best(lambda: workflow.analyze(campaign))
    plain, points = best(lambda: plain_pipeline(campaign))
    print(f"\nanalyze {ours:.2f} s, plain pandas and lmfit {plain:.2f} s: {plain / ours:.2f} times")
    found = [point.friction_n for curve in results.curves for point in curve.points]
    np.testing.assert_allclose(np.sort(found), np.sort(points.friction), atol=5.0)
    assert ours < plain


def test_memory_does_not_grow_with_the_number_of_runs(campaign):
    """Peak of a quarter of the runs and of all: the samples would be 7 MB more."""
    whole = load_campaign(campaign)
    peaks = []
    for part in (whole.entries[: len(whole.entries) // 4], whole.entries):
        tracemalloc.start()
        workflow.results.derive(replace(whole, entries=part))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    print(f"\npeak {peaks[0] / 1e6:.1f} MB of 45 runs, {peaks[1] / 1e6:.1f} MB of 180")
    assert peaks[1] - peaks[0] < 2.5e6
